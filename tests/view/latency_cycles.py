"""The same of Cycles in Blender's module bpy, without a window: python latency_cycles.py FOLDER [ROUNDS].

FOLDER is what `etendue bench SCENE --export OUT --size WxH` wrote for one scene: a folder in OUT. Prints what latency_mitsuba.py prints. Blender keeps its
data from picture to picture here (use_persistent_data), as its viewport does. docs/view.md has the numbers."""

import sys
from pathlib import Path

import latency_peers

CHILD = """
import os, sys, time
start = float(sys.argv[2])
import bpy
import cycles_scene
scene = cycles_scene.build(sys.argv[1], 1, len(os.sched_getaffinity(0)), 0)
scene.render.use_persistent_data = True
full = scene.render.resolution_x, scene.render.resolution_y

def picture(shape):
    scene.render.resolution_x, scene.render.resolution_y = shape
    bpy.ops.render.render()

coarse = [max(1, n // 4) for n in full]
picture(coarse)
print("LATENCY first", 1000 * (time.time() - start))
for step in range(1, 6):
    for what, shape in (("drag", coarse), ("full", full)):
        begin = time.time()
        scene.camera.location.z += 0.01
        picture(shape)
        print("LATENCY", what, 1000 * (time.time() - begin))
"""

modules = Path(__file__).resolve().parents[1] / "bench" / "compare"
latency_peers.measure(CHILD, [sys.argv[1]], int(sys.argv[2]) if len(sys.argv) > 2 else 5, {"PYTHONPATH": str(modules)})
