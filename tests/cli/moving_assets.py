"""A glTF asset that moves, put together for tests."""

import base64
import json
import struct


class Asset:
    """A triangle with a morph target under a node, a camera, and whatever animations are added."""

    def __init__(self):
        self.data, self.views, self.accessors = b"", [], []
        corners = self.floats([0, 0, 0, 1, 0, 0, 0, 1, 0], "VEC3")
        bulge = self.floats([0, 0, 1, 0, 0, 0, 0, 0, 0], "VEC3")
        dent = self.floats([0, 0, 0, 0, 1, 0, 0, 0, 0], "VEC3")
        self.tree = {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"name": "flag", "mesh": 0, "translation": [5, 6, 7]}, {"name": "eye", "camera": 0, "translation": [0, 0, 4]}],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": corners}, "targets": [{"POSITION": bulge}, {"POSITION": dent}]}]}],
            "materials": [{"emissiveFactor": [1, 1, 1]}],
            "animations": [],
        }

    def floats(self, numbers, kind, code="f", component=5126, **more):
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind]
        while len(self.data) % 4:
            self.data += b"\0"
        packed = struct.pack("<%d%s" % (len(numbers), code), *numbers)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed)})
        self.data += packed
        self.accessors.append({"bufferView": len(self.views) - 1, "componentType": component, "count": len(numbers) // width,
                               "type": kind, **more})
        return len(self.accessors) - 1

    def channel(self, node, path, times, values, interpolation=None, animation=0, name="", output=None):
        """Adds one to an animation; values are flat."""
        while len(self.tree["animations"]) <= animation:
            self.tree["animations"].append({"channels": [], "samplers": []})
        into = self.tree["animations"][animation]
        if name:
            into["name"] = name
        kind = {"rotation": "VEC4", "weights": "SCALAR"}.get(path, "VEC3")
        sampler = {"input": self.floats(times, "SCALAR"), "output": self.floats(values, kind) if output is None else output}
        if interpolation:
            sampler["interpolation"] = interpolation
        into["samplers"].append(sampler)
        into["channels"].append({"sampler": len(into["samplers"]) - 1, "target": {"node": node, "path": path}})
        return self

    def write(self, path):
        tree = {**self.tree, "bufferViews": self.views, "accessors": self.accessors,
                "buffers": [{"byteLength": len(self.data),
                             "uri": "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()}]}
        with open(path, "w") as file:
            json.dump(tree, file, indent=1)
