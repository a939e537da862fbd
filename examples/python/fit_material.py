"""Finds the colour of a wall in a picture, by rendering the room again and again.

    python fit_material.py            makes a picture of a room whose wall has a known colour, and finds it
    python fit_material.py photo.exr  finds it in a picture of the same room with standard errors

Least squares by Gauss and Newton. Derivatives are differences of two renders with the same seed, hence the same random
numbers, so that their noise is nearly the same and the difference nearly free of it. A colour has three parameters, but
red light depends on the red reflectance alone: two renders give all three derivatives. What is compared with the
picture is a third one with another seed: noise that slope and residual shared would pull the colour away.
"""

import sys

import numpy as np

import etendue as et

WALL = "materials.wall.albedo"


def room(wall=(0.5, 0.5, 0.5), width=64, height=48):
    """A corner with a ball in it, under a lamp. Light that the wall sends to the ball and the floor counts, too."""
    T = et.Transform4f()

    def plane(transform, bsdf):
        return {"type": "rectangle", "to_world": transform, "bsdf": {"type": "ref", "id": bsdf}}

    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 6, "rr_depth": 100},
            "sensor": {
                "type": "perspective",
                "fov": 45,
                "to_world": T.look_at(origin=[1, 1.2, 5], target=[0, 1, 0], up=[0, 1, 0]),
                "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"}},
            },
            "wall": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(wall)}},
            "white": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.7, 0.7, 0.7]}},
            "floor": plane(T.rotate([1, 0, 0], -90).scale(3), "white"),
            "back": plane(T.translate([0, 1, -2]).scale(3), "wall"),
            "ball": {"type": "sphere", "center": [0.3, 0.7, 0], "radius": 0.7, "bsdf": {"type": "ref", "id": "white"}},
            "lamp": {
                "type": "rectangle",
                "to_world": T.translate([0, 3.5, 1]).rotate([1, 0, 0], 90),
                "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [8, 8, 8]}},
            },
        }
    )


def fit_color(scene, name, target, spp=64, steps=8, seed=1):
    """Changes the colour `name` of the scene until it renders to the picture `target`, which has a standard error.
    Returns the colour and the standard error of each of its components."""

    def rendered(color, seed):
        scene.parameters[name] = color
        return et.render(scene, spp=spp, seed=seed)

    step = 0.02
    color = np.array(scene.parameters[name])
    for _ in range(steps):
        here = rendered(color, seed)
        slope = (rendered(color + step, seed + 1).mean.astype(float) - rendered(color, seed + 1).mean) / step
        curvature = np.sum(slope**2, axis=(0, 1))
        change = np.sum(slope * (target.mean.astype(float) - here.mean), axis=(0, 1)) / curvature
        variance = here.standard_error.astype(float) ** 2 + target.standard_error.astype(float) ** 2
        error = np.sqrt(np.sum(slope**2 * variance, axis=(0, 1))) / curvature
        color = np.clip(color + change, 0.01, 0.97)
        print(f"colour {np.array2string(color, precision=4)}, changed by {np.array2string(change, precision=4)}")
        if np.all(np.abs(change) < 0.1 * error):
            break
    scene.parameters[name] = color
    return color, error


def main(arguments):
    truth = (0.65, 0.3, 0.12)
    target = et.read_image(arguments[0]) if arguments else et.render(room(truth), spp=256, seed=2)
    if target.standard_error is None:
        sys.exit("the picture has no standard errors; et.Image.from_arrays(mean, standard_error) gives it some")
    scene = room(width=target.width, height=target.height)
    color, error = fit_color(scene, WALL, target)
    print("the wall is", ", ".join(f"{c:.4f} ± {e:.4f}" for c, e in zip(color, error)))
    if not arguments:
        print("it was     ", ", ".join(f"{c:.4f}" for c in truth))


if __name__ == "__main__":
    main(sys.argv[1:])
