#!/usr/bin/env python3
"""What a picture costs beyond its samples: start-up time and memory, of Etendue and other renderers.

    PATH=~/peers/bin:$PATH overhead.py --etendue build/release/src/etendue

Start-up: seconds from the command to a finished, small picture with one sample per pixel, with empty caches of compiled
kernels and with those that this first run left. Memory: the peak of the process for two scenes that differ in one number,
of triangles, instances or texels, and the difference for each. All programs read the same file: what `etendue convert --to
mitsuba` makes of the scene; Cycles gets the neutral export. The standard library is enough. docs/benchmarks.md says
what the figures mean.
"""

import argparse
import json
import os
import tempfile

import made_scenes
import overhead_table
import table
from compare import ROOT, Etendue, circumstances, exported_scene, find_adapters, say, spread, versions
from process import Run, TooLong
from renderers import Mitsuba, Unsupported

SCENES = [
    'made:empty',
    os.path.join(ROOT, 'scenes', 'cbox-sphere.xml'),
    'made:triangles=1000000',
    os.path.join(ROOT, 'scenes', 'material-gallery.xml'),
]
PARTS = ('start', 'memory')
# Caches lie below these two; the others would move Mesa's or switch it off.
CACHE_PLACES = ('HOME', 'XDG_CACHE_HOME')
NOT_INHERITED = ('MESA_SHADER_CACHE_DIR', 'MESA_SHADER_CACHE_DISABLE', 'MESA_GLSL_CACHE_DIR', 'MESA_GLSL_CACHE_DISABLE')


class Case:
    """A scene, ready for each program: a command that renders one sample per pixel of it, or why there is none."""

    def __init__(self, scene, folder, etendue, adapters, options):
        self.scene, self.folder, self.options = scene, folder, options
        os.makedirs(folder)
        self.same, exported, self.changes = exported_scene(etendue, scene, folder, True)
        self.commands, self.environments, self.unsupported = {}, {}, {}
        source = etendue.source(self.same, exported)
        self.commands[etendue.name] = etendue.render_command(self.common_file(source, exported), 1, self.out('.exr'), 0)
        for adapter in adapters:
            try:
                adapter.prepare(source, exported)
            except Unsupported as reason:
                self.unsupported[adapter.name] = str(reason)
                continue
            out = self.out(adapter.suffix)
            self.commands[adapter.name] = adapter.command(exported, out, 1, options.threads, 0)
            self.environments[adapter.name] = adapter.environment()

    def out(self, suffix):
        return os.path.join(self.folder, 'out' + suffix)

    def common_file(self, source, exported):
        """The file that Mitsuba gets, for Etendue as well, or Etendue's own where that cannot be written."""
        try:
            Mitsuba('scalar_rgb').prepare(source, exported)
        except Unsupported:
            return self.same
        return os.path.join(exported, 'mitsuba.xml')

    def run(self, name, caches):
        """Renders with the caches in that folder."""
        for suffix in ('.exr', '.pfm'):
            if os.path.exists(self.out(suffix)):
                os.remove(self.out(suffix))
        places = {place: os.path.join(caches, place.lower()) for place in CACHE_PLACES}
        for place in places.values():
            os.makedirs(place, exist_ok=True)
        environment = {**self.environments.get(name, {}), **places, **dict.fromkeys(NOT_INHERITED)}
        run = Run(self.commands[name], self.options.threads, environment, self.options.limit)
        if not any(os.path.exists(self.out(suffix)) for suffix in ('.exr', '.pfm')):
            raise RuntimeError(f'{name} ended well but wrote no picture of {self.scene}')
        return run

    def run_cold_and_warm(self, name):
        with tempfile.TemporaryDirectory(dir=self.folder) as caches:
            return self.run(name, caches), self.run(name, caches)

    def run_warm(self, name):
        """With caches that are kept for the next time."""
        caches = os.path.join(self.folder, 'caches-' + name)
        if not os.path.exists(caches):
            self.run(name, caches)
        return self.run(name, caches)

    def leave_out(self, name, reason):
        self.unsupported[name] = str(reason)
        del self.commands[name]
        say(f'  {self.scene} {name}: {reason}')


class StartUp:
    """Cold and warm runs of one scene: by program one pair a repetition."""

    def __init__(self, case):
        self.case, self.runs = case, {}

    def repeat(self, repetition):
        for name in list(self.case.commands):
            try:
                if repetition == 0:
                    self.case.run_cold_and_warm(name)  # not counted: all files come into the system's page cache
                cold, warm = self.case.run_cold_and_warm(name)
            except TooLong as reason:
                self.case.leave_out(name, reason)
                self.runs.pop(name, None)
                continue
            self.runs.setdefault(name, []).append((cold, warm))
            say(f'  {self.case.scene} {name}: {cold.seconds:.2f} s, then {warm.seconds:.2f} s')

    def report(self):
        rows = []
        for name, pairs in self.runs.items():
            row = {'renderer': name, 'peak_bytes': spread([warm.peak_bytes for _, warm in pairs])}
            for label, runs in (('cold', [c for c, _ in pairs]), ('warm', [w for _, w in pairs])):
                row[f'{label}_seconds'] = spread([run.seconds for run in runs])
                row[f'{label}_cpu_seconds'] = spread([run.cpu_seconds for run in runs])
            rows.append(row)
        rows += [{'renderer': name, 'unsupported': reason} for name, reason in self.case.unsupported.items()]
        return {'scene': self.case.scene, 'rows': rows}


