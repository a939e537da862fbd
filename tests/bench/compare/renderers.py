"""Adapters of other renderers: each turns the neutral export of `etendue bench --export` (scene.json and PLY files), or
what `etendue convert` writes, into the renderer's own scene, names the command that renders it, and finds the time of
rendering in what the command prints.

A new renderer is a Renderer with `name`, `find`, `export` (or `prepare`), `command`, `render_seconds` and `version`, listed in
ADAPTERS. `command` must pass on the seed: two pictures of one renderer are taken to be independent.

Path lengths: maxDepth N here means N segments and N − 1 scattering vertices. pbrt counts the
scattering vertices (N − 1); Cycles counts bounces after the first (N − 2). Russian roulette changes noise and time, not
the expectation; Mitsuba is told where it may begin, the others keep their own rule.
"""

import functools
import glob
import math
import os
import re
import shutil
import subprocess
import xml.etree.ElementTree

from shared_copies import share_copies

HERE = os.path.dirname(os.path.abspath(__file__))
UNLIMITED_DEPTH = 1024
ONLY_PATHS = 'only the path integrator has a counterpart'


class Unsupported(Exception):
    """The renderer cannot draw this scene; the text says why."""


def path_segments(scene):
    if scene['integrator']['type'] != 'path':
        raise Unsupported(ONLY_PATHS)
    return min(scene['integrator']['max_depth'], UNLIMITED_DEPTH)


def is_constant(sky):
    return sky['top'] == sky['horizon']


def numbers(values, separator=' '):
    return separator.join(f'{v:.9g}' for v in values)


def output_of(command, environment=None):
    """What a command prints on stdout and stderr, whatever its exit code."""
    done = subprocess.run(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors='replace',
        check=False,
        env={**os.environ, **(environment or {})},
    )
    return done.stdout


class Source:
    """A scene as adapters get it: a file that Etendue reads, and what `etendue bench --export` wrote of it, or why it wrote
    nothing."""

    def __init__(self, convert, description=None, reason=''):
        """`convert(out, *options)` runs `etendue convert`; RuntimeError where it fails."""
        self.convert, self.description, self.reason = convert, description, reason

    def described(self):
        if self.description is None:
            raise Unsupported(self.reason)
        return self.description


class Renderer:
    suffix = '.exr'  # of the pictures it writes

    def prepare(self, source, folder):
        """Writes the renderer's own scene into the folder; Unsupported where it has none."""
        self.export(source.described(), folder)

    def environment(self):
        """Of its process, added to that of this one."""
        return {}

    def details(self, output):
        """What a rendering process says of how it computes, for the table; empty where it says nothing."""
        return ''


def python_with(module):
    """The first python3 on PATH when it has that module, or None."""
    python = shutil.which('python3')
    # Looking the module up does not load it, which would take seconds.
    search = f'import importlib.util; print("{module} found" if importlib.util.find_spec("{module}") else "none")'
    return python if python and f'{module} found' in output_of([python, '-c', search]) else None


class Cycles(Renderer):
    """Blender's path tracer: the Python module bpy of the first python3 on PATH, or else the program blender."""

    name = 'cycles'

    @functools.cached_property
    def python(self):
        return python_with('bpy')

    def find(self):
        return self.python or shutil.which('blender')

    def environment(self):
        # The Python inside the program takes its libraries from beside the first python3 on PATH, which must be the
        # system's.
        return {} if self.python else {'PATH': '/usr/bin:' + os.environ.get('PATH', '')}

    def export(self, scene, folder):
        if path_segments(scene) < 2:
            raise Unsupported('Cycles always scatters once, maxDepth 1 does not')

    def command(self, folder, out, spp, threads, seed):
        script = os.path.join(HERE, 'cycles_scene.py')
        start = (
            [self.python, script] if self.python else [self.find(), '-b', '--factory-startup', '-noaudio', '-P', script]
        )
        return [*start, '--', folder, out, str(spp), str(threads), str(seed)]

    def render_seconds(self, output):
        found = re.search(r'^CYCLES \S+ ([\d.]+)$', output, re.MULTILINE)
        return float(found.group(1)) if found else None

    def version(self):
        if self.python:
            return (
                'Blender '
                + output_of([self.python, '-c', 'import bpy; print(bpy.app.version_string)']).strip().split('\n')[-1]
            )
        return output_of([self.find(), '--version']).split('\n')[0]


