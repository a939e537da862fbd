"""Rendering."""

from __future__ import annotations

import os
from typing import Callable, Iterator, NamedTuple, Optional, Sequence, Union, cast

from . import _core, _notebook
from ._errors import Interrupted, UsageError
from ._images import Film, PathLike
from ._scenes import Scene, load_file

ProgressCallback = Callable[[int, int], object]


class Device(NamedTuple):
    """A Vulkan device of this machine."""

    number: int
    name: str
    type: str  # "discrete GPU", "CPU", …
    driver: str
    missing: str  # why it cannot render; "" if it can

    @property
    def usable(self) -> bool:
        return not self.missing


def devices() -> list[Device]:
    """All Vulkan devices, in the order of their numbers. Raises DeviceError if there is no Vulkan loader."""
    return [Device(number, *facts) for number, facts in enumerate(_core.devices())]


class Progressive(Iterator[Film]):
    """A render in steps: an iterator over films with more and more samples. Devices stay open between steps, and each
    film is identical, byte for byte, to the result of render() with as many samples.

    The scene cannot be changed until the render ends or is closed; a ``with`` block closes it. In a notebook, the
    picture is shown while it renders.
    """

    def __init__(self, render: _core.Render, step: Optional[int], show: bool, progress: Optional[ProgressCallback]):
        self._render: Optional[_core.Render] = render
        self._step = step
        self._next = step or 1
        self._view = _notebook.LiveView() if show else None
        self._progress = progress
        self._film: Optional[Film] = None  # after the render has ended

    def __iter__(self) -> Progressive:
        return self

    def __next__(self) -> Film:
        if self._render is None:
            raise StopIteration
        film = _advance(self._render, self._next, self._told)
        done, total, end = self._render.done, self._render.total, self._render.end
        self._next = done + self._step if self._step else 2 * done
        if done >= total or end != "complete":
            self.close()
        if self._view is not None:
            self._view.show(film, total)
        return film

    @property
    def film(self) -> Optional[Film]:
        """The samples rendered so far, also after Ctrl-C; None before the first one."""
        return self._film if self._render is None else _film_of(self._render)

    def close(self) -> None:
        """Ends the render and releases the devices and the scene; ``film`` remains available."""
        if self._render is not None:
            self._film = _film_of(self._render)
            self._render.close()
            self._render = None

    def __enter__(self) -> Progressive:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _told(self, done: int, total: int) -> None:
        if self._view is not None:
            self._view.tell(done, total)
        if self._progress is not None:
            self._progress(done, total)


def render(
    scene: Union[Scene, PathLike],
    *,
    spp: Optional[int] = None,
    seed: int = 0,
    device: Union[str, int] = "auto",
    aovs: Optional[Sequence[str]] = None,
    samples: Optional[tuple[int, int]] = None,
    time: Optional[float] = None,
    until_error: Optional[float] = None,
    start: Optional[Film] = None,
    checkpoint: PathLike = "",
    checkpoint_every: float = 60.0,
    max_wait: Optional[float] = None,
    progress: Optional[ProgressCallback] = None,
) -> Film:
    """Renders a scene or a scene file. The film has ``mean``, ``standard_error`` and ``aovs``.

    spp          samples per pixel; by default, the scene's. The sobol sampler renders whole sets.
    device       "auto"; the number of a device or a part of its name; "0,1" or "all" for several that share the work;
                 "reference" for the double-precision renderer on the CPU
    aovs         names of the AOVs to render (docs/aovs.md), in place of ``scene.aovs``
    samples      (begin, end): only this range of samples, for films to be merged
    time         time limit in seconds
    until_error  stop once ``relative_error`` is at most this, and rare bright samples are unlikely to change it
    start        a film of the same render to continue
    checkpoint   film file for the samples so far, written every ``checkpoint_every`` seconds
    max_wait     seconds after which a device that does not answer counts as hanging
    progress     function called some twenty times per second with the number of samples done and of all samples, over
                 all pixels

    With the same scene, seed and kind of device, the bytes are those of ``etendue render``, however often the render
    was stopped. The GIL is released meanwhile. Ctrl-C ends the render after the current dispatch (half a second at
    most) and raises Interrupted, a KeyboardInterrupt whose ``film`` holds the samples rendered so far. Raises
    UsageError, SceneError, DeviceError, DeviceLostError, FileError.
    """
    opened = _open(scene, spp, seed, device, aovs, samples, time, until_error, start, checkpoint, checkpoint_every, max_wait)
    try:
        return _advance(opened, 0, progress)
    finally:
        opened.close()  # now, not when the last exception that refers to this frame is deleted


