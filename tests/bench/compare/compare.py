#!/usr/bin/env python3
"""Etendue against Embree and other renderers: one run, one machine, everything in turns.

    compare.py --etendue build/release/src/etendue --embree build/release/tests/bench/compare/embree_rays \\
               scenes/cbox-sphere.xml scenes/cbox-bumpy.xml

Rays: `etendue bench` casts primary, diffuse and shadow rays and exports them; embree_rays casts the very same ones
through the same triangles. Samples: every renderer found on PATH renders the exported scene at the same size, samples
per pixel, path length, pixel filter and number of threads, each time with another seed; the means of its pictures, of
the whole and of blocks, must be Etendue's as far as chance allows. Ratios are formed within one repetition, and their
median is told with the extremes. `--etendue NAME=PATH` may be repeated: the first is what the others are held against.
Rays need nothing but Python's standard library, pictures numpy. docs/benchmarks.md says what the figures mean.
"""

import argparse
import json
import os
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

import made_scenes
import table
from process import Run
from renderers import ADAPTERS, HERE, Source, Unsupported
from shared_scene import box_filtered, with_common_materials

try:
    import agreement
except ModuleNotFoundError:  # numpy: comparisons of rays alone do without
    agreement = None

ROOT = os.path.relpath(os.path.join(HERE, '..', '..', '..'))
SCENES = [
    *(
        os.path.join(ROOT, 'scenes', f'{name}.xml')
        for name in (
            'cbox-sphere',
            'bubble',
            'cbox-bumpy',
            'cbox-ajax',
            'thousand-lamps',
            'material-gallery',
            'still-life',
            'gallery/terrace',
            'daylight',
            'forest',
        )
    ),
    'made:room',
    'made:triangles=10000000',
]


def say(text):
    print(text, file=sys.stderr, flush=True)


def spread(values):
    """Median and extremes; None where there is no value, or where one could not be measured (None)."""
    values = [] if None in values else values
    return (
        {'median': statistics.median(values), 'min': min(values), 'max': max(values), 'count': len(values)}
        if values
        else None
    )


def rate_beyond(samples, took, base, least):
    """Samples per second of what took longer than a picture of one sample; None where that is not at least so many times
    as much."""
    return samples / (took - base) if took - base > least * base else None


def ratios(firsts, others):
    """One a repetition; None where either was not measured."""
    return [None if first is None or other is None else first / other for first, other in zip(firsts, others)]


class Etendue:
    def __init__(self, text, options):
        self.name, _, self.path = text.rpartition('=')
        self.name = self.name or 'etendue'
        self.options = options
        self.device = self.driver = 'unknown'

    def bench(self, scene, *more):
        device = ['--device', self.options.device, '--threads', str(self.options.threads)]
        report = Run([self.path, 'bench', scene, *device, '--json', *more], self.options.threads).json()
        self.device, self.driver = report['device'], report['driver']
        return report['scenes'][0]

    def version(self):
        return Run([self.path, '--version'], 1).output.strip()

    def rays(self, scene, *more):
        report = self.bench(scene, '--part', 'rays', '--rays', str(self.options.rays), '--repetitions', '1', *more)
        return {(r['class'], r['order']): r for r in report['rays']}

    def export(self, scene, folder):
        """Scene and rays, in a folder that is named after the scene in this one."""
        rays = ['--part', 'rays', '--rays', str(self.options.rays), '--repetitions', '0']
        self.bench(scene, *rays, '--size', self.options.size, '--export', folder)

    def source(self, scene, folder):
        """The scene for adapters; scene.json lies in `folder` where Etendue could write it."""

        def convert(out, *more):
            Run([self.path, 'convert', scene, out, '--size', self.options.size, '--force', '-q', *more], 1)

        path = os.path.join(folder, 'scene.json')
        if not os.path.exists(path):
            return Source(convert, reason='the scene has more than `etendue bench --export` writes')
        with open(path, encoding='utf-8') as file:
            return Source(convert, json.load(file))

    def render_command(self, scene, spp, out, seed, *more):
        device = ['--device', self.options.device, '--threads', str(self.options.threads)]
        how = ['--size', self.options.size, '--spp', str(spp), '--seed', str(seed)]
        return [self.path, 'render', scene, *device, *how, '-o', out, '--json', *more]

    def render(self, scene, spp, out, seed, *more):
        """Seconds of rendering, compilation of the kernel left out, and CPU seconds of the whole process."""
        run = Run(self.render_command(scene, spp, out, seed, *more), self.options.threads)
        report = run.json()
        return report['render_seconds'] - report.get('timings', {}).get('pipeline', 0.0), run.cpu_seconds

    def render_and_compile(self, scene, spp, out, seed):
        """Seconds of rendering with compilation, and CPU seconds of the whole process. What `render` leaves out includes
        the samples of the first dispatch, in which drivers compile: in a small picture these are most of all."""
        run = Run(self.render_command(scene, spp, out, seed), self.options.threads)
        return run.json()['render_seconds'], run.cpu_seconds


