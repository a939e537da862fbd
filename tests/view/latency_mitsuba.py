"""The same of Mitsuba 3 in Python, by a script as its users write it: python latency_mitsuba.py SCENE [ROUNDS] [VARIANT].

SCENE is a scene for Mitsuba (`etendue convert SCENE out.xml --to mitsuba`). Prints in milliseconds the medians of: from the start of
Python to the first picture, of one sample a pixel at a quarter of the size across; from another place of the camera to such a picture;
and to one of full size. docs/view.md has the numbers."""

import sys

import latency_peers

CHILD = """
import sys, time
start = float(sys.argv[3])
import mitsuba as mi
mi.set_variant(sys.argv[2])
import numpy as np
scene = mi.load_file(sys.argv[1])
parameters = mi.traverse(scene)
size = next(k for k in parameters.keys() if k.endswith("film.size"))
sensor = size.removesuffix("film.size") + "to_world"
full = np.array(parameters[size])

def picture(shape, seed):
    for name in (size, size.replace("film.size", "film.crop_size")):
        parameters[name] = [int(n) for n in shape]
    parameters.update()
    return np.array(mi.render(scene, spp=1, seed=seed))

coarse = [max(1, int(n) // 4) for n in full]
picture(coarse, 0)
print("LATENCY first", 1000 * (time.time() - start))
own = parameters[sensor]
for step in range(1, 6):
    for what, shape in (("drag", coarse), ("full", full)):
        begin = time.time()
        parameters[sensor] = own @ type(own)().translate([0, 0, 0.01 * step])
        picture(shape, step)
        print("LATENCY", what, 1000 * (time.time() - begin))
"""

variant = sys.argv[3] if len(sys.argv) > 3 else "llvm_ad_rgb"
latency_peers.measure(CHILD, [sys.argv[1], variant], int(sys.argv[2]) if len(sys.argv) > 2 else 5)
