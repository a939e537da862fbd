"""What load_file takes beside a file's name."""

import sys

import numpy as np
import pytest

import etendue as et
from conftest import SOURCES

sys.path.insert(0, str(SOURCES / "tests/cli"))
from moving_assets import Asset  # noqa: E402


@pytest.fixture
def asset(tmp_path):
    moving = Asset()
    moving.tree["scenes"].append({"name": "empty", "nodes": [1]})
    moving.tree["scene"] = 0
    moving.tree["nodes"][1]["name"] = "eye"
    moving.channel(0, "translation", [0, 2], [0, 0, 0, 4, 0, 0], name="walk")
    moving.channel(0, "translation", [0, 2], [0, 0, 0, 0, 6, 0], animation=1, name="jump")
    moving.write(tmp_path / "asset.gltf")
    return tmp_path / "asset.gltf"


def place(scene: et.Scene) -> list[float]:
    name = next(name for name in scene.parameters if name.startswith("instances.") and name.endswith(".to_world"))
    return list(np.round(scene.parameters[name][:3, 3], 6))


def test_times_and_animations(asset):
    assert place(et.load_file(asset, at=1, animation="walk")) == [2, 0, 0]
    assert place(et.load_file(asset, at=0.5, animation="walk")) == [1, 0, 0]
    assert place(et.load_file(asset, at=1, animation=1)) == [0, 3, 0]
    assert place(et.load_file(asset)) == [5, 6, 7], "as the file stands"
    with pytest.raises(et.UsageError, match="jump"):
        et.load_file(asset, at=1, animation="hop")


def test_cameras_of_scenes_at_a_time():
    turntable = SOURCES / "scenes/cameras/turntable.xml"
    first, later = et.load_file(turntable, at=0), et.load_file(turntable, at=1.0)
    assert not np.allclose(first.parameters["camera.to_world"], later.parameters["camera.to_world"])
    assert np.allclose(first.parameters["camera.to_world"], et.load_file(turntable).parameters["camera.to_world"])


def test_scenes_and_cameras(asset):
    placed = et.load_file(asset, camera=(0, 0, 9, 0, 0, 0, 40))
    assert list(placed.parameters["camera.to_world"][:3, 3]) == [0, 0, 9]
    assert placed.parameters["camera.fov"] == 40
    assert list(et.load_file(asset, camera=0).parameters["camera.to_world"][:3, 3]) == [0, 0, 4]
    assert list(et.load_file(asset, camera="eye").parameters["camera.to_world"][:3, 3]) == [0, 0, 4]


def test_what_is_approximated(tmp_path):
    foreign = tmp_path / "foreign.xml"
    foreign.write_text('<scene version="3.0.0"><integrator type="path"/><sensor type="perspective"/><shape type="sphere"><bsdf type="hair"/></shape><emitter type="constant"/></scene>')
    with pytest.raises(et.SceneError, match="hair"):
        et.load_file(foreign)
    scene = et.load_file(foreign, approximate=True)
    assert scene.approximations and any("hair" in problem.message for problem in scene.problems)
