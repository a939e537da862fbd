"""The adapters write what the renderers' manuals ask for. None of them is started."""

import contextlib
import json
import math
import os
import re
import tempfile
import unittest
import unittest.mock
import xml.etree.ElementTree

import table
from compare import RayComparison, SampleComparison, ratios, spread
from process import Run
from renderers import ADAPTERS, Cycles, Mitsuba, Pbrt, Source, Unsupported, newest_llvm
from shared_scene import box_filtered


def scene(**changes):
    """A camera at (1, 2, 3) that looks along world +X, with world −Z on its left; the columns are left, up, forward."""
    description = {
        'name': 'test',
        'camera': {
            'width': 80,
            'height': 60,
            'fov': 40.0,
            'near': 0.01,
            'far': 100.0,
            'world_from_camera': [[0, 0, 1, 1], [0, 1, 0, 2], [-1, 0, 0, 3], [0, 0, 0, 1]],
        },
        'integrator': {'type': 'path', 'max_depth': 8, 'rr_depth': 5, 'nee': True, 'mis': True},
        'samples': 16,
        'sky': {'top': [0.1, 0.2, 0.3], 'horizon': [0.1, 0.2, 0.3]},
        'shapes': [
            {
                'name': 'a',
                'mesh': {'file': 'shape-0.ply', 'triangles': 2, 'normals': False},
                'bsdf': {'type': 'diffuse', 'albedo': [0.1, 0.2, 0.3]},
                'radiance': [3, 2, 1],
            },
            {
                'name': 'b',
                'sphere': {'center': [1, 2, 3], 'radius': 0.5},
                'bsdf': {'type': 'dielectric', 'int_ior': 1.5, 'ext_ior': 1.2},
                'radiance': None,
            },
            {
                'name': 'c',
                'mesh': {'file': 'shape-2.ply', 'triangles': 2, 'normals': True},
                'bsdf': {'type': 'mirror'},
                'radiance': None,
            },
        ],
    }
    description.update(changes)
    return json.loads(json.dumps(description))


def exported(adapter, description, name):
    with tempfile.TemporaryDirectory() as folder:
        adapter.export(description, folder)
        with open(os.path.join(folder, name), 'rb') as file:
            return file.read()


def converted(integrator='path'):
    """A source that is converted to a scene with nothing in it, and has the description of scene()."""

    def convert(out, *options):
        assert options == ('--to', 'mitsuba')
        with open(out, 'w', encoding='utf-8') as file:
            file.write(
                f'<scene version="3.0.0"><integrator type="{integrator}"/><sensor type="perspective">'
                '<film type="hdrfilm"/><sampler type="independent"><integer name="sample_count" value="4"/></sampler>'
                '</sensor></scene>'
            )

    return Source(convert, scene(integrator={'type': integrator, 'max_depth': 8, 'rr_depth': 5}))


def prepared(adapter, name):
    with tempfile.TemporaryDirectory() as folder:
        adapter.prepare(converted(), folder)
        with open(os.path.join(folder, name), 'rb') as file:
            return file.read()


