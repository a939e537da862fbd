"""How the cost of a sample grows with the scene, by `etendue bench`: triangles, lamps, instances, materials, pixels and threads. Only when
asked for (--only scaling): the largest mesh is a file of 835 MB. Writes a figure, and the table in docs/benchmarks.md."""
import math
import os

from studio import ROOT, progress

START, END = "<!-- the chapter `scaling` writes from here; do not edit -->", "<!-- to here -->"
WHITE = '<color name="albedo" value="0.6, 0.6, 0.6"/>'
# With k materials the first k kinds in turn, each time with another colour.
KINDS = [
    ("diffuse", '<color name="albedo" value="{rgb}"/>'),
    ("roughconductor", '<string name="material" value="Au"/><float name="alpha" value="{number}"/>'),
    ("plastic", '<color name="diffuse_reflectance" value="{rgb}"/>'),
    ("dielectric", '<float name="intIOR" value="{index}"/>'),
    ("roughplastic", '<color name="diffuse_reflectance" value="{rgb}"/><float name="alpha" value="{number}"/>'),
    ("roughdielectric", '<float name="intIOR" value="{index}"/><float name="alpha" value="{number}"/>'),
    ("principled", '<color name="base_color" value="{rgb}"/><float name="roughness" value="{number}"/>'),
    ("conductor", '<string name="material" value="Cu"/>'),
]


def scene_file(studio, name, shapes, camera, sky=True):
    """A scene of its own in the scratch folder; `camera` is origin and target."""
    path = studio.scratch / f"{name}.xml"
    light = '<emitter type="constant"><color name="radiance" value="0.8, 0.9, 1"/></emitter>' if sky else ""
    path.write_text(
        f"""<scene>
<integrator type="path"><integer name="maxDepth" value="6"/></integrator>
<sampler type="independent"><integer name="sampleCount" value="16"/></sampler>
<camera type="perspective">
  <integer name="width" value="400"/><integer name="height" value="300"/><float name="fov" value="40"/>
  <transform name="toWorld"><lookat origin="{camera[0]}" target="{camera[1]}" up="0, 1, 0"/></transform>
  <rfilter type="box"/>
</camera>
{light}
{shapes}
</scene>
""", encoding="utf-8")  # yapf: disable
    return path


def mesh(studio, kind, triangles):
    path = studio.scratch / f"{kind}-{triangles}.obj"
    if not path.exists():
        progress(f"{kind} of {triangles} triangles")
        studio.run(studio.sculptor, "--kind", kind, "--triangles", triangles, "-o", path)
    return path


def of_triangles(studio, count):
    """The bumpy sphere of cbox-bumpy with another number of triangles."""
    file = mesh(studio, "bumpy-sphere", count)

    def change(root):
        next(e for e in root.iter("string") if e.get("value") == "etendue:bumpy-sphere.obj").set("value", str(file))

    return studio.variant(ROOT / "scenes" / "cbox-bumpy.xml", f"triangles-{count}", change)


def of_lamps(studio, count):
    """Small lamps over a floor with a ball, together always as bright."""
    radiance = 3000.0 / count
    shapes = f"""<mesh type="obj"><string name="filename" value="{ROOT}/scenes/meshes/floor.obj"/><bsdf type="diffuse">{WHITE}</bsdf></mesh>
<mesh type="sphere"><point name="center" value="0.1, 0.2, -0.3"/><float name="radius" value="0.2"/><bsdf type="diffuse">{WHITE}</bsdf></mesh>
<mesh type="obj"><string name="filename" value="{mesh(studio, 'lamps', count)}"/>
  <emitter type="area"><color name="radiance" value="{radiance}, {radiance}, {radiance}"/></emitter></mesh>"""
    return scene_file(studio, f"lamps-{count}", shapes, ("0.15, 0.75, 2.1", "0, 0.02, 0.15"), sky=False)


def of_instances(studio, count):
    """Copies of a ball of 10 000 triangles on a square of fixed size, without changing how much of the picture they cover."""
    side = math.ceil(math.sqrt(count))
    scale = 0.8 / side
    file = mesh(studio, "bumpy-sphere", 10000)
    lines = ['<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="6"/></integrator>',
             '<sensor type="perspective"><float name="fov" value="40"/><transform name="to_world">'
             '<lookat origin="0, 1, 1.2" target="0, 0, 0" up="0, 1, 0"/></transform><sampler type="independent"/>'
             '<film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/><rfilter type="box"/></film></sensor>',
             '<emitter type="constant"/><shape type="shapegroup" id="ball">'
             f'<shape type="obj"><string name="filename" value="{file}"/><bsdf type="diffuse"/></shape></shape>']  # yapf: disable
    for i in range(count):
        x, z = (i % side + 0.5) / side - 0.5, (i // side + 0.5) / side - 0.5
        lines.append(f'<shape type="instance"><ref id="ball"/><transform name="to_world"><rotate y="1" angle="{i * 137.5 % 360:.1f}"/>'
                     f'<scale value="{scale:.7g}"/><translate x="{x:.7g}" z="{z:.7g}"/></transform></shape>')
    path = studio.scratch / f"instances-{count}.xml"
    path.write_text("\n".join([*lines, "</scene>"]), encoding="utf-8")
    return path


def of_materials(studio, count):
    """A hundred balls that share so many materials."""
    shapes = [f'<mesh type="obj"><string name="filename" value="{ROOT}/scenes/meshes/floor.obj"/><bsdf type="diffuse">{WHITE}</bsdf></mesh>']
    for i in range(100):
        material = i % count
        kind, parameters = KINDS[material % len(KINDS)]
        share = (material + 1) / count
        parameters = parameters.format(rgb=f"{0.2 + 0.6 * share:.3f}, 0.5, {0.8 - 0.6 * share:.3f}", number=f"{0.1 + 0.4 * share:.3f}", index=f"{1.3 + 0.4 * share:.3f}")
        shapes.append(f'<mesh type="sphere"><point name="center" value="{i % 10 * 0.18 - 0.81:.3f}, 0.08, {i // 10 * 0.18 - 0.81:.3f}"/>'
                      f'<float name="radius" value="0.08"/><bsdf type="{kind}">{parameters}</bsdf></mesh>')
    return scene_file(studio, f"materials-{count}", "\n".join(shapes), ("0, 1.2, 1.9", "0, 0, 0.1"))


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
