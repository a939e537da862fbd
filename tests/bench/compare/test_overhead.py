"""Start-up and memory as overhead.py measures them, and the scenes that are made or changed for it. No renderer is started."""

import math
import os
import struct
import tempfile
import unittest
import unittest.mock
import xml.etree.ElementTree
import zlib
from pathlib import Path

import gltf_room
import made_scenes
import overhead
import overhead_table
import shared_copies
from process import Run, TooLong
from shared_scene import GLTF_REPLACED, without_microfacet, with_common_materials

MIB = 1 << 20


class RunTest(unittest.TestCase):
    def test_the_peak_is_that_of_the_program(self):
        """Though this process, which starts it, is much larger."""
        large = bytearray(os.urandom(MIB)) * 300
        self.assertLess(Run(['true'], 1).peak_bytes, 100 * MIB)
        self.assertEqual(len(large), 300 * MIB)

    def test_times(self):
        run = Run(['sh', '-c', 'sleep 0.2'], 1)
        self.assertGreater(run.seconds, 0.2)
        self.assertLess(run.cpu_seconds, 0.2)

    def test_environment(self):
        with unittest.mock.patch.dict(os.environ, {'GONE': 'a', 'KEPT': 'b'}):
            run = Run(['sh', '-c', 'echo ${GONE-unset} $KEPT $MORE'], 1, {'GONE': None, 'MORE': 'c'})
        self.assertEqual(run.output, 'unset b c\n')

    def test_the_limit_ends_a_program_with_its_children(self):
        with self.assertRaisesRegex(TooLong, 'takes more than 1 s'):
            Run(['sh', '-c', 'sleep 30 & wait'], 1, limit=1)
        with self.assertRaisesRegex(RuntimeError, 'ended with code 3'):
            Run(['sh', '-c', 'exit 3'], 1, limit=9)

    def test_a_program_that_is_not_there(self):
        with self.assertRaisesRegex(RuntimeError, 'no-such-program cannot be started: No such file'):
            Run(['no-such-program'], 1)


class CachesTest(unittest.TestCase):
    def test_cold_is_empty_and_warm_is_what_cold_left(self):
        with tempfile.TemporaryDirectory() as folder:
            case = overhead.Case.__new__(overhead.Case)
            case.scene, case.folder, case.options = 'a', folder, unittest.mock.Mock(threads=1, limit=0)
            count = 'for f in "$HOME/a" "$XDG_CACHE_HOME/a"; do test -e "$f" && echo warm; touch "$f"; done'
            case.commands = {'one': ['sh', '-c', f'{count}; echo "${{MESA_SHADER_CACHE_DIR-none}}"; touch {folder}/out.exr']}
            case.environments = {}
            with unittest.mock.patch.dict(os.environ, {'MESA_SHADER_CACHE_DIR': '/there'}):
                for _ in range(2):
                    cold, warm = case.run_cold_and_warm('one')
                    self.assertEqual([cold.output, warm.output], ['none\n', 'warm\nwarm\nnone\n'])

    def test_no_picture_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, 'out.exr').touch()  # of an earlier run
            case = overhead.Case.__new__(overhead.Case)
            case.scene, case.folder, case.options = 'a', folder, unittest.mock.Mock(threads=1, limit=0)
            case.commands, case.environments = {'one': ['true']}, {}
            with self.assertRaisesRegex(RuntimeError, 'no picture of a'):
                case.run_cold_and_warm('one')


