"""Tests whether pictures are right, by comparing them with each other and with theory."""

from __future__ import annotations

import json
import os
from typing import Any, Mapping, Optional, Union

import numpy.typing as npt

from . import _core
from ._images import Image, PathLike, read_image
from ._scenes import text_of


class Report:
    """A verdict: ``passed``, all numbers in ``details``, and in ``text`` what the command line prints."""

    def __init__(self, details: dict[str, Any], text: str, passed: bool):
        self.details = details
        self.text = text
        self.passed = passed

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return self.text


class Comparison(Report):
    """How much two pictures differ, and whether chance explains it."""

    @property
    def verdict(self) -> str:
        """"identical", "rounding only", "statistically equal", "different" or "untested"."""
        return str(self.details["verdict"])

    @property
    def metrics(self) -> dict[str, Any]:
        """Distances by name: mse, rmse, relmse, mae, psnr, ssim, flip …"""
        return dict(self.details["metrics"])


def compare(
    test: Union[Image, PathLike, npt.ArrayLike],
    reference: Union[Image, PathLike, npt.ArrayLike],
    *,
    significance: float = 0.01,
    at_most: Optional[Mapping[str, float]] = None,
    at_least: Optional[Mapping[str, float]] = None,
    allow_untested: bool = False,
) -> Comparison:
    """Compares pictures, picture files, or arrays of shape (height, width, 3), as ``etendue compare`` does
    (docs/validation.md). If both have standard errors, statistical tests are made, with the false-alarm rate
    ``significance`` for all together. ``at_most={"flip": 0.05}`` and ``at_least={"ssim": 0.98}`` set limits on metrics.
    Raises UsageError if the pictures cannot be compared, and FileError."""
    test_name, test_image = _named(test, "test")
    reference_name, reference_image = _named(reference, "reference")
    told, text, passed = _core.compare(
        test_image._picture,
        test_name,
        reference_image._picture,
        reference_name,
        significance=significance,
        at_most=[f"{name}={bound!r}" for name, bound in (at_most or {}).items()],
        at_least=[f"{name}={bound!r}" for name, bound in (at_least or {}).items()],
        allow_untested=allow_untested,
    )
    return Comparison(json.loads(told), text, passed)


def ttest(
    path: PathLike,
    *,
    device: Union[str, int] = "auto",
    seed: int = 0,
    samples: Optional[int] = None,
    spp: Optional[int] = None,
    significance: Optional[float] = None,
    allow_untested: bool = False,
    overrides: Optional[Mapping[str, Any]] = None,
) -> Report:
    """Tests mean radiances, or albedos of materials, against known values, as ``etendue ttest`` does. ``path`` is a
    file with a ``<test type="ttest">``. ``samples`` (per scene, over all pixels), ``spp`` and ``significance`` override
    those of the file. Raises SceneError for any other file, and whatever render() raises."""
    told, text, passed = _core.ttest(
        os.fspath(path),
        parameters=[(name, text_of(value)) for name, value in (overrides or {}).items()],
        device=str(device),
        seed=seed,
        samples=samples,
        spp=spp,
        significance=significance,
        allow_untested=allow_untested,
    )
    return Report(json.loads(told), text, passed)


def _named(picture: Union[Image, PathLike, npt.ArrayLike], name: str) -> tuple[str, Image]:
    if isinstance(picture, Image):
        return name, picture
    if isinstance(picture, (str, os.PathLike)):
        return os.fspath(picture), read_image(picture)
    return name, Image.from_arrays(picture)
