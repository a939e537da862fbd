#!/usr/bin/env python3
"""Writes a scene of many instances of one mesh, for Etendue and for Mitsuba 3, and measures what reading it, building its
trees and a first picture take: CPU seconds and peak memory.

  many_instances.py FOLDER [--instances 100000] [--triangles 100000] [--etendue PROGRAM] [--python PYTHON] [--variant NAME]

PYTHON is an interpreter that has Mitsuba; without it only Etendue is measured.
"""

import argparse
import math
import os
import random
import subprocess
import sys
from pathlib import Path

RENDER_MITSUBA = """
import sys
import mitsuba
mitsuba.set_variant(sys.argv[2])
scene = mitsuba.load_file(sys.argv[1])
mitsuba.Bitmap(mitsuba.render(scene, spp=1)).write(sys.argv[3])
"""


def write_ball(path, triangles):
    """A sphere with bumps, as PLY: rows × columns quads cut in two, but for those at the poles."""
    rows = max(2, round(math.sqrt(triangles / 4)))
    columns = 2 * rows
    with open(path, 'wb') as file:
        count = (rows + 1) * columns
        faces = 2 * (rows - 1) * columns
        file.write(f'ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n'
                   f'element face {faces}\nproperty list uchar int vertex_indices\nend_header\n'.encode())
        for row in range(rows + 1):
            for column in range(columns):
                theta, phi = math.pi * row / rows, 2 * math.pi * column / columns
                r = 1 + 0.1 * math.sin(9 * theta) * math.sin(8 * phi)
                file.write(f'{r * math.sin(theta) * math.cos(phi):.6f} {r * math.cos(theta):.6f} '
                           f'{r * math.sin(theta) * math.sin(phi):.6f}\n'.encode())
        for row in range(rows):
            for column in range(columns):
                a, b = row * columns + column, row * columns + (column + 1) % columns
                if row > 0:
                    file.write(f'3 {a} {b} {a + columns}\n'.encode())
                if row < rows - 1:
                    file.write(f'3 {b} {b + columns} {a + columns}\n'.encode())
    return faces


def write_scene(path, instances):
    random.seed(1)
    side = math.ceil(math.sqrt(instances))
    with open(path, 'w', encoding='utf-8') as file:
        file.write(f"""<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="3"/></integrator>
<sensor type="perspective">
  <float name="fov" value="40"/>
  <transform name="to_world"><lookat origin="0, {side}, {2 * side}" target="0, 0, 0" up="0, 1, 0"/></transform>
  <sampler type="independent"><integer name="sample_count" value="1"/></sampler>
  <film type="hdrfilm"><integer name="width" value="320"/><integer name="height" value="240"/><rfilter type="box"/></film>
</sensor>
<emitter type="constant"/>
<shape type="shapegroup" id="group">
  <shape type="ply"><string name="filename" value="ball.ply"/><bsdf type="diffuse"/></shape>
</shape>
""")
        for i in range(instances):
            x, z = (i % side - side / 2) * 2.5, (i // side - side / 2) * 2.5
            file.write(f'<shape type="instance"><ref id="group"/><transform name="to_world">'
                       f'<rotate y="1" angle="{random.uniform(0, 360):.3f}"/><scale value="{random.uniform(0.5, 1.2):.3f}"/>'
                       f'<translate x="{x}" y="0" z="{z}"/></transform></shape>\n')
        file.write('</scene>\n')


def measure(name, command):
    """CPU seconds and peak memory of a command, as the kernel counts them."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        sys.exit(f'{name} failed: {" ".join(command)}')
    print(f'| {name} | {usage.ru_utime + usage.ru_stime:.1f} | {usage.ru_maxrss / 1024:.0f} |', flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--instances', type=int, default=100000)
    parser.add_argument('--triangles', type=int, default=100000)
    parser.add_argument('--etendue', default='etendue')
    parser.add_argument('--python')
    parser.add_argument('--variant', default='llvm_ad_rgb')
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    faces = write_ball(options.folder / 'ball.ply', options.triangles)
    scene = options.folder / 'instances.xml'
    write_scene(scene, options.instances)
    print(f'{options.instances} instances of {faces} triangles\n\n| program | CPU seconds | peak MB |\n|---|---|---|')
    measure('etendue', [options.etendue, 'render', str(scene), '--spp', '1', '-q', '--force', '-o', str(options.folder / 'etendue.exr')])
    if options.python:
        program = options.folder / 'render_mitsuba.py'
        program.write_text(RENDER_MITSUBA, encoding='utf-8')
        measure(f'mitsuba {options.variant}',
                [options.python, str(program), str(scene), options.variant, str(options.folder / 'mitsuba.exr')])


if __name__ == '__main__':
    main()
