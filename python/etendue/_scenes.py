"""Scenes."""

from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Sequence, Union

from . import _core
from ._errors import Problem
from ._images import PathLike
from ._parameters import Parameters


class Scene:
    """A scene to render, made by load_file() or load_dict()."""

    def __init__(self, core: Optional[_core.Scene] = None):
        self._core = core if core is not None else _core.Scene()

    @property
    def name(self) -> str:
        return self._core.name

    @name.setter
    def name(self, name: str) -> None:
        self._core.name = name

    @property
    def file(self) -> str:
        """Path of the file that the scene was read from, as given; "" if none."""
        return self._core.file

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture in pixels."""
        return self._core.size

    @size.setter
    def size(self, size: tuple[int, int]) -> None:
        self._core.size = (int(size[0]), int(size[1]))

    @property
    def spp(self) -> int:
        """Samples per pixel, unless render() is given another number."""
        return self._core.spp

    @spp.setter
    def spp(self, spp: int) -> None:
        self._core.spp = spp

    @property
    def aovs(self) -> list[str]:
        """Names of the AOVs to render: "depth", "normal", "albedo" … (docs/aovs.md)."""
        return self._core.aovs

    @aovs.setter
    def aovs(self, names: Sequence[str]) -> None:
        self._core.aovs = [names] if isinstance(names, str) else list(names)

    @property
    def problems(self) -> list[Problem]:
        """Warnings and notes of the reader."""
        return [Problem(*finding) for finding in self._core.findings]

    @property
    def approximations(self) -> list[str]:
        """Sentences about what the reader replaced by something similar (``approximate=True``)."""
        return self._core.approximations

    @property
    def hash(self) -> int:
        """64-bit hash of everything that can change the picture, except size, seed, samples and integrator."""
        return self._core.hash

    @property
    def primitive_count(self) -> int:
        """Number of triangles and other shapes, counting every instance."""
        return self._core.primitive_count

    @property
    def parameters(self) -> Parameters:
        """The numbers of the scene by name, which can be read and changed::

            scene.parameters["materials.white.albedo"] = (0.8, 0.2, 0.2)

        "camera.…", "sampler.…", "integrator.…" and "sky.…"; "materials.NAME.…" with the parameters of each material
        (for textured ones, the constant factor); "instances.NAME." with "to_world", "radiance" of lamps, and
        "positions" and "normals" (n, 3) of meshes or "center" and "radius" of spheres, which all instances of a shape
        share; "lights.NAME." with "intensity" and "to_world". NAME is the path in the dictionary, or the name or type
        in the file, followed by _2, _3 … if it is not the first.

        Arrays that are read are copies. An unknown name raises KeyError. A value of the wrong type or shape raises
        UsageError, as does a change while the scene is being rendered. A value that is out of range makes render()
        raise SceneError. Changes of camera, sampler and integrator do not require recompiling the scene.
        """
        return Parameters(self._core)

    def copy(self) -> Scene:
        """An independent copy; texture pictures are shared."""
        return Scene(self._core.copy())

    def __repr__(self) -> str:
        width, height = self.size
        return f"<etendue.Scene {self.name!r}: {width}x{height}, {self.primitive_count} primitives>"


def load_file(
    path: PathLike,
    *,
    overrides: Optional[Mapping[str, Any]] = None,
    strict: bool = False,
    approximate: bool = False,
    environment: PathLike = "",
    camera: Union[str, int, Sequence[float]] = "",
    at: Optional[float] = None,
    scene: Union[str, int] = "",
    animation: Union[str, int] = "",
    variant: str = "",
    lamps: str = "auto",
    **parameters: Any,
) -> Scene:
    """Reads a scene in any format that ``etendue render`` accepts: Etendue's, Nori's and Mitsuba's XML, glTF, OBJ, PLY.

    overrides    properties to change: {"integrator.nee": False, "camera.width": 400}
    parameters   values for the parameters of a Mitsuba scene: ``spp=64`` for ``$spp``
    strict       unknown properties are errors
    approximate  whatever a foreign scene uses that does not exist here is replaced by something similar, with a warning
    environment  a latitude-longitude picture that lights the scene in place of its sky
    camera       (x, y, z, x, y, z) of the eye and the point it looks at, optionally with the field of view in degrees;
                 for a glTF asset also the name or number of one of its cameras
    at           the time in seconds at which cameras with keyframes and animations of glTF assets are shown
    scene, animation, variant, lamps   for glTF assets: which scene, which animation (default: all), which material
                 variant, "auto", "blender" or "standard"; scenes and animations by name or number

    Raises SceneError, UsageError or FileError with file, line and column; warnings go to the logger "etendue" and
    into ``problems``.
    """
    given = {**(overrides or {}), **parameters}
    return Scene(
        _core.read_scene(
            os.fspath(path),
            parameters=[(name, text_of(value)) for name, value in given.items()],
            strict=strict,
            approximate=approximate,
            environment=os.fspath(environment),
            camera=text_of(camera),
            at=at,
            scene=str(scene),
            animation=str(animation),
            variant=variant,
            lamps=lamps,
        )
    )


def text_of(value: Any) -> str:
    """A value as it would be written in a scene file."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if hasattr(value, "__len__"):
        return ", ".join(text_of(part) for part in value)
    return repr(float(value)) if isinstance(value, float) else str(value)
