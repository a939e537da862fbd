"""The parameters of a scene, which can be changed by name."""

from __future__ import annotations

import difflib
from typing import Any, Iterator, MutableMapping

import numpy as np

from . import _core


class Parameters(MutableMapping[str, Any]):
    """The numbers of a scene by name, as NumPy arrays and Python numbers; see Scene.parameters."""

    def __init__(self, core: _core.Scene):
        self._core = core

    def __getitem__(self, name: str) -> Any:
        found = _core.get_parameter(self._core, name)
        if found is None:
            raise KeyError(self._complaint(name))
        return found

    def __setitem__(self, name: str, value: Any) -> None:
        if not isinstance(value, (bool, int, float)):
            value = np.asarray(getattr(value, "matrix", value))
            rows = value.ndim == 2 and value.shape != (4, 4)
            value = np.ascontiguousarray(value, np.float64) if rows else value.ravel().tolist() if value.ndim else value.item()
        if not _core.set_parameter(self._core, name, value):
            raise KeyError(self._complaint(name))

    def __delitem__(self, name: str) -> None:
        raise TypeError("the parameters of a scene can be changed, but not removed")

    def __iter__(self) -> Iterator[str]:
        return iter(_core.parameter_names(self._core))

    def __len__(self) -> int:
        return len(_core.parameter_names(self._core))

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {value.shape if getattr(value, 'ndim', 0) == 2 else value}" for name, value in self.items())

    def _complaint(self, name: str) -> str:
        close = difflib.get_close_matches(name, list(self), n=1, cutoff=0.3)
        return f"the scene has no parameter {name!r}" + (f"; did you mean {close[0]!r}?" if close else "")