@contextlib.contextmanager
def on_path(**programs):
    """Programs by name, shell scripts with the given text, as all there is on PATH."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in programs.items():
            path = os.path.join(folder, name)
            with open(path, 'w', encoding='utf-8') as file:
                file.write(f'#!/bin/sh\n{text}\n')
            os.chmod(path, 0o755)
        with unittest.mock.patch.dict(os.environ, {'PATH': folder}):
            yield folder


class MitsubaTest(unittest.TestCase):
    def setUp(self):
        self.adapter = Mitsuba('scalar_rgb')
        self.root = xml.etree.ElementTree.fromstring(prepared(self.adapter, 'mitsuba.xml'))

    def test_pictures_are_read_without_a_library(self):
        self.assertEqual(self.root.find("sensor/film/string[@name='file_format']").get('value'), 'pfm')

    def test_samples_and_seed_are_defined_on_the_command_line(self):
        """-s would choose the sensor with that number."""
        defaults = {d.get('name') for d in self.root.findall('default')}
        sampler = {i.get('name'): i.get('value') for i in self.root.find('sensor/sampler')}
        self.assertEqual(sampler, {'sample_count': '$spp', 'seed': '$seed'})
        self.assertEqual(defaults, {'spp', 'seed'})
        with on_path(mitsuba='true'):
            command = self.adapter.command('folder', 'out.exr', 24, 2, 7)
        self.assertNotIn('-s', command)
        defined = [command[i + 1] for i, word in enumerate(command) if word == '-D']
        self.assertEqual(defined, ['spp=24', 'seed=7'])
        self.assertEqual(command[command.index('-t') + 1], '3', 'one thread does not render')

    def test_the_library_of_the_variant(self):
        with unittest.mock.patch.dict(os.environ, {'DRJIT_LIBLLVM_PATH': '/lib/libLLVM.so.42.0'}):
            self.assertEqual(Mitsuba('llvm_ad_rgb').environment(), {'DRJIT_LIBLLVM_PATH': '/lib/libLLVM.so.42.0'})
            self.assertEqual(Mitsuba('scalar_rgb').environment(), {})
        names = [
            '/usr/lib/x/libLLVM-9.so',
            '/usr/lib/x/libLLVM-15.so.1',
            '/usr/lib/x/libLLVM.so.19.1',
            '/usr/lib/x/libLLVM.so',
            '/usr/lib/x/libLLVM-14.0.6.so.1',
        ]
        with unittest.mock.patch('glob.glob', side_effect=[names, [], []]):
            self.assertEqual(newest_llvm(), '/usr/lib/x/libLLVM.so.19.1')
        with unittest.mock.patch('glob.glob', return_value=[]):
            self.assertIsNone(newest_llvm())

    def test_version(self):
        help_text = 'Mitsuba version 3.9.1 (master[478e193], Linux, 64bit, 3 threads, 8-wide SIMD)'
        with on_path(mitsuba=f'echo "{help_text}"'):
            self.assertEqual(Mitsuba('scalar_rgb').version(), 'Mitsuba 3.9.1')
        output = 'jit_llvm_init(): found LLVM 19.1.7 (ORCv2), target=x86_64-pc-linux-gnu, cpu=x, width=16.\nmore'
        self.assertEqual(self.adapter.details(output), 'LLVM 19.1.7, 16 wide')
        self.assertEqual(self.adapter.details('nothing'), '')

    def test_the_program_of_the_package(self):
        with on_path(mitsuba='true') as folder:
            self.assertEqual(Mitsuba('scalar_rgb').find(), os.path.join(folder, 'mitsuba'))
        with tempfile.TemporaryDirectory() as root:
            program = os.path.join(os.path.realpath(root), 'lib', 'python3.11', 'site-packages', 'mitsuba', 'mitsuba')
            for path in (program, os.path.join(root, 'bin', 'mitsuba')):
                os.makedirs(os.path.dirname(path))
                with open(path, 'w', encoding='utf-8') as file:
                    file.write('#!/bin/sh\n')
                os.chmod(path, 0o755)
            with unittest.mock.patch.dict(os.environ, {'PATH': os.path.join(root, 'bin')}):
                self.assertEqual(Mitsuba('scalar_rgb').find(), program)
        with on_path():
            self.assertIsNone(Mitsuba('scalar_rgb').find())

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


class CyclesTest(unittest.TestCase):
    """Blender comes as a program or as a module of a Python."""

    finds, finds_not = 'echo "a warning"; echo "bpy found"', 'echo none'

    def test_the_module_is_taken_before_the_program(self):
        with on_path(python3=self.finds, blender='true') as folder:
            cycles = Cycles()
            self.assertEqual(cycles.find(), os.path.join(folder, 'python3'))
            command = cycles.command('folder', 'out.exr', 24, 2, 7)
            self.assertEqual(command[0], os.path.join(folder, 'python3'))
            self.assertEqual(command[-6:], ['--', 'folder', 'out.exr', '24', '2', '7'])
            self.assertEqual(cycles.environment(), {}, 'the module needs the Python it lies in')

    def test_the_program_where_there_is_no_module(self):
        with on_path(python3=self.finds_not, blender='echo "Blender 3.4.1"') as folder:
            cycles = Cycles()
            self.assertEqual(cycles.find(), os.path.join(folder, 'blender'))
            command = cycles.command('folder', 'out.exr', 24, 2, 7)
            self.assertIn('-b', command)
            self.assertEqual(command[-6:], ['--', 'folder', 'out.exr', '24', '2', '7'])
            self.assertTrue(cycles.environment()['PATH'].startswith('/usr/bin:'))
            self.assertEqual(cycles.version(), 'Blender 3.4.1')

    def test_neither(self):
        with on_path(python3=self.finds_not):
            self.assertIsNone(Cycles().find())
        with on_path():
            self.assertIsNone(Cycles().find())


class TableTest(unittest.TestCase):
    def report(self):
        spread_of = {'median': 2e6, 'min': 1e6, 'max': 3e6, 'count': 3}
        ratio = {'median': 2.0, 'min': 1.5, 'max': 2.5, 'count': 3}
        rates = {'samples_per_second': spread_of, 'samples_per_cpu_second': spread_of}
        agreement = {
            'brighter': [0.001, -0.002, 0.0],
            'brighter_95': [0.001, 0.003, 0.002],
            'blocks': 432,
            'z_deviation': 0.97,
            'z_largest': 2.5,
            'z_largest_expected': 4.2,
        }
        rows = [
            {'renderer': 'etendue', **rates},
            {'renderer': 'other', **rates, 'ratio': ratio, 'cpu_ratio': ratio, 'agreement': agreement},
            {'renderer': 'third', 'unsupported': 'has no | sky'},
        ]
        return {
            'date': '2026-01-02',
            'command': './compare.py x.xml',
            'load': 0.1,
            'sources': 'abc1234',
            'device': 'a device',
            'driver': 'a driver',
            'threads': 2,
            'size': '8x6',
            'spp': 4,
            'repetitions': 3,
            'versions': {'other': 'Other 1.2'},
            'changes': {'scenes/box.xml': ['brass for gold', 'tin for silver']},
            'rays': [],
            'samples': [{'scene': 'scenes/box.xml', 'rows': rows}],
            'machine': {'processor': 'A processor', 'instruction_set': 'AVX2', 'processors': 2},
        }

    @staticmethod
    def words(text):
        """Without regard to where lines end."""
        return ' '.join(text.split())

    def test_every_row_has_every_column(self):
        lines = [line for line in table.markdown(self.report()).split('\n') if line.startswith('|')]
        self.assertEqual(len(lines), 5)
        self.assertEqual({len(re.findall(r'(?<!\\)\|', line)) for line in lines}, {9})

    def test_what_the_table_says(self):
        text = self.words(table.markdown(self.report()))
        for part in (
            './compare.py x.xml',
            'A processor',
            'AVX2',
            '8x6',
            'Other 1.2',
            '2.00 (1.50–2.50)',
            '+0.10 -0.20 +0.00 ±0.30 %',
            '0.97, 2.5 (4.2)',
            'otherwise idle',
            '- box: brass for gold and tin for silver, in all programs',
        ):
            self.assertIn(part, text)
        self.assertIn('abc1234', text)
        self.assertIn('others used the machine', self.words(table.markdown({**self.report(), 'load': 3.0})))
        self.assertIn('0.97, 2.5 (4.2)', table.terminal_text(self.report()))

    def test_the_widest_instruction_set(self):
        def of(flags):
            return table.machine(f'model name\t: Name of it\nflags\t\t: fpu {flags} x\n')

        self.assertEqual(of('avx avx2 avx512f')['instruction_set'], 'AVX-512')
        self.assertEqual(of('sse4_2 avx avx2')['instruction_set'], 'AVX2')
        self.assertEqual(of('avx2')['processor'], 'Name of it')
        self.assertEqual(table.machine('Features : fp asimd')['instruction_set'], 'NEON')
        self.assertEqual(table.machine('')['instruction_set'], 'unknown')

    def test_only_what_stands_between_the_marks_is_replaced(self):
        with tempfile.TemporaryDirectory() as folder:
            page = os.path.join(folder, 'page.md')
            with open(page, 'w', encoding='utf-8') as file:
                file.write(f'before\n{table.BEGIN} -->\nold\n{table.END}\nafter\n')
            for _ in range(2):
                table.write_between_marks(page, 'new')
            with open(page, encoding='utf-8') as file:
                self.assertEqual(file.read(), f'before\n{table.BEGIN} -->\n\nnew\n\n{table.END}\nafter\n')
            with open(page, 'w', encoding='utf-8') as file:
                file.write('no marks\n')
            with self.assertRaisesRegex(ValueError, 'has no lines'):
                table.write_between_marks(page, 'new')


class FilterTest(unittest.TestCase):
    def box(self, text):
        """What becomes of a scene: its text and whether it is the same file."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'scene.xml')
            with open(path, 'w', encoding='utf-8') as file:
                file.write(text)
            out = box_filtered(None, path, os.path.join(folder, 'box'))
            with open(out, encoding='utf-8') as file:
                return file.read().replace(folder, 'FOLDER'), out == path

    def test_a_box_is_left_alone(self):
        text = '<scene><camera><rfilter type="box"/></camera></scene>'
        self.assertEqual(self.box(text), (text, True))

    def test_whatever_the_default_is(self):
        text, same = self.box('<scene><camera/></scene>')
        self.assertFalse(same)
        self.assertEqual(xml.etree.ElementTree.fromstring(text).find('camera/rfilter').attrib, {'type': 'box'})

    def test_another_becomes_a_box_and_files_are_still_found(self):
        text, same = self.box(
            '<scene><camera><rfilter type="gaussian"><float name="stddev" value="1"/></rfilter></camera>'
            '<mesh type="obj"><string name="filename" value="meshes/a.obj"/></mesh>'
            '<mesh type="obj"><string name="filename" value="etendue:b.obj"/></mesh></scene>'
        )
        self.assertFalse(same)
        root = xml.etree.ElementTree.fromstring(text)
        self.assertEqual(root.find('camera/rfilter').attrib, {'type': 'box'})
        self.assertEqual(len(root.find('camera/rfilter')), 0)
        files = [file.get('value') for file in root.iterfind('mesh/string')]
        self.assertEqual(files, ['FOLDER/meshes/a.obj', 'etendue:b.obj'])


