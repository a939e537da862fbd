#!/usr/bin/env python3
"""Etendue's pictures against those of other renderers: the verdict of `etendue compare` for every scene of a list.

    against.py --etendue build/release/src/etendue -o against.html scenes/still-life.xml scenes/daylight.xml ...

Scenes may be of any format that Etendue reads. Mitsuba 3 renders the file itself where that is a scene for Mitsuba with
a box filter, and what `etendue convert --to mitsuba` makes of it otherwise; Cycles renders what `etendue bench
--export` writes, where it can. All use the box filter, so that pixels do not depend on each other. What is not
installed is left out. The page shows for each scene both pictures, how many standard errors their means are apart,
what the test of blocks says, and the verdict; docs/benchmarks.md says how to read it. Exit code 1: a picture differs, or
none could be compared. Needs numpy.
"""

import argparse
import dataclasses
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

import numpy

import against_page
import agreement
from renderers import HERE, Cycles, Unsupported, newest_llvm, python_with

sys.path.append(os.path.join(HERE, '..', '..', '..', 'docs', 'report'))
import exr

CYCLES_PICTURES = 8


class Failed(Exception):
    """A program did not do what it should; the text is what it said."""


def run(command, environment=None):
    """What a command prints on stdout. Raises Failed."""
    done = subprocess.run(
        command, capture_output=True, text=True, errors='replace', env={**os.environ, **(environment or {})}, check=False
    )
    if done.returncode:
        said = (done.stderr.strip() or done.stdout.strip())[-1000:]
        raise Failed(f'{os.path.basename(command[0])} ended with code {done.returncode}: {said}')
    return done.stdout


@dataclasses.dataclass
class Picture:
    """The mean of `samples` a pixel and its standard error, both [height, width, 3]."""

    mean: numpy.ndarray
    error: numpy.ndarray
    samples: int
    version: str
    source: str = ''  # what was rendered, where that is not the scene file itself

    def write(self, path):
        count = numpy.full(self.mean.shape[:2], self.samples, '<u4')
        planes = {c: self.mean[:, :, i].astype('<f4') for i, c in enumerate('RGB')}
        errors = {f'StdErr.{c}': self.error[:, :, i].astype('<f4') for i, c in enumerate('RGB')}
        exr.write(path, {**planes, **errors, 'SampleCount': count})


def with_box_filter(scene):
    """Changes a file written by `etendue convert`; its other files lie where they lay."""
    tree = xml.etree.ElementTree.parse(scene)
    for camera in tree.iter('camera'):
        for other in camera.findall('rfilter'):
            camera.remove(other)
        xml.etree.ElementTree.SubElement(camera, 'rfilter', type='box')
    tree.write(scene, encoding='utf-8', xml_declaration=True)


class Scene:
    """A scene on its way to the renderers: the file, and a copy in Etendue's own XML with the box filter."""

    def __init__(self, file, etendue, folder):
        self.file, self.etendue, self.folder = file, etendue, folder
        self.name = os.path.splitext(os.path.basename(file))[0]
        os.makedirs(folder)
        self.boxed = os.path.join(folder, 'scene.xml')
        run([etendue, 'convert', file, self.boxed, '-q'])
        with_box_filter(self.boxed)

    def is_for_mitsuba(self):
        """Mitsuba's scenes have sensors, Etendue's cameras; meshes have neither."""
        if not self.file.endswith('.xml'):
            return False
        try:
            root = xml.etree.ElementTree.parse(self.file).getroot()
        except xml.etree.ElementTree.ParseError:
            return False  # Etendue has read it; whatever it is, Mitsuba gets a copy
        return root.find('camera') is None and root.get('version') is not None

    def render(self, options):
        out = os.path.join(self.folder, 'etendue.exr')
        command = [self.etendue, 'render', self.boxed, '--spp', str(options.spp), '--seed', str(options.seed)]
        run([*command, '--device', options.device, '-q', '--force', '-o', out])
        planes = exr.read(out)
        self.size = f"{planes['R'].shape[1]}x{planes['R'].shape[0]}"
        return out


