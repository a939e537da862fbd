"""Scenes as dictionaries, in the form accepted by Mitsuba's load_dict."""

from __future__ import annotations

import os
from typing import Any, Mapping, Optional

import numpy as np

from . import _core
from ._errors import UsageError
from ._images import Image
from ._scenes import Scene

_DEEPEST = 32
_MESH_ARRAYS = ("positions", "triangles", "normals", "uvs", "colors")


def load_dict(dictionary: Mapping[str, Any], *, strict: bool = False, approximate: bool = False) -> Scene:
    """Builds a scene from nested dictionaries, as Mitsuba's load_dict does; docs/mitsuba.md lists the names::

        et.load_dict({
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 8},
            "sensor": {"type": "perspective", "fov": 40, "to_world": et.Transform4f().look_at([0, 1, 6], [0, 1, 0], [0, 1, 0])},
            "white": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.8, 0.8]}},
            "ball": {"type": "sphere", "bsdf": {"type": "ref", "id": "white"}},
            "lamp": {"type": "constant"},
        })

    Values are numbers, strings, lists of numbers, transforms or matrices of shape (4, 4), and dictionaries. In addition
    to Mitsuba's types there is {"type": "mesh", "positions": (n, 3), "triangles": (m, 3)}, optionally with "normals"
    (n, 3), "uvs" (n, 2) and "colors" (n, 3) of its vertices. Textures and environments may have a "bitmap" or "data" in
    place of a "filename": an array of shape (height, width) or (height, width, channels), either uint8 (sRGB codes) or
    floating-point (linear).

    ``strict`` and ``approximate`` are those of load_file(). Raises SceneError; its ``file`` is a path of names, such as
    "dict:/ball/bsdf".
    """
    return Scene(_core.read_objects(_object(dictionary, "dict:", 0), strict=strict, approximate=approximate))


def _object(dictionary: Mapping[str, Any], place: str, depth: int) -> _core.SceneObject:
    if not isinstance(dictionary.get("type"), str):
        raise UsageError(f'{place}: an object needs a "type", a string.')
    if depth > _DEEPEST:
        raise UsageError(f"{place}: objects are nested more than {_DEEPEST} levels deep; does one contain itself?")
    made = _core.SceneObject()
    made.type = dictionary["type"]
    for name, value in dictionary.items():
        if name == "type" or (made.type == "mesh" and name in _MESH_ARRAYS):
            continue
        _add(made, name, value, f"{place}/{name}", depth)
    if made.type == "mesh":
        _set_mesh(made, dictionary, place)
    return made


def _add(made: _core.SceneObject, name: str, value: Any, place: str, depth: int) -> None:
    if isinstance(value, Mapping):
        made.add_object(name, _object(value, place, depth + 1))
    elif isinstance(value, (bool, np.bool_)):
        made.add_bool(name, bool(value))
    elif isinstance(value, (int, np.integer)):
        made.add_int(name, int(value))
    elif isinstance(value, (float, np.floating)):
        made.add_float(name, float(value))
    elif isinstance(value, (str, os.PathLike)):
        made.add_text(name, os.fspath(value))
    elif name in ("bitmap", "data"):
        _set_bitmap(made, value, place)
    elif made.type == "spectrum" and name == "value":
        made.add_text(name, _spectrum(value, place))
    else:
        _add_numbers(made, name, value, place)


def _add_numbers(made: _core.SceneObject, name: str, value: Any, place: str) -> None:
    try:
        numbers = np.asarray(getattr(value, "matrix", value), np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"{place}: a {type(value).__name__} cannot be a value in a scene; give a number, a string, "
            "a list of numbers, a 4 x 4 matrix or a dictionary."
        ) from error
    if numbers.shape == (4, 4):
        made.add_matrix(name, np.ascontiguousarray(numbers))
    elif numbers.shape == (3, 3):  # a texture's transform: x, y and translation
        matrix = np.eye(4)
        matrix[:2, :2], matrix[:2, 3] = numbers[:2, :2], numbers[:2, 2]
        made.add_matrix(name, matrix)
    elif numbers.ndim == 1:
        made.add_numbers(name, numbers.tolist())
    elif numbers.ndim == 0:
        made.add_float(name, float(numbers))
    else:
        raise UsageError(f"{place}: an array of shape {numbers.shape} is neither a list nor a 4 x 4 matrix.")


def _spectrum(value: Any, place: str) -> str:
    """Formats pairs of wavelength, in nanometres, and value."""
    pairs = np.asarray(value, np.float64)
    if pairs.ndim != 2 or pairs.shape[1] != 2:
        raise UsageError(f"{place}: a spectrum is a number or a list of (wavelength, value); this has shape {pairs.shape}.")
    return ", ".join(f"{wavelength!r}:{number!r}" for wavelength, number in pairs.tolist())


def _set_mesh(made: _core.SceneObject, dictionary: Mapping[str, Any], place: str) -> None:
    def rows(name: str, columns: int, dtype: Any) -> Optional[Any]:
        if dictionary.get(name) is None:
            return None
        array = np.asarray(dictionary[name])
        if array.ndim != 2 or array.shape[1] != columns:
            raise UsageError(f"{place}/{name}: the array has shape {array.shape}; it must be (n, {columns}).")
        if dtype is np.uint32 and (array.dtype.kind not in "iu" or (array.size and (array.min() < 0 or array.max() >= 2**32))):
            raise UsageError(f"{place}/{name}: the array has type {array.dtype}; indices must be integers from 0 on.")
        return np.ascontiguousarray(array, dtype)

    positions, triangles = rows("positions", 3, np.float64), rows("triangles", 3, np.uint32)
    if positions is None or triangles is None:
        raise UsageError(f'{place}: a mesh needs "positions" of shape (n, 3) and "triangles" of shape (m, 3).')
    made.set_mesh(positions, triangles, rows("normals", 3, np.float64), rows("uvs", 2, np.float32), rows("colors", 3, np.float32))


def _set_bitmap(made: _core.SceneObject, value: Any, place: str) -> None:
    array = value.mean if isinstance(value, Image) else np.asarray(value)
    if array.ndim == 2:
        array = array[:, :, np.newaxis]
    if array.ndim != 3 or not 1 <= array.shape[2] <= 4 or 0 in array.shape:
        raise UsageError(
            f"{place}: the array has shape {array.shape}; it must be (height, width) or (height, width, 1 to 4)."
        )
    codes = array.dtype == np.uint8
    if not codes and array.dtype.kind != "f":
        raise UsageError(
            f"{place}: the array has type {array.dtype}; it must be uint8 (sRGB codes) or floating-point (linear)."
        )
    data = np.ascontiguousarray(array, np.uint8 if codes else np.float32)
    made.set_bitmap(data.tobytes(), array.shape[1], array.shape[0], array.shape[2], codes)
