"""What the tests of the Python module share: small scenes, and the command line to hold the module against."""

import os
import pathlib
import subprocess

import pytest

import etendue as et

SOURCES = pathlib.Path(os.environ["ETENDUE_SOURCES"])
PROGRAM = os.environ["ETENDUE_PROGRAM"]

BOX = {"camera.width": 40, "camera.height": 30, "sampler.sampleCount": 4}


@pytest.fixture
def box() -> et.Scene:
    """A Cornell box of 40 x 30 pixels and 4 samples."""
    return et.load_file(SOURCES / "scenes/cbox-sphere.xml", overrides=BOX)


@pytest.fixture
def etendue(tmp_path):
    """Runs the program in a folder of its own; returns what it prints."""

    def run(*arguments: object) -> str:
        words = [PROGRAM, *map(str, arguments)]
        return subprocess.run(words, cwd=tmp_path, check=True, capture_output=True, text=True).stdout

    return run


@pytest.fixture
def box_arguments():
    """The box for the command line."""
    return [SOURCES / "scenes/cbox-sphere.xml", *(word for name, value in BOX.items() for word in ("-D", f"{name}={value}"))]
