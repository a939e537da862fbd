"""What `pip install .` reads: its metadata, and what goes into the archive of sources. The wheel itself is not built here."""

import contextlib
import email
import os
import pathlib
import re
import subprocess
import sys
import tarfile

import pytest

import etendue as et
from conftest import SOURCES

backend = pytest.importorskip("scikit_build_core.build")


@contextlib.contextmanager
def in_sources():
    before = os.getcwd()
    os.chdir(SOURCES)
    try:
        yield
    finally:
        os.chdir(before)


def version_of_the_project() -> str:
    return re.search(r"project\(etendue VERSION ([0-9.]+)", (SOURCES / "CMakeLists.txt").read_text()).group(1)


def test_metadata(tmp_path):
    with in_sources():
        folder = backend.prepare_metadata_for_build_wheel(str(tmp_path))
    metadata = email.message_from_string((tmp_path / folder / "METADATA").read_text())
    assert (metadata["Name"], metadata["Version"]) == ("etendue", version_of_the_project())
    assert metadata["Requires-Python"] == ">=3.10"
    assert et.__version__ == version_of_the_project()


def test_build_requirements_are_those_of_the_tests():
    """The wheel is built with what the module is tested with."""
    pinned = dict(line.strip().split("==") for line in (SOURCES / "tests/python/requirements.txt").read_text().splitlines() if "==" in line)
    asked = re.search(r"requires = \[(.*)\]", (SOURCES / "pyproject.toml").read_text()).group(1)
    for name, version in re.findall(r'"([\w-]+)==([\d.]+)"', asked):
        assert pinned[name.replace("-", "_")] == version, name


def test_source_archive(tmp_path):
    with in_sources():
        archive = tmp_path / backend.build_sdist(str(tmp_path))
    with tarfile.open(archive) as files:
        names = {name.partition("/")[2] for name in files.getnames()}
    for wanted in ("CMakeLists.txt", "python/CMakeLists.txt", "python/etendue/py.typed", "shaders/gpu_types.h", "src/library/render.cpp", "LICENSE"):
        assert wanted in names, wanted
    assert not any(name.startswith(("build/", "tests/")) for name in names)
    assert archive.stat().st_size < 8 << 20


def test_types(tmp_path):
    """What is exported has a docstring; all types, those of the compiled part too, hold before a strict checker."""
    for name in et.__all__:
        assert name == "__version__" or getattr(et, name).__doc__, name
    package = pathlib.Path(et.__file__).parent
    assert (package / "py.typed").exists()
    user = tmp_path / "user.py"
    user.write_text("import etendue as et\nbrightness: float = et.render(et.load_dict({}), spp=1).relative_error\nwrong: int = et.render('s.xml').mean\n")
    # The checker finds installed packages itself, and takes offence at being told where they are.
    path = {} if package.parent.name == "site-packages" else {"MYPYPATH": str(package.parent)}
    words = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), "-p", "etendue"]
    checked = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, env={**os.environ, **path})
    assert checked.returncode == 0, checked.stdout
    words[-2:] = [str(user)]
    checked = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, env={**os.environ, **path})
    assert "user.py:3" in checked.stdout and "user.py:2" not in checked.stdout, checked.stdout
