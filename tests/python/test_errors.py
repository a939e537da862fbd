"""Errors: a class for each kind, with the place in the file."""

import logging

import pytest

import etendue as et
from conftest import SOURCES


def test_place(tmp_path):
    scene = tmp_path / "wrong.xml"
    text = (SOURCES / "scenes/cbox-sphere.xml").read_text().replace("meshes/", f"{SOURCES}/scenes/meshes/")
    lines = text.splitlines()
    line = next(number for number, words in enumerate(lines, 1) if '<float name="fov"' in words)
    lines[line - 1] = '    <float name="fov" value="wide"/> <bogus/>'
    scene.write_text("\n".join(lines))
    with pytest.raises(et.SceneError) as caught:
        et.load_file(scene)
    error = caught.value
    assert (error.file, error.line) == (str(scene), line) and error.column in (30, 38)
    assert str(error).startswith(f"{scene}:{line}:")
    found = [problem for problem in error.problems if problem.severity == "error"]
    assert {problem.column for problem in found} == {30, 38} and {problem.line for problem in found} == {line}
    assert any("wide" in problem.message for problem in found) and any("bogus" in problem.message for problem in found)
    assert isinstance(error, et.Error) and isinstance(error, ValueError)


def test_kinds(box, tmp_path):
    with pytest.raises(et.SceneError, match="cannot open the file"):
        et.load_file(tmp_path / "missing.xml")
    with pytest.raises(OSError):
        et.read_film(SOURCES / "README.md")
    with pytest.raises(et.UsageError, match="camera.bogus") as caught:
        et.load_file(SOURCES / "scenes/cbox-sphere.xml", overrides={"camera.bogus": 1})
    assert caught.value.file is None
    with pytest.raises(et.DeviceError, match="no such"):
        et.render(box, spp=1, device="no such device")
    with pytest.raises(et.UsageError, match="samples"):
        et.render(box, samples=(4, 4))
    with pytest.raises(et.UsageError, match="depht"):
        box.aovs = ["depht"]
    with pytest.raises(et.UsageError, match="no film"):
        et.Image.from_arrays([[0.5]])._picture.write("picture.exr", film=True, tonemap="none", exposure=0.0)
    with pytest.raises(et.UsageError, match="neither in .exr nor in .png"):
        et.render(box, spp=1).write(tmp_path / "picture.jpg")
    with pytest.raises(et.FileError):
        et.render(box, spp=1).write(tmp_path / "no folder" / "picture.exr")
    with pytest.raises(et.SceneError, match="ttest"):
        et.load_file(SOURCES / "scenes/ttest-direct.xml")


def test_warnings_are_logged(tmp_path, caplog):
    scene = tmp_path / "scene.xml"
    text = (SOURCES / "scenes/cbox-sphere.xml").read_text().replace("meshes/", f"{SOURCES}/scenes/meshes/")
    scene.write_text(text.replace("</scene>", '<string name="colour" value="x"/></scene>'))
    with caplog.at_level(logging.WARNING, "etendue"):
        read = et.load_file(scene)
    assert any("colour" in record.message for record in caplog.records)
    assert any("colour" in str(problem) and problem.line > 0 for problem in read.problems)


def test_an_impossible_scene_is_an_error(box):
    box.size = (0, 3)
    with pytest.raises(et.SceneError, match="0 × 3"):
        et.render(box, spp=1)
