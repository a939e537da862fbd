"""The counterpart of Mitsuba's mi.util."""

from __future__ import annotations

from typing import Union

import numpy.typing as npt

from ._images import Image, PathLike

__all__ = ["write_bitmap"]


def write_bitmap(filename: PathLike, data: Union[Image, npt.ArrayLike]) -> None:
    """Writes a picture, or an array of shape (height, width, 3) or (height, width), as ``.exr`` or ``.png``."""
    picture = data if isinstance(data, Image) else Image.from_arrays(data)
    picture.write(filename)
