"""One path as `etendue explain` tells it, and what Russian roulette saves and costs."""
import numpy as np

from studio import LUMINANCE

PIXEL, SAMPLE = (95, 100), 1


def one_path(studio):
    """A path through the bubble, chosen for what happens on it: several materials, lamps in sight and hidden."""
    size = (240, 135)  # whatever the mode: the path depends on it
    text = studio.etendue("explain", studio.scene("bubble"), "--size", f"{size[0]}x{size[1]}", "--pixel", f"{PIXEL[0]},{PIXEL[1]}",
                          "--sample", SAMPLE)  # yapf: disable
    text = text.replace(str(studio.scene("bubble").parent), "scenes").rstrip()
    studio.keep_data("explain", {"text": text, "command": "etendue explain scenes/bubble.xml --size 240x135 "
                                                          f"--pixel {PIXEL[0]},{PIXEL[1]} --sample {SAMPLE}"})


def roulette(studio):
    depth, size, spp = 64, studio.pick((160, 120), (32, 24)), studio.pick(256, 8)
    ways = {way: [f"integrator.maxDepth={depth}", f"integrator.rrDepth={start}"] for way, start in (("without", 0), ("with", 5))}
    means, errors, variances = {}, {}, {}
    for seed, (way, define) in enumerate(ways.items()):  # independent pictures
        render = studio.render("cbox-sphere", f"roulette-{way}", spp=spp, size=size, seed=seed, define=define)
        picture, error = render.rgb()
        means[way] = float(np.mean(picture @ LUMINANCE))
        # The channels of a sample go up and down together: at most their errors add up.
        errors[way] = float(np.sqrt(np.sum((error @ LUMINANCE) ** 2)) / error[..., 0].size)
        variances[way] = render.variance()
    difference = means["with"] - means["without"]
    ratio = variances["with"] / variances["without"]
    studio.keep_data("roulette", {"depth": depth, "spp": spp, "difference": difference / means["without"], "variance_ratio": ratio,
                                  "z": difference / float(np.hypot(errors["with"], errors["without"]))})
    costs = studio.costs("cbox-sphere", studio.pick(65, 3), size, ways, studio.pick(3, 1))
    speed = costs["without"] / costs["with"]
    studio.keep_data("time_roulette", {"speed": speed, "gain": speed / ratio})


def run(studio):
    one_path(studio)
    roulette(studio)
