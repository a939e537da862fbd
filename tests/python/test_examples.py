"""The examples run: the tutorial in a kernel of its own, as a person would run it, and the fit of a material."""

import base64
import os
import re
import subprocess
import sys

import nbclient
import nbformat
import pytest

from conftest import SOURCES

FOLDER = SOURCES / "examples/python"


@pytest.fixture(scope="module")
def tutorial():
    """The notebook with its outputs. An error in a cell is an error here."""
    notebook = nbformat.read(FOLDER / "tutorial.ipynb", as_version=4)
    nbformat.validate(notebook)
    nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(FOLDER)}}).execute()
    return notebook


def outputs(notebook, beginning):
    """Those of the cell that begins like this."""
    return next(cell.outputs for cell in notebook.cells if cell.source.startswith(beginning))


def test_films_show_themselves(tutorial):
    shown = outputs(tutorial, "film = et.render(scene, spp=16)")[-1].data
    assert base64.b64decode(shown["image/png"]).startswith(b"\x89PNG")
    assert "160x120, 16 spp" in shown["text/plain"]


def test_progressive_renders_show_themselves(tutorial):
    live = [output for output in outputs(tutorial, "films = et.progressive") if "text/html" in output.get("data", {})]
    assert len(live) == 1, "one output that is replaced, not one for each step"
    page = live[0].data["text/html"]
    picture = re.search('base64,([^"]*)"', page).group(1)
    assert base64.b64decode(picture).startswith(b"\x89PNG")
    assert re.search(r"\d+ of 128 spp, error [\d.]+ %", page)


def test_the_tutorial_is_kept_without_outputs():
    notebook = nbformat.read(FOLDER / "tutorial.ipynb", as_version=4)
    assert all(not cell.outputs and cell.execution_count is None for cell in notebook.cells if cell.cell_type == "code")


def test_a_material_is_found():
    said = subprocess.run([sys.executable, FOLDER / "fit_material.py"], check=True, capture_output=True, text=True, env=os.environ).stdout
    found = [tuple(map(float, pair)) for pair in re.findall(r"(\d\.\d+) ± (\d\.\d+)", said)]
    truth = [float(number) for number in re.search("it was(.*)", said).group(1).split(",")]
    assert len(found) == len(truth) == 3
    for (color, error), true in zip(found, truth):
        # Of three components, with this seed: 5 standard errors, and those are small.
        assert abs(color - true) < 5 * error and error < 0.003
