"""What against.py does around the renderers: pictures out and in again, the box filter, scores, the page. Where Mitsuba
is installed, a scene is held against it from end to end, as it is and with a lamp of another brightness, which must be
noticed; ETENDUE names the program.

Exit code 77: there is no numpy.
"""

import json
import os
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree
import zlib

try:
    import numpy
except ModuleNotFoundError:
    sys.exit(77)

import against
import against_page
import exr
from renderers import python_with

SCENE = """<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 3, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/>{filter}</film>
  </sensor>
  <shape type="sphere"><point name="center" y="1" x="0" z="0"/><bsdf type="plastic"/></shape>
  <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="4"/></transform></shape>
  <emitter type="point"><point name="position" x="2" y="4" z="2"/><rgb name="intensity" value="20"/></emitter>
  <emitter type="constant"><rgb name="radiance" value="0.2, 0.3, 0.5"/></emitter>
</scene>
"""


def picture(mean, error, samples=100):
    shape = (6, 8, 3)
    return against.Picture(numpy.full(shape, mean), numpy.full(shape, error), samples, 'Peer 1.0')


class PictureTest(unittest.TestCase):
    def test_what_is_written_is_read(self):
        random = numpy.random.default_rng(3)
        drawn = against.Picture(random.random((5, 7, 3)), random.random((5, 7, 3)), 12, '')
        with tempfile.TemporaryDirectory() as folder:
            drawn.write(os.path.join(folder, 'a.exr'))
            planes = exr.read(os.path.join(folder, 'a.exr'))
        self.assertEqual(sorted(planes), ['B', 'G', 'R', 'SampleCount', 'StdErr.B', 'StdErr.G', 'StdErr.R'])
        for i, c in enumerate('RGB'):
            self.assertTrue(numpy.array_equal(planes[c], drawn.mean[:, :, i].astype('<f4')))
            self.assertTrue(numpy.array_equal(planes[f'StdErr.{c}'], drawn.error[:, :, i].astype('<f4')))
        self.assertTrue((planes['SampleCount'] == 12).all())

    def test_scores_of_means(self):
        """48 pixels of error 3 and 4 have a mean with error 5/√48."""
        planes = {c: numpy.full((6, 8), 1.0, '<f4') for c in 'RGB'}
        planes |= {f'StdErr.{c}': numpy.full((6, 8), 3.0, '<f4') for c in 'RGB'}
        scores = against.mean_scores(planes, picture(0.0, 4.0))
        for score in scores:
            self.assertAlmostEqual(score, 48.0**0.5 / 5.0)
        still = {c: p if not c.startswith('StdErr') else 0.0 * p for c, p in planes.items()}
        self.assertEqual(against.mean_scores(still, picture(0.0, 0.0)), [0.0, 0.0, 0.0])


class SceneTest(unittest.TestCase):
    def test_the_box_filter_takes_the_place_of_any_other(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'scene.xml')
            with open(path, 'w', encoding='utf-8') as file:
                file.write('<scene><camera type="perspective"><rfilter type="tent"/></camera></scene>')
            against.with_box_filter(path)
            camera = xml.etree.ElementTree.parse(path).getroot().find('camera')
        self.assertEqual([f.get('type') for f in camera.findall('rfilter')], ['box'])

    def test_lists(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'list')
            with open(path, 'w', encoding='utf-8') as file:
                file.write('# all of them\na.xml\n\n  b/c.xml\n')
            found = list(against.listed(['first.xml', '@' + path]))
        self.assertEqual(found, ['first.xml', os.path.join(folder, 'a.xml'), os.path.join(folder, 'b/c.xml')])