class OtherTest(unittest.TestCase):
    def test_cycles_time_and_depth(self):
        self.assertEqual(Cycles().render_seconds('Saved\nCYCLES 3.4.1 5.66\n\nBlender quit'), 5.66)
        with self.assertRaises(Unsupported):
            Cycles().export(scene(integrator={'type': 'path', 'max_depth': 1}), '.')

    def test_everyone_refuses_what_is_no_path_tracing(self):
        for adapter in ADAPTERS:
            with self.assertRaises(Unsupported), tempfile.TemporaryDirectory() as folder:
                adapter.prepare(converted('normals'), folder)

    def test_what_has_no_neutral_export_is_for_mitsuba_only(self):
        for adapter in ADAPTERS:
            with tempfile.TemporaryDirectory() as folder:
                source = Source(converted().convert, reason='textures')
                if isinstance(adapter, Mitsuba):
                    adapter.prepare(source, folder)
                    continue
                with self.assertRaisesRegex(Unsupported, 'textures'):
                    adapter.prepare(source, folder)

    def test_what_cannot_be_converted_is_left_out_with_the_reason(self):
        def convert(*_):
            raise RuntimeError("'etendue convert a.xml' ended with code 3:\nerror: a.xml: a material is not there\n")

        for adapter in ADAPTERS:
            if isinstance(adapter, Mitsuba):
                with self.assertRaisesRegex(Unsupported, '^error: a.xml: a material is not there$'):
                    adapter.prepare(Source(convert, scene()), '.')

    def test_json_among_messages(self):
        self.assertEqual(Run(['printf', 'a {b}\\n{\\n"x": 1}\\nDone.'], 2).json(), {'x': 1})
        with self.assertRaises(RuntimeError):
            Run(['false'], 2)

    def test_other_hits_are_a_failure(self):
        comparison = RayComparison('scene', 'scene.xml', '.', [], None)
        comparison.differ = {('primary', 'picture'): 0.0}
        self.assertTrue(comparison.passed())
        comparison.differ['diffuse', 'picture'] = 0.01
        self.assertFalse(comparison.passed())

    def test_rays_are_cast_through_the_file(self):
        """Not through what the command line calls it: a made scene is no file."""
        etendue = unittest.mock.Mock()
        etendue.rays.return_value = {}
        with unittest.mock.patch('compare.Run') as run:
            run.return_value.json.return_value = {'rays': []}
            RayComparison('made:empty', 'a.xml', '.', [etendue], unittest.mock.Mock(embree_high=False)).repeat(0)
        etendue.rays.assert_called_once_with('a.xml')

    def test_spread(self):
        self.assertEqual(spread([3, 1, 2]), {'median': 2, 'min': 1, 'max': 3, 'count': 3})

    def test_what_is_too_short_to_measure_is_no_number(self):
        self.assertEqual(ratios([4.0, None, 3.0], [2.0, 1.0, None]), [2.0, None, None])
        self.assertIsNone(spread([2.0, None, 3.0]))
        self.assertEqual(table.spread_text(spread([2.0, None])), 'too short')

    def test_cpu_time_of_a_short_picture(self):
        """A program whose picture costs hardly more than its start has no rate per CPU second."""
        for cpu, expected in ((2.05, None), (3.0, 48 * 3 / 1.0)):
            comparison = SampleComparison.__new__(SampleComparison)
            comparison.scene, comparison.samples, comparison.rates = 'scene.xml', 48 * 4, {}
            comparison.options, comparison.base_cpu, comparison.base_seconds = unittest.mock.Mock(spp=4), {'one': 2.0}, {}
            comparison.estimates = {'one': unittest.mock.Mock()}
            comparison.programs = lambda: [('one', '.exr', None)]
            comparison.render = lambda *how, cpu=cpu: ('out.exr', 0.5, cpu)
            with unittest.mock.patch('compare.agreement', unittest.mock.Mock()), unittest.mock.patch('compare.say'):
                comparison.repeat(0)
            self.assertEqual(comparison.rates['one'][0], (48 * 4 / 0.5, expected))

    def test_compilation_is_that_of_a_picture_of_one_sample(self):
        """Of Etendue, whose first samples cannot be told from the compilation that they wait for."""
        for base, expected in ((0.3, 48 * 3 / 0.2), (0.4, None)):
            comparison = SampleComparison.__new__(SampleComparison)
            comparison.scene, comparison.samples, comparison.rates = 'scene.xml', 48 * 4, {}
            comparison.options = unittest.mock.Mock(spp=4)
            comparison.base_cpu, comparison.base_seconds = {'one': 2.0}, {'one': base}
            comparison.estimates = {'one': unittest.mock.Mock()}
            comparison.programs = lambda: [('one', '.exr', None)]
            comparison.render = lambda *how: ('out.exr', 0.5, 3.0)
            with unittest.mock.patch('compare.agreement', unittest.mock.Mock()), unittest.mock.patch('compare.say'):
                comparison.repeat(0)
            rate = comparison.rates['one'][0][0]
            self.assertEqual(rate is None, expected is None)
            self.assertAlmostEqual(rate or 0.0, expected or 0.0)


if __name__ == '__main__':
    unittest.main()