class ReportTest(unittest.TestCase):
    def growth(self, thing, numbers):
        cases = [unittest.mock.Mock(commands={'one': []}, unsupported={'two': 'why'}) for _ in range(2)]
        for case, more in zip(cases, (0, 12 * 4096 * 4096)):
            case.run_warm.return_value = unittest.mock.Mock(peak_bytes=100 * MIB + more)
        growth = overhead.Growth(thing, numbers, cases)
        with unittest.mock.patch('overhead.say'):
            growth.repeat(0)
        return growth.report()

    def test_bytes_for_each(self):
        report = self.growth('texels', [1024, 5120])
        self.assertEqual([report['few'], report['many']], [1024**2, 5120**2])
        self.assertEqual(report['rows'][0]['bytes_each']['median'], 12 * 4096**2 / (5120**2 - 1024**2))
        self.assertEqual(report['rows'][1], {'renderer': 'two', 'unsupported': 'why'})
        report = self.growth('instances', [1, 1 + 4096**2])
        self.assertEqual(report['rows'][0]['bytes_each']['median'], 12.0)

    def test_what_takes_too_long_is_left_out(self):
        case = overhead.Case.__new__(overhead.Case)
        case.commands, case.unsupported, case.scene = {'one': []}, {}, 'a'
        case.run_warm = case.run_cold_and_warm = unittest.mock.Mock(side_effect=TooLong('takes more than 5 s'))
        growth = overhead.Growth('texels', [1, 2], [case, unittest.mock.Mock(commands={'one': []})])
        with unittest.mock.patch('overhead.say'):
            growth.repeat(0)
            growth.repeat(1)
        self.assertEqual(growth.report()['rows'], [{'renderer': 'one', 'unsupported': 'takes more than 5 s'}])
        case.commands, case.unsupported = {'one': []}, {}
        start = overhead.StartUp(case)
        with unittest.mock.patch('overhead.say'):
            start.repeat(0)
        self.assertEqual(start.report()['rows'], [{'renderer': 'one', 'unsupported': 'takes more than 5 s'}])

    def test_tables(self):
        value = {'median': 2.0, 'min': 1.0, 'max': 3.0, 'count': 3}
        times = {f'{kind}_{unit}': value for kind in ('cold', 'warm') for unit in ('seconds', 'cpu_seconds')}
        start = [{'renderer': 'one', **times, 'peak_bytes': value}, {'renderer': 'two', 'unsupported': 'why | not'}]
        report = {
            'date': '2026-01-02',
            'command': './overhead.py',
            'load': 0.1,
            'sources': 'abc1234',
            'device': 'a device',
            'driver': 'a driver',
            'threads': 2,
            'size': '8x6',
            'repetitions': 3,
            'versions': {'one': 'One 1.2'},
            'changes': {'scenes/box.xml': ['brass for gold']},
            'machine': {'processor': 'A processor', 'instruction_set': 'AVX2', 'processors': 2},
            'start': [{'scene': 'made:triangles=7', 'rows': start}],
            'memory': [self.growth('instances', [1000, 1001000])],
        }
        text = overhead_table.markdown(report)
        lines = [line.replace('\\|', '') for line in text.split('\n') if line.startswith('|')]
        self.assertEqual([line.count('|') for line in lines], [8] * 4 + [6] * 4)
        for part in ('| made:triangles=7 | one | 2.00 (1.00–3.00) |', 'instances: 1 000 → 1 001 000', '- box: brass for gold'):
            self.assertIn(part, text)
        self.assertIn('201.33 (201.33–201.33)', text)
        self.assertIn('why | not', overhead_table.terminal_text(report))

    def test_triangles_are_those_of_the_mesh(self):
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, 'made'))
            mesh = Path(folder, 'made', 'bumpy-sphere-3.obj')
            mesh.write_text('v 0 0 0\nf 1 1 1\nf 1 1 1\nf 1 1 1\nf 1 1 1\n', encoding='utf-8')
            growth = overhead.Growth('triangles', [3, 4], [])
            self.assertEqual(growth.count(3, unittest.mock.Mock(folder=folder)), 4)

    def test_two_numbers(self):
        self.assertEqual(overhead.two_numbers('10,200'), [10, 200])
        for wrong in ('10', '200,10', '0,5', '5,5'):
            with self.assertRaises(overhead.argparse.ArgumentTypeError):
                overhead.two_numbers(wrong)


class MadeTest(unittest.TestCase):
    def test_names(self):
        self.assertEqual(made_scenes.scene_file('scenes/a.xml', None), 'scenes/a.xml')
        for wrong in ('made:nothing', 'made:triangles', 'made:empty=3', 'made:texels=0', 'made:'):
            with self.assertRaisesRegex(SystemExit, f"no scene '{wrong}'.*made:triangles=NUMBER"):
                made_scenes.scene_file(wrong, None)

    def test_noise_is_a_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, 'a.png')
            made_scenes.write_noise(path, 5)
            data = path.read_bytes()
        self.assertEqual(data[:8] + data[12:24], b'\x89PNG\r\n\x1a\nIHDR' + struct.pack('>II', 5, 5))
        size = struct.unpack('>I', data[33:37])[0]
        rows = zlib.decompress(data[41 : 41 + size])
        self.assertEqual(len(rows), 5 * (1 + 3 * 5))
        self.assertEqual(set(rows[::16]), {0})

    def test_the_rooms_triangles_face_as_their_normals(self):
        for name, mesh in gltf_room.furnished().items():
            self.assertEqual(len(mesh.positions), len(mesh.uvs))
            for at in range(0, len(mesh.indices), 3):
                a, b, c = (mesh.positions[k] for k in mesh.indices[at : at + 3])
                u, v = ([q - p for p, q in zip(a, other)] for other in (b, c))
                cross = [u[i - 2] * v[i - 1] - u[i - 1] * v[i - 2] for i in range(3)]
                normal = mesh.normals[mesh.indices[at]]
                self.assertAlmostEqual(math.hypot(*normal), 1.0)
                self.assertGreater(sum(p * q for p, q in zip(cross, normal)), 0.0, name)


