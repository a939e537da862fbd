"""Ctrl-C: at once, and what was done is kept."""

import os
import signal
import subprocess
import sys
import time

from conftest import SOURCES

RENDER = """
import signal, sys, time
import etendue as et
signal.signal(signal.SIGINT, signal.default_int_handler)
scene = et.load_file(sys.argv[1], overrides={"camera.width": 64, "camera.height": 48})
began = False
def progress(done, total):
    global began
    if not began:
        began = True
        print("rendering", flush=True)
try:
    if sys.argv[2] == "render":
        et.render(scene, spp=100_000_000, progress=progress)
    else:
        films = et.progressive(scene, spp=100_000_000, progress=progress)
        for film in films:
            pass
except KeyboardInterrupt as stop:
    film = stop.film if sys.argv[2] == "render" else films.film  # between steps Python itself raises
    assert film.spp > 0 and film.mean.mean() > 0.1, film
    print("kept", film.spp, flush=True)
"""


def interrupted(way: str) -> tuple[str, float]:
    words = [sys.executable, "-c", RENDER, str(SOURCES / "scenes/cbox-sphere.xml"), way]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=os.environ) as process:
        assert process.stdout.readline() == "rendering\n"
        started = time.monotonic()
        process.send_signal(signal.SIGINT)
        said = process.stdout.read()
        assert process.wait(timeout=60) == 0
        return said, time.monotonic() - started


def test_render():
    said, seconds = interrupted("render")
    assert said.startswith("kept ")
    assert seconds < 15  # a dispatch takes half a second; the rest is for a machine that is busy


def test_progressive():
    said, seconds = interrupted("progressive")
    assert said.startswith("kept ")
    assert seconds < 15
