"""What against.py found: a line for the terminal, and a page that needs no other file."""

import base64
import html
import struct
import zlib

import numpy

MOST_PIXELS = 240  # of a thumbnail's width
LUMINANCE = numpy.array([0.212671, 0.715160, 0.072169])

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em; color: #222; }
table { border-collapse: collapse; } td, th { padding: .5em .8em; text-align: left; vertical-align: top; }
tr { border-top: 1px solid #ddd; } img { display: block; image-rendering: pixelated; min-width: 10em; }
.equal { color: #1a7f37; } .different { color: #b42318; font-weight: 600; } .none { color: #777; }
small { color: #666; } code { overflow-wrap: anywhere; }
@media (prefers-color-scheme: dark) { body { background: #16181c; color: #ddd; } tr { border-color: #333; } }
"""


def class_of(verdict):
    if verdict == 'different':
        return 'different'
    return 'none' if verdict.startswith('not ') else 'equal'


def scores_text(row):
    return ' '.join(f'{z:+.1f}' for z in row['z_of_means'])


def block_families(row):
    """The tests of blocks, by name; the page shows the worst of each."""
    return [(name, family) for name, family in row['families'].items() if family['tests']]


def line(row):
    """For a terminal."""
    head = f"{row['scene']}, {row['peer']}: {row['verdict']}"
    if 'z_of_means' not in row:
        return f"{head}: {row['why']}"
    brighter = '' if row['brighter'] is None else f", brighter by {100.0 * row['brighter']:+.2f} %"
    return f'{head}; z of means {scores_text(row)}{brighter}' + (f" ({row['why']})" if row['why'] else '')


def srgb(linear):
    """8-bit codes."""
    linear = numpy.clip(linear, 0.0, 1.0)
    encoded = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return (encoded * 255.0 + 0.5).astype(numpy.uint8)


def png(pixels):
    """A PNG file of [height, width, 3] bytes."""

    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))

    height, width, _ = pixels.shape
    rows = b''.join(b'\0' + row.tobytes() for row in pixels)
    header = struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0)
    return (
        b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header) + chunk(b'IDAT', zlib.compress(rows, 9)) + chunk(b'IEND', b'')
    )


def smaller(picture):
    """Means of square blocks, so that a thumbnail is not wider than MOST_PIXELS."""
    step = -(-picture.shape[1] // MOST_PIXELS)
    height, width = (max(1, size // step) for size in picture.shape[:2])
    step_y, step_x = min(step, picture.shape[0]), min(step, picture.shape[1])
    cut = picture[: height * step_y, : width * step_x]
    return cut.reshape(height, step_y, width, step_x, 3).mean(axis=(1, 3))


def image(picture, exposure, text):
    data = base64.b64encode(png(srgb(smaller(picture) * exposure))).decode()
    return f'<img alt="{html.escape(text)}" title="{html.escape(text)}" src="data:image/png;base64,{data}">'


def exposure_of(picture):
    """Brings the mean luminance of what is not black to a third, as one factor for both pictures."""
    light = picture @ LUMINANCE
    lit = light[light > 1e-6 * max(light.max(), 1e-30)]
    return 1.0 / (3.0 * lit.mean()) if lit.size else 1.0


def numbers(row):
    brighter = '' if row['brighter'] is None else f"<br>brighter by {100.0 * row['brighter']:+.3f} %"
    families = ''.join(
        f"<br>{html.escape(name)}: worst z {family['worst']['z']:+.1f}, p of all {family['familyP']:.2g}"
        for name, family in block_families(row)
    )
    ours, theirs = row['samples']
    return f'z of means {scores_text(row)}{brighter}<small>{families}<br>{ours} and {theirs} samples per pixel</small>'


def row_html(row):
    name = f"<td><b>{html.escape(row['scene'])}</b><br>{html.escape(row.get('version', row['peer']))}"
    name += f"<br><small>{html.escape(row['source'])}</small></td>" if row.get('source') else '</td>'
    verdict = f"<td class='{class_of(row['verdict'])}'>{html.escape(row['verdict'])}"
    verdict += f"<br><small>{html.escape(row['why'])}</small></td>" if row['why'] else '</td>'
    if 'pictures' not in row:
        return f'<tr>{name}<td></td><td></td><td></td>{verdict}</tr>'
    exposure = exposure_of(row['pictures'][1])
    ours, theirs = (image(p, exposure, t) for p, t in zip(row['pictures'], ('Etendue', row['peer'])))
    return f'<tr>{name}<td>{ours}</td><td>{theirs}</td><td>{numbers(row)}</td>{verdict}</tr>'


def summary(rows):
    counts = {}
    for row in rows:
        counts[row['verdict']] = counts.get(row['verdict'], 0) + 1
    return ', '.join(f'{count} {verdict}' for verdict, count in sorted(counts.items()))


def page(facts):
    rows = '\n'.join(row_html(row) for row in facts['rows'])
    return f"""<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Etendue against other renderers</title><style>{STYLE}</style>
<h1>Etendue against other renderers</h1>
<p>{html.escape(summary(facts['rows']))}. {html.escape(facts['date'])}, {html.escape(facts['etendue'])}:
<code>{html.escape(facts['command'])}</code></p>
<p>The z of means is how many standard errors the means of the whole pictures are apart in red, green and blue: beyond 3
chance explains one in 370. The verdict is that of <code>etendue compare</code>, which tests pixels, blocks and the
whole.</p>
<table><tr><th>scene<th>Etendue<th>the other<th>difference<th>verdict</tr>
{rows}
</table></html>
"""