class PageTest(unittest.TestCase):
    ROW = {
        'scene': 'a<b.xml',
        'peer': 'mitsuba',
        'version': 'Mitsuba 3',
        'source': 'converted',
        'samples': [64, 32],
        'verdict': 'different',
        'why': '',
        'z_of_means': [0.5, -7.25, 1.0],
        'brighter': -0.0125,
        'families': {'8×8 blocks': {'tests': 12, 'familyP': 0.5, 'worst': {'z': 2.5}}},
        'pictures': [numpy.full((40, 500, 3), 0.5), numpy.full((40, 500, 3), 0.25)],
    }

    def test_everything_is_on_the_page(self):
        bad = {'scene': 'c.xml', 'peer': 'cycles', 'verdict': 'not compared', 'why': 'a material & more'}
        text = against_page.page({'date': 'today', 'etendue': 'etendue 1', 'command': 'x', 'rows': [self.ROW, bad]})
        for word in ('a&lt;b.xml', '-7.2', '-1.250 %', '8×8 blocks: worst z +2.5', 'converted', '64 and 32 samples'):
            self.assertIn(word, text)
        self.assertIn('a material &amp; more', text)
        self.assertIn('1 different, 1 not compared', text)
        self.assertEqual(text.count('data:image/png'), 2)
        self.assertIn('z of means +0.5 -7.2 +1.0, brighter by -1.25 %', against_page.line(self.ROW))
        self.assertTrue(against_page.line(bad).endswith('not compared: a material & more'))

    def test_thumbnails_are_means_as_codes_of_srgb(self):
        stripes = numpy.zeros((4, 480, 3))
        stripes[:, ::2] = 1.0
        small = against_page.smaller(stripes)
        self.assertEqual(small.shape, (2, 240, 3))
        self.assertTrue(numpy.allclose(small, 0.5))
        self.assertEqual(against_page.srgb(numpy.array([0.0, 0.5, 2.0])).tolist(), [0, 188, 255])
        data = against_page.png(against_page.srgb(small))
        at = data.index(b'IDAT') + 4
        rows = zlib.decompress(data[at:-16])  # the sum of the chunk, and IEND
        self.assertEqual(rows, (b'\0' + bytes([188]) * 720) * 2)


class MitsubaTest(unittest.TestCase):
    def setUp(self):
        self.etendue = os.environ.get('ETENDUE')
        if not self.etendue or not python_with('mitsuba'):
            self.skipTest('Mitsuba is not installed, or ETENDUE does not name the program')

    def against(self, folder, text, *more):
        path = os.path.join(folder, 'scene.xml')
        with open(path, 'w', encoding='utf-8') as file:
            file.write(text)
        files = [os.path.join(folder, name) for name in ('page.html', 'rows.json')]
        command = [sys.executable, 'against.py', path, '--etendue', self.etendue, '--with', 'mitsuba']
        counts = ['--spp', '64', '--pictures', '32', '--variant', 'scalar_rgb', '-o', files[0], '--json', files[1]]
        done = subprocess.run([*command, *counts, *more], capture_output=True, text=True, check=False)
        self.assertTrue(os.path.exists(files[1]), done.stdout + done.stderr)
        with open(files[1], encoding='utf-8') as file:
            return done.returncode, json.load(file)['rows'][0]

    def test_a_scene_is_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            code, row = self.against(folder, SCENE.format(filter='<rfilter type="box"/>'))
        self.assertEqual((code, row['verdict'], row['source']), (0, 'statistically equal', ''), row)
        self.assertLess(max(map(abs, row['z_of_means'])), 4.5)

    def test_another_filter_takes_a_copy_and_a_brighter_lamp_is_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            code, row = self.against(folder, SCENE.format(filter=''))
            self.assertEqual((code, row['verdict'], row['source']), (0, 'statistically equal', 'converted'), row)
            # The copy of another scene, whose lamp is a tenth brighter, stands for an error of the exchange.
            fake = os.path.join(folder, 'etendue')
            with open(fake, 'w', encoding='utf-8') as file:
                file.write(f'#!/bin/sh\n{self.etendue} "$@" || exit\n[ "$1" = convert ] && [ "$5" = mitsuba ] && ')
                file.write('sed -i \'s/name="intensity" value="[^"]*"/name="intensity" value="22"/\' "$3"\nexit 0\n')
            os.chmod(fake, 0o755)
            self.etendue = fake
            code, row = self.against(folder, SCENE.format(filter=''))
        self.assertEqual((code, row['verdict']), (1, 'different'), row)


if __name__ == '__main__':
    unittest.main()