def tell_samples(scene):
    """Has a converted scene take its samples and seed from the command line, and write a file that is read without a
    library."""
    for name, value in (('spp', '16'), ('seed', '0')):
        scene.insert(0, xml.etree.ElementTree.Element('default', name=name, value=value))
    sensor = scene.find('sensor')
    sampler = sensor.find('sampler')
    for number in list(sampler):
        sampler.remove(number)
    for name in ('sample_count', 'seed'):
        value = '$spp' if name == 'sample_count' else '$seed'
        xml.etree.ElementTree.SubElement(sampler, 'integer', name=name, value=value)
    xml.etree.ElementTree.SubElement(sensor.find('film'), 'string', name='file_format', value='pfm')


def newest_llvm():
    """The newest LLVM library of the system, or None: Mesa's may lie beside it."""
    found = {}
    for path in (
        glob.glob('/usr/lib/*/libLLVM*.so*')
        + glob.glob('/usr/lib/llvm-*/lib/libLLVM*.so*')
        + glob.glob('/usr/lib64/libLLVM*.so*')
    ):
        version = re.search(r'libLLVM(?:-(\d+))?\.so(?:\.(\d+))?', os.path.basename(path))
        if version and (version.group(1) or version.group(2)):
            found[int(version.group(1) or version.group(2))] = path
    return found[max(found)] if found else None


def program_of_wheel(script):
    """The program that the script of the package from PyPI starts: the script itself takes half a second and 80 MB. What is
    no such script stays."""
    if script:
        root = os.path.dirname(os.path.dirname(os.path.realpath(script)))
        for program in glob.glob(os.path.join(glob.escape(root), 'lib', 'python3*', 'site-packages', 'mitsuba', 'mitsuba')):
            return program
    return script


class Mitsuba(Renderer):
    """Mitsuba 3; scene format of its documentation, version 3.0.0."""

    suffix = '.pfm'  # its EXR files are packed with PIZ, which takes a library to undo

    def __init__(self, variant):
        self.variant = variant
        self.name = f'mitsuba-{variant}'

    def find(self):
        return program_of_wheel(shutil.which('mitsuba'))

    def environment(self):
        llvm = os.environ.get('DRJIT_LIBLLVM_PATH') or newest_llvm()
        return {'DRJIT_LIBLLVM_PATH': llvm} if llvm and self.variant.startswith('llvm') else {}

    def prepare(self, source, folder):
        """What `etendue convert` makes of the scene, with the samples, the seed and the file format of this comparison."""
        file = os.path.join(folder, 'mitsuba.xml')
        try:
            source.convert(file, '--to', 'mitsuba')
        except RuntimeError as reason:
            raise Unsupported(str(reason).strip().split('\n')[-1]) from reason
        tree = xml.etree.ElementTree.parse(file)
        if tree.find('integrator').get('type') != 'path':
            raise Unsupported(ONLY_PATHS)
        tell_samples(tree.getroot())
        share_copies(tree.getroot(), folder)
        tree.write(file, encoding='utf-8', xml_declaration=True)

    def command(self, folder, out, spp, threads, seed):
        # The thread that was started with is one of -t, and does not render. -s would choose a sensor, not the samples.
        return [
            self.find(),
            '-v',
            '-v',
            '-m',
            self.variant,
            '-t',
            str(threads + 1),
            '-D',
            f'spp={spp}',
            '-D',
            f'seed={seed}',
            '-o',
            out,
            os.path.join(folder, 'mitsuba.xml'),
        ]

    def render_seconds(self, output):
        """From 'Rendering finished. (took 1.53s)'; the unit may be ms, s, m or h."""
        found = re.search(r'Rendering finished\.? \(took ([\d.]+)\s*(ms|s|m|h)\)', output)
        return float(found.group(1)) * {'ms': 1e-3, 's': 1.0, 'm': 60.0, 'h': 3600.0}[found.group(2)] if found else None

    def details(self, output):
        """From 'jit_llvm_init(): found LLVM 19.1.7 (ORCv2), target=x86_64-pc-linux-gnu, cpu=x86-64, width=8.'"""
        found = re.search(r'found (LLVM [\d.]+).*, width=(\d+)', output)
        return f'{found.group(1)}, {found.group(2)} wide' if found else ''

    def version(self):
        found = re.search(r'Mitsuba version ([\w.]+)', output_of([self.find(), '--help']))
        return f'Mitsuba {found.group(1)}' if found else 'Mitsuba of unknown version'


