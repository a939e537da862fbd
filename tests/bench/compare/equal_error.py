#!/usr/bin/env python3
"""Time to equal error: how long Etendue and Mitsuba 3 take, each with several samplers, until a picture is as good as wanted.

    PATH=~/peers/bin:$PATH equal_error.py --etendue build/release/src/etendue scenes/cbox-sphere.xml scenes/cbox-bumpy.xml

Every way renders --pictures pictures of --spp samples, in turns, each with another seed; their errors are those against a
picture of --reference samples by Etendue with independent samples, which both programs agree with. relMSE is the mean over
pixels and channels of (x − r)² / (r² + 0.01 m²), where m is the mean of the reference. It falls with the number of samples,
and the time to 1 % is taken to be t · relMSE / 0.01: right for independent samples, and for points that are distributed
evenly as long as noise dominates. Times are seconds of rendering, without reading the scene and compiling kernels; the median
counts. Needs numpy. docs/benchmarks.md has the results.
"""

import argparse
import os
import statistics
import tempfile
import xml.etree.ElementTree

import numpy

import agreement
from compare import Etendue, say
from process import Run
from renderers import Mitsuba
from shared_scene import box_filtered

MITSUBA_SAMPLERS = ['independent', 'stratified', 'multijitter', 'ldsampler']


def relative_error(picture, reference):
    floor = 0.01 * reference.mean() ** 2
    return float(numpy.mean((picture - reference) ** 2 / (reference**2 + floor)))


def with_sampler(scene, kind, out):
    tree = xml.etree.ElementTree.parse(scene)
    for sampler in tree.iter('sampler'):
        sampler.set('type', kind)
    tree.write(out, encoding='utf-8', xml_declaration=True)
    return out


class Ways:
    """What renders one scene: by name a function (spp, seed) → (picture, seconds)."""

    def __init__(self, scene, folder, options):
        self.folder, self.options = folder, options
        self.etendue = Etendue(options.etendue, options)
        self.same = box_filtered(self.etendue, scene, os.path.join(folder, 'box'))
        self.by_name = {f'etendue, {kind}': self.of_etendue(kind) for kind in ('independent', 'sobol')}
        mitsuba = Mitsuba(options.variant)
        if not mitsuba.find():
            say('Mitsuba is not on PATH and left out.')
            return
        mitsuba.prepare(self.etendue.source(self.same, folder), folder)
        for kind in MITSUBA_SAMPLERS:
            with_sampler(os.path.join(folder, 'mitsuba.xml'), kind, os.path.join(folder, f'{kind}.xml'))
            self.by_name[f'{mitsuba.name}, {kind}'] = self.of_mitsuba(mitsuba, kind)

    def of_etendue(self, kind):
        def render(spp, seed):
            out = os.path.join(self.folder, 'etendue.exr')
            if os.path.exists(out):
                os.remove(out)
            seconds, _ = self.etendue.render(self.same, spp, out, seed, '-D', f'sampler.type={kind}')
            return agreement.read_picture(out), seconds

        return render

    def of_mitsuba(self, mitsuba, kind):
        def render(spp, seed):
            out = os.path.join(self.folder, 'mitsuba.pfm')
            command = mitsuba.command(self.folder, out, spp, self.options.threads, seed)
            command[-1] = os.path.join(self.folder, f'{kind}.xml')
            run = Run(command, self.options.threads, mitsuba.environment())
            return agreement.read_picture(out), mitsuba.render_seconds(run.output)

        return render


def compare(scene, options, folder):
    ways = Ways(scene, folder, options)
    reference, _ = ways.by_name['etendue, independent'](options.reference, 4096)
    errors, times = ({name: [] for name in ways.by_name} for _ in range(2))
    for name, render in ways.by_name.items():
        render(options.spp, 1)  # compiles kernels
    for picture in range(options.pictures):
        for name, render in ways.by_name.items():
            values, seconds = render(options.spp, 2 + picture)
            errors[name].append(relative_error(values, reference))
            times[name].append(seconds)
    for name in ways.by_name:
        error, seconds = statistics.mean(errors[name]), statistics.median(times[name])
        print(f'| {os.path.basename(scene)} | {name} | {error:.4f} | {seconds:.2f} | {seconds * error / 0.01:.2f} |', flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scenes', nargs='+', metavar='SCENE')
    parser.add_argument('--etendue', required=True)
    parser.add_argument('--device', default='auto')
    parser.add_argument('--variant', default='llvm_ad_rgb', help='of Mitsuba')
    parser.add_argument('--threads', type=int, default=2)
    parser.add_argument('--size', default='320x240')
    parser.add_argument('--spp', type=int, default=64, help='a square, for samplers that want one')
    parser.add_argument('--pictures', type=int, default=5)
    parser.add_argument('--reference', type=int, default=8192, metavar='SPP')
    options = parser.parse_args()
    print('| scene | renderer, sampler | relMSE | seconds | seconds to 1 % |\n|---|---|---|---|---|')
    for scene in options.scenes:
        with tempfile.TemporaryDirectory(prefix='etendue-equal-error-') as folder:
            compare(scene, options, folder)


if __name__ == '__main__':
    main()