class RayComparison:
    """Rates of each class and order: one list for every program, one entry a repetition."""

    def __init__(self, scene, same, folder, etendues, options):
        """`same`: the file that was exported into `folder`."""
        self.scene, self.same, self.folder, self.etendues, self.options = scene, same, folder, etendues, options
        self.rates = {}  # (class, order) -> name -> list of (wall rate, CPU rate)
        self.differ = {}

    def add(self, key, name, wall, cpu):
        self.rates.setdefault(key, {}).setdefault(name, []).append((wall, cpu))

    def repeat(self, _):
        for etendue in self.etendues:
            for key, r in etendue.rays(self.same).items():
                self.add(key, etendue.name, r['rays_per_second']['median'], r['rays_per_cpu_second']['median'])
        qualities = {'embree': []} if not self.options.embree_high else {'embree': [], 'embree high': ['--high']}
        for name, more in qualities.items():
            run = Run(
                [
                    self.options.embree,
                    '--threads',
                    str(self.options.threads),
                    '--repetitions',
                    '1',
                    *more,
                    os.path.join(self.folder, 'rays.bin'),
                ],
                self.options.threads,
            )
            for r in run.json()['rays']:
                key = (r['class'], r['order'])
                self.add(key, name, r['rays_per_second'][0], r['rays_per_cpu_second'][0])
                self.differ[key] = max(self.differ.get(key, 0), r['differ'] / r['rays'])

    def report(self):
        first = self.etendues[0].name
        rows = []
        for key, by_name in self.rates.items():
            for name, rates in by_name.items():
                row = {
                    'class': key[0],
                    'order': key[1],
                    'program': name,
                    'rays_per_second': spread([r[0] for r in rates]),
                    'rays_per_cpu_second': spread([r[1] for r in rates]),
                    'share_of_differing_hits': self.differ[key],
                }
                if name != first:
                    row['ratio'] = spread([e[0] / r[0] for e, r in zip(by_name[first], rates)])
                    row['cpu_ratio'] = spread([e[1] / r[1] for e, r in zip(by_name[first], rates)])
                rows.append(row)
        return rows

    def passed(self):
        return all(share <= 1e-3 for share in self.differ.values())


