"""Pictures and films."""

from __future__ import annotations

import importlib.util
import os
import pathlib
from typing import Any, Iterable, Optional, Union, cast

import numpy as np
import numpy.typing as npt

from . import _core

PathLike = Union[str, "os.PathLike[str]"]
FloatArray = npt.NDArray[np.float32]


class Image(np.lib.mixins.NDArrayOperatorsMixin):
    """A picture: linear Rec. 709 radiance and, if known, its standard error.

    NumPy functions accept it in place of the array ``mean``, and notebooks display it. All arrays are read-only views
    of the picture, without a copy; the top row comes first.
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
        """Makes a picture from arrays, which are copied: ``mean`` and ``standard_error`` of shape (height, width, 3),
        ``sample_count`` of shape (height, width). Grey arrays of shape (height, width) become colour. Raises UsageError
        for other shapes."""
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
        """float32 array of shape (height, width, 3): the mean of the samples."""
        return self._picture.mean

    @property
    def standard_error(self) -> Optional[FloatArray]:
        """float32 array of shape (height, width, 3): the standard error of the mean, infinite with fewer than two
        samples; None if unknown."""
        return self._picture.standard_error

    @property
    def sample_count(self) -> Optional[npt.NDArray[np.uint32]]:
        """uint32 array of shape (height, width): the number of samples in the mean, or with the sobol sampler of sets
        of samples; None if unknown."""
        return cast("Optional[npt.NDArray[np.uint32]]", self._picture.sample_count)

    @property
    def aovs(self) -> dict[str, npt.NDArray[Any]]:
        """The AOVs by name (docs/aovs.md), arrays of shape (height, width) for one number per pixel, otherwise (height,
        width, n). They are float32, or uint32 for the numbers of objects."""
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
        """Scene, device, seed and more, as in the file's header (docs/image_files.md)."""
        return self._picture.metadata

    @property
    def relative_error(self) -> float:
        """Root mean square of the standard error divided by the mean pixel value: the noise as a fraction of the
        brightness. Infinite if unknown."""
        if self.standard_error is None:
            return float("inf")
        brightness = float(np.mean(self.mean, dtype=np.float64))
        if brightness == 0:
            return float("inf")
        return float(np.sqrt(np.mean(np.square(self.standard_error, dtype=np.float64)))) / brightness

    def write(self, path: PathLike, *, tonemap: str = "none", exposure: float = 0.0) -> None:
        """Writes an ``.exr`` file (float32 radiance, standard error, AOVs, metadata) or a ``.png`` file (8-bit sRGB,
        after ``exposure``, in stops, and ``tonemap``: "none", "reinhard" or "aces"). The file is written completely or
        not at all. Raises FileError."""
        self._picture.write(os.fspath(path), film=False, tonemap=tonemap, exposure=exposure)

    def png(self, *, tonemap: str = "none", exposure: float = 0.0) -> bytes:
        """The bytes of the ``.png`` file that write() would write."""
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
    """A picture with the exact sums of its samples. Films of one render can be merged, and a render can be continued
    from a film. render() and read_film() return films."""

    @property
    def samples(self) -> list[tuple[int, int]]:
        """Half-open ranges of the sample indices in the film, sorted; with the sobol sampler, indices count sets of
        samples."""
        return self._picture.samples

    @property
    def spp(self) -> int:
        """Samples per pixel."""
        sets = sum(end - begin for begin, end in self.samples)
        return sets * int(self.metadata.get("sampler", "setSize=1").partition("setSize=")[2] or 1)

    @property
    def rejected(self) -> int:
        """Number of samples left out because they were not finite or too large."""
        return self._picture.rejected

    def write_film(self, path: PathLike) -> None:
        """Writes the film with its exact sums, as an ``.exr`` file for ``etendue merge`` and ``--resume`` that any
        viewer can show. Raises FileError."""
        self._picture.write(os.fspath(path), film=True, tonemap="none", exposure=0.0)

    def __repr__(self) -> str:
        return f"<etendue.Film {self.width}x{self.height}, {self.spp} spp>"


def read_image(path: PathLike) -> Image:
    """Reads an ``.exr`` or ``.png`` file from any program; sRGB is decoded to linear. Raises FileError."""
    return Image(_core.read_picture(os.fspath(path), film=False))


def read_film(path: PathLike) -> Film:
    """Reads a film file with its exact sums. Raises FileError for any other file."""
    return Film(_core.read_picture(os.fspath(path), film=True))


def merge(films: Iterable[Union[Film, PathLike]]) -> Film:
    """Merges films, or film files: the result is identical, byte for byte, to a single render of all their samples.
    Raises FileError if the films come from different renders or share samples, UsageError if there are none."""
    pictures = [film if isinstance(film, Film) else read_film(film) for film in films]
    return Film(_core.merge([film._picture for film in pictures]))


def denoise(picture: Union[Image, PathLike], *, library: PathLike = "") -> Image:
    """Removes the noise from a picture, EXR file or film file, using Open Image Denoise.

    The AOVs "albedo" and "normal" guide it if the picture has them: ``et.render(scene, aovs=["albedo", "normal"])``. A
    denoised picture has neither standard error nor sample count; its metadata say that it was denoised, and compare()
    reports distances without any test. ``library`` is the path of the library's file; by default it is the one that the
    environment variable ETENDUE_OIDN names, that of the package pyoidn if this Python has it, or the system's. Raises
    FileError if the library is missing, saying how to get it, and if the picture is denoised already.
    """
    noisy = picture._picture if isinstance(picture, Image) else _core.read_noisy_picture(os.fspath(picture))
    path = os.fspath(library) or os.environ.get("ETENDUE_OIDN") or _library_of_pyoidn()
    return Image(_core.denoise(noisy, path))


def _library_of_pyoidn() -> str:
    """The file in the package pyoidn, which is not imported for it; "" if there is none."""
    package = importlib.util.find_spec("pyoidn")
    for folder in (package and package.submodule_search_locations) or []:
        file = pathlib.Path(folder, "oidn", "lib", "libOpenImageDenoise.so.2")
        if file.is_file():
            return str(file)
    return ""


def _colors(values: npt.ArrayLike) -> FloatArray:
    array = np.asarray(values, np.float32)
    if array.ndim == 2:
        array = np.repeat(array[:, :, np.newaxis], 3, axis=2)
    if array.ndim != 3 or array.shape[2] != 3:
        from ._errors import UsageError

        raise UsageError(f"A picture must have shape (height, width, 3) or (height, width), not {array.shape}.")
    return np.ascontiguousarray(array)
