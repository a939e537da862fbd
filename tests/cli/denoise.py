"""Denoising with a library of the test's own (fake_oidn.cpp), which writes down how it is called, without any, and with
the library of this machine if it has one. usage: denoise.py ETENDUE SOURCES LIBRARY OTHER_LIBRARY"""

import ctypes
import ctypes.util
import importlib.util
import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest

from exr_pixels import read_exr

ETENDUE, SOURCES, LIBRARY, OTHER_LIBRARY = (sys.argv.pop(1) for _ in range(4))
SCENE = SOURCES + "/scenes/cbox-sphere.xml"
RENDER = ["render", SCENE, "--device", "reference", "--size", "13x7", "--spp", "2"]
IMAGE = "format 3 size 13x7 offset 0 strides 12 156"
GUIDES = [["albedo.R", "albedo.G", "albedo.B"], ["normal.X", "normal.Y", "normal.Z"]]


def calls(*images):
    """What the library hears of one picture."""
    return (["device 1", "commit device 1", "int version", "filter 1 RT"] + [f"image {name} {IMAGE}" for name in images] +
            ["bool hdr 1", "commit filter", "execute 1", "release filter", "release device 1"])


def foreign_exr(path, width, height, red, name="R"):
    """A picture that no renderer of ours made: not compressed, and without a word on where it comes from."""
    def attribute(title, kind, value):
        return title + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value

    channels = b"".join(channel + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for channel in (b"B", b"G", name.encode())) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<II", 20000630, 2) + b"".join([
        attribute(b"channels", b"chlist", channels), attribute(b"compression", b"compression", b"\0"),
        attribute(b"dataWindow", b"box2i", box), attribute(b"displayWindow", b"box2i", box),
        attribute(b"lineOrder", b"lineOrder", b"\0"), attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        attribute(b"screenWindowCenter", b"v2f", bytes(8)), attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))]) + b"\0"
    lines = [struct.pack("<ii%df" % (3 * width), y, 12 * width, *([0.5] * (2 * width)), *red[y * width:(y + 1) * width])
             for y in range(height)]
    places = [len(head) + 8 * height + y * len(lines[0]) for y in range(height)]
    with open(path, "wb") as file:
        file.write(head + struct.pack("<%dQ" % height, *places) + b"".join(lines))


def library_of_this_machine():
    """Open Image Denoise itself: what ETENDUE_OIDN names, the system's, or that of the package pyoidn; "" without it."""
    package = importlib.util.find_spec("pyoidn")
    folders = package.submodule_search_locations if package else []
    names = [os.environ.get("ETENDUE_OIDN"), ctypes.util.find_library("OpenImageDenoise"),
             *(os.path.join(folder, "oidn/lib/libOpenImageDenoise.so.2") for folder in folders)]
    for name in filter(None, names):
        try:
            return ctypes.CDLL(name)._name
        except OSError:
            pass
    return ""