def shape(matrix='1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1', more='', file='a.ply'):
    return (
        f'<shape type="ply"><string name="filename" value="{file}"/><boolean name="face_normals" value="true"/>'
        f'<transform name="to_world"><matrix value="{matrix}"/></transform><ref id="material-0"/>{more}</shape>'
    )


class SharedCopiesTest(unittest.TestCase):
    def shared(self, text, size=shared_copies.WORTH_SHARING):
        root = xml.etree.ElementTree.fromstring(f'<scene>{text}</scene>')
        with tempfile.TemporaryDirectory() as folder:
            for name in ('a.ply', 'b.ply'):
                with open(os.path.join(folder, name), 'wb') as file:
                    file.truncate(size)
            shared_copies.share_copies(root, folder)
        return root

    def test_copies_become_instances(self):
        other = '2, 0, 0, 5,  0, 2, 0, 6,  0, 0, 2, 7,  0, 0, 0, 1'
        root = self.shared(shape() + shape(file='b.ply') + shape(other))
        self.assertEqual([s.get('type') for s in root], ['shapegroup', 'instance', 'ply', 'instance'])
        group = root[0]
        self.assertEqual(group.find('shape/string').get('value'), 'a.ply')
        self.assertEqual(group.find('shape/ref').get('id'), 'material-0')
        self.assertIsNone(group.find('shape/transform'))
        self.assertEqual(root[3].find('ref').get('id'), group.get('id'))
        self.assertEqual(root[3].find('transform/matrix').get('value'), other)

    def test_what_instances_cannot_show_stays(self):
        mirrored = shape('-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1')
        for text in (2 * shape(more='<emitter type="area"/>'), 2 * mirrored, shape() + shape(file='b.ply'), shape()):
            self.assertEqual({s.get('type') for s in self.shared(text)}, {'ply'})
        smooth = mirrored.replace('true', 'false')
        self.assertEqual(self.shared(2 * smooth)[0].get('type'), 'shapegroup')

    def test_small_meshes_stay(self):
        self.assertEqual({s.get('type') for s in self.shared(2 * shape(), size=1000)}, {'ply'})


class CommonMaterialsTest(unittest.TestCase):
    def test_microfacet_becomes_roughplastic_and_files_are_still_found(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'a.xml')
            bsdf = '<bsdf type="microfacet"><color name="kd" value="1 0 0"/><float name="alpha" value="0.2"/></bsdf>'
            Path(path).write_text(f'<scene><mesh><string name="filename" value="b.obj"/>{bsdf}</mesh></scene>', encoding='utf-8')
            out, changed = without_microfacet(path, os.path.join(folder, 'new'))
            self.assertTrue(changed)
            mesh = xml.etree.ElementTree.parse(out).find('mesh')
            self.assertEqual(mesh.find('string').get('value'), os.path.join(folder, 'b.obj'))
            bsdf = mesh.find('bsdf')
            self.assertEqual(bsdf.get('type'), 'roughplastic')
            names = {p.get('name'): p.get('value') for p in bsdf}
            self.assertEqual(names, {'diffuse_reflectance': '1 0 0', 'alpha': '0.2', 'intIOR': '1.5046'})
            self.assertEqual(without_microfacet(out, folder), (out, False))

    def test_materials_of_gltf_are_those_of_the_common_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'a.xml')
            Path(path).write_text('<scene/>', encoding='utf-8')
            for said, expected in ((GLTF_REPLACED, 'principled for materials of glTF'), ('another warning', None)):
                with unittest.mock.patch('shared_scene.Run', return_value=unittest.mock.Mock(output=f'warning: {said}, x')):
                    out, changes = with_common_materials(unittest.mock.Mock(path='etendue'), path, folder)
                self.assertEqual(changes, [expected] if expected else [])
                self.assertEqual(out, os.path.join(folder, 'common', 'a.xml') if expected else path)
            with unittest.mock.patch('shared_scene.Run', side_effect=RuntimeError):
                out = with_common_materials(unittest.mock.Mock(path='etendue'), path, folder)
                self.assertEqual(out, (path, []))


if __name__ == '__main__':
    unittest.main()
