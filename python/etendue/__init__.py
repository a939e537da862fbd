"""Etendue: a path tracer that renders the same picture on every device, and proves it.

    import etendue as et

    scene = et.load_file("scenes/cbox-sphere.xml")
    film = et.render(scene, spp=64)
    film.mean, film.standard_error      # numpy arrays, height x width x 3
    film.write("cbox-sphere.exr")

docs/python.md is the manual.
"""

from . import util
from ._core import set_thread_count, thread_count
from ._core import version as __version__
from ._dictionaries import load_dict
from ._errors import (
    ComparisonError,
    DeviceError,
    DeviceLostError,
    Error,
    FileError,
    InternalError,
    Interrupted,
    Problem,
    SceneError,
    UsageError,
)
from ._images import Film, Image, denoise, merge, read_film, read_image
from ._mitsuba_words import set_variant, traverse
from ._parameters import Parameters
from ._renders import Device, Progressive, devices, progressive, render
from ._scenes import Scene, load_file
from ._transforms import ScalarTransform4f, Transform4f
from ._verdicts import Comparison, Report, compare, ttest

__all__ = [
    "Comparison",
    "ComparisonError",
    "Device",
    "DeviceError",
    "DeviceLostError",
    "Error",
    "FileError",
    "Film",
    "Image",
    "InternalError",
    "Interrupted",
    "Parameters",
    "Problem",
    "Progressive",
    "Report",
    "ScalarTransform4f",
    "Scene",
    "SceneError",
    "Transform4f",
    "UsageError",
    "__version__",
    "compare",
    "denoise",
    "devices",
    "load_dict",
    "load_file",
    "merge",
    "progressive",
    "read_film",
    "read_image",
    "render",
    "set_thread_count",
    "set_variant",
    "thread_count",
    "traverse",
    "ttest",
    "util",
]