class SampleComparison:
    """Seconds of rendering of each renderer, one list entry a repetition."""

    def __init__(self, scene, same, folder, etendues, adapters, options):
        """`same`: the scene, or its copy with the box filter; `folder`: where adapters find and write what they need."""
        self.scene, self.same, self.folder, self.etendues, self.options = scene, same, folder, etendues, options
        width, height = map(int, options.size.split('x'))
        self.samples = width * height * options.spp
        self.adapters, self.unsupported = [], {}
        source = etendues[0].source(same, folder)
        for adapter in adapters:
            try:
                adapter.prepare(source, folder)
                self.adapters.append(adapter)
            except Unsupported as reason:
                self.unsupported[adapter.name] = str(reason)
        self.rates, self.base_cpu, self.base_seconds = {}, {}, {}
        self.estimates = {name: agreement.Estimate() for name, *_ in self.programs()}
        self.agreement, self.details = {}, {}

    def programs(self):
        """Of what renders: name, suffix of pictures, and function (spp, picture, seed) → (render s, CPU s)."""
        for etendue in self.etendues:
            yield etendue.name, '.exr', lambda *how, e=etendue: e.render_and_compile(self.same, *how)
        for adapter in self.adapters:
            yield adapter.name, adapter.suffix, lambda *how, a=adapter: self.render_by(a, *how)

    def render_by(self, adapter, spp, out, seed):
        command = adapter.command(self.folder, out, spp, self.options.threads, seed)
        run = Run(command, self.options.threads, adapter.environment())
        self.details[adapter.name] = adapter.details(run.output)
        seconds = adapter.render_seconds(run.output)
        if seconds is None:
            raise RuntimeError(f'{adapter.name} does not say how long it rendered:\n{run.output[-2000:]}')
        return seconds, run.cpu_seconds

    def render(self, number, spp, seed):
        """One picture by one of the programs; its path, the render seconds and the CPU seconds."""
        name, suffix, render = list(self.programs())[number]
        out = os.path.join(self.folder, name + suffix)
        if os.path.exists(out):
            os.remove(out)  # what is read afterwards was rendered now
        seconds, cpu = render(spp, out, seed)
        if not os.path.exists(out):
            raise RuntimeError(f'{name} ended well but wrote no {out}')
        return out, seconds, cpu

    def prepare(self):
        """Warms caches of kernels, which may depend on the number of samples; measures a picture of one sample."""
        for number, (name, *_) in enumerate(self.programs()):
            self.render(number, self.options.spp, 0)
            self.render(number, 1, 0)
            _, seconds, self.base_cpu[name] = self.render(number, 1, 0)
            if number < len(self.etendues):  # the others' times are without compilation
                self.base_seconds[name] = seconds

    def repeat(self, repetition):
        pixels = self.samples / self.options.spp
        for number, (name, *_) in enumerate(self.programs()):
            # Different for every picture: the same build under two names would otherwise make the same ones.
            out, seconds, cpu = self.render(number, self.options.spp, 1 + 1000 * number + repetition)
            more = pixels * (self.options.spp - 1)
            # Less than a tenth more than a picture of one sample took is within what starting a process varies by, less
            # than half within what compiling does.
            cpu_rate = rate_beyond(more, cpu, self.base_cpu[name], 0.1)
            if name in self.base_seconds:
                rate = rate_beyond(more, seconds, self.base_seconds[name], 0.5)
            else:
                rate = self.samples / max(seconds, 1e-6)
            self.rates.setdefault(name, []).append((rate, cpu_rate))
            self.estimates[name].add(agreement.read_picture(out))
            say(f'  {os.path.basename(self.scene)} {name}: {seconds:.2f} s')

    def compare_pictures(self):
        first = self.etendues[0].name
        for name, estimate in self.estimates.items():
            if name != first:
                self.agreement[name] = agreement.compare(estimate, self.estimates[first])

    def report(self):
        first = self.etendues[0].name
        rows = []
        for name, rates in self.rates.items():
            row = {
                'renderer': name,
                'samples_per_second': spread([r[0] for r in rates]),
                'samples_per_cpu_second': spread([r[1] for r in rates]),
            }
            if name != first:
                row['ratio'] = spread(ratios([e[0] for e in self.rates[first]], [r[0] for r in rates]))
                row['cpu_ratio'] = spread(ratios([e[1] for e in self.rates[first]], [r[1] for r in rates]))
                row['agreement'] = self.agreement[name]
            rows.append(row)
        rows += [{'renderer': name, 'unsupported': reason} for name, reason in self.unsupported.items()]
        return rows

    def passed(self):
        """Whether every picture is the same, whole and block by block, as far as chance and the tolerance go."""
        return all(agreement.agrees(result, self.options.tolerance) for result in self.agreement.values())


