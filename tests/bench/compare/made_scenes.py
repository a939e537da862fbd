"""Scenes that are written on the fly, where a command expects a scene file:

    made:empty               one quad under a constant sky
    made:triangles=1000000   the box of cbox-bumpy with its sphere in so many triangles
    made:instances=1000      so many instances of a ball of 10 000 triangles
    made:texels=4096         a quad with a picture of 4096 × 4096 texels, 8 bits in each of three channels
    made:room                a glTF room with pictures on its surfaces

Meshes and pictures come from etendue-sculpt, beside etendue.
"""

import os
import random
import re
import struct
import subprocess
import sys
import xml.etree.ElementTree
import zlib
from pathlib import Path

import gltf_room
from shared_scene import with_absolute_names

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', '..', 'docs', 'report'))
import grown_scenes

MADE = 'made:'
TILE = """<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="6"/></integrator>
<sensor type="perspective"><float name="fov" value="40"/>
  <transform name="to_world"><lookat origin="0, 1.3, 0.4" target="0, 0, 0" up="0, 1, 0"/></transform>
  <sampler type="independent"/>
  <film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/><rfilter type="box"/></film>
</sensor>
<emitter type="constant"/>
<shape type="obj"><string name="filename" value="{mesh}"/><bsdf type="diffuse">{reflectance}</bsdf></shape>
</scene>
"""
PICTURE = '<texture type="bitmap" name="reflectance"><string name="filename" value="{}"/></texture>'


class Workshop:
    """A folder for scenes and their meshes, and the program that makes those."""

    def __init__(self, etendue, folder):
        self.scratch = Path(folder).resolve()
        self.scratch.mkdir(parents=True, exist_ok=True)
        self.sculptor = Path(etendue).resolve().parent / 'etendue-sculpt'

    def run(self, program, *arguments):
        command = [str(program), *map(str, arguments)]
        if not os.path.exists(command[0]):
            sys.exit(f'{command[0]} is not there; scenes that are made need it beside etendue.')
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"'{' '.join(command)}' ended with code {done.returncode}:\n{done.stdout[-2000:]}")

    def variant(self, scene, name, change):
        """A changed copy of a scene: `change` gets the root element."""
        tree = xml.etree.ElementTree.parse(scene)
        with_absolute_names(tree, str(scene))
        change(tree.getroot())
        path = self.scratch / f'{name}.xml'
        tree.write(path, encoding='utf-8', xml_declaration=True)
        return path

    def sculpted(self, suffix, *options):
        """A file by etendue-sculpt, made once."""
        path = self.scratch / ('-'.join(word.lstrip('-') for word in map(str, options)) + suffix)
        if not path.exists():
            self.run(self.sculptor, *options, '-o', path)
        return path


def write_noise(path, side):
    """A PNG of random colours, which nothing can store in less than its texels: filter 0 for each row, not deflated."""
    source = random.Random(side)
    rows = b''.join(b'\0' + source.randbytes(3 * side) for _ in range(side))

    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))

    header = struct.pack('>IIBBBBB', side, side, 8, 2, 0, 0, 0)
    png = b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header) + chunk(b'IDAT', zlib.compress(rows, 0)) + chunk(b'IEND', b'')
    path.write_bytes(png)


def tile(workshop, name, reflectance):
    path = workshop.scratch / f'{name}.xml'
    path.write_text(TILE.format(mesh=workshop.sculpted('.obj', '--kind', 'tile'), reflectance=reflectance), encoding='utf-8')
    return path


def empty(workshop, _):
    return tile(workshop, 'empty', '')


def of_texels(workshop, side):
    picture = workshop.scratch / f'noise-{side}.png'
    if not picture.exists():
        # In a process of its own: the memory would count as that of every child of this one.
        program = 'import sys, pathlib; sys.path.append(sys.argv[1]); import made_scenes; '
        program += 'made_scenes.write_noise(pathlib.Path(sys.argv[2]), int(sys.argv[3]))'
        workshop.run(sys.executable, '-c', program, os.path.dirname(os.path.abspath(__file__)), picture, side)
    return tile(workshop, f'texels-{side}', PICTURE.format(picture))


# By name: function (workshop, number) → path, and whether the name takes a number.
KINDS = {
    'empty': (empty, False),
    'triangles': (grown_scenes.of_triangles, True),
    'instances': (grown_scenes.of_instances, True),
    'texels': (of_texels, True),
    'room': (lambda workshop, _: gltf_room.write(workshop), False),
}


def count_triangles(mesh):
    """Of an OBJ file by etendue-sculpt, which makes a few more than it is asked for."""
    with open(mesh, 'rb') as file:
        return sum(line.startswith(b'f ') for line in file)


def scene_file(text, workshop):
    """The file of a scene as named on the command line: of a made one the file that was written."""
    if not text.startswith(MADE):
        return text
    found = re.fullmatch(r'made:([a-z]+)(?:=([1-9]\d*))?', text)
    make, numbered = KINDS.get(found.group(1), (None, False)) if found else (None, False)
    if make is None or numbered != bool(found.group(2)):
        names = ', '.join(f'made:{name}=NUMBER' if takes else f'made:{name}' for name, (_, takes) in KINDS.items())
        sys.exit(f"There is no scene '{text}'; there are {names}.")
    return str(make(workshop, int(found.group(2) or 0)))
