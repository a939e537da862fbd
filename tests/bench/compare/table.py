"""What compare.py found, as text for a terminal and as the tables of docs/benchmarks.md; and the machine it ran on."""

import os
import platform
import re
import textwrap

BEGIN, END = '<!-- compare.py writes from here', '<!-- to here -->'
# What a renderer may use at most, widest first: flag in /proc/cpuinfo and name.
INSTRUCTION_SETS = (
    ('avx512f', 'AVX-512'),
    ('avx2', 'AVX2'),
    ('avx', 'AVX'),
    ('sse4_2', 'SSE4.2'),
    ('sve', 'SVE'),
    ('asimd', 'NEON'),
)


def machine(cpuinfo=None):
    """Name of the processor, the widest instruction set it has, and the number of processors this process may use."""
    if cpuinfo is None:
        try:
            with open('/proc/cpuinfo', encoding='utf-8', errors='replace') as file:
                cpuinfo = file.read()
        except OSError:
            cpuinfo = ''
    name = re.search(r'^model name\s*: *(.+)$', cpuinfo, re.MULTILINE)
    flags = re.search(r'^(?:flags|Features)\s*: *(.+)$', cpuinfo, re.MULTILINE)
    flags = flags.group(1).split() if flags else []
    return {
        'processor': name.group(1).strip() if name else platform.machine() or 'unknown',
        'instruction_set': next((text for flag, text in INSTRUCTION_SETS if flag in flags), 'unknown'),
        'processors': len(os.sched_getaffinity(0)),
    }


def spread_text(spread, unit=1.0):
    """'1.23 (1.10–1.31)': the median and the extremes; says so where it was too short to measure."""
    if spread is None:
        return 'too short'
    return f"{spread['median'] / unit:.2f} ({spread['min'] / unit:.2f}–{spread['max'] / unit:.2f})"


def brighter_text(result):
    """How much brighter in R, G and B, with the widest of the three 95 % intervals, in percent."""
    return ' '.join(f'{100.0 * b:+.2f}' for b in result['brighter']) + f" ±{100.0 * max(result['brighter_95']):.2f} %"


def blocks_text(result):
    if not result['blocks']:
        return 'no noise to judge by'
    return f"{result['z_deviation']:.2f}, {result['z_largest']:.1f} ({result['z_largest_expected']:.1f})"


RAY_HEADS = (
    'scene',
    'rays',
    'order',
    'program',
    'Mrays/s',
    'per CPU second',
    "Etendue's rate relative to it",
    'per CPU second',
    'hits that differ',
)
SAMPLE_HEADS = (
    'scene',
    'renderer',
    'Msamples/s',
    'per CPU second',
    "Etendue's rate relative to it",
    'per CPU second',
    'brighter in R, G, B',
    'z of blocks: deviation, largest (1 in 100)',
)


def scene_name(path):
    return os.path.splitext(os.path.basename(path))[0]


def change_lines(report):
    """What was replaced in scenes for all programs."""
    for scene, words in report['changes'].items():
        yield f"{scene_name(scene)}: {' and '.join(words)}, in all programs"


def ray_rows(report):
    for part in report['rays']:
        for row in part['rows']:
            ratios = (
                [
                    spread_text(row['ratio']),
                    spread_text(row['cpu_ratio']),
                    f"{100.0 * row['share_of_differing_hits']:.3f} %",
                ]
                if 'ratio' in row
                else ['', '', '']
            )
            yield [
                scene_name(part['scene']),
                row['class'],
                row['order'],
                row['program'],
                spread_text(row['rays_per_second'], 1e6),
                spread_text(row['rays_per_cpu_second'], 1e6),
                *ratios,
            ]


def sample_rows(report):
    for part in report['samples']:
        for row in part['rows']:
            if 'unsupported' in row:
                yield [scene_name(part['scene']), row['renderer'], row['unsupported'], '', '', '', '', '']
                continue
            others = (
                [
                    spread_text(row['ratio']),
                    spread_text(row['cpu_ratio']),
                    brighter_text(row['agreement']),
                    blocks_text(row['agreement']),
                ]
                if 'ratio' in row
                else ['', '', '', '']
            )
            yield [
                scene_name(part['scene']),
                row['renderer'],
                spread_text(row['samples_per_second'], 1e6),
                spread_text(row['samples_per_cpu_second'], 1e6),
                *others,
            ]


def columns_text(heads, rows):
    """Aligned columns, two blanks apart."""
    rows = [list(heads), *rows]
    widths = [max(len(row[i]) for row in rows) for i in range(len(heads))]
    return '\n'.join('  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)


def terminal_text(report):
    parts = []
    if report['rays']:
        parts.append(columns_text(RAY_HEADS, list(ray_rows(report))))
    if report['samples']:
        parts.append(columns_text(SAMPLE_HEADS, list(sample_rows(report))))
    if report['changes']:
        parts.append('\n'.join(change_lines(report)))
    return '\n\n'.join(parts)


def markdown_table(heads, rows):
    return '\n'.join(
        [
            '| ' + ' | '.join(heads) + ' |',
            '|' + '---|' * len(heads),
            *('| ' + ' | '.join(cell.replace('|', '\\|') for cell in row) + ' |' for row in rows),
        ]
    )


def circumstances(report, how):
    """The command, the machine and the versions, as lines; `how` says what was measured."""
    at = report['machine']
    facts = [
        f"{report['date']}; {how}, {report['threads']} threads on {at['processors']} processors: "
        f"{at['processor']}, widest instruction set {at['instruction_set']}.",
        f"Etendue's device: {report['device']}; driver: {report['driver']}; commit {report['sources']}. "
        f"Load average at the start {report['load']:.1f}: {load_remark(report)}",
    ]
    lines = ['```sh', report['command'], '```', '']
    for fact in facts:
        lines += [textwrap.fill(fact, 120, break_long_words=False, break_on_hyphens=False), '']
    return lines + [f'- {name}: {version}' for name, version in report['versions'].items()]


def markdown(report):
    """The command, the machine, the versions and both tables."""
    how = f"{report['repetitions']} repetitions in turns, {report['size']}, {report['spp']} samples per pixel"
    lines = circumstances(report, how) + [f'- {change}' for change in change_lines(report)]
    for heads, rows in ((SAMPLE_HEADS, list(sample_rows(report))), (RAY_HEADS, list(ray_rows(report)))):
        if rows:
            lines += ['', markdown_table(heads, rows)]
    return '\n'.join(lines)


def load_remark(report):
    if report['load'] > 0.5:
        return 'others used the machine as well; only ratios are meaningful, preferably those per CPU second.'
    return 'the machine was otherwise idle.'


def write_between_marks(path, text, mark=BEGIN):
    """Replaces what stands between the two marks of a page. Raises ValueError where they are missing."""
    with open(path, encoding='utf-8') as file:
        page = file.read()
    begin = page.find(mark)
    end = page.find(END, max(begin, 0))
    if begin < 0 or end < 0:
        raise ValueError(f'{path} has no lines "{mark} …" and "{END}" between which the table could stand')
    start = page.index('\n', begin) + 1
    with open(path, 'w', encoding='utf-8') as file:
        file.write(f'{page[:start]}\n{text}\n\n{page[end:]}')
