"""Adapters of other renderers: each turns the neutral export of `etendue bench --export` (scene.json and PLY files) into the
renderer's own scene, names the command that renders it, and finds the time of rendering in what the command prints.

A new renderer is a Renderer with `name`, `find`, `export`, `command`, `render_seconds` and `version`, listed in ADAPTERS.

Path lengths: maxDepth N here means N segments and N − 1 scattering vertices. Mitsuba counts like that; pbrt counts the scattering
vertices (N − 1); Cycles counts bounces after the first (N − 2). Russian roulette changes noise and time, not the expectation, and stays
with what each renderer does by default.
"""
import math
import os
import re
import shutil
import struct
import subprocess
from xml.sax.saxutils import quoteattr

HERE = os.path.dirname(os.path.abspath(__file__))
UNLIMITED_DEPTH = 1024


class Unsupported(Exception):
    """The renderer cannot draw this scene; the text says why."""


def path_segments(scene):
    if scene['integrator']['type'] != 'path':
        raise Unsupported('only the path integrator has a counterpart')
    return min(scene['integrator']['max_depth'], UNLIMITED_DEPTH)


def is_constant(sky):
    return sky['top'] == sky['horizon']


def numbers(values, separator=' '):
    return separator.join(f'{v:.9g}' for v in values)


class Renderer:
    environment = {}  # of its process, added to that of this one


class Cycles(Renderer):
    """Blender's path tracer; Debian's package blender."""
    name = 'cycles'
    # Blender's Python takes its libraries from beside the first python3 on PATH, which must be the system's.
    environment = {'PATH': '/usr/bin:' + os.environ.get('PATH', '')}

    def find(self):
        return shutil.which('blender')

    def export(self, scene, folder):
        if path_segments(scene) < 2:
            raise Unsupported('Cycles always scatters once, maxDepth 1 does not')

    def command(self, folder, out, spp, threads):
        return [self.find(), '-b', '--factory-startup', '-noaudio', '-P', os.path.join(HERE, 'cycles_scene.py'), '--', folder, out,
                str(spp), str(threads)]

    def render_seconds(self, output):
        found = re.search(r'^CYCLES \S+ ([\d.]+)$', output, re.MULTILINE)
        return float(found.group(1)) if found else None

    def version(self):
        return subprocess.run([self.find(), '--version'], capture_output=True, text=True, check=True).stdout.split('\n')[0]


