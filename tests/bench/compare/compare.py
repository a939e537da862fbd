#!/usr/bin/env python3
"""Etendue against Embree and other renderers: one run, one machine, everything in turns.

    compare.py --etendue build/release/src/etendue --embree build/release/tests/bench/compare/embree_rays \\
               scenes/cbox-sphere.xml scenes/cbox-bumpy.xml

Rays: `etendue bench` casts primary, diffuse and shadow rays and exports them; embree_rays casts the very same ones through the same
triangles. Samples: every renderer found on PATH renders the exported scene at the same size, samples per pixel, path length and
number of threads; its picture must have the mean luminance of Etendue's. Ratios are formed within one repetition, and their median is
told with the extremes. `--etendue NAME=PATH` may be repeated: the first is what the others are held against. Python's standard
library is all this needs. docs/benchmarks.md says what the figures mean.
"""
import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time

from renderers import ADAPTERS, Unsupported


def say(text):
    print(text, file=sys.stderr, flush=True)


def spread(values):
    return {'median': statistics.median(values), 'min': min(values), 'max': max(values), 'count': len(values)} if values else None



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
        return json.JSONDecoder().raw_decode(self.output[start.start():])[0]


class Etendue:
    def __init__(self, text, options):
        self.name, _, self.path = text.rpartition('=')
        self.name = self.name or 'etendue'
        self.options = options

    def bench(self, scene, *more):
        device = ['--device', self.options.device, '--threads', str(self.options.threads)]
        return Run([self.path, 'bench', scene, *device, '--json', *more], self.options.threads).json()['scenes'][0]

    def rays(self, scene, *more):
        report = self.bench(scene, '--part', 'rays', '--rays', str(self.options.rays), '--repetitions', '1', *more)
        return {(r['class'], r['order']): r for r in report['rays']}

    def export(self, scene, folder):
        """Scene and rays; returns the folder of the scene."""
        self.bench(scene, '--part', 'rays', '--rays', str(self.options.rays), '--size', self.options.size, '--repetitions', '0', '--export',
                   folder)
        return os.path.join(folder, os.path.splitext(os.path.basename(scene))[0])

    def render(self, scene, spp, out):
        """Seconds of rendering, compilation of the kernel left out, and CPU seconds of the whole process."""
        run = Run([self.path, 'render', scene, '--device', self.options.device, '--threads', str(self.options.threads), '--size',
                   self.options.size, '--spp', str(spp), '-o', out, '--json'], self.options.threads)
        report = run.json()
        return report['render_seconds'] - report.get('timings', {}).get('pipeline', 0.0), run.cpu_seconds

    def relative_bias(self, picture, reference):
        """How much brighter a picture is on average than this one's, with its 95 % interval, both as fractions."""
        with tempfile.NamedTemporaryFile(suffix='.json') as file:
            Run([self.path, 'compare', '--no-flip', '--json', file.name, picture, reference], self.options.threads)
            with open(file.name, encoding='utf-8') as text:
                metrics = json.load(text)['metrics']
        return metrics['relbias'], metrics['relbiasInterval']


class RayComparison:
    """Rates of each class and order: one list for every program, one entry a repetition."""

    def __init__(self, scene, folder, etendues, options):
        self.scene, self.folder, self.etendues, self.options = scene, folder, etendues, options
        self.rates = {}  # (class, order) -> name -> list of (wall rate, CPU rate)
        self.differ = {}

    def add(self, key, name, wall, cpu):
        self.rates.setdefault(key, {}).setdefault(name, []).append((wall, cpu))

    def repeat(self):
        for etendue in self.etendues:
            for key, r in etendue.rays(self.scene).items():
                self.add(key, etendue.name, r['rays_per_second']['median'], r['rays_per_cpu_second']['median'])
        qualities = {'embree': []} if not self.options.embree_high else {'embree': [], 'embree high': ['--high']}
        for name, more in qualities.items():
            run = Run([self.options.embree, '--threads', str(self.options.threads), '--repetitions', '1', *more,
                       os.path.join(self.folder, 'rays.bin')], self.options.threads)
            for r in run.json()['rays']:
                key = (r['class'], r['order'])
                self.add(key, name, r['rays_per_second'][0], r['rays_per_cpu_second'][0])
                self.differ[key] = max(self.differ.get(key, 0), r['differ'] / r['rays'])

    def report(self):
        first = self.etendues[0].name
        rows = []
        for key, by_name in self.rates.items():
            for name, rates in by_name.items():
                row = {'class': key[0], 'order': key[1], 'program': name, 'rays_per_second': spread([r[0] for r in rates]),
                       'rays_per_cpu_second': spread([r[1] for r in rates]), 'share_of_differing_hits': self.differ[key]}
                if name != first:
                    row['ratio'] = spread([e[0] / r[0] for e, r in zip(by_name[first], rates)])
                    row['cpu_ratio'] = spread([e[1] / r[1] for e, r in zip(by_name[first], rates)])
                rows.append(row)
        return rows

    def passed(self):
        return all(share <= 1e-3 for share in self.differ.values())


