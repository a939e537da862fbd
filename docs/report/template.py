"""Fills docs/report/report.md.in with the numbers of docs/data, so that text and data cannot part.

    {{convergence.slope.naive:.3f}}     one number of docs/data/convergence.json, in Python's format language
    {{#ttests.rows}}| {scene} | {p:.3g} |  this line once for each row of a list

Besides Python's formats there are `:sci` (4.4 · 10⁻⁷), `:sep` (30 000), `:pct` (41.7 %; `pct0`, `pct2`), `:mega` (0.41 for
410 000), `:minutes` (12 for 720), `:z` (+0.42), `:yes`.
"""
import json
import re
import string

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NUMBER = re.compile(r"\{\{([a-z_0-9]+(?:\.[a-zA-Z_0-9]+)+)(?::([^{}]*))?\}\}")
INLINE = re.compile(r"\$[^$]*\$|`[^`]*`")
ROWS = re.compile(r"^\{\{#([a-z_0-9.]+)\}\}(.*)$")


def scientific(value):
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa} · 10{str(int(exponent)).translate(SUPERSCRIPTS)}"


FORMATS = {
    "sci": lambda v: "0" if v == 0 else scientific(v),
    "sep": lambda v: f"{v:,.0f}".replace(",", " "),
    "pct": lambda v: f"{100 * v:.1f} %",
    "pct2": lambda v: f"{100 * v:.2f} %",
    "pct0": lambda v: f"{100 * v:.0f} %",
    "minutes": lambda v: f"{v / 60:.0f}",
    "mega": lambda v: f"{v / 1e6:.2f}",
    "yes": lambda v: "yes" if v else "no",
    "z": lambda v: f"{v:+.2f}",
}  # yapf: disable


def show(value, spec):
    """One value as text; a value that a row does not have is a dash."""
    if value is None:
        return "–"
    if spec in FORMATS:
        return FORMATS[spec](value).replace("-", "−")
    return format(value, spec or "").replace("-", "−") if isinstance(value, (int, float)) else format(value, spec or "")


class RowFormatter(string.Formatter):
    """Formats a row; what it does not have is a dash."""

    def get_field(self, field_name, args, kwargs):
        try:
            return super().get_field(field_name, args, kwargs)
        except (KeyError, TypeError):
            return None, field_name

    def format_field(self, value, format_spec):
        return show(value, format_spec)


def look_up(data, path):
    value = data
    for key in path.split("."):
        try:
            value = value[int(key)] if isinstance(value, list) else value[key]
        except (KeyError, IndexError, TypeError, ValueError):
            raise KeyError(f"report.md.in asks for {path}, which docs/data does not have") from None
    return value


def load(folder):
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


def wrapped(text, longest=120):
    """Paragraphs and list items in lines of at most `longest` characters. Tables, pictures, code and display math stay as they are; formulas
    and code spans are not broken."""
    out, paragraph, verbatim = [], [], ""

    def flush():
        words = INLINE.sub(lambda m: m[0].replace(" ", "\0"), " ".join(paragraph)).split(" ")
        indent = "  " if words[0] == "-" else ""
        line = ""
        for word in words:
            if line and len(line) + 1 + len(word) > longest and not re.fullmatch(r"[-+*|#>].*|\d+\.", word):
                out.append(line.replace("\0", " "))
                line = indent + word
            else:
                line += (" " if line else "") + word
        if paragraph:
            out.append(line.replace("\0", " "))
        paragraph.clear()

    for line in text.split("\n"):
        fence = next((mark for mark in ("```", "$$") if line.startswith(mark)), "")
        if verbatim or fence or not line or line[0] in "|!#":
            flush()
            out.append(line)
            if fence and verbatim in ("", fence):
                verbatim = "" if verbatim else fence
        else:
            if line.startswith("- "):
                flush()
            paragraph.append(line.strip())
    flush()
    return "\n".join(out)


def fill(text, data):
    """The report. Raises KeyError for a number that does not exist."""
    lines = []
    for line in text.split("\n"):
        rows = ROWS.match(line)
        if rows:
            lines += [RowFormatter().format(rows[2], **row) for row in look_up(data, rows[1])]
        else:
            lines.append(NUMBER.sub(lambda m: show(look_up(data, m[1]), m[2]), line))
    return wrapped("\n".join(lines))
