"""The exceptions, one for each kind of error; the text of each is a sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Optional

if TYPE_CHECKING:
    from ._images import Film


class Problem(NamedTuple):
    """A finding of a reader. ``line`` and ``column`` count from 1; 0 where they are not known."""

    severity: str  # "error", "warning" or "note"
    message: str
    file: str
    line: int
    column: int

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part)
        return f"{place}: {self.message}" if place else self.message


class Error(Exception):
    """Any error of Etendue. The text is one sentence: where, what, the number, and what would be right.

    ``file``, ``line`` and ``column`` (from 1) are those of the first problem in a file, otherwise None.
    ``problems`` lists everything that a reader found in one pass, including warnings.
    """

    _has_place = True

    def __init__(self, message: str, problems: tuple[Problem, ...] = ()):
        super().__init__(message)
        self.problems = problems
        first = next((p for p in problems if p.severity == "error"), None) if self._has_place else None
        self.file: Optional[str] = (first.file or None) if first else None
        self.line: Optional[int] = (first.line or None) if first else None
        self.column: Optional[int] = (first.column or None) if first else None


class UsageError(Error, ValueError):
    """An argument is wrong."""

    _has_place = False


class SceneError(Error, ValueError):
    """A scene or mesh contains an error, or cannot be opened."""


class DeviceError(Error, RuntimeError):
    """No suitable Vulkan device."""


class DeviceLostError(DeviceError):
    """A device was lost, hangs, or ran out of memory."""


class FileError(Error, OSError):
    """A file cannot be read or written."""


class ComparisonError(Error):
    """Results differ from the expected ones."""


class InternalError(Error, RuntimeError):
    """An error in Etendue itself; please report it."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a render. ``film`` holds the samples rendered so far; None if there are none."""

    def __init__(self, film: Optional[Film]):
        done = f"{film.spp} samples per pixel are kept in .film" if film is not None else "no sample was finished"
        super().__init__(f"interrupted; {done}")
        self.film = film


_CLASSES: dict[str, type[Error]] = {
    "usage": UsageError,
    "scene": SceneError,
    "device": DeviceError,
    "lost": DeviceLostError,
    "file": FileError,
    "comparison": ComparisonError,
}


def error_of(kind: str, message: str, findings: list[tuple[str, str, str, int, int]]) -> Error:
    """The exception for an error of the library; called by the compiled module."""
    return _CLASSES.get(kind, InternalError)(message, tuple(Problem(*finding) for finding in findings))
