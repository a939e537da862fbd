"""Pictures of arrays and files, and verdicts about them."""

import ctypes
import ctypes.util
import os
import re
import shutil
import struct

import numpy as np
import pytest

import etendue as et
from conftest import SOURCES


def test_from_arrays():
    values = np.linspace(0, 1, 24, dtype=np.float64).reshape(2, 4, 3)
    picture = et.Image.from_arrays(values, standard_error=0.1 * values, sample_count=np.full((2, 4), 7))
    assert (picture.width, picture.height) == (4, 2)
    assert np.array_equal(picture.mean, values.astype(np.float32))
    assert np.all(picture.sample_count == 7)
    assert np.array_equal(et.Image.from_arrays(values[:, :, 0]).mean[:, :, 2], values[:, :, 0].astype(np.float32))
    for wrong in (np.zeros((2, 2, 4)), np.zeros(3), np.zeros((0, 4, 3))):
        with pytest.raises(et.UsageError):
            et.Image.from_arrays(wrong)
    with pytest.raises(et.UsageError, match="standard error has 2x4"):
        et.Image.from_arrays(values, standard_error=np.zeros((4, 2, 3)))


def test_png():
    picture = et.Image.from_arrays(np.full((3, 5, 3), 0.25))
    data = picture._repr_png_()
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", data[16:24]) == (5, 3)
    assert picture.png(exposure=1) != data
    with pytest.raises(et.UsageError, match="aces"):
        picture.png(tonemap="filmic")


def test_denoise(box, etendue, box_arguments, tmp_path, monkeypatch):
    monkeypatch.setenv("ETENDUE_OIDN", os.environ["ETENDUE_FAKE_OIDN"])
    log = tmp_path / "calls"
    monkeypatch.setenv("FAKE_OIDN_LOG", str(log))
    film = et.render(box, spp=2, aovs=["albedo", "normal"])
    picture = et.denoise(film)
    called = log.read_text()
    assert "image albedo" in called and "image normal" in called and "image color" in called
    assert picture.shape == film.shape and picture.standard_error is None and "denoised" in picture.metadata
    assert film.standard_error is not None, "the film is what it was"
    # What the program makes of the same picture.
    film.write(tmp_path / "noisy.exr")
    etendue("denoise", "noisy.exr", "-o", "program.exr", "-q")
    picture.write(tmp_path / "module.exr")
    assert (tmp_path / "program.exr").read_bytes() == (tmp_path / "module.exr").read_bytes()
    assert np.array_equal(et.denoise(tmp_path / "noisy.exr", library=os.environ["ETENDUE_FAKE_OIDN"]).mean, picture.mean)
    log.unlink()
    et.denoise(et.render(box, spp=2))
    assert "image albedo" not in log.read_text(), "guides are what there is"
    with pytest.raises(et.FileError, match="denoised"):
        et.denoise(picture)
    with pytest.raises(et.FileError, match="pyoidn"):
        et.denoise(film, library=tmp_path / "missing.so")


def test_denoise_finds_pyoidn(box, tmp_path, monkeypatch):
    monkeypatch.delenv("ETENDUE_OIDN", raising=False)
    folder = tmp_path / "pyoidn/oidn/lib"
    folder.mkdir(parents=True)
    (tmp_path / "pyoidn/__init__.py").write_text("raise ImportError('it need not be imported')")
    shutil.copy(os.environ["ETENDUE_FAKE_OIDN"], folder / "libOpenImageDenoise.so.2")
    monkeypatch.syspath_prepend(tmp_path)
    film = et.render(box, spp=1)
    assert np.array_equal(et.denoise(film).mean, 2 * film.mean), "what the stand-in makes of a picture without guides"
    monkeypatch.setenv("ETENDUE_OIDN", str(tmp_path / "missing.so"))
    with pytest.raises(et.FileError, match="missing.so"):
        et.denoise(film)