def options_from_command_line():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        'scenes',
        nargs='*',
        metavar='SCENE',
        help='files, or made:NAME for scenes that are written on the fly (made_scenes.py; default: those of docs/benchmarks.md)',
    )
    parser.add_argument(
        '--etendue', action='append', required=True, metavar='[NAME=]PATH', help='the program; may be repeated'
    )
    parser.add_argument('--embree', metavar='PATH', help='embree_rays; without it rays are not compared')
    parser.add_argument('--embree-high', action='store_true', help="also Embree's slowest build with spatial splits")
    parser.add_argument(
        '--with',
        dest='wanted',
        metavar='NAMES',
        help='renderers, with commas (default: all that are found; - for none)',
    )
    parser.add_argument('--device', default='auto', help='of Etendue')
    parser.add_argument('--threads', type=int, default=2)
    parser.add_argument('--repetitions', type=int, default=5)
    parser.add_argument('--rays', type=int, default=1 << 19, help='primary rays')
    parser.add_argument('--size', default='800x600')
    parser.add_argument('--spp', type=int, default=64)
    parser.add_argument(
        '--tolerance',
        type=float,
        default=0.01,
        help='relative difference of means, of the picture and its blocks, that is allowed beyond what chance explains',
    )
    parser.add_argument('--json', metavar='FILE', help='write everything to this file')
    parser.add_argument(
        '--page', metavar='FILE', help='write the tables between the marks of this page (docs/benchmarks.md)'
    )
    parser.add_argument('--keep', metavar='FOLDER', help='keep exported scenes and pictures here')
    options = parser.parse_args()
    if options.spp < 2 or options.repetitions < 1 or options.threads < 1:
        parser.error('--spp must be at least 2, --repetitions and --threads at least 1')
    options.scenes = options.scenes or SCENES
    return options


def find_adapters(options):
    wanted = options.wanted.split(',') if options.wanted else [a.name for a in ADAPTERS]
    known = {a.name for a in ADAPTERS}
    for name in wanted:
        if name != '-' and name not in known:
            sys.exit(f"There is no adapter '{name}'; there are {', '.join(sorted(known))}.")
    found = [a for a in ADAPTERS if a.name in wanted and a.find()]
    for adapter in ADAPTERS:
        if adapter.name in wanted and adapter not in found:
            say(f'{adapter.name} is not on PATH and left out.')
    return found


def has_instances(scene):
    if not scene.endswith('.xml'):
        return False
    root = xml.etree.ElementTree.parse(scene).getroot()
    return any(element.get('type') == 'instance' for element in root)


def exported_scene(etendue, scene, folder, others):
    """What programs share of a scene: the file for Etendue, the folder of its neutral export, which is empty where there
    is none, and what was replaced in the file because `others` lack it."""
    file = made_scenes.scene_file(scene, made_scenes.Workshop(etendue.path, os.path.join(folder, 'made')))
    same, changes = box_filtered(etendue, file, os.path.join(folder, 'box')), []
    if others:
        same, changes = with_common_materials(etendue, same, folder)
    exported = os.path.join(folder, os.path.splitext(os.path.basename(same))[0])
    os.makedirs(exported, exist_ok=True)
    if has_instances(file):
        say(f'{scene}: neither rays nor what needs its neutral export, which has a copy for each instance')
        return same, exported, changes
    try:
        etendue.export(same, folder)
    except RuntimeError as reason:
        why = str(reason).strip().split('\n')[-1]
        say(f'{scene}: neither rays nor what needs its neutral export ({why})')
    return same, exported, changes