class SampleComparison:
    """Seconds of rendering of each renderer, one list entry a repetition."""

    def __init__(self, scene, folder, etendues, adapters, options):
        self.scene, self.folder, self.etendues, self.options = scene, folder, etendues, options
        with open(os.path.join(folder, 'scene.json'), encoding='utf-8') as file:
            description = json.load(file)
        self.samples = description['camera']['width'] * description['camera']['height'] * options.spp
        self.adapters, self.unsupported = [], {}
        for adapter in adapters:
            try:
                adapter.export(description, folder)
                self.adapters.append(adapter)
            except Unsupported as reason:
                self.unsupported[adapter.name] = str(reason)
        self.rates, self.base_cpu, self.bias = {}, {}, {}

    def programs(self):
        """Name and a function (spp, picture) → (render seconds, CPU seconds) of everything that renders."""
        for etendue in self.etendues:
            yield etendue.name, lambda spp, out, e=etendue: e.render(self.scene, spp, out)
        for adapter in self.adapters:
            yield adapter.name, lambda spp, out, a=adapter: self.render_by(a, spp, out)

    def render_by(self, adapter, spp, out):
        run = Run(adapter.command(self.folder, out, spp, self.options.threads), self.options.threads, adapter.environment)
        seconds = adapter.render_seconds(run.output)
        if seconds is None:
            raise RuntimeError(f'{adapter.name} does not say how long it rendered:\n{run.output[-2000:]}')
        return seconds, run.cpu_seconds

    def prepare(self):
        """One sample a pixel: warms caches, and shows what a process costs apart from its samples."""
        for name, render in self.programs():
            self.base_cpu[name] = render(1, os.path.join(self.folder, f'{name}-1.exr'))[1]

    def repeat(self):
        pixels = self.samples / self.options.spp
        for name, render in self.programs():
            seconds, cpu = render(self.options.spp, os.path.join(self.folder, f'{name}.exr'))
            cpu_rate = pixels * (self.options.spp - 1) / max(cpu - self.base_cpu[name], 1e-6)
            self.rates.setdefault(name, []).append((self.samples / max(seconds, 1e-6), cpu_rate))
            say(f'  {os.path.basename(self.scene)} {name}: {seconds:.2f} s')

    def compare_pictures(self):
        first = self.etendues[0]
        for name, _ in self.programs():
            if name != first.name:
                self.bias[name] = first.relative_bias(os.path.join(self.folder, f'{name}.exr'),
                                                      os.path.join(self.folder, f'{first.name}.exr'))

    def report(self):
        first = self.etendues[0].name
        rows = []
        for name, rates in self.rates.items():
            row = {'renderer': name, 'samples_per_second': spread([r[0] for r in rates]),
                   'samples_per_cpu_second': spread([r[1] for r in rates])}
            if name != first:
                row['ratio'] = spread([e[0] / r[0] for e, r in zip(self.rates[first], rates)])
                row['cpu_ratio'] = spread([e[1] / r[1] for e, r in zip(self.rates[first], rates)])
                row['relative_bias'], row['relative_bias_interval'] = self.bias[name]
            rows.append(row)
        rows += [{'renderer': name, 'unsupported': reason} for name, reason in self.unsupported.items()]
        return rows

    def passed(self):
        """Whether every picture has the same mean luminance, within 95 % of chance and the tolerance."""
        return all(abs(bias) <= self.options.tolerance + (interval[1] - interval[0]) / 2.0 for bias, interval in self.bias.values())


def text_of(row, unit):
    median = f"{row['median'] / unit:.2f} ({row['min'] / unit:.2f} - {row['max'] / unit:.2f})"
    return f'{median:>22}'


