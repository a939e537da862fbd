"""Rendering: arrays, the same bytes as the command line, budgets, pieces, steps."""

import threading
import time

import numpy as np
import pytest

import etendue as et


def test_arrays(box):
    box.aovs = ["depth", "normal", "alpha", "instance"]
    film = et.render(box, spp=8)
    assert (film.spp, film.samples, film.rejected) == (8, [(0, 8)], 0)
    assert film.mean.shape == film.standard_error.shape == film.shape == (30, 40, 3)
    assert film.mean.dtype == np.float32 and film.mean.min() >= 0 and film.mean.mean() > 0.1
    assert np.all(film.sample_count == 8)
    assert set(film.aovs) == {"depth", "normal", "alpha", "instance"}
    assert film.aovs["depth"].shape == (30, 40) and film.aovs["normal"].shape == (30, 40, 3)
    assert film.aovs["instance"].dtype == np.uint32 and len(np.unique(film.aovs["instance"])) > 3
    # The box is looked at from some 3 units away, and everything in it lies within 7.
    assert 3 < np.median(film.aovs["depth"]) < 7
    assert film.metadata["scene"] == "cbox-sphere" and film.metadata["seed"] == "0"


def test_aovs_of_one_render(box):
    box.aovs = ["normal"]
    film = et.render(box, spp=2, aovs=["depth", "instance"])
    assert set(film.aovs) == {"depth", "instance"} and box.aovs == ["normal"]
    assert set(et.render(box, spp=2, aovs=[]).aovs) == set()
    assert set(et.render(box, spp=2).aovs) == {"normal"}
    assert np.array_equal(et.render(box, spp=2).mean, film.mean), "the picture is the same"
    box.aovs = ["depth", "instance"]
    assert np.array_equal(et.render(box, spp=2).aovs["depth"], film.aovs["depth"])
    for last in et.progressive(box, spp=2, aovs=["uv"], show=False):
        assert set(last.aovs) == {"uv"}
    with pytest.raises(et.UsageError, match="deep"):
        et.render(box, spp=2, aovs=["deep"])
    assert set(et.render(box, spp=1, aovs="depth").aovs) == {"depth"}


def test_arrays_are_views_that_outlive_the_film(box):
    film = et.render(box, spp=2)
    mean = film.mean
    assert np.shares_memory(mean, film.mean) and not mean.flags.writeable
    total = mean.sum()
    del film
    assert mean.sum() == total


def test_a_film_counts_as_its_mean(box):
    film = et.render(box, spp=2)
    assert np.array_equal(np.asarray(film), film.mean)
    assert np.allclose(film**0.5, film.mean**0.5, rtol=1e-6)  # of an array NumPy 2.2 takes the square root
    assert np.array_equal(film[3, 4], film.mean[3, 4])
    assert np.asarray(film, dtype=np.float64).dtype == np.float64


def test_same_bytes_as_the_command_line(box, etendue, box_arguments, tmp_path):
    etendue("render", *box_arguments, "--spp", 5, "--seed", 3, "--film", "-q", "-o", "program.exr")
    etendue("render", *box_arguments, "--spp", 5, "--seed", 3, "-q", "-o", "picture.exr", "-o", "picture.png")
    film = et.render(box, spp=5, seed=3)
    film.write_film(tmp_path / "module.exr")
    film.write(tmp_path / "module-picture.exr")
    film.write(tmp_path / "module-picture.png")
    for program, module in (("program.exr", "module.exr"), ("picture.exr", "module-picture.exr"), ("picture.png", "module-picture.png")):
        assert (tmp_path / program).read_bytes() == (tmp_path / module).read_bytes()
    assert film.png() == (tmp_path / "picture.png").read_bytes()
    assert np.array_equal(et.read_image(tmp_path / "picture.exr").mean, film.mean)


