"""Light sampling against chance at equal samples and at equal time; many emitters; multiple importance sampling against both."""
from pathlib import Path

import numpy as np

import exr
from studio import LUMINANCE, luminance

NAIVE, NEE, MIS = ["integrator.nee=false"], ["integrator.nee=true", "integrator.mis=false"], ["integrator.mis=true"]


def next_event(studio):
    """Pictures at equal samples and at equal time, and what one sample's variance and one second are worth."""
    scene, size, spp = "cbox-bumpy", studio.pick((240, 180), (32, 24)), studio.pick(16, 4)
    strategies = {"naive": NAIVE, "nee": NEE}
    costs = studio.costs(scene, studio.pick(17, 3), size, strategies, studio.pick(3, 1))
    speed = costs["nee"] / costs["naive"]  # naive samples in the time of one with light sampling
    equal_time = max(spp, round(spp * speed))
    for name, count, define in (("naive", spp, NAIVE), ("nee", spp, NEE), ("naive-time", equal_time, NAIVE)):
        studio.keep_picture(f"nee-{name}", studio.render(scene, f"nee-{name}", spp=count, size=size, seed=9, define=define).png())
    deep = studio.pick(64, 16)
    deep_render = {name: studio.render(scene, f"nee-deep-{name}", spp=deep, size=size, seed=5, define=define)
                   for name, define in strategies.items()}  # yapf: disable
    variance = {name: render.variance() for name, render in deep_render.items()}
    pixels = {name: np.mean(render.rgb()[1]**2, axis=2) for name, render in deep_render.items()}
    lit = (pixels["naive"] > 0) & (pixels["nee"] > 0)
    ratio, median_ratio = variance["naive"] / variance["nee"], float(np.median(pixels["naive"][lit] / pixels["nee"][lit]))
    studio.keep_data("nee", {"spp": spp, "deep_spp": deep, "variance": variance, "ratio": ratio,
                             "median_ratio": median_ratio})
    studio.keep_data("time_nee", {"equal_time_spp": equal_time, "speed": speed, "efficiency": ratio / speed,
                                  "median_efficiency": median_ratio / speed})


def only_lamp(keep):
    """A change of the scene that turns all lamps off but number `keep`, and the sky unless `keep` is None."""

    def change(root):
        lamps = [mesh.find("emitter") for mesh in root.iter("mesh") if mesh.find("emitter") is not None]
        for i, lamp in enumerate(lamps):
            if i != keep:
                lamp.find("color").set("value", "0, 0, 0")
        if keep is not None:
            for colour in root.findall("color"):
                colour.set("value", "0, 0, 0")

    return change


def many_emitters(studio):
    """The bubble's lamps and its sky: how often each is chosen, what it gives to the picture, and whether the parts add up to the whole."""
    size, spp = studio.pick((240, 135), (48, 27)), studio.pick(96, 8)
    counted = studio.json("explain", studio.scene("bubble"), "--lights", studio.pick(200000, 2000), "--json", "--size",
                          f"{size[0]}x{size[1]}")  # yapf: disable
    whole, whole_error = studio.render("bubble", "bubble-whole", spp=spp, size=size, seed=3).rgb()
    total = float(np.mean(luminance(whole)))
    parts, variance, rows = np.zeros_like(whole), whole_error**2, []
    names = ["warm sphere, upper left", "cool panel, upper right", "small triangle, at the back", "sky"]
    for i, light in enumerate(counted["lights"]):
        scene = studio.variant("bubble", f"bubble-{i}", only_lamp(None if light["instance"] == "sky" else i))
        render = studio.render(scene, f"bubble-{i}", spp=spp, size=size, seed=4 + i)
        picture, error = render.rgb()
        parts += picture
        variance = variance + error**2
        studio.keep_picture(f"emitters-{i}", render.png())
        given = float(np.mean(luminance(picture))) / total
        rows.append({"name": names[i], "given": given, "chosen": light["share"], "unhidden": light["reached"] / light["chosen"]})
    difference = (np.mean(parts - whole, axis=(0, 1)) @ LUMINANCE) / total
    # The channels of a sample go up and down together: at most their errors add up.
    error = float(np.sqrt(np.sum((np.sqrt(variance) @ LUMINANCE) ** 2)) / whole[..., 0].size) / total
    studio.keep_data("emitters", {"paths": counted["paths"], "light_samples": counted["lightSamples"], "rows": rows, "spp": spp,
                                  "sum_difference": float(difference), "sum_error": error, "sum_z": float(difference) / error})


def from_above(studio, lamps):
    """A change of scenes/thousand-lamps.xml: so many lamps that together shine alike, seen from above, where they show their dark backs; without
    the bright globe and the mirror, so that the choice of lamps is all the noise there is."""
    mesh = studio.scratch / f"lamps-{lamps}.obj"
    studio.run(studio.sculptor, "--kind", "lamps", "--triangles", lamps, "-o", mesh)

    def change(root):
        for entry in root.iter("string"):
            if Path(entry.get("value")).name == "lamps.obj":
                entry.set("value", str(mesh))
        for sphere in root.findall("mesh[@type='sphere']"):
            if sphere.find("emitter") is not None or sphere.find("bsdf[@type='mirror']") is not None:
                root.remove(sphere)
        root.find("camera/transform/lookat").attrib.update(origin="0, 2.5, 0.01", target="0, 0, 0", up="0, 0, -1")
        root.find("sampler").set("type", "independent")

    return change