def print_rays(scene, rows):
    print(f'\n{scene}: Mrays/s, per CPU second, and Etendue as multiples of the other')
    for row in rows:
        print(f"  {row['class']:<8} {row['order']:<9} {row['program']:<14} {text_of(row['rays_per_second'], 1e6)} "
              f"{text_of(row['rays_per_cpu_second'], 1e6)}" + (f" {text_of(row['ratio'], 1)} {text_of(row['cpu_ratio'], 1)}  "
              f"{100.0 * row['share_of_differing_hits']:.3f} % of the hits differ" if 'ratio' in row else ''))


def print_samples(scene, rows):
    print(f'\n{scene}: Msamples/s, per CPU second, and Etendue as multiples of the other')
    for row in rows:
        if 'unsupported' in row:
            print(f"  {row['renderer']:<22} {row['unsupported']}")
            continue
        line = f"  {row['renderer']:<22} {text_of(row['samples_per_second'], 1e6)} {text_of(row['samples_per_cpu_second'], 1e6)}"
        if 'ratio' in row:
            low, high = row['relative_bias_interval']
            line += (f" {text_of(row['ratio'], 1)} {text_of(row['cpu_ratio'], 1)}  brighter by {100.0 * row['relative_bias']:+.2f} % "
                     f'[{100.0 * low:+.2f}, {100.0 * high:+.2f}]')
        print(line)


def options_from_command_line():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scenes', nargs='+', metavar='SCENE')
    parser.add_argument('--etendue', action='append', required=True, metavar='[NAME=]PATH', help='the program; may be repeated')
    parser.add_argument('--embree', metavar='PATH', help='embree_rays; without it rays are not compared')
    parser.add_argument('--embree-high', action='store_true', help="also Embree's slowest build with spatial splits")
    parser.add_argument('--with', dest='wanted', metavar='NAMES', help='renderers, with commas (default: all that are found; - for none)')
    parser.add_argument('--device', default='auto', help='of Etendue')
    parser.add_argument('--threads', type=int, default=2)
    parser.add_argument('--repetitions', type=int, default=5)
    parser.add_argument('--rays', type=int, default=1 << 19, help='primary rays')
    parser.add_argument('--size', default='800x600')
    parser.add_argument('--spp', type=int, default=64)
    parser.add_argument('--tolerance', type=float, default=0.02,
                        help='relative difference of mean luminance that is no error beyond what chance explains')
    parser.add_argument('--json', metavar='FILE', help='write everything to this file')
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


def run(options, folder):
    etendues = [Etendue(text, options) for text in options.etendue]
    adapters = find_adapters(options)
    rays, samples = [], []
    for scene in options.scenes:
        exported = etendues[0].export(scene, folder)
        if options.embree:
            rays.append(RayComparison(scene, exported, etendues, options))
        if adapters or len(etendues) > 1:
            samples.append(SampleComparison(scene, exported, etendues, adapters, options))
    for comparison in samples:
        comparison.prepare()
    for repetition in range(options.repetitions):
        say(f'repetition {repetition + 1} of {options.repetitions}')
        for comparison in rays + samples:
            comparison.repeat()
    for comparison in samples:
        comparison.compare_pictures()
    report = {'date': time.strftime('%Y-%m-%d', time.gmtime()), 'threads': options.threads, 'size': options.size, 'spp': options.spp,
              'versions': {a.name: a.version() for a in adapters},
              'rays': [{'scene': c.scene, 'rows': c.report()} for c in rays],
              'samples': [{'scene': c.scene, 'rows': c.report()} for c in samples],
              'passed': all(c.passed() for c in rays + samples)}
    return report


def main():
    options = options_from_command_line()
    with tempfile.TemporaryDirectory(prefix='etendue-compare-') as temporary:
        report = run(options, options.keep or temporary)
    for part in report['rays']:
        print_rays(part['scene'], part['rows'])
    for part in report['samples']:
        print_samples(part['scene'], part['rows'])
    if options.json:
        with open(options.json, 'w', encoding='utf-8') as file:
            json.dump(report, file, indent=2)
            file.write('\n')
    if not report['passed']:
        sys.exit('Hits or pictures differ by more than chance and rounding explain: the ratios above compare different things.')


if __name__ == '__main__':
    main()