def comparisons(options, etendues, adapters, folder):
    """Of rays and of samples, one a scene each; and what was replaced in each scene."""
    rays, samples, changes = [], [], {}
    for scene in options.scenes:
        same, exported, changes[scene] = exported_scene(etendues[0], scene, folder, bool(adapters))
        if options.embree and os.path.exists(os.path.join(exported, 'rays.bin')):
            rays.append(RayComparison(scene, same, exported, etendues, options))
        if adapters or len(etendues) > 1:
            samples.append(SampleComparison(scene, same, exported, etendues, adapters, options))
    return rays, samples, changes


def require_pictures(options):
    if agreement is None:
        sys.exit(
            f'Pictures are compared with numpy, which {sys.executable} does not have (Debian: python3-numpy); '
            'with "--with -" rays alone are compared, without it.'
        )
    if options.repetitions < agreement.LEAST_PICTURES:
        sys.exit(
            f'{options.repetitions} pictures of a renderer say too little about chance: --repetitions must be at least '
            f'{agreement.LEAST_PICTURES} where pictures are compared.'
        )


def git_commit():
    """Of the tree that this file is in, with a plus where it was changed since; "unknown" outside of a repository."""
    done = (
        subprocess.run(
            ['git', 'describe', '--always', '--exclude=*', '--dirty=+'],
            cwd=os.path.dirname(os.path.abspath(__file__)),
            capture_output=True,
            text=True,
            check=False,
        )
        if shutil.which('git')
        else None
    )
    return done.stdout.strip() if done and done.returncode == 0 else 'unknown'


def circumstances(etendue, load):
    """When, how and where a report came to be; `load`: before it began."""
    return {
        'date': time.strftime('%Y-%m-%d', time.gmtime()),
        'command': shlex.join(sys.argv),
        'machine': table.machine(),
        'load': load,
        'sources': git_commit(),
        'device': etendue.device,
        'driver': etendue.driver,
    }


def versions(etendues, adapters, samples):
    """Of every program, with what it says of how it computes."""
    details = {name: text for comparison in samples for name, text in comparison.details.items()}
    return {
        **{e.name: e.version() for e in etendues},
        **{a.name: ', '.join(filter(None, [a.version(), details.get(a.name)])) for a in adapters},
    }


def run(options, folder):
    etendues = [Etendue(text, options) for text in options.etendue]
    adapters = find_adapters(options)
    if adapters or len(etendues) > 1:
        require_pictures(options)
    load = os.getloadavg()[0]
    rays, samples, changes = comparisons(options, etendues, adapters, folder)
    for comparison in samples:
        comparison.prepare()
    for repetition in range(options.repetitions):
        say(f'repetition {repetition + 1} of {options.repetitions}')
        for comparison in rays + samples:
            comparison.repeat(repetition)
    for comparison in samples:
        comparison.compare_pictures()
    return {
        **circumstances(etendues[0], load),
        'threads': options.threads,
        'size': options.size,
        'spp': options.spp,
        'repetitions': options.repetitions,
        'versions': versions(etendues, adapters, samples),
        'changes': {scene: words for scene, words in changes.items() if words},
        'rays': [{'scene': c.scene, 'rows': c.report()} for c in rays],
        'samples': [{'scene': c.scene, 'rows': c.report()} for c in samples],
        'passed': all(c.passed() for c in rays + samples),
    }


def main():
    options = options_from_command_line()
    with tempfile.TemporaryDirectory(prefix='etendue-compare-') as temporary:
        report = run(options, options.keep or temporary)
    print(table.terminal_text(report))
    if options.page:
        table.write_between_marks(options.page, table.markdown(report))
    if options.json:
        with open(options.json, 'w', encoding='utf-8') as file:
            json.dump(report, file, indent=2)
            file.write('\n')
    if not report['passed']:
        sys.exit(
            'Hits or pictures differ by more than chance and rounding explain: the ratios compare different things.'
        )


if __name__ == '__main__':
    main()