def denoiser_of_this_machine() -> str:
    """Open Image Denoise itself; "" where there is none."""
    path = os.environ.get("ETENDUE_OIDN") or et._images._library_of_pyoidn() or ctypes.util.find_library("OpenImageDenoise") or ""
    try:
        return ctypes.CDLL(path)._name if path else ""
    except OSError:
        return ""


def test_denoise_takes_noise_away(box, etendue, tmp_path, monkeypatch):
    """With the library of this machine where there is one, with the stand-in elsewhere."""
    real = denoiser_of_this_machine()
    if "/" in real or not real:  # the system's is found by both without a word
        monkeypatch.setenv("ETENDUE_OIDN", real or os.environ["ETENDUE_FAKE_OIDN"])
    film = et.render(box, spp=4, aovs=["albedo", "normal"])
    picture = et.denoise(film)
    assert re.fullmatch(r"Open Image Denoise 2\.\d+\.\d+ guides=albedo,normal", picture.metadata["denoised"])
    if real:
        truth = et.render(box, spp=1024, seed=1)
        noisy, denoised = (et.compare(of, truth, allow_untested=True).metrics["relmse"] for of in (film, picture))
        assert denoised < noisy / 4
    else:
        assert np.allclose(picture.mean, 2 * film.mean + film.aovs["albedo"] + film.aovs["normal"])
    film.write(tmp_path / "noisy.exr")
    etendue("denoise", "noisy.exr", "-o", "program.exr", "-q")
    assert np.array_equal(et.read_image(tmp_path / "program.exr").mean, picture.mean)


def test_compare(box, etendue, box_arguments, tmp_path):
    mis, nee = et.render(box, spp=32), et.render(et.load_file(box.file, overrides={"integrator.mis": False, "camera.width": 40, "camera.height": 30}), spp=32, seed=1)
    comparison = et.compare(nee, mis)
    assert comparison.passed and comparison.verdict == "statistically equal"
    brighter = et.Image.from_arrays(1.5 * mis.mean, mis.standard_error, mis.sample_count)
    assert not et.compare(brighter, mis).passed
    assert et.compare(mis, mis).verdict == "identical"
    # Without standard errors there are distances alone, and bounds.
    assert et.compare(mis.mean, mis.mean + 0.01, at_most={"mae": 0.011}).passed
    assert not et.compare(mis.mean, mis.mean + 0.01, at_most={"mae": 0.009}).passed
    assert et.compare(mis.mean, mis.mean + 0.01, allow_untested=True).metrics["mae"] == pytest.approx(0.01, rel=1e-3)
    nee.write(tmp_path / "nee.exr")
    mis.write(tmp_path / "mis.exr")
    said = etendue("compare", "nee.exr", "mis.exr")
    ours = str(et.compare(tmp_path / "nee.exr", tmp_path / "mis.exr"))
    assert said.splitlines()[1:4] == ours.splitlines()[1:4]
    with pytest.raises(et.UsageError):
        et.compare(mis, mis.mean[:10])


@pytest.fixture
def means(tmp_path):
    """Writes a t-test of the first two scenes of scenes/ttest-direct.xml, with a reference of one's own."""

    def write(reference: float):
        text = (SOURCES / "scenes/ttest-direct.xml").read_text().replace("meshes/", f"{SOURCES}/scenes/meshes/")
        text = re.sub(r'(name="references" value=)"[^"]*"', rf'\1"{reference}, {reference}"', text)
        scenes = text.split("</scene>")
        path = tmp_path / "means.xml"
        path.write_text("</scene>".join(scenes[:2]) + "</scene></test>")
        return path

    return write


def test_ttest(means):
    report = et.ttest(means(0.0898394))
    assert report.passed and len(report.details["scenes"]) == 2 and "passed: 2 of 2" in str(report)
    assert not et.ttest(means(0.1)).passed
    with pytest.raises(et.SceneError, match="ttest"):
        et.ttest(SOURCES / "scenes/cbox-sphere.xml")