def many_lamps(studio):
    """Lights chosen by power and by the tree: pictures at equal samples, and what a second is worth with ever more lamps."""
    tree, power = ["integrator.lightSampler=tree"], ["integrator.lightSampler=power"]
    picture, spp = studio.pick((360, 200), (48, 27)), 64
    for name, define in (("power", power), ("tree", tree)):
        studio.keep_picture(f"lamps-{name}", studio.render("thousand-lamps", f"lamps-{name}", spp=spp, size=picture, define=define).png())
    size, deep = studio.pick((96, 54), (32, 18)), studio.pick(128, 16)
    rows, times = [], []
    for lamps in (10, 100, 1000):
        scene = studio.variant("thousand-lamps", f"lamps-{lamps}", from_above(studio, lamps))
        variance = {way: studio.render(scene, f"lamps-deep-{way}", spp=deep, size=size, seed=1, define=define).variance()
                    for way, define in (("power", power), ("tree", tree))}
        cost = studio.costs(scene, studio.pick(65, 3), size, {"power": power, "tree": tree}, studio.pick(3, 1))
        ratio = variance["power"] / variance["tree"]
        rows.append({"lamps": lamps, **variance, "ratio": ratio})
        times.append({"lamps": lamps, "cost": cost["tree"] / cost["power"], "gain": ratio * cost["power"] / cost["tree"],
                      "microseconds": 1e6 * cost["tree"] / (size[0] * size[1])})
    studio.keep_data("lamps", {"spp": spp, "deep_spp": deep, "rows": rows})
    studio.keep_data("time_lamps", {"rows": times})


def regions(width, height):
    """The four lamps of scenes/lamps.xml and the floor before them, as columns of the picture; shares of its width."""
    edges = [0.0, 0.125, 0.30, 0.54, 1.0]
    floor = slice(int(0.41 * height), int(0.65 * height))
    return [(floor, slice(int(a * width), int(b * width))) for a, b in zip(edges, edges[1:])]


def against_both(studio):
    """One strategy, the other, and both weighted, on lamps of equal power and different size."""
    size, spp = studio.pick((480, 180), (64, 24)), studio.pick(16, 4)
    small, deep = studio.pick((240, 90), (64, 24)), studio.pick(256, 16)
    strategies = {"naive": NAIVE, "nee": NEE, "mis": MIS}
    columns, lamps = {}, ["0.06", "0.2", "0.6", "1.6"]
    for name, define in strategies.items():
        studio.keep_picture(f"mis-{name}", studio.render("lamps", f"mis-{name}", spp=spp, size=size, define=define).png())
        planes = exr.read(studio.render("lamps", f"mis-deep-{name}", spp=deep, size=small, seed=1, define=define).path)
        variance = planes["StdErr.G"].astype(np.float64) ** 2 * planes["SampleCount"]
        columns[name] = [float(np.mean(variance[rows, cols])) for rows, cols in regions(*small)]
    rows = [{"lamp": lamp, **{name: columns[name][i] for name in strategies},
             "over_naive": columns["naive"][i] / columns["mis"][i], "over_nee": columns["nee"][i] / columns["mis"][i]}
            for i, lamp in enumerate(lamps)]  # yapf: disable
    costs = studio.costs("lamps", studio.pick(33, 3), size, strategies, studio.pick(3, 1))
    studio.keep_data("mis", {"spp": spp, "deep_spp": deep, "rows": rows,
                            "least": min(min(row["over_naive"], row["over_nee"]) for row in rows)})
    studio.keep_data("time_mis", {"cost_over_naive": costs["mis"] / costs["naive"], "cost_over_nee": costs["mis"] / costs["nee"]})


def plates(studio):
    """The same on four plates of different roughness under four lamps of different size, after [Veach1997]: pictures at equal samples, and the noise of each
    strategy as a share of the picture's brightness."""
    size, spp, rows = studio.pick((300, 200), (48, 32)), studio.pick(16, 4), []
    for name, define in {"naive": NAIVE, "nee": NEE, "mis": MIS}.items():
        render = studio.render("lights/veach-mis", f"veach-{name}", spp=spp, size=size, define=define)
        studio.keep_picture(f"veach-{name}", render.png())
        picture, error = render.rgb()
        rows.append({"name": name, "noise": float(np.sqrt(np.mean(error**2)) / np.mean(picture))})
    studio.keep_data("veach", {"spp": spp, "naive": rows[0]["noise"], "nee": rows[1]["noise"], "mis": rows[2]["noise"]})


def run(studio):
    next_event(studio)
    many_emitters(studio)
    many_lamps(studio)
    against_both(studio)
    plates(studio)
