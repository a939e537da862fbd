"""Functions that notebooks written for Mitsuba call, and that have little to do here."""

from __future__ import annotations

from ._errors import UsageError
from ._parameters import Parameters
from ._scenes import Scene


def set_variant(*variants: str) -> None:
    """Accepts the names of Mitsuba's variants and does nothing, because Etendue always renders in RGB. Raises
    UsageError if none of them is an RGB variant."""
    if variants and not any(variant.endswith("rgb") for variant in variants):
        raise UsageError(f"There is no variant {variants[0]!r}: Etendue renders in RGB; choose one that ends in _rgb.")


def traverse(scene: Scene) -> Parameters:
    """Returns ``scene.parameters``. The names are Etendue's; a KeyError suggests the nearest one. update() may be
    called with changes or without arguments."""
    return scene.parameters