def rounded(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


class Denoise(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()

    def tearDown(self):
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def run_etendue(self, *arguments, fault="", **environment):
        settings = {"ETENDUE_OIDN": LIBRARY, "FAKE_OIDN_LOG": self.path("log"), "FAKE_OIDN": fault, **environment}
        if os.path.exists(self.path("log")):
            os.remove(self.path("log"))
        result = subprocess.run([ETENDUE, *arguments], cwd=self.folder.name, env={**os.environ, **settings}, capture_output=True,
                                text=True, timeout=120)
        self.log = []
        if os.path.exists(self.path("log")):
            with open(self.path("log")) as file:
                self.log = file.read().splitlines()
        return result

    def expect(self, code, words, *arguments, **settings):
        result = self.run_etendue(*arguments, **settings)
        self.assertEqual(result.returncode, code, result.stderr)
        for word in [words] if isinstance(words, str) else words:
            self.assertIn(word, result.stderr)
        if code:
            self.assertEqual(result.stderr.count("error: "), 1, result.stderr)
        return result

    def expect_denoised(self, noisy, denoised, guides):
        """The library's doing, number for number."""
        width, height, before, _ = read_exr(self.path(noisy))
        size = read_exr(self.path(denoised))
        self.assertEqual(size[:2], (width, height))
        self.assertEqual(sorted(name for name in size[2] if name != "A"), ["B", "G", "R"])
        for i, color in enumerate("RGB"):
            expected = [2 * value for value in before[color]]
            for names in guides:
                expected = [rounded(a + b) for a, b in zip(expected, before[names[i]])]
            self.assertEqual(list(size[2][color]), expected)
        text = size[3]["denoised"].decode()
        self.assertTrue(text.startswith("Open Image Denoise 2.3.4 guides="), text)
        return text.split("=")[1]

    def test_render(self):
        result = self.expect(0, "wrote a.exr and a.png and a.denoised.exr and a.denoised.png", *RENDER, "--denoise", "-o", "a.exr",
                             "-o", "a.png", "--json=a.json")
        self.assertNotIn("warning", result.stderr)
        self.assertEqual(self.log, calls("color", "albedo", "normal", "output"))
        self.assertEqual(self.expect_denoised("a.exr", "a.denoised.exr", GUIDES), "albedo,normal")
        with open(self.path("a.json")) as file:
            self.assertEqual(json.load(file)["denoised"], {"by": "Open Image Denoise 2.3.4",
                                                           "outputs": ["a.denoised.exr", "a.denoised.png"]})
        # The picture with its noise is the one that a render without a denoiser makes.
        self.expect(0, "", *RENDER, "--aov", "albedo,normal", "-o", "b.exr")
        with open(self.path("a.exr"), "rb") as a, open(self.path("b.exr"), "rb") as b:
            self.assertEqual(a.read(), b.read())
        self.expect(0, "", "denoise", "a.exr", "-o", "c.exr")
        with open(self.path("a.denoised.exr"), "rb") as a, open(self.path("c.exr"), "rb") as c:
            self.assertEqual(a.read(), c.read())

    def test_guides_that_are_there(self):
        for aov, images, text in (("", ["color", "output"], "none"), ("albedo", ["color", "albedo", "output"], "albedo"),
                                  ("normal", ["color", "output"], "none")):
            more = ["--aov", aov] if aov else []
            self.expect(0, "", *RENDER, *more, "-o", "a.exr", "--force", "--alpha")
            self.expect(0, "Denoised 13x7 in", "denoise", "a.exr", "-o", "d.exr", "--force")
            self.assertEqual(self.log, calls(*images))
            self.assertEqual(self.expect_denoised("a.exr", "d.exr", GUIDES[:1] if aov == "albedo" else []), text)
            self.assertEqual(read_exr(self.path("a.exr"))[2]["A"], read_exr(self.path("d.exr"))[2]["A"])

    def test_film(self):
        self.expect(0, "", *RENDER, "--film", "--aov", "albedo,normal", "-o", "f.exr")
        self.expect(0, "", "denoise", "f.exr", "-o", "d.exr")
        self.assertEqual(self.log, calls("color", "albedo", "normal", "output"))

    def test_with_the_library_of_this_machine(self):
        """It takes most of the noise away. Where there is none, the stand-in's numbers show that it was asked."""
        path = library_of_this_machine()
        environment = {"ETENDUE_OIDN": path if "/" in path else ""} if path else {}
        print("library:", path or LIBRARY)
        render = ["render", SCENE, "--size", "40x30"]
        self.expect(0, "wrote a.exr and a.denoised.exr", *render, "--spp", "4", "--denoise", "-o", "a.exr", **environment)
        self.expect(0, "", "denoise", "a.exr", "-o", "again.exr", **environment)
        pictures = [read_exr(self.path(name)) for name in ("a.denoised.exr", "again.exr")]
        self.assertEqual(pictures[0][2], pictures[1][2])
        if not path:
            self.assertEqual(self.expect_denoised("a.exr", "a.denoised.exr", GUIDES), "albedo,normal")
            return
        self.assertRegex(pictures[0][3]["denoised"].decode(), r"^Open Image Denoise 2\.\d+\.\d+ guides=albedo,normal$")
        self.expect(0, "", *render, "--spp", "1024", "--seed", "1", "-o", "truth.exr")
        errors = []
        for name in ("a.exr", "a.denoised.exr"):
            told = self.run_etendue("compare", name, "truth.exr", "--json", "--fail-above", "rmse=1e9")
            errors.append(json.loads(told.stdout)["metrics"]["relmse"])
        self.assertLess(errors[1], errors[0] / 4)

    def test_who_refuses_denoised_pictures(self):
        self.expect(0, "", *RENDER, "--denoise", "-o", "a.exr", "-o", "f.exr")
        self.expect(0, "", *RENDER, "--seed", "1", "-o", "b.exr")
        for arguments in (["merge", "a.denoised.exr", "-o", "m.exr"], [*RENDER, "--resume", "a.denoised.exr", "-o", "r.exr"],
                          ["denoise", "a.denoised.exr", "-o", "d.exr"]):
            self.expect(6, "is a denoised picture (Open Image Denoise 2.3.4 guides=albedo,normal)", *arguments)
        self.expect(2, "is a denoised picture", *RENDER, "--checkpoint", "a.denoised.exr", "-o", "r.exr")
        for pair, name in ((["a.denoised.exr", "b.exr"], "A"), (["b.exr", "a.denoised.exr"], "B")):
            result = self.run_etendue("compare", *pair)
            self.assertEqual(result.returncode, 1)
            self.assertIn(f"not tested: {name} is denoised", result.stdout)
            self.assertEqual(self.run_etendue("compare", *pair, "--fail-above", "rmse=1e9").returncode, 0)

    def test_nothing_with_noise_is_lost(self):
        self.expect(0, "", *RENDER, "-o", "a.exr")
        self.expect(0, "", *RENDER, "--seed", "2", "-o", "b.exr")
        self.expect(6, "that is not denoised", "denoise", "a.exr", "-o", "b.exr")
        self.expect(2, "are the same file", "denoise", "a.exr", "-o", "a.exr")
        self.expect(0, "", "denoise", "a.exr", "-o", "b.exr", "--force")
        self.expect(0, "will be replaced", "denoise", "a.exr", "-o", "b.exr")
        self.expect(2, "add -o NAME.exr", *RENDER, "--denoise", "-o", "p.png")
        self.expect(2, "are the same file", *RENDER, "--denoise", "-o", "p.exr", "-o", "p.denoised.exr")
        self.assertFalse(os.path.exists(self.path("p.exr")))

    def test_libraries_that_will_not_do(self):
        self.expect(0, "", *RENDER, "-o", "a.exr")
        for command in (["denoise", "a.exr", "-o", "d.exr"], [*RENDER, "--denoise", "-o", "c.exr"]):
            nothing = {"ETENDUE_OIDN": "/no/such/lib.so"}
            self.expect(6, ["/no/such/lib.so", "libopenimagedenoise2", "pip install pyoidn"], *command, **nothing)
            self.expect(6, ["has no function oidnNewDevice"], *command, ETENDUE_OIDN=OTHER_LIBRARY)
            self.expect(6, ["1.4.3 is too old", "2.0"], *command, fault="old")
            self.expect(6, ["no device for the CPU"], *command, fault="no device")
            self.assertFalse(os.path.exists(self.path("c.exr")), "found out after the render")
        # What goes wrong at the end costs the denoised picture alone.
        self.expect(6, "no filter RT", *RENDER, "--denoise", "-o", "c.exr", fault="no filter")
        self.assertTrue(os.path.exists(self.path("c.exr")))
        result = self.expect(5, "failed in its filter: out of", *RENDER, "--denoise", "-o", "e.exr", fault="fails")
        self.assertNotIn("\x1b", result.stderr)
        self.assertTrue(os.path.exists(self.path("e.exr")))
        self.assertFalse(os.path.exists(self.path("e.denoised.exr")))
        self.expect(0, "", "denoise", "a.exr", "-o", "d.exr", "--oidn", LIBRARY, ETENDUE_OIDN="/no/such/lib.so")
        self.expect(2, "--oidn", *RENDER, "--oidn", LIBRARY, "-o", "g.exr")

    def test_pictures_that_are_not_denoised(self):
        self.expect(0, "", *RENDER, "-o", "a.exr", "-o", "a.png")
        self.expect(6, "is not an EXR file", "denoise", "a.png", "-o", "d.exr")
        self.expect(6, "nothing.exr", "denoise", "nothing.exr", "-o", "d.exr")
        with open(self.path("a.exr"), "rb") as file:
            data = bytearray(file.read())
        data[-20] ^= 0xFF
        with open(self.path("a.exr"), "wb") as file:
            file.write(data)
        self.expect(6, "damaged EXR", "denoise", "a.exr", "-o", "d.exr")
        numbers = [0.25] * 24
        foreign_exr(self.path("foreign.exr"), 6, 4, numbers)
        self.expect(0, "", "denoise", "foreign.exr", "-o", "d.exr")
        self.assertEqual(list(read_exr(self.path("d.exr"))[2]["R"]), [0.5] * 24)
        numbers[8], numbers[20] = float("nan"), float("-inf")
        foreign_exr(self.path("foreign.exr"), 6, 4, numbers)
        self.expect(6, "2 pixels of its colour are not finite, the first at (2, 1)", "denoise", "foreign.exr", "-o", "e.exr")


if __name__ == "__main__":
    unittest.main(verbosity=2)
