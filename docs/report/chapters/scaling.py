"""How the cost of a sample grows with the scene, by `etendue bench`: triangles, lamps, instances, materials, pixels and threads. Only when
asked for (--only scaling): the largest mesh is a file of 835 MB. Writes a figure, and the table in docs/benchmarks.md."""
import os

from grown_scenes import of_instances, of_lamps, of_materials, of_triangles
from studio import ROOT, progress

START, END = "<!-- the chapter `scaling` writes from here; do not edit -->", "<!-- to here -->"


def microseconds(bench):
    """Of processor time per sample where the driver computes on the processor, else of time."""
    spread = bench.get("samples_per_cpu_second") or bench["samples_per_second"]
    return {"cost": 1e6 / spread["median"], "least": 1e6 / spread["max"], "most": 1e6 / spread["min"]}


def measure(studio, label, scenes, options=(), environment=None):
    """One row for each scene (by its number of things); the scenes take turns."""
    limits = studio.pick(["--time", "0.7s", "--repetitions", 3], ["--quick"])
    report = studio.json("bench", *scenes.values(), "--part", "samples", "--json", *limits, *options, *studio.device_options(),
                         environment=environment)
    progress(f"{label} measured")
    return [{"x": x, **microseconds(bench)} for x, bench in zip(scenes, report["scenes"])]


def powers(first, last):
    return [10**k for k in range(first, last + 1)]


def curves(studio):
    """Name, the label of its axis, rows."""
    small = studio.pick(["--size", "400x300"], ["--size", "32x24"])
    ways = [
        ("triangles", of_triangles, studio.pick(powers(3, 7), powers(3, 4))),
        ("lamps", of_lamps, studio.pick(powers(0, 5), powers(0, 1))),
        ("instances", of_instances, studio.pick(powers(0, 5), powers(0, 1))),
        ("materials", of_materials, studio.pick([1, 2, 4, 8, 16, 32, 100], [1, 8])),
    ]
    result = [(name, measure(studio, name, {n: make(studio, n) for n in counts}, small)) for name, make, counts in ways]
    bumpy = studio.scene("cbox-bumpy")
    sizes = studio.pick([(320, 240), (640, 480), (1280, 720), (1920, 1080), (3840, 2160)], [(32, 24), (64, 48)])
    rows = [row | {"x": w * h} for w, h in sizes for row in measure(studio, f"{w}x{h}", {0: bumpy}, ["--size", f"{w}x{h}"])]
    result.append(("pixels", rows))
    threads = range(1, len(os.sched_getaffinity(0)) + 1)
    rows = [row | {"x": n} for n in threads for row in measure(studio, f"{n} threads", {0: bumpy}, small, {"LP_NUM_THREADS": str(n)})]
    return [*result, ("threads", rows)]


def plot(studio, result):
    import plots  # pylint: disable=import-outside-toplevel
    figure, panels = plots.axes(7.2, 5.4, nrows=2, ncols=3)
    for panel, (name, rows) in zip(panels.flat, result):
        xs, ys = [row["x"] for row in rows], [row["cost"] for row in rows]
        spread = [[row["cost"] - row["least"] for row in rows], [row["most"] - row["cost"] for row in rows]]
        panel.errorbar(xs, ys, yerr=spread, marker="o", color=plots.BLUE)
        panel.set_xlabel(name)
        panel.set_ylim(0, 1.15 * max(row["most"] for row in rows))
        if name == "threads":
            panel.set_xticks(xs)
        else:
            panel.set_xscale("log")
    for panel in panels[:, 0]:
        panel.set_ylabel("µs per sample")
    studio.keep_plot("scaling", figure)


def table(result, machine):
    lines = ["", f"{machine['cpu']}, {machine['cores']} processors; {machine['driver']}.", "", "| | µs of processor time per sample, median (least–most) |", "|---|---|"]
    for name, rows in result:
        cells = "; ".join(f"{row['x']:,}: {row['cost']:.2f} ({row['least']:.2f}–{row['most']:.2f})".replace(",", " ") for row in rows)
        lines.append(f"| {name} | {cells} |")
    return "\n".join(lines) + "\n\n"


def run(studio):
    from figures import describe_machine  # pylint: disable=import-outside-toplevel
    result = curves(studio)
    studio.keep_data("time_scaling", {"curves": [{"name": name, "rows": rows} for name, rows in result]})
    plot(studio, result)
    if studio.quick:
        return
    page = ROOT / "docs" / "benchmarks.md"
    text = page.read_text(encoding="utf-8")
    begin = text.index(START) + len(START) + 1
    page.write_text(text[:begin] + table(result, describe_machine(studio)) + text[text.index(END, begin):], encoding="utf-8")