class Pbrt(Renderer):
    """pbrt-v4 on the CPU; it renders spectra, which costs time that RGB renderers do not spend."""

    name = 'pbrt'

    def find(self):
        return shutil.which('pbrt')

    def export(self, scene, folder):
        camera = scene['camera']
        lines = [
            'Option "string rendercoordsys" [ "world" ]',
            *self.camera(camera),
            'Film "rgb" "string filename" [ "pbrt.exr" ] "bool savefp16" [ false ] '
            f'"integer xresolution" [ {camera["width"]} ] '
            f'"integer yresolution" [ {camera["height"]} ]',
            'PixelFilter "box" "float xradius" [ 0.5 ] "float yradius" [ 0.5 ]',
            'Sampler "independent"',
            f'Integrator "path" "integer maxdepth" [ {path_segments(scene) - 1} ]',
            'WorldBegin',
        ]
        if not is_constant(scene['sky']):
            raise Unsupported('pbrt-v4 takes a sky that is not constant as an equal-area octahedral map only')
        if max(scene['sky']['top']) > 0.0:
            lines.append(f'LightSource "infinite" "rgb L" [ {numbers(scene["sky"]["top"])} ]')
        for shape in scene['shapes']:
            lines += self.shape(shape)
        with open(os.path.join(folder, 'pbrt.pbrt'), 'w', encoding='utf-8') as file:
            file.write('\n'.join(lines) + '\n')

    @staticmethod
    def camera(camera):
        # pbrt's cameras have +X to the right, and its field of view is that of the shorter side. The matrix is that of
        # camera from world, column after column; the camera is rigid, so its inverse is the transpose.
        axes = [[row[i] * (-1.0 if i == 0 else 1.0) for row in camera['world_from_camera'][:3]] for i in range(3)]
        origin = [row[3] for row in camera['world_from_camera'][:3]]
        moved = [-sum(a * o for a, o in zip(axis, origin)) for axis in axes]
        columns = [axis[c] for c in range(3) for axis in (*axes, [0.0] * 3)] + moved + [1.0]
        half = math.tan(math.radians(camera['fov']) / 2.0) * min(1.0, camera['height'] / camera['width'])
        return [
            f'Transform [ {numbers(columns)} ]',
            f'Camera "perspective" "float fov" [ {math.degrees(2.0 * math.atan(half)):.9g} ]',
        ]

    @staticmethod
    def shape(shape):
        lines = ['AttributeBegin']
        bsdf = shape['bsdf']
        if bsdf['type'] == 'diffuse':
            lines.append(f'  Material "diffuse" "rgb reflectance" [ {numbers(bsdf["albedo"])} ]')
        elif bsdf['type'] == 'mirror':
            lines.append('  Material "conductor" "rgb reflectance" [ 1 1 1 ]')
        else:
            lines.append(f'  Material "dielectric" "float eta" [ {bsdf["int_ior"] / bsdf["ext_ior"]:.9g} ]')
        if shape['radiance']:
            lines.append(f'  AreaLightSource "diffuse" "rgb L" [ {numbers(shape["radiance"])} ]')
        if 'sphere' in shape:
            lines += [
                f'  Translate {numbers(shape["sphere"]["center"])}',
                f'  Shape "sphere" "float radius" [ {shape["sphere"]["radius"]:.9g} ]',
            ]
        else:
            lines.append(f'  Shape "plymesh" "string filename" [ "{shape["mesh"]["file"]}" ]')
        return lines + ['AttributeEnd']

    def command(self, folder, out, spp, threads, seed):
        return [
            self.find(),
            '--nthreads',
            str(threads),
            '--spp',
            str(spp),
            '--seed',
            str(seed),
            '--outfile',
            out,
            os.path.join(folder, 'pbrt.pbrt'),
        ]

    def render_seconds(self, output):
        """From the end of the progress bar: 'Rendering: [++++]  (12.3s)'."""
        found = re.findall(r'Rendering:? \[\+*\]\s+\(([\d.]+)s\)', output)
        return float(found[-1]) if found else None

    def version(self):
        return 'pbrt-v4'


ADAPTERS = [Cycles(), Mitsuba('llvm_ad_rgb'), Mitsuba('scalar_rgb'), Pbrt()]
