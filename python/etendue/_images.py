"""Pictures and films."""

from __future__ import annotations

import os
from typing import Any, Iterable, Optional, Union, cast

import numpy as np
import numpy.typing as npt

from . import _core

PathLike = Union[str, "os.PathLike[str]"]
FloatArray = npt.NDArray[np.float32]


class Image(np.lib.mixins.NDArrayOperatorsMixin):
    """A picture: linear Rec. 709 radiance with its standard error, where that is known.

    It counts as the array of its mean wherever numpy wants one, and shows itself in notebooks. All arrays are
    read-only views of the picture, without a copy; the top row comes first.
    """

    def __init__(self, picture: _core.Picture):
        self._picture = picture
        self._aovs: Optional[dict[str, npt.NDArray[Any]]] = None

    @classmethod
    def from_arrays(
        cls,
        mean: npt.ArrayLike,
        standard_error: Optional[npt.ArrayLike] = None,
        sample_count: Optional[npt.ArrayLike] = None,
    ) -> Image:
        """A picture of arrays, which are copied: ``mean`` and ``standard_error`` of shape (height, width, 3),
        ``sample_count`` of shape (height, width). Grey (height, width) becomes colour. Raises UsageError for others."""
        return Image(
            _core.Picture.from_arrays(
                _colors(mean),
                None if standard_error is None else _colors(standard_error),
                None if sample_count is None else np.ascontiguousarray(sample_count, np.uint32),
            )
        )

    @property
    def width(self) -> int:
        return self._picture.width

    @property
    def height(self) -> int:
        return self._picture.height

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, 3)"""
        return (self.height, self.width, 3)

    @property
    def dtype(self) -> np.dtype[Any]:
        return np.dtype(np.float32)

    @property
    def mean(self) -> FloatArray:
        """float32 (height, width, 3): mean of the samples."""
        return self._picture.mean

    @property
    def standard_error(self) -> Optional[FloatArray]:
        """float32 (height, width, 3): standard error of the mean, infinite with fewer than two samples; None where it
        is not known."""
        return self._picture.standard_error

    @property
    def sample_count(self) -> Optional[npt.NDArray[np.uint32]]:
        """uint32 (height, width): samples in the mean; with the sobol sampler, sets of samples. None where it is not
        known."""
        return cast("Optional[npt.NDArray[np.uint32]]", self._picture.sample_count)

    @property
    def aovs(self) -> dict[str, npt.NDArray[Any]]:
        """What was rendered beside the picture, by name (docs/aovs.md): (height, width) for one number a pixel, else
        (height, width, n). float32, but uint32 for numbers of things."""
        if self._aovs is None:
            layers: dict[str, list[npt.NDArray[Any]]] = {}
            for name, values in self._picture.channels:
                layers.setdefault("alpha" if name == "A" else name.rpartition(".")[0], []).append(cast("npt.NDArray[Any]", values))
            self._aovs = {
                name: planes[0] if len(planes) == 1 else np.stack(planes, axis=-1) for name, planes in layers.items()
            }
        return self._aovs

    @property
    def metadata(self) -> dict[str, str]:
        """What the picture says about itself: scene, device, seed and more (docs/image_files.md)."""
        return self._picture.metadata

    @property
    def relative_error(self) -> float:
        """Root mean square of the standard error over the mean pixel value: the noise as a fraction of the brightness.
        Infinite while it is not known."""
        if self.standard_error is None:
            return float("inf")
        brightness = float(np.mean(self.mean, dtype=np.float64))
        if brightness == 0:
            return float("inf")
        return float(np.sqrt(np.mean(np.square(self.standard_error, dtype=np.float64)))) / brightness

    def write(self, path: PathLike, *, tonemap: str = "none", exposure: float = 0.0) -> None:
        """Writes ``.exr`` (float32 radiance, standard error, AOVs, metadata) or ``.png`` (8-bit sRGB of what
        ``tonemap``, "none", "reinhard" or "aces", and ``exposure``, in stops, make of it). The file appears whole or
        not at all. Raises FileError."""
        self._picture.write(os.fspath(path), film=False, tonemap=tonemap, exposure=exposure)

    def png(self, *, tonemap: str = "none", exposure: float = 0.0) -> bytes:
        """The bytes of the ``.png`` file."""
        return self._picture.png(tonemap, exposure)

    def _repr_png_(self) -> bytes:
        return self.png()

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> npt.NDArray[Any]:
        if copy is False and dtype is not None and np.dtype(dtype) != np.float32:
            raise ValueError(f"a picture holds float32; {np.dtype(dtype)} needs a copy")
        if copy:
            return np.array(self.mean, dtype=dtype)
        return np.asarray(self.mean, dtype=dtype)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        values = [value.mean if isinstance(value, Image) else value for value in inputs]
        return getattr(ufunc, method)(*values, **kwargs)

    def __getitem__(self, index: Any) -> Any:
        return self.mean[index]

    def __len__(self) -> int:
        return self.height

    def __repr__(self) -> str:
        return f"<etendue.{type(self).__name__} {self.width}x{self.height}>"


class Film(Image):
    """A picture with the exact sums of its samples: films of one render can be merged, and a render can go on from
    one. render() and read_film() give them."""

    @property
    def samples(self) -> list[tuple[int, int]]:
        """Half-open ranges of the sample indices inside, sorted; with the sobol sampler, of sets of samples."""
        return self._picture.samples

    @property
    def spp(self) -> int:
        """Samples of each pixel."""
        sets = sum(end - begin for begin, end in self.samples)
        return sets * int(self.metadata.get("sampler", "setSize=1").partition("setSize=")[2] or 1)

    @property
    def rejected(self) -> int:
        """Samples that were not finite or too large, and were left out."""
        return self._picture.rejected

    def write_film(self, path: PathLike) -> None:
        """Writes the film with its exact sums, an ``.exr`` file that ``etendue merge`` and ``--resume`` take and any
        viewer shows. Raises FileError."""
        self._picture.write(os.fspath(path), film=True, tonemap="none", exposure=0.0)

    def __repr__(self) -> str:
        return f"<etendue.Film {self.width}x{self.height}, {self.spp} spp>"


def read_image(path: PathLike) -> Image:
    """Reads an ``.exr`` or ``.png`` file of any program; sRGB is decoded to linear. Raises FileError."""
    return Image(_core.read_picture(os.fspath(path), film=False))


def read_film(path: PathLike) -> Film:
    """Reads a film file, exact sums and all. Raises FileError for anything else."""
    return Film(_core.read_picture(os.fspath(path), film=True))


def merge(films: Iterable[Union[Film, PathLike]]) -> Film:
    """The film of all samples of these films, or film files: the one that a single render of these samples gives, to
    the byte. Raises FileError for films of different renders or with common samples, UsageError for none."""
    pictures = [film if isinstance(film, Film) else read_film(film) for film in films]
    return Film(_core.merge([film._picture for film in pictures]))


def denoise(picture: Union[Image, PathLike], *, library: PathLike = "") -> Image:
    """The picture, or that of an EXR or film file, without its noise, by Open Image Denoise.

    The AOVs "albedo" and "normal" guide it where the picture has them: ``et.render(scene, aovs=["albedo", "normal"])``.
    A denoised picture has neither standard error nor sample count; its metadata say what it is, and compare() tells
    distances and tests nothing. ``library`` is the file of the library, where it is not the system's: without it the environment
    variable ETENDUE_OIDN names it. Raises FileError that says how to get the library where it is missing, and for a
    picture that is denoised already.
    """
    noisy = picture._picture if isinstance(picture, Image) else _core.read_noisy_picture(os.fspath(picture))
    return Image(_core.denoise(noisy, os.fspath(library)))


def _colors(values: npt.ArrayLike) -> FloatArray:
    array = np.asarray(values, np.float32)
    if array.ndim == 2:
        array = np.repeat(array[:, :, np.newaxis], 3, axis=2)
    if array.ndim != 3 or array.shape[2] != 3:
        from ._errors import UsageError

        raise UsageError(f"A picture has the shape (height, width, 3) or (height, width), not {array.shape}.")
    return np.ascontiguousarray(array)
