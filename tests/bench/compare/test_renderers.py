"""The adapters write what the renderers' manuals ask for. None of them is started."""
import json
import math
import os
import re
import struct
import tempfile
import unittest
import xml.etree.ElementTree

from compare import RayComparison, Run, spread
from renderers import ADAPTERS, Cycles, Mitsuba, Pbrt, Unsupported


def scene(**changes):
    """A camera at (1, 2, 3) that looks along world +X, so that world −Z is on its left; the columns are left, up, forward."""
    description = {
        'name': 'test',
        'camera': {'width': 80, 'height': 60, 'fov': 40.0, 'near': 0.01, 'far': 100.0,
                   'world_from_camera': [[0, 0, 1, 1], [0, 1, 0, 2], [-1, 0, 0, 3], [0, 0, 0, 1]]},
        'integrator': {'type': 'path', 'max_depth': 8, 'rr_depth': 5, 'nee': True, 'mis': True},
        'samples': 16,
        'sky': {'top': [0.1, 0.2, 0.3], 'horizon': [0.1, 0.2, 0.3]},
        'shapes': [
            {'name': 'a', 'mesh': {'file': 'shape-0.ply', 'triangles': 2, 'normals': False},
             'bsdf': {'type': 'diffuse', 'albedo': [0.1, 0.2, 0.3]}, 'radiance': [3, 2, 1]},
            {'name': 'b', 'sphere': {'center': [1, 2, 3], 'radius': 0.5}, 'bsdf': {'type': 'dielectric', 'int_ior': 1.5, 'ext_ior': 1.2},
             'radiance': None},
            {'name': 'c', 'mesh': {'file': 'shape-2.ply', 'triangles': 2, 'normals': True}, 'bsdf': {'type': 'mirror'}, 'radiance': None}]}
    description.update(changes)
    return json.loads(json.dumps(description))


def exported(adapter, description, name):
    with tempfile.TemporaryDirectory() as folder:
        adapter.export(description, folder)
        with open(os.path.join(folder, name), 'rb') as file:
            return file.read()


class MitsubaTest(unittest.TestCase):
    def setUp(self):
        self.adapter = Mitsuba('scalar_rgb')
        self.root = xml.etree.ElementTree.fromstring(exported(self.adapter, scene(), 'mitsuba.xml'))

    def test_depth_counts_segments(self):
        self.assertEqual(self.root.find("integrator/integer[@name='max_depth']").get('value'), '8')

    def test_shapes_materials_and_lights(self):
        ply, sphere, smooth = self.root.findall('shape')
        self.assertEqual(ply.find("boolean[@name='face_normals']").get('value'), 'true')
        self.assertEqual(ply.find('emitter/rgb').get('value'), '3, 2, 1')
        self.assertEqual(ply.find('bsdf/rgb').get('value'), '0.1, 0.2, 0.3')
        self.assertEqual(sphere.find('point').attrib, {'name': 'center', 'x': '1', 'y': '2', 'z': '3'})
        self.assertEqual(sphere.find("bsdf/float[@name='int_ior']").get('value'), '1.5')
        self.assertIsNone(smooth.find('boolean'))
        self.assertEqual(smooth.find('bsdf').get('type'), 'conductor')

    def test_gradient_sky_is_brightest_at_the_top_row(self):
        sky = {'top': [1, 0, 0], 'horizon': [0, 1, 0]}
        data = exported(self.adapter, scene(sky=sky), 'sky.pfm')
        header = b'PF\n16 2048\n-1.0\n'
        self.assertTrue(data.startswith(header))
        pixels = data[len(header):]
        self.assertEqual(len(pixels), 16 * 2048 * 12)
        bottom, top = struct.unpack_from('<3f', pixels), struct.unpack_from('<3f', pixels, len(pixels) - 12)
        self.assertEqual(bottom, (0.0, 1.0, 0.0))
        self.assertAlmostEqual(top[0], 1.0, places=5)
        # A quarter of the way down, 45 degrees above the horizon.
        quarter = struct.unpack_from('<3f', pixels, 12 * 16 * (2048 * 3 // 4))
        self.assertAlmostEqual(quarter[0], math.sqrt(0.5), delta=2e-3)

    def test_time_in_any_unit(self):
        for text, seconds in (('ms', 0.5), ('s', 500.0), ('m', 30000.0)):
            self.assertAlmostEqual(self.adapter.render_seconds(f'x\nRendering finished. (took 500{text})\n'), seconds)
        self.assertIsNone(self.adapter.render_seconds('nothing'))


class PbrtTest(unittest.TestCase):
    def text(self, description=None):
        return exported(Pbrt(), description or scene(), 'pbrt.pbrt').decode()

    def test_depth_counts_scattering(self):
        self.assertIn('"integer maxdepth" [ 7 ]', self.text())

    def test_camera_sees_what_ours_sees(self):
        found = re.search(r'^Transform \[ (.*) \]$', self.text(), re.MULTILINE)
        m = [float(v) for v in found.group(1).split()]

        def to_camera(p):
            return [sum(m[4 * c + r] * v for c, v in enumerate((*p, 1.0))) for r in range(3)]
        self.assertEqual(to_camera((1, 2, 3)), [0, 0, 0])
        self.assertEqual(to_camera((6, 2, 3)), [0, 0, 5], 'forward')
        self.assertEqual(to_camera((1, 3, 3)), [0, 1, 0], 'up')
        self.assertEqual(to_camera((1, 2, 2)), [-1, 0, 0], 'our +X, to the left')

    def test_field_of_view_is_that_of_the_shorter_side(self):
        fov = float(re.search(r'"float fov" \[ ([\d.]+) \]', self.text()).group(1))
        self.assertAlmostEqual(math.tan(math.radians(fov / 2)), math.tan(math.radians(20)) * 0.75, places=6)

    def test_a_gradient_is_refused(self):
        with self.assertRaises(Unsupported):
            self.text(scene(sky={'top': [1, 0, 0], 'horizon': [0, 1, 0]}))

    def test_time(self):
        self.assertEqual(Pbrt().render_seconds('Rendering: [+++++]  (12.5s)'), 12.5)


class OtherTest(unittest.TestCase):
    def test_cycles_time_and_depth(self):
        self.assertEqual(Cycles().render_seconds('Saved\nCYCLES 3.4.1 5.66\n\nBlender quit'), 5.66)
        with self.assertRaises(Unsupported):
            Cycles().export(scene(integrator={'type': 'path', 'max_depth': 1}), '.')

    def test_everyone_refuses_what_is_no_path_tracing(self):
        for adapter in ADAPTERS:
            with self.assertRaises(Unsupported), tempfile.TemporaryDirectory() as folder:
                adapter.export(scene(integrator={'type': 'normals', 'max_depth': 8}), folder)

    def test_json_among_messages(self):
        self.assertEqual(Run(['printf', 'a {b}\\n{\\n"x": 1}\\nDone.'], 2).json(), {'x': 1})
        with self.assertRaises(RuntimeError):
            Run(['false'], 2)

    def test_other_hits_are_a_failure(self):
        comparison = RayComparison('scene', '.', [], None)
        comparison.differ = {('primary', 'picture'): 0.0}
        self.assertTrue(comparison.passed())
        comparison.differ['diffuse', 'picture'] = 0.01
        self.assertFalse(comparison.passed())

    def test_spread(self):
        self.assertEqual(spread([3, 1, 2]), {'median': 2, 'min': 1, 'max': 3, 'count': 3})


if __name__ == '__main__':
    unittest.main()