class MitsubaPeer:
    """Mitsuba 3 as a module of the first python3 on PATH."""

    def __init__(self, variant):
        self.name, self.variant = 'mitsuba', variant

    def find(self):
        return python_with('mitsuba')

    def draw(self, scene, options):
        if not scene.is_for_mitsuba():
            return self.draw_copy(scene, options)
        picture, used = self.draw_file(scene.file, scene, options)
        if used == 'BoxFilter':
            return picture
        return self.draw_copy(scene, options)

    def draw_copy(self, scene, options):
        copy = os.path.join(scene.folder, 'mitsuba.xml')
        done = subprocess.run(
            [scene.etendue, 'convert', scene.boxed, copy, '--to', 'mitsuba', '--force'],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise Unsupported(done.stderr.strip())
        picture, _ = self.draw_file(copy, scene, options)
        picture.source = 'converted'
        # What the reader says of the scene has a place in it; the rest is what Mitsuba renders differently.
        said = [line for line in done.stderr.splitlines() if line.startswith('warning: ') and scene.boxed not in line]
        if said:
            picture.source += ': ' + ' '.join(line.removeprefix('warning: ') for line in said)
        return picture

    def draw_file(self, file, scene, options):
        out = os.path.join(scene.folder, 'mitsuba.npy')
        script = os.path.join(HERE, 'mitsuba_scene.py')
        counts = [str(options.spp), str(options.pictures), str(options.seed + 1)]
        llvm = os.environ.get('DRJIT_LIBLLVM_PATH') or newest_llvm()
        environment = {'DRJIT_LIBLLVM_PATH': llvm} if llvm and self.variant.startswith('llvm') else {}
        said = json.loads(
            run([self.find(), script, self.variant, file, out, *counts], environment).strip().splitlines()[-1]
        )
        if said['filter'] == 'grey':
            return None, 'grey'
        mean, error = numpy.load(out)
        return Picture(mean, error, said['samples'], said['version']), said['filter']


class CyclesPeer:
    """Blender's Cycles; a process for each picture, of which there are fewer."""

    name = 'cycles'

    def __init__(self):
        self.adapter = Cycles()

    def find(self):
        return self.adapter.find()

    def draw(self, scene, options):
        export = os.path.join(scene.folder, 'export')
        command = [scene.etendue, 'bench', scene.boxed, '--device', options.device, '--part', 'rays', '--rays', '64']
        try:
            run([*command, '--size', scene.size, '--repetitions', '0', '--export', export, '--json'])
        except Failed as error:  # it says what has no counterpart
            raise Unsupported(str(error)) from error
        exported = os.path.join(export, 'scene')
        with open(os.path.join(exported, 'scene.json'), encoding='utf-8') as file:
            self.adapter.export(json.load(file), exported)
        estimate, each = agreement.Estimate(), max(2, options.spp // CYCLES_PICTURES)
        for picture in range(CYCLES_PICTURES):
            out = os.path.join(scene.folder, 'cycles.exr')
            seed = options.seed + picture
            run(self.adapter.command(exported, out, each, options.threads, seed), self.adapter.environment())
            estimate.add(agreement.read_picture(out))
        error = numpy.sqrt(estimate.variance())
        return Picture(estimate.mean, error, each * CYCLES_PICTURES, self.adapter.version(), 'exported')


def mean_scores(planes, picture):
    """How many standard errors the means of the whole are apart, in red, green and blue; 0 where there is no noise."""
    scores = []
    for i, c in enumerate('RGB'):
        difference = float(planes[c].mean(dtype=numpy.float64) - picture.mean[:, :, i].mean())
        squares = planes[f'StdErr.{c}'].astype(numpy.float64) ** 2 + picture.error[:, :, i] ** 2
        error = float(numpy.sqrt(squares.sum())) / squares.size
        scores.append(difference / error if error > 0.0 else 0.0)
    return scores


def judge(scene, ours, peer, options):
    """A row of the page."""
    row = {'scene': scene.file, 'peer': peer.name}
    try:
        picture = peer.draw(scene, options)
    except (Unsupported, Failed) as error:
        return {**row, 'verdict': 'not compared', 'why': str(error)}
    theirs, report = (os.path.join(scene.folder, f'{peer.name}.{kind}') for kind in ('exr', 'json'))
    planes = exr.read(ours)
    if picture.mean.shape[:2] != planes['R'].shape:
        return {**row, 'verdict': 'different', 'why': f'{peer.name} renders {agreement.size_text(picture.mean)} pixels'}
    picture.write(theirs)
    command = [options.etendue, 'compare', ours, theirs, '--no-flip', '--significance', str(options.significance)]
    subprocess.run([*command, f'--json={report}'], capture_output=True, check=False)
    with open(report, encoding='utf-8') as file:
        said = json.load(file)
    families = {f['name']: f for f in said.get('tests', {}).get('families', [])}
    return {
        **row,
        'version': picture.version,
        'source': picture.source,
        'samples': [options.spp, picture.samples],
        'verdict': said['verdict'],
        'why': said['untestedWhy'],
        'z_of_means': mean_scores(planes, picture),
        'brighter': said['metrics']['relbias'],
        'families': families,
        'pictures': [numpy.stack([planes[c] for c in 'RGB'], axis=-1), picture.mean],
    }


def rows_of(scene_file, number, peers, options, folder):
    """One row for each renderer; one where Etendue itself does not render the scene."""
    try:
        scene = Scene(scene_file, options.etendue, os.path.join(folder, str(number)))
        ours = scene.render(options)
    except Failed as error:
        return [{'scene': scene_file, 'peer': 'none', 'verdict': 'not compared', 'why': str(error)}]
    return [judge(scene, ours, peer, options) for peer in peers]


def options_from_command_line():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scenes', nargs='+', metavar='SCENE', help='scene files of any format; or @LIST, one a line')
    parser.add_argument('--etendue', default=shutil.which('etendue') or 'etendue', metavar='PATH')
    parser.add_argument('--device', default='0', help="Etendue's device, as for its own commands")
    parser.add_argument('--variant', default='llvm_ad_rgb', help="Mitsuba's variant; one whose colours are RGB")
    parser.add_argument('--with', dest='wanted', default='mitsuba,cycles', help='which renderers, if they are there')
    parser.add_argument('--spp', type=int, default=256, help='samples per pixel, of each renderer')
    parser.add_argument('--pictures', type=int, default=64, help="of Mitsuba: standard errors follow from their spread")
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--threads', type=int, default=len(os.sched_getaffinity(0)), help='of Cycles')
    parser.add_argument('--significance', type=float, default=0.01, help='false alarms of each comparison')
    parser.add_argument('-o', '--out', default='against.html', metavar='FILE', help='the page')
    parser.add_argument('--json', metavar='FILE', help='the rows without their pictures')
    parser.add_argument('--keep', metavar='FOLDER', help='keep scenes and pictures here')
    options = parser.parse_args()
    if options.spp < options.pictures or options.pictures < 8:
        parser.error('--pictures must be at least 8, and --spp at least as many')
    return options


def listed(scenes):
    """Names of files; @LIST stands for the lines of a file, whose names are relative to it."""
    for scene in scenes:
        if not scene.startswith('@'):
            yield scene
            continue
        with open(scene[1:], encoding='utf-8') as file:
            for line in map(str.strip, file):
                if line and not line.startswith('#'):
                    yield os.path.join(os.path.dirname(scene[1:]), line)


def find_peers(options):
    peers = [MitsubaPeer(options.variant), CyclesPeer()]
    wanted = options.wanted.split(',')
    for name in wanted:
        if name not in {p.name for p in peers}:
            sys.exit(f"There is no renderer '{name}'; there are mitsuba and cycles.")
    found = [p for p in peers if p.name in wanted and p.find()]
    for peer in peers:
        if peer.name in wanted and peer not in found:
            print(f'{peer.name} is not installed and left out.', file=sys.stderr)
    return found


def main():
    options = options_from_command_line()
    peers = find_peers(options)
    if not peers:
        sys.exit('There is no other renderer: a python3 on PATH has the module mitsuba or bpy, or there is blender.')
    rows = []
    with tempfile.TemporaryDirectory(prefix='etendue-against-') as temporary:
        for number, scene in enumerate(listed(options.scenes)):
            for row in rows_of(scene, number, peers, options, options.keep or temporary):
                print(against_page.line(row), flush=True)
                rows.append(row)
    facts = {'date': time.strftime('%Y-%m-%d', time.gmtime()), 'command': ' '.join(sys.argv), 'rows': rows}
    facts['etendue'] = run([options.etendue, '--version']).strip()
    with open(options.out, 'w', encoding='utf-8') as file:
        file.write(against_page.page(facts))
    if options.json:
        plain = [{k: v for k, v in row.items() if k != 'pictures'} for row in rows]
        with open(options.json, 'w', encoding='utf-8') as file:
            json.dump({**facts, 'rows': plain}, file, indent=2)
    verdicts = [row['verdict'] for row in rows]
    compared = [v for v in verdicts if v not in ('not compared', 'not tested')]
    sys.exit(1 if 'different' in verdicts or not compared else 0)


if __name__ == '__main__':
    main()
