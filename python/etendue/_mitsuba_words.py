"""What a notebook for Mitsuba calls and there is little to do for here."""

from __future__ import annotations

from ._errors import UsageError
from ._parameters import Parameters
from ._scenes import Scene


def set_variant(*variants: str) -> None:
    """Takes the names of Mitsuba's variants and does nothing: there is one, in RGB. Raises UsageError where none of
    them is in RGB."""
    if variants and not any(variant.endswith("rgb") for variant in variants):
        raise UsageError(f"There is no variant {variants[0]!r}: Etendue renders in RGB. Take one that ends in _rgb.")


def traverse(scene: Scene) -> Parameters:
    """``scene.parameters``. Their names are Etendue's; a KeyError suggests them. update() takes changes, or nothing."""
    return scene.parameters
