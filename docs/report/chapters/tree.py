"""What a ray costs as the mesh grows: records visited, time, and the time to build the tree."""
import numpy as np

import plots

CLASSES = {"primary": (plots.ORANGE, "from the camera"), "diffuse": (plots.BLUE, "after a diffuse bounce"), "shadow": (plots.VIOLET, "to the lamp")}


def sculpted(studio, triangles):
    """The Cornell box with a bumpy sphere of about so many triangles; the mesh; how many they are."""
    mesh = studio.scratch / f"bumpy-{triangles}.obj"
    studio.run(studio.sculptor, "--kind", "bumpy-sphere", "--triangles", triangles, "-o", mesh)
    with open(mesh, encoding="ascii") as file:
        faces = sum(line.startswith("f ") for line in file)

    def change(root):
        for entry in root.iter("string"):
            if entry.get("value").endswith("bumpy-sphere.obj"):
                entry.set("value", str(mesh))

    return studio.variant("cbox-bumpy", f"bumpy-{triangles}", change), mesh, faces


def measure(studio, triangles, on_processor):
    """One row: `etendue bench` casts rays of three classes, in the order of the picture, and checks them against the reference."""
    scene, mesh, faces = sculpted(studio, triangles)
    repetitions = studio.pick(3 if triangles < 1_000_000 else 1, 1)
    report = studio.json("bench", scene, "--part", "start", "--part", "rays", "--json", "--repetitions", repetitions,
                         "--rays", studio.pick(1 << 17, 1 << 12), "--size", "320x240", *studio.device_options())["scenes"][0]
    mesh.unlink()
    row = {"triangles": faces, "build_s": report["seconds"]["compile"]["min"]}
    for rays in report["rays"]:
        if rays["order"] == "picture":
            row[f"{rays['class']}_steps"] = rays["steps_per_ray"]
            # A driver on the processor is measured by processor time, which others on the machine do not disturb.
            rate = rays.get("rays_per_cpu_second") if on_processor else None
            row[f"{rays['class']}_ns"] = 1e9 / (rate or rays["rays_per_second"])["median"]
    return row


def plot(studio, name, rows, quantity, label):
    figure, axis = plots.axes(7.2, 3.6)
    n = np.array([row["triangles"] for row in rows])
    for kind, (colour, where) in CLASSES.items():
        axis.semilogx(n, [row[quantity.format(kind)] for row in rows], "o-", color=colour, label=where)
    axis.set_ylabel(label)
    axis.set_xlabel("triangles of the sphere")
    axis.set_ylim(bottom=0)
    axis.legend(loc="upper left")
    studio.keep_plot(name, figure)


def heat_map(studio):
    """Where in a picture the tree is dear: nodes and primitives a sample, all rays of its path together."""
    picture = studio.scratch / "heat-map.png"
    studio.render("cbox-bumpy", "heat", spp=studio.pick(64, 1), size=studio.pick((400, 300), (40, 30)), more=("--heat-map", picture))
    studio.keep_picture("heat-map", picture)


def run(studio):
    heat_map(studio)
    counts = studio.pick([120, 1000, 10_000, 100_000, 1_000_000, 10_000_000], [120, 1000])  # the smallest that the sculptor does well
    on_processor = studio.driver_on_processor()
    rows = [measure(studio, count, on_processor) for count in counts]
    plot(studio, "tree", rows, "{}_steps", "records of the tree that a ray visits")
    plot(studio, "tree-time", rows, "{}_ns", "time of a ray (ns of one core)" if on_processor else "time of a ray (ns)")
    first, last = rows[0], rows[-1]
    steps = [{"triangles": row["triangles"], **{kind: row[f"{kind}_steps"] for kind in CLASSES}} for row in rows]
    studio.keep_table("tree", steps)
    studio.keep_table("time_tree", rows)
    studio.keep_data("tree", {"rows": steps, "growth": last["triangles"] / first["triangles"], "largest": last["triangles"],
                              "steps_growth": {kind: last[f"{kind}_steps"] / first[f"{kind}_steps"] for kind in CLASSES}})
    studio.keep_data("time_tree", {
        "rows": rows, "largest_build": last["build_s"], "build_rate": last["triangles"] / last["build_s"] / 1e6,
        "time_growth": {kind: last[f"{kind}_ns"] / first[f"{kind}_ns"] for kind in CLASSES},
    })  # yapf: disable