class Growth:
    """Peak memory of two scenes with few and with many of the same thing: by program one pair a repetition."""

    def __init__(self, thing, numbers, cases):
        self.thing, self.numbers, self.cases, self.peaks = thing, numbers, cases, {}

    def count(self, number, case):
        """Of what there really is in the scene."""
        if self.thing == 'triangles':
            return made_scenes.count_triangles(os.path.join(case.folder, 'made', f'bumpy-sphere-{number}.obj'))
        return number * number if self.thing == 'texels' else number

    def repeat(self, _):
        for name in [name for name in self.cases[0].commands if name in self.cases[1].commands]:
            try:
                peaks = [case.run_warm(name).peak_bytes for case in self.cases]
            except TooLong as reason:
                self.cases[0].leave_out(name, reason)
                self.peaks.pop(name, None)
                continue
            self.peaks.setdefault(name, []).append(peaks)
            say(f'  {self.thing} {name}: {peaks[0] >> 20} and {peaks[1] >> 20} MiB')

    def report(self):
        few, many = (self.count(number, case) for number, case in zip(self.numbers, self.cases))
        rows = [
            {
                'renderer': name,
                'few_peak_bytes': spread([pair[0] for pair in pairs]),
                'many_peak_bytes': spread([pair[1] for pair in pairs]),
                'bytes_each': spread([(pair[1] - pair[0]) / (many - few) for pair in pairs]),
            }
            for name, pairs in self.peaks.items()
        ]
        rows += [{'renderer': name, 'unsupported': reason} for name, reason in self.cases[0].unsupported.items()]
        return {'thing': self.thing, 'few': few, 'many': many, 'rows': rows}


def two_numbers(text):
    numbers = [int(word) for word in text.split(',')]
    if len(numbers) != 2 or not 0 < numbers[0] < numbers[1]:
        raise argparse.ArgumentTypeError(f"'{text}' is not two numbers like 1000,10000, the smaller one first")
    return numbers


def options_from_command_line():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scenes', nargs='*', metavar='SCENE', help='for start-up; files or made:NAME (made_scenes.py)')
    parser.add_argument('--etendue', required=True, metavar='[NAME=]PATH')
    parser.add_argument('--with', dest='wanted', metavar='NAMES', help='renderers, with commas (default: all; - for none)')
    parser.add_argument('--part', action='append', choices=PARTS, help='only this; may be repeated')
    parser.add_argument('--device', default='auto', help='of Etendue')
    parser.add_argument('--threads', type=int, default=2)
    parser.add_argument('--repetitions', type=int, default=3)
    parser.add_argument('--size', default='64x48')
    parser.add_argument('--limit', type=int, default=60, metavar='SECONDS', help='what takes longer is left out (default: 60)')
    parser.add_argument('--triangles', type=two_numbers, default=[100000, 1000000], metavar='FEW,MANY')
    parser.add_argument('--instances', type=two_numbers, default=[1000, 10000], metavar='FEW,MANY')
    parser.add_argument('--texels', type=two_numbers, default=[512, 4096], metavar='FEW,MANY', help='along a side')
    parser.add_argument('--json', metavar='FILE', help='write everything to this file')
    parser.add_argument('--page', metavar='FILE', help='write the tables between the marks of this page (docs/benchmarks.md)')
    options = parser.parse_args()
    if options.repetitions < 1 or options.threads < 1:
        parser.error('--repetitions and --threads must be at least 1')
    options.scenes = options.scenes or SCENES
    options.parts = options.part or PARTS
    options.rays = 1024  # the neutral export casts some; they are not used
    return options


def measurements(options, etendue, adapters, folder):
    """Of start-up and of memory."""
    made = {}

    def case(scene):
        if scene not in made:
            made[scene] = Case(scene, os.path.join(folder, str(len(made))), etendue, adapters, options)
        return made[scene]

    starts = [StartUp(case(scene)) for scene in options.scenes] if 'start' in options.parts else []
    things = {name: getattr(options, name) for name in ('triangles', 'instances', 'texels')}
    growths = [
        Growth(thing, numbers, [case(f'made:{thing}={number}') for number in numbers])
        for thing, numbers in (things.items() if 'memory' in options.parts else ())
    ]
    return starts, growths


def run(options, folder):
    load = os.getloadavg()[0]
    etendue, adapters = Etendue(options.etendue, options), find_adapters(options)
    starts, growths = measurements(options, etendue, adapters, folder)
    for repetition in range(options.repetitions):
        say(f'repetition {repetition + 1} of {options.repetitions}')
        for measurement in starts + growths:
            measurement.repeat(repetition)
    return {
        **circumstances(etendue, load),
        'threads': options.threads,
        'size': options.size,
        'repetitions': options.repetitions,
        'versions': versions([etendue], adapters, []),
        'changes': {s.case.scene: s.case.changes for s in starts if s.case.changes},
        'start': [s.report() for s in starts],
        'memory': [g.report() for g in growths],
    }


def main():
    options = options_from_command_line()
    with tempfile.TemporaryDirectory(prefix='etendue-overhead-') as folder:
        report = run(options, folder)
    print(overhead_table.terminal_text(report))
    if options.page:
        table.write_between_marks(options.page, overhead_table.markdown(report), overhead_table.BEGIN)
    if options.json:
        with open(options.json, 'w', encoding='utf-8') as file:
            json.dump(report, file, indent=2)
            file.write('\n')


if __name__ == '__main__':
    main()
