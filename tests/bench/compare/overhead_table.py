"""What overhead.py found, as text for a terminal and as the tables of docs/benchmarks.md."""

from table import change_lines, circumstances, columns_text, markdown_table, scene_name, spread_text

BEGIN = '<!-- overhead.py writes from here'
START_HEADS = ('scene', 'renderer', 'cold, s', 'CPU s', 'warm, s', 'CPU s', 'peak, MiB')
MEMORY_HEADS = ('what grows', 'renderer', 'peak with few, MiB', 'with many, MiB', 'bytes for each')
MIB = 1 << 20


def whole_text(spread, unit):
    """'123 (120–131)'"""
    return f"{spread['median'] / unit:.0f} ({spread['min'] / unit:.0f}–{spread['max'] / unit:.0f})"


def thousands(number):
    return f'{number:,}'.replace(',', ' ')


def start_rows(report):
    for part in report['start']:
        for row in part['rows']:
            cells = [scene_name(part['scene']), row['renderer']]
            if 'unsupported' in row:
                yield [*cells, row['unsupported'], '', '', '', '']
                continue
            times = ('cold_seconds', 'cold_cpu_seconds', 'warm_seconds', 'warm_cpu_seconds')
            yield [*cells, *(spread_text(row[time]) for time in times), whole_text(row['peak_bytes'], MIB)]


def memory_rows(report):
    for part in report['memory']:
        for row in part['rows']:
            cells = [f"{part['thing']}: {thousands(part['few'])} → {thousands(part['many'])}", row['renderer']]
            if 'unsupported' in row:
                yield [*cells, row['unsupported'], '', '']
                continue
            peaks = [whole_text(row[key], MIB) for key in ('few_peak_bytes', 'many_peak_bytes')]
            yield [*cells, *peaks, spread_text(row['bytes_each'])]


def tables(report):
    """Heads and rows of those that have any."""
    both = ((START_HEADS, list(start_rows(report))), (MEMORY_HEADS, list(memory_rows(report))))
    return [(heads, rows) for heads, rows in both if rows]


def terminal_text(report):
    parts = [columns_text(heads, rows) for heads, rows in tables(report)]
    return '\n\n'.join([*parts, *change_lines(report)])


def markdown(report):
    how = f"{report['repetitions']} repetitions in turns, {report['size']}, one sample per pixel"
    lines = circumstances(report, how) + [f'- {change}' for change in change_lines(report)]
    for heads, rows in tables(report):
        lines += ['', markdown_table(heads, rows)]
    return '\n'.join(lines)