def test_pieces_add_up(box, tmp_path):
    whole = et.render(box, spp=6)
    left, right = et.render(box, samples=(0, 2)), et.render(box, samples=(2, 6))
    right.write_film(tmp_path / "right.exr")
    for merged in (et.merge([right, left]), et.merge([left, tmp_path / "right.exr"])):
        merged.write_film(tmp_path / "merged.exr")
        whole.write_film(tmp_path / "whole.exr")
        assert (tmp_path / "merged.exr").read_bytes() == (tmp_path / "whole.exr").read_bytes()
    on = et.render(box, spp=6, start=left)
    assert np.array_equal(on.mean, whole.mean) and on.samples == [(0, 6)]


def test_what_does_not_add_up_is_refused(box):
    one = et.render(box, spp=2)
    with pytest.raises(et.FileError, match="both hold the samples 0:2"):
        et.merge([one, one])
    with pytest.raises(et.FileError, match="seeds"):
        et.merge([one, et.render(box, samples=(2, 4), seed=1)])
    with pytest.raises(et.UsageError, match="nothing to merge"):
        et.merge([])


def test_steps(box):
    films = list(et.progressive(box, spp=6))
    assert [film.spp for film in films] == [1, 2, 4, 6]
    assert np.array_equal(films[1].mean, et.render(box, spp=2).mean)
    assert np.array_equal(films[-1].mean, et.render(box, spp=6).mean)
    assert films[-1].relative_error < films[1].relative_error < float("inf") == films[0].relative_error
    assert [film.spp for film in et.progressive(box, spp=5, step=2)] == [2, 4, 5]


def test_steps_can_be_left(box):
    with et.progressive(box, spp=64) as films:
        next(films)
        with pytest.raises(et.UsageError, match="is being rendered"):
            box.size = (10, 10)
    box.size = (10, 10)
    assert et.render(box, spp=1).shape == (10, 10, 3)
    assert films.film.spp == 1
    with pytest.raises(StopIteration):
        next(films)


def test_budgets(box):
    film = et.render(box, spp=100000, time=0.2)
    assert 0 < film.spp < 100000
    film = et.render(box, spp=100000, until_error=0.5)
    assert 16 <= film.spp < 2000 and film.relative_error < 0.5


def test_progress(box):
    told = []
    et.render(box, spp=400, progress=lambda done, total: told.append((done, total)))
    assert told and all(0 < done <= total == 400 * 1200 for done, total in told)
    assert told == sorted(told)


def test_an_error_in_progress_ends_the_render(box):
    def fail(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough") as caught:
        et.render(box, spp=4_000_000, progress=fail)
    box.size = (10, 10)  # the scene is free, although the exception, as in a notebook, still knows the frames
    assert caught.tb is not None


def test_the_gil_is_free(box):
    over, longest = threading.Event(), 0.0

    def watch():
        nonlocal longest
        last = time.monotonic()
        while not over.wait(0.01):
            now = time.monotonic()
            longest, last = max(longest, now - last), now

    thread = threading.Thread(target=watch)
    thread.start()
    began = time.monotonic()
    try:
        et.render(box, spp=10_000_000, time=2.0)
    finally:
        seconds = time.monotonic() - began
        over.set()
        thread.join()
    assert longest < 0.5 * seconds  # a render that kept the GIL would keep the other thread for nearly all of it


def test_checkpoint(box, tmp_path):
    film = et.render(box, spp=3, checkpoint=tmp_path / "checkpoint.exr")
    kept = et.read_film(tmp_path / "checkpoint.exr")
    assert kept.samples == film.samples and np.array_equal(kept.mean, film.mean)


def test_devices(box):
    usable = [device for device in et.devices() if device.usable]
    assert usable and usable[0].name
    film = et.render(box, spp=1, device=usable[0].number)
    assert usable[0].name in film.metadata["device"]
    reference = et.render(box, spp=1, device="reference")
    assert "reference" in reference.metadata["device"] or reference.metadata["device"] != film.metadata["device"]
    # The same random numbers: the same light to rounding, but for the few paths that rounding parts.
    assert np.median(np.abs(reference.mean - film.mean) / (1e-3 + film.mean)) < 1e-4
