"""What moves: cameras with keyframes and animations of glTF at a time, against closed forms; damaged animations; and
`render --frames`. usage: frames.py ETENDUE SOURCES"""

import glob
import json
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from moving_assets import Asset

ETENDUE, SOURCES = sys.argv.pop(1), sys.argv.pop(1)
LIGHT = ["--device", "reference", "--size", "12x8"]

SCENE = """<scene>
<integrator type="path"/>
<camera type="perspective">
%s
</camera>
<mesh type="sphere"><bsdf type="diffuse"/><emitter type="area"><color name="radiance" value="1,1,1"/></emitter></mesh>
</scene>
"""


def key(at, transform):
    return f'<keyframe><float name="time" value="{at}"/><transform name="toWorld">{transform}</transform></keyframe>'


def moved(x, y, z):
    return f'<translate value="{x},{y},{z}"/>'


def turn(axis, degrees):
    """A quaternion (x, y, z, w)."""
    half = math.radians(degrees) / 2
    return [math.sin(half) * a for a in axis] + [math.cos(half)]


class Frames(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.number = 0

    def tearDown(self):
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def run_etendue(self, *arguments):
        return subprocess.run([ETENDUE, *arguments], cwd=self.folder.name, capture_output=True, text=True, timeout=120)

    def expect(self, code, words, *arguments):
        result = self.run_etendue(*arguments)
        self.assertEqual(result.returncode, code, result.stderr)
        said = result.stderr + (result.stdout if arguments[0] == "check" else "")  # whose findings are its results
        for word in [words] if isinstance(words, str) else words:
            self.assertIn(word, said)
        return result

    # What a scene is at a time, by what convert writes.

    def converted(self, scene, at, *more):
        self.number += 1
        name = f"out-{self.number}"
        self.expect(0, "", "convert", scene, name + ".xml", "--at", str(at), *more)
        self.files = self.path(name + "-files")
        return self.read(name + ".xml").decode()

    @staticmethod
    def matrix_in(text):
        """Rows of the matrix of a toWorld; identity where there is none."""
        numbers = re.search(r'<transform name="toWorld">\s*<matrix value="([^"]*)"', text)
        if not numbers:
            return [[1.0 if i == k else 0.0 for k in range(4)] for i in range(4)]
        values = [float(n) for n in re.split(r"[\s,]+", numbers.group(1).strip())]
        return [values[4 * i:4 * i + 4] for i in range(4)]

    def camera(self, scene, at, *more):
        return self.matrix_in(re.search(r"<camera.*?</camera>", self.converted(scene, at, *more), re.S).group())

    def flag(self, asset, at, *more):
        """Where the flag's node has its mesh."""
        asset.write(self.path("asset.gltf"))
        return self.matrix_in(re.search(r"<mesh.*?</mesh>", self.converted("asset.gltf", at, *more), re.S).group())

    def assert_close(self, found, expected, places=6):
        self.assertEqual(len(found), len(expected))
        for a, b in zip(found, expected):
            self.assertAlmostEqual(a, b, places=places, msg=f"{found} for {expected}")

    def place(self, matrix):
        return [row[3] for row in matrix[:3]]

    def column(self, matrix, i):
        return [row[i] for row in matrix[:3]]

    # Camera paths.

    def path_scene(self, keys, more=""):
        self.write("path.xml", SCENE % (more + "\n".join(keys)))
        return "path.xml"

    def test_a_spline_is_exact_for_a_quadratic(self):
        def where(t):
            return [1 + 2 * t - 3 * t * t, 4 * t * t, 5 - t]

        scene = self.path_scene([key(t, moved(*where(t))) for t in (0, 0.5, 2, 2.25, 4)])
        for t in (0.1, 0.5, 1, 1.7, 2.1, 3, 3.9):
            self.assert_close(self.place(self.camera(scene, t)), where(t), places=9)
        self.assert_close(self.place(self.camera(scene, 9)), where(4))
        self.assert_close(self.place(self.camera(scene, 0)), where(0))

    def test_straight_lines(self):
        scene = self.path_scene([key(0, moved(0, 0, 0)), key(1, moved(2, 0, 0)), key(3, moved(2, 8, 0))],
                                '<string name="path" value="linear"/>')
        self.assert_close(self.place(self.camera(scene, 0.25)), [0.5, 0, 0])
        self.assert_close(self.place(self.camera(scene, 2)), [2, 4, 0])
        two = self.path_scene([key(1, moved(0, 0, 0)), key(2, moved(2, 0, 0))])
        self.assert_close(self.place(self.camera(two, 1.5)), [1, 0, 0])
        self.assert_close(self.place(self.camera(two, 0.5)), [0, 0, 0])

    def test_rotations_go_evenly_along_the_shortest_arc(self):
        rotate = '<rotate axis="%s" angle="%g"/>'
        scene = self.path_scene([key(0, rotate % ("0,1,0", 20)), key(2, rotate % ("0,1,0", 140)), key(3, rotate % ("0,1,0", 320))])
        for t, angle in ((0.5, 50), (1, 80), (1.5, 110)):
            z = self.column(self.camera(scene, t), 2)
            self.assert_close(z, [math.sin(math.radians(angle)), 0, math.cos(math.radians(angle))], places=9)
        back = self.path_scene([key(0, rotate % ("1,0,0", 10)), key(1, rotate % ("1,0,0", 350))])
        self.assert_close(self.column(self.camera(back, 0.5), 2), [0, 0, 1], places=9)

    def test_scales_and_mirrors(self):
        scene = self.path_scene([key(0, '<scale value="-1,1,1"/>'), key(1, '<scale value="-3,5,7"/>')])
        m = self.camera(scene, 0.25)
        self.assert_close([m[0][0], m[1][1], m[2][2]], [-1.5, 2, 2.5])

    def test_a_turntable_is_round(self):
        keys = 12
        scene = self.path_scene([key(t, f'<translate value="0,0,-4"/><rotate axis="0,1,0" angle="{30 * t}"/>')
                                 for t in range(keys + 1)])
        for t in (0.3, 0.5, 2.3, 11.5, 11.7):  # at the seam as well
            m = self.camera(scene, t)
            x, y, z = self.place(m)
            self.assertAlmostEqual(math.hypot(x, z), 4, delta=4 * 0.002)
            # It looks at the middle.
            forward = self.column(m, 2)
            self.assertGreater(-(x * forward[0] + z * forward[2]) / math.hypot(x, z), 1 - 1e-4)

    def test_a_path_survives_convert(self):
        scene = self.path_scene([key(0, moved(0, 0, -5)), key(1, moved(1, 0, -5)), key(3, moved(0, 2, -4))],
                                '<string name="path" value="linear"/>')
        self.expect(0, "", "convert", scene, "copy.xml")
        self.assertEqual(self.camera(scene, 1.7), self.camera("copy.xml", 1.7))
        self.expect(0, "the camera moves", "convert", scene, "other.xml", "--to", "mitsuba")

    def test_paths_that_are_wrong(self):
        stand = moved(0, 0, -5)
        for keys, more, words in (
            ([key(0, stand), key(0, stand)], "", ["path.xml:5:", "not later than the one before it"]),
            ([key(1, stand), key(0.5, stand)], "", ["path.xml:5:", "keyframe 2 of the camera is at 0.5 s"]),
            ([key("nan", stand)], "", ["path.xml:4:"]),
            ([key(0, stand), key(1, '<scale value="-1,1,1"/>')], "", ["path.xml:5:", "mirrored"]),
            ([key(0, '<matrix value="1,0.5,0,0,0,1,0,0,0,0,1,0,0,0,0,1"/>')], "", ["path.xml:4:", "shears"]),
            ([key(0, '<scale value="0,1,1"/>')], "", ["path.xml:4:", "singular"]),
            (["<keyframe/>"], "", ["path.xml:4:", 'needs its property "time"']),
            ([key(0, stand)], f'<transform name="toWorld">{stand}</transform>', ["both \"toWorld\" and keyframes"]),
            ([key(0, stand)], '<string name="path" value="splin"/>', ['did you mean "spline"']),
        ):
            scene = self.path_scene(keys, more)
            self.expect(3, words, "check", scene)

    # Animations.

    def test_translations(self):
        times, values = [1, 2, 4], [0, 0, 0, 2, 0, 0, 2, 8, 4]
        for interpolation, expected in ((None, {0.5: [0, 0, 0], 1.25: [0.5, 0, 0], 3: [2, 4, 2], 9: [2, 8, 4]}),
                                        ("STEP", {1.99: [0, 0, 0], 2: [2, 0, 0], 3.9: [2, 0, 0], 4: [2, 8, 4]})):
            asset = Asset().channel(0, "translation", times, values, interpolation)
            for at, place in expected.items():
                self.assert_close(self.place(self.flag(asset, at)), place)

    def test_cubics(self):
        # p(t) = t³ along x: tangents are 3t², times are not at the unit.
        times = [1, 3]
        triples = [[3 * t * t, 0, 0] if tangent else [t ** 3, 0, 0] for t in times for tangent in (True, False, True)]
        asset = Asset().channel(0, "translation", times, sum(triples, []), "CUBICSPLINE")
        for at in (1.5, 2, 2.7):
            self.assert_close(self.place(self.flag(asset, at)), [at ** 3, 0, 0], places=5)
        self.assert_close(self.place(self.flag(asset, 5)), [27, 0, 0])

    def test_rotations(self):
        flipped = [-q for q in turn([0, 0, 1], 80)]
        asset = Asset().channel(0, "rotation", [0, 2], turn([0, 0, 1], 20) + flipped)
        m = self.flag(asset, 0.5)
        self.assert_close(self.column(m, 0), [math.cos(math.radians(35)), math.sin(math.radians(35)), 0])
        self.assert_close(self.place(m), [5, 6, 7])  # what no channel moves stays
        # Shorts, where 32767 is 1.
        asset = Asset()
        output = asset.floats([0, 0, 0, 32767, 0, 0, 32767, 0], "VEC4", "h", 5122, normalized=True)
        asset.channel(0, "rotation", [0, 1], [], output=output)
        self.assert_close(self.column(self.flag(asset, 0.25), 0), [math.cos(math.pi / 4), math.sin(math.pi / 4), 0])
        # A cubic with tangents of 0 is half-way in the middle, and a unit quaternion by then.
        still = [0, 0, 0, 0]
        asset = Asset().channel(0, "rotation", [0, 1], still + turn([0, 0, 1], 0) + still + still + turn([0, 0, 1], 90) + still,
                                "CUBICSPLINE")
        self.assert_close(self.column(self.flag(asset, 0.5), 0), [math.cos(math.pi / 4), math.sin(math.pi / 4), 0])

    def test_scales_and_parents(self):
        asset = Asset().channel(2, "scale", [0, 1], [1, 1, 1, 3, 5, 7]).channel(0, "translation", [0, 1], [0, 0, 0, 2, 2, 2])
        asset.tree["nodes"].append({"children": [0], "translation": [1, 0, 0]})
        asset.tree["scenes"][0]["nodes"] = [2, 1]
        m = self.flag(asset, 0.5)
        self.assert_close([m[0][0], m[1][1], m[2][2]], [2, 3, 4])
        self.assert_close(self.place(m), [1 + 2, 3, 4])

    def corners(self):
        """Of the one mesh that was written."""
        (name,) = glob.glob(self.files + "/*.ply")
        self.expect(0, "", "check", name)
        with open(name, "rb") as file:
            head, _, body = file.read().partition(b"end_header\n")
        self.assertIn(b"format binary_little_endian", head)
        lines = head.decode().splitlines()
        count = int(next(line.split()[2] for line in lines if line.startswith("element vertex")))
        kinds = []
        for line in lines[next(i for i, line in enumerate(lines) if line.startswith("element vertex")) + 1:]:
            if not line.startswith("property"):
                break
            kinds.append(line.split()[1])
        import struct
        layout = "<" + "".join({"float": "f", "double": "d"}[kind] for kind in kinds)
        return [list(struct.unpack_from(layout, body, i * struct.calcsize(layout))[:3]) for i in range(count)]

    def test_weights(self):
        asset = Asset().channel(0, "weights", [0, 2], [0, 1, 1, 0])
        self.flag(asset, 0.5)
        self.assertIn([0, 0, 0.25], self.corners())
        self.assertIn([1, 0.75, 0], self.corners())

    def test_skins(self):
        asset = Asset()
        primitive = asset.tree["meshes"][0]["primitives"][0]
        primitive["attributes"]["JOINTS_0"] = asset.floats([0, 1, 0, 0] * 3, "VEC4", "B", 5121)
        primitive["attributes"]["WEIGHTS_0"] = asset.floats([0.5, 0.5, 0, 0] * 3, "VEC4")
        asset.tree["nodes"] += [{"name": "hip"}, {"name": "knee", "translation": [0, 2, 0]}]
        asset.tree["scenes"][0]["nodes"] += [2, 3]
        asset.tree["nodes"][0]["skin"] = 0
        asset.tree["skins"] = [{"joints": [2, 3]}]
        asset.channel(2, "translation", [0, 1], [0, 0, 0, 0, 0, 8])
        asset.write(self.path("asset.gltf"))
        self.converted("asset.gltf", 0.5)
        self.assertIn([1, 1, 2], self.corners())  # half of hip's (1, 0, 4), half of knee's (1, 2, 0)

    def test_cameras_move(self):
        asset = Asset().channel(1, "translation", [0, 1], [0, 0, 4, 2, 0, 4])
        asset.write(self.path("asset.gltf"))
        self.assert_close(self.place(self.camera("asset.gltf", 0.5)), [1, 0, 4])

    def test_several_animations(self):
        asset = Asset().channel(0, "translation", [0, 1], [0, 0, 0, 1, 0, 0], name="walk")
        asset.channel(0, "translation", [0, 1], [0, 0, 0, 0, 2, 0], animation=1, name="jump")
        self.assert_close(self.place(self.flag(asset, 1)), [1, 0, 0])
        self.assert_close(self.place(self.flag(asset, 1, "--animation", "jump")), [0, 2, 0])
        self.assert_close(self.place(self.flag(asset, 1, "--animation", "1")), [0, 2, 0])
        self.expect(0, "animations 0 and 1 both move the translation of node 0", "check", "asset.gltf", "--at", "1")
        self.expect(2, ['"walk"', '"jump"'], "check", "asset.gltf", "--at", "1", "--animation", "hop")
        self.expect(2, "--at", "check", "asset.gltf", "--animation", "jump")

    def test_nothing_moves(self):
        asset = Asset()
        asset.write(self.path("still.gltf"))
        self.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        scene = self.path_scene([f'<transform name="toWorld">{moved(0, 0, -5)}</transform>'])
        for name in ("still.gltf", "mesh.obj", scene):
            self.expect(2, "nothing in", "check", name, "--at", "1")
            self.expect(2, "nothing in", "render", name, *LIGHT, "--frames", "0:2", "-o", "f-#.exr")
        self.expect(2, "--animation", "check", scene, "--animation", "walk")
        for text in ("soon", "-1", "1e9x", "1.5x", ""):
            self.expect(2, "--at", "check", "still.gltf", f"--at={text}")

    def test_damaged_animations(self):
        inf, nan = float("inf"), float("nan")

        def breaks(change):
            asset = Asset().channel(0, "translation", [0, 1], [0, 0, 0, 1, 1, 1])
            change(asset, asset.tree["animations"][0])
            return asset

        def sampler(**values):
            return lambda asset, animation: animation["samplers"][0].update(values)

        cases = [
            (sampler(input=99), 'number 99 of "accessors"'), (sampler(output=4294967295), "accessors|too large"),
            (sampler(input=-1), "non-negative"), (sampler(input="0"), "must be a number"),
            (sampler(interpolation="BEZIER"), '"BEZIER" is unknown'), (sampler(interpolation="CUBICSPLINE"), "it needs 18"),
            (lambda a, m: a.channel(0, "scale", [0, 1, 1], [1] * 9), "not later than the one before it"),
            (lambda a, m: a.channel(0, "scale", [1, 0], [1] * 6), "keyframe 1 of an animation is at 0 s"),
            (lambda a, m: a.channel(0, "scale", [0, nan], [1] * 6), "is at nan s, which is not a time"),
            (lambda a, m: a.channel(0, "scale", [0, inf], [1] * 6), "is at inf s, which is not a time"),
            (lambda a, m: a.channel(0, "scale", [0, 1], [1, 1, nan, 1, 1, 1]), "the value nan"),
            (lambda a, m: a.channel(0, "scale", [0, 1], [1] * 9), "2 keyframes and 9 numbers; it needs 6"),
            (lambda a, m: a.channel(0, "rotation", [0, 1], [0] * 8), "a rotation of length 0"),
            (lambda a, m: a.channel(0, "weights", [0, 1], [1] * 3), "2 keyframes and 3 numbers; it needs 4"),
            (lambda a, m: a.channel(1, "weights", [0, 1], [1] * 4), "a node without a mesh"),
            (lambda a, m: a.channel(77, "scale", [0, 1], [1] * 6), 'number 77 of "nodes"'),
            (lambda a, m: a.channel(0, "translation", [0, 1], [1] * 6), "two channels of an animation move the translation of node 0"),
            (lambda a, m: a.tree["nodes"][0].update(matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "which has a matrix"),
            (lambda a, m: m["channels"][0].update(sampler=5), 'number 5 of the "samplers"'),
            (lambda a, m: m["channels"][0].pop("sampler"), 'no "sampler"'), (lambda a, m: m["channels"][0].pop("target"), 'no "target"'),
            (lambda a, m: m["channels"].append(3), "must hold objects"), (lambda a, m: m["samplers"].__setitem__(0, []), "must hold objects"),
            (lambda a, m: a.tree.update(animations=[7]), "must hold objects"), (lambda a, m: m["samplers"][0].pop("input"), 'no "input"'),
        ]
        for change, words in cases:
            breaks(change).write(self.path("bad.gltf"))
            result = self.run_etendue("check", "bad.gltf", "--at", "0.5")
            self.assertEqual(result.returncode, 3, f"{words}: {result.stderr}")
            self.assertRegex(result.stdout, r"error: bad\.gltf:\d+:\d+: ")
            self.assertRegex(result.stdout, words)
        # What the standard leaves to others is not moved, and said.
        asset = breaks(lambda a, m: m["channels"].append({"sampler": 0, "target": {"path": "pointer"}}))
        asset.write(self.path("other.gltf"))
        self.expect(0, 'moves "pointer", which is not supported and stays still', "check", "other.gltf", "--at", "0.5")

    # Frames.

    def spin(self, keys=(0, 1, 2)):
        return self.path_scene([key(t, f'<translate value="0,0,-4"/><rotate axis="0,1,0" angle="{30 * t}"/>') for t in keys])

    def test_frames(self):
        scene = self.spin()
        result = self.expect(0, "", "render", scene, *LIGHT, "--spp", "2", "--frames", "1:4", "--fps", "2", "-o", "f-###.exr", "-o",
                             "f#.png", "--json")
        self.assertEqual(sorted(os.listdir(self.folder.name)),
                         ["f-001.exr", "f-002.exr", "f-003.exr", "f1.png", "f2.png", "f3.png", "path.xml"])
        report = json.loads(result.stdout)
        self.assertEqual([frame["frame"] for frame in report["frames"]], [1, 2, 3])
        # Each is what a render at its time is.
        for frame in (1, 2, 3):
            self.expect(0, "", "render", scene, *LIGHT, "--spp", "2", "--at", f"{frame / 2}s", "-o", "one.exr", "--force")
            self.assertEqual(self.read("one.exr"), self.read(f"f-00{frame}.exr"))
        self.assertNotEqual(self.read("f-001.exr"), self.read("f-002.exr"))

    def test_frames_of_an_asset(self):
        asset = Asset().channel(0, "translation", [0, 1], [0, 0, 0, 0.5, 0, 0])
        asset.write(self.path("asset.gltf"))
        self.expect(0, "", "render", "asset.gltf", *LIGHT, "--spp", "16", "--frames", "0:3", "--fps", "4")
        self.expect(0, "", "render", "asset.gltf", *LIGHT, "--spp", "16", "--at", "0.5", "-o", "one.exr")
        self.assertEqual(self.read("one.exr"), self.read("asset-0002.exr"))
        self.assertNotEqual(self.read("one.exr"), self.read("asset-0001.exr"))
        self.assertTrue(os.path.exists(self.path("asset-0000.png")))

    def test_what_is_there_stays(self):
        scene = self.spin()
        command = ["render", scene, *LIGHT, "--frames", "0:3", "--fps", "2", "-o", "f-#.exr", "-o", "f-#.png"]

        def rendered(*more):
            return re.findall(r"wrote f-(\d)", self.expect(0, "", *command, *more).stderr)

        self.assertEqual(rendered("--spp", "2"), ["0", "1", "2"])
        self.assertEqual(rendered("--spp", "2"), [])
        os.remove(self.path("f-1.png"))
        self.assertEqual(rendered("--spp", "2"), ["1"])
        self.assertEqual(rendered("--spp", "2", "--force"), ["0", "1", "2"])
        self.assertEqual(rendered("--spp", "3"), ["0", "1", "2"])  # more samples
        self.assertEqual(rendered("--spp", "3", "--aov", "depth"), ["0", "1", "2"])
        self.assertEqual(rendered("--spp", "3", "--aov", "depth"), [])
        self.assertEqual(rendered("--spp", "3", "--seed", "2"), ["0", "1", "2"])
        self.spin((0, 1, 3))  # the scene is edited: a spline takes another way everywhere but at its keys
        self.assertEqual(rendered("--spp", "3", "--seed", "2"), ["1"])
        self.expect(0, "", *command, "--film", "--spp", "3", "--seed", "2", "--force")
        self.assertEqual(rendered("--film", "--spp", "3", "--seed", "2"), [])

    def test_interrupted_frames_go_on(self):
        scene = self.spin()
        command = ["render", scene, "--device", "reference", "--size", "60x40", "--spp", "600", "--frames", "0:2", "--fps", "2", "-o"]
        for patience in (0.5, 2, 8):  # until it has begun
            process = subprocess.Popen([ETENDUE, *command, "f-#.exr"], cwd=self.folder.name, stderr=subprocess.PIPE, text=True)
            time.sleep(patience)
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130, err)
            if "before anything was rendered" not in err and "before the first pass" not in err:
                break
        self.assertTrue(os.path.exists(self.path("f-0.checkpoint.exr")), err)
        before = re.search(r"at (\d+) spp of 600, interrupted", err)
        self.assertIsNotNone(before, err)
        # Another render's checkpoint is not gone on from.
        self.expect(6, ["Frame 0 was interrupted and cannot continue", "--force"], *command, "f-#.exr", "--seed", "7")
        self.assertTrue(os.path.exists(self.path("f-0.checkpoint.exr")))
        self.expect(0, "", *command, "f-#.exr")
        self.assertEqual(sorted(glob.glob(self.path("*.checkpoint.exr"))), [])
        self.expect(0, "", *command, "g-#.exr")
        for frame in "01":
            self.assertEqual(self.read(f"f-{frame}.exr"), self.read(f"g-{frame}.exr"))

    def test_what_frames_do_not_take(self):
        scene = self.spin()
        for more, words in ((["-o", "f.exr"], "'-o f.exr' has no place for the number of the frame"),
                            (["-o", "#-#.exr"], "two places"), (["-o", "f-#.exr", "--time", "1m"], "--time"),
                            (["-o", "f-#.exr", "--until-error", "1%"], "--until-error"), (["-o", "f-#.exr", "--at", "1s"], "--at"),
                            (["-o", "f-#.exr", "--resume", "x.exr"], "--resume"), (["-o", "f-#.exr", "--fps", "0"], "--fps"),
                            (["-o", "f-#.exr", "--checkpoint", "c.exr"], "'--checkpoint c.exr' has no place"), (["-o", "f-#.bmp"], ".bmp")):
            self.expect(2, words, "render", scene, *LIGHT, "--frames", "0:2", *more)
        for text in ("3", "2:2", "3:1", "a:b", "-1:2", "0:4294967296"):
            self.expect(2, "--frames", "render", scene, *LIGHT, f"--frames={text}", "-o", "f-#.exr")


if __name__ == "__main__":
    unittest.main(verbosity=2)
