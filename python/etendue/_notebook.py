"""The live view of a progressive render in a notebook."""

from __future__ import annotations

import base64
import html
import importlib
import sys
import time
from typing import Any, Optional

from ._images import Film


def in_notebook() -> bool:
    """Whether this runs in a Jupyter kernel; does not import anything."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and getattr(shell, "kernel", None) is not None


class LiveView:
    """An output cell, updated in place, with the picture so far and the progress."""

    _SECONDS_BETWEEN = 0.25

    def __init__(self) -> None:
        self._handle: Optional[Any] = None
        self._picture = ""
        self._caption = ""
        self._told = 0.0
        self._started = time.monotonic()

    def show(self, film: Film, total: int) -> None:
        """Shows the film of a step; `total` is the final number of samples per pixel."""
        data = base64.b64encode(film.png()).decode("ascii")
        self._picture = f'<img alt="render" src="data:image/png;base64,{data}" style="max-width: 100%"/>'
        error = film.relative_error
        noise = f", error {100 * error:.2g} %" if error < float("inf") else ""
        seconds = time.monotonic() - self._started
        self._caption = f"{film.spp} of {total} spp{noise}, {seconds:.1f} s"
        self._update("")

    def tell(self, done: int, total: int) -> None:
        """Shows the progress between steps, in samples of all pixels."""
        now = time.monotonic()
        if now - self._told >= self._SECONDS_BETWEEN:
            self._told = now
            self._update(f" · {100 * done / total:.0f} %")

    def _update(self, more: str) -> None:
        ipython: Any = importlib.import_module("IPython.display")
        caption = html.escape(self._caption + more)
        page = ipython.HTML(f"<figure style='margin: 0'>{self._picture}<figcaption>{caption}</figcaption></figure>")
        if self._handle is None:
            self._handle = ipython.display(page, display_id=True)
        else:
            self._handle.update(page)