class Mitsuba(Renderer):
    """Mitsuba 3; scene format of its documentation, version 3.0.0."""

    def __init__(self, variant):
        self.variant = variant
        self.name = f'mitsuba-{variant}'

    def find(self):
        return shutil.which('mitsuba')

    def export(self, scene, folder):
        lines = ['<scene version="3.0.0">', '  <integrator type="path">',
                 f'    <integer name="max_depth" value="{path_segments(scene)}"/>', '  </integrator>', *self.sensor(scene['camera'])]
        for shape in scene['shapes']:
            lines += self.shape(shape)
        lines += self.sky(scene['sky'], folder) + ['</scene>', '']
        with open(os.path.join(folder, 'mitsuba.xml'), 'w', encoding='utf-8') as file:
            file.write('\n'.join(lines))

    def sensor(self, camera):
        # The camera looks along +Z with +X to the left, as ours does.
        matrix = numbers(v for row in camera['world_from_camera'] for v in row)
        return ['  <sensor type="perspective">', '    <string name="fov_axis" value="x"/>',
                f'    <float name="fov" value="{camera["fov"]:.9g}"/>', f'    <float name="near_clip" value="{camera["near"]:.9g}"/>',
                f'    <float name="far_clip" value="{camera["far"]:.9g}"/>',
                f'    <transform name="to_world"><matrix value="{matrix}"/></transform>', '    <sampler type="independent"/>',
                '    <film type="hdrfilm">', f'      <integer name="width" value="{camera["width"]}"/>',
                f'      <integer name="height" value="{camera["height"]}"/>', '      <string name="pixel_format" value="rgb"/>',
                '      <string name="component_format" value="float32"/>', '      <rfilter type="box"/>', '    </film>', '  </sensor>']

    def shape(self, shape):
        if 'sphere' in shape:
            center = dict(zip('xyz', shape['sphere']['center']))
            lines = ['  <shape type="sphere">', '    <point name="center" ' + ' '.join(f'{k}="{v:.9g}"' for k, v in center.items()) + '/>',
                     f'    <float name="radius" value="{shape["sphere"]["radius"]:.9g}"/>']
        else:
            lines = ['  <shape type="ply">', f'    <string name="filename" value={quoteattr(shape["mesh"]["file"])}/>']
            if not shape['mesh']['normals']:
                lines.append('    <boolean name="face_normals" value="true"/>')
        lines.append('    ' + self.bsdf(shape['bsdf']))
        if shape['radiance']:
            lines.append(f'    <emitter type="area"><rgb name="radiance" value="{numbers(shape["radiance"], ", ")}"/></emitter>')
        return lines + ['  </shape>']

    @staticmethod
    def bsdf(bsdf):
        if bsdf['type'] == 'diffuse':
            return f'<bsdf type="diffuse"><rgb name="reflectance" value="{numbers(bsdf["albedo"], ", ")}"/></bsdf>'
        if bsdf['type'] == 'mirror':
            return '<bsdf type="conductor"><string name="material" value="none"/></bsdf>'
        return (f'<bsdf type="dielectric"><float name="int_ior" value="{bsdf["int_ior"]:.9g}"/>'
                f'<float name="ext_ior" value="{bsdf["ext_ior"]:.9g}"/></bsdf>')

    @staticmethod
    def sky(sky, folder):
        if is_constant(sky):
            if max(sky['top']) == 0.0:
                return []
            return [f'  <emitter type="constant"><rgb name="radiance" value="{numbers(sky["top"], ", ")}"/></emitter>']
        # Latitude and longitude with +Y up; the gradient does not depend on the longitude.
        width, height = 16, 2048
        rows = []
        for row in reversed(range(height)):  # PFM files begin at the bottom
            y = max(0.0, math.cos(math.pi * (row + 0.5) / height))
            pixel = struct.pack('<3f', *(h + (t - h) * y for h, t in zip(sky['horizon'], sky['top'])))
            rows.append(pixel * width)
        with open(os.path.join(folder, 'sky.pfm'), 'wb') as file:
            file.write(f'PF\n{width} {height}\n-1.0\n'.encode() + b''.join(rows))
        return ['  <emitter type="envmap"><string name="filename" value="sky.pfm"/></emitter>']

    def command(self, folder, out, spp, threads):
        # The thread that was started with is one of -t, and does not render.
        return [self.find(), '-m', self.variant, '-t', str(threads + 1), '-s', str(spp), '-o', out,
                os.path.join(folder, 'mitsuba.xml')]

    def render_seconds(self, output):
        """From 'Rendering finished. (took 1.53s)'; the unit may be ms, s, m or h."""
        found = re.search(r'Rendering finished\.? \(took ([\d.]+)\s*(ms|s|m|h)\)', output)
        return float(found.group(1)) * {'ms': 1e-3, 's': 1.0, 'm': 60.0, 'h': 3600.0}[found.group(2)] if found else None

    def version(self):
        text = subprocess.run([self.find(), '--help'], capture_output=True, text=True, check=False).stdout
        return text.strip().split('\n')[0]


class Pbrt(Renderer):
    """pbrt-v4 on the CPU; it renders spectra, which costs time that RGB renderers do not spend."""
    name = 'pbrt'

    def find(self):
        return shutil.which('pbrt')

    def export(self, scene, folder):
        camera = scene['camera']
        lines = ['Option "string rendercoordsys" [ "world" ]', *self.camera(camera),
                 f'Film "rgb" "string filename" [ "pbrt.exr" ] "integer xresolution" [ {camera["width"]} ] '
                 f'"integer yresolution" [ {camera["height"]} ]',
                 'PixelFilter "box" "float xradius" [ 0.5 ] "float yradius" [ 0.5 ]', 'Sampler "independent"',
                 f'Integrator "path" "integer maxdepth" [ {path_segments(scene) - 1} ]', 'WorldBegin']
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
        return [f'Transform [ {numbers(columns)} ]', f'Camera "perspective" "float fov" [ {math.degrees(2.0 * math.atan(half)):.9g} ]']

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
            lines += [f'  Translate {numbers(shape["sphere"]["center"])}', f'  Shape "sphere" "float radius" [ {shape["sphere"]["radius"]:.9g} ]']
        else:
            lines.append(f'  Shape "plymesh" "string filename" [ "{shape["mesh"]["file"]}" ]')
        return lines + ['AttributeEnd']

    def command(self, folder, out, spp, threads):
        return [self.find(), '--nthreads', str(threads), '--spp', str(spp), '--outfile', out, os.path.join(folder, 'pbrt.pbrt')]

    def render_seconds(self, output):
        """From the end of the progress bar: 'Rendering: [++++]  (12.3s)'."""
        found = re.findall(r'Rendering:? \[\+*\]\s+\(([\d.]+)s\)', output)
        return float(found[-1]) if found else None

    def version(self):
        return 'pbrt-v4'


ADAPTERS = [Cycles(), Mitsuba('llvm_ad_rgb'), Mitsuba('scalar_rgb'), Pbrt()]
