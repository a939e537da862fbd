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
import re
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

import table
from renderers import ADAPTERS, Source, Unsupported

try:
    import agreement
except ModuleNotFoundError:  # numpy: comparisons of rays alone do without
    agreement = None


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


def ratios(firsts, others):
    """One a repetition; None where either was not measured."""
    return [None if first is None or other is None else first / other for first, other in zip(firsts, others)]


def box_filtered(etendue, scene, folder):
    """The scene with the box filter: itself where it has no other, or a copy in `folder` with absolute file names. Of a
    scene of another format, what `etendue convert` makes of it."""
    os.makedirs(folder, exist_ok=True)
    cameras = []
    if scene.endswith('.xml'):
        tree = xml.etree.ElementTree.parse(scene)
        cameras = list(tree.iter('camera'))
    if not cameras:
        own = os.path.join(folder, os.path.splitext(os.path.basename(scene))[0] + '-own.xml')
        Run([etendue.path, 'convert', scene, own, '--force', '-q'], 1)
        return box_filtered(etendue, own, folder)
    if all([f.get('type') for f in camera.findall('rfilter')] == ['box'] for camera in cameras):
        return scene
    for camera in cameras:
        for other in camera.findall('rfilter'):
            camera.remove(other)
        xml.etree.ElementTree.SubElement(camera, 'rfilter', type='box')
    for name in tree.iter('string'):
        if name.get('name') == 'filename' and not name.get('value').startswith('etendue:'):
            name.set('value', os.path.join(os.path.dirname(os.path.abspath(scene)), name.get('value')))
    copy = os.path.join(folder, os.path.basename(scene))
    tree.write(copy, encoding='utf-8', xml_declaration=True)
    return copy


class Run:
    """One process: what it printed and the CPU seconds it took, all threads together."""

    def __init__(self, command, threads, environment=None):
        environment = {**os.environ, 'LP_NUM_THREADS': str(threads), **(environment or {})}  # LP: of Mesa's lavapipe
        with tempfile.TemporaryFile('w+', encoding='utf-8', errors='replace') as out:
            process = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, env=environment)
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            out.seek(0)
            self.output = out.read()
        self.cpu_seconds = usage.ru_utime + usage.ru_stime
        if process.returncode != 0:
            raise RuntimeError(f"'{' '.join(command)}' ended with code {process.returncode}:\n{self.output[-2000:]}")

    def json(self):
        """The JSON object in the output; messages may stand before and after it."""
        start = re.search(r'^\{', self.output, re.MULTILINE)
        if not start:
            raise RuntimeError(f'no JSON in the output:\n{self.output[-2000:]}')
        return json.JSONDecoder().raw_decode(self.output[start.start() :])[0]


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

    def render(self, scene, spp, out, seed, *more):
        """Seconds of rendering, compilation of the kernel left out, and CPU seconds of the whole process."""
        run = Run(
            [
                self.path,
                'render',
                scene,
                '--device',
                self.options.device,
                '--threads',
                str(self.options.threads),
                '--size',
                self.options.size,
                '--spp',
                str(spp),
                '--seed',
                str(seed),
                '-o',
                out,
                '--json',
                *more,
            ],
            self.options.threads,
        )
        report = run.json()
        return report['render_seconds'] - report.get('timings', {}).get('pipeline', 0.0), run.cpu_seconds


class RayComparison:
    """Rates of each class and order: one list for every program, one entry a repetition."""

    def __init__(self, scene, folder, etendues, options):
        self.scene, self.folder, self.etendues, self.options = scene, folder, etendues, options
        self.rates = {}  # (class, order) -> name -> list of (wall rate, CPU rate)
        self.differ = {}

    def add(self, key, name, wall, cpu):
        self.rates.setdefault(key, {}).setdefault(name, []).append((wall, cpu))

    def repeat(self, _):
        for etendue in self.etendues:
            for key, r in etendue.rays(self.scene).items():
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
        self.rates, self.base_cpu = {}, {}
        self.estimates = {name: agreement.Estimate() for name, *_ in self.programs()}
        self.agreement, self.details = {}, {}

    def programs(self):
        """Of what renders: name, suffix of pictures, and function (spp, picture, seed) → (render s, CPU s)."""
        for etendue in self.etendues:
            yield etendue.name, '.exr', lambda *how, e=etendue: e.render(self.same, *how)
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
            self.base_cpu[name] = self.render(number, 1, 0)[2]

    def repeat(self, repetition):
        pixels = self.samples / self.options.spp
        for number, (name, *_) in enumerate(self.programs()):
            # Different for every picture: the same build under two names would otherwise make the same ones.
            out, seconds, cpu = self.render(number, self.options.spp, 1 + 1000 * number + repetition)
            more_cpu = cpu - self.base_cpu[name]
            # Less than a tenth more than a picture of one sample took: that is within what starting a process varies
            # by.
            cpu_rate = pixels * (self.options.spp - 1) / more_cpu if more_cpu > 0.1 * self.base_cpu[name] else None
            self.rates.setdefault(name, []).append((self.samples / max(seconds, 1e-6), cpu_rate))
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
    parser.add_argument('scenes', nargs='+', metavar='SCENE')
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


def comparisons(options, etendues, adapters, folder):
    """Of rays and of samples, one a scene each."""
    rays, samples = [], []
    for scene in options.scenes:
        same = box_filtered(etendues[0], scene, os.path.join(folder, 'box'))
        exported = os.path.join(folder, os.path.splitext(os.path.basename(same))[0])
        os.makedirs(exported, exist_ok=True)
        try:
            etendues[0].export(same, folder)
        except RuntimeError as reason:
            say(f'{scene}: neither rays nor what needs its neutral export ({reason})')
        if options.embree and os.path.exists(os.path.join(exported, 'rays.bin')):
            rays.append(RayComparison(scene, exported, etendues, options))
        if adapters or len(etendues) > 1:
            samples.append(SampleComparison(scene, same, exported, etendues, adapters, options))
    return rays, samples


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
    rays, samples = comparisons(options, etendues, adapters, folder)
    for comparison in samples:
        comparison.prepare()
    for repetition in range(options.repetitions):
        say(f'repetition {repetition + 1} of {options.repetitions}')
        for comparison in rays + samples:
            comparison.repeat(repetition)
    for comparison in samples:
        comparison.compare_pictures()
    return {
        'date': time.strftime('%Y-%m-%d', time.gmtime()),
        'command': shlex.join(sys.argv),
        'machine': table.machine(),
        'load': load,
        'sources': git_commit(),
        'device': etendues[0].device,
        'driver': etendues[0].driver,
        'threads': options.threads,
        'size': options.size,
        'spp': options.spp,
        'repetitions': options.repetitions,
        'versions': versions(etendues, adapters, samples),
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
