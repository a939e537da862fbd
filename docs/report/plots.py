"""One style for all plots: SVG with real text, readable on light and on dark pages."""
import re

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  pylint: disable=wrong-import-position

INK, PAPER, GRID = "#1f2328", "#ffffff", "#d1d9e0"  # light; exchanged for the colours below where the page is dark
DARK = {INK: "#e6edf3", PAPER: "#0d1117", GRID: "#3d444d"}
# Strong enough on both papers, and apart from each other for the colour-blind, too.
BLUE, ORANGE, GREEN, VIOLET, GREY = "#2f81f7", "#d4720b", "#2da44e", "#a475f9", "#7d8590"

pyplot.rcParams.update({
    "svg.fonttype": "none", "svg.hashsalt": "etendue",
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans"], "font.size": 10.5,
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": INK, "xtick.color": INK, "ytick.color": INK,
    "figure.facecolor": PAPER, "axes.facecolor": PAPER, "savefig.facecolor": PAPER,
    "axes.grid": True, "grid.color": GRID, "grid.linewidth": 0.7, "axes.axisbelow": True,
    "axes.spines.top": False, "axes.spines.right": False, "lines.linewidth": 1.8, "lines.markersize": 5.5,
    "legend.frameon": False, "legend.fontsize": 9.5,
})  # yapf: disable


def axes(width=7.2, height=4.0, **options):
    """A figure with one or more axes; inches."""
    return pyplot.subplots(figsize=(width, height), layout="constrained", **options)


def save(figure, path):
    """Writes the SVG and adds what turns it dark: a page's colour scheme is known to the pictures in it."""
    figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
    pyplot.close(figure)
    svg = path.read_text(encoding="utf-8")
    rules = "".join(f'[style*="{prop}: {light}"]{{{prop}:{dark}!important}}'
                    for light, dark in DARK.items() for prop in ("fill", "stroke"))
    style = f"<style>@media (prefers-color-scheme: dark){{{rules}}}</style>"
    # The fonts that browsers have; matplotlib measured the text with DejaVu Sans, which is as wide as they come.
    svg = svg.replace("'DejaVu Sans', sans-serif", "'DejaVu Sans', Verdana, sans-serif")
    svg = re.sub(r"(<svg [^>]*>)", lambda m: m[1] + style, svg, count=1, flags=re.S)
    path.write_text("\n".join(line.rstrip() for line in svg.splitlines()) + "\n", encoding="utf-8")