def progressive(
    scene: Union[Scene, PathLike],
    *,
    spp: Optional[int] = None,
    step: Optional[int] = None,
    seed: int = 0,
    device: Union[str, int] = "auto",
    aovs: Optional[Sequence[str]] = None,
    time: Optional[float] = None,
    until_error: Optional[float] = None,
    start: Optional[Film] = None,
    max_wait: Optional[float] = None,
    progress: Optional[ProgressCallback] = None,
    show: Optional[bool] = None,
) -> Progressive:
    """Renders step by step::

        for film in et.progressive(scene, spp=1024):
            if film.relative_error < 0.01:
                break

    Films have 1, 2, 4, 8 … samples per pixel, or ``step``, 2 ``step``, 3 ``step`` …. ``show`` displays a live picture;
    the default is to do so in notebooks. Everything else is as for render().
    """
    if step is not None and step < 1:
        raise UsageError(f"step is {step}; it must be at least 1.")
    opened = _open(scene, spp, seed, device, aovs, None, time, until_error, start, "", 60.0, max_wait)
    return Progressive(opened, step, _notebook.in_notebook() if show is None else show, progress)


def _open(
    scene: Union[Scene, PathLike],
    spp: Optional[int],
    seed: int,
    device: Union[str, int],
    aovs: Optional[Sequence[str]],
    samples: Optional[tuple[int, int]],
    time: Optional[float],
    until_error: Optional[float],
    start: Optional[Film],
    checkpoint: PathLike,
    checkpoint_every: float,
    max_wait: Optional[float],
) -> _core.Render:
    if not isinstance(scene, Scene):
        scene = load_file(scene)
    first, count = 0, spp
    if samples is not None:
        first, end = samples
        if not 0 <= first < end:
            raise UsageError(f"samples is ({first}, {end}); a range must begin at 0 or later and end after it begins.")
        if spp is not None and end > spp:
            raise UsageError(f"samples ends at {end}, which is more than spp={spp}.")
        count = end - first
    if count is not None and not 0 < count < 2**32:
        raise UsageError(f"{count} samples per pixel were requested; allowed are 1 to 2^32 - 1.")
    if not 0 <= seed < 2**32:
        raise UsageError(f"seed is {seed}; it must be from 0 to 2^32 - 1.")
    return _core.Render(
        scene._core,
        spp=count or 0,
        first=first,
        seed=seed,
        device=str(device),
        time=time,
        until_error=until_error,
        max_wait=max_wait,
        checkpoint=os.fspath(checkpoint),
        checkpoint_every=checkpoint_every,
        start=None if start is None else start._picture,
        aovs=None if aovs is None else [aovs] if isinstance(aovs, str) else list(aovs),
    )


def _advance(render: _core.Render, samples: int, progress: Optional[ProgressCallback]) -> Film:
    """Renders until there are this many samples, or all for 0; raises what was raised meanwhile, keeping the film."""
    try:
        raised = cast(Optional[BaseException], render.advance(samples, progress))
        film = _film_of(render)
    except KeyboardInterrupt as stop:  # raised just before or after the call
        raise Interrupted(_film_of(render)) from stop
    if isinstance(raised, KeyboardInterrupt):
        raise Interrupted(film) from raised
    if raised is not None:
        raise raised
    assert film is not None
    return film


def _film_of(render: _core.Render) -> Optional[Film]:
    picture = render.picture
    return None if picture is None else Film(picture)
