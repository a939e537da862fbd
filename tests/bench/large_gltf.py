#!/usr/bin/env python3
"""Writes a .glb of many meshes, to measure what a large asset takes:

    large_gltf.py big.glb [--nodes 2000] [--triangles 5000] [--index-bits 32]
    /usr/bin/time -v etendue check big.glb

Each node has a mesh of its own, a wavy square with positions and normals.
"""

import argparse
import array
import json
import math
import struct
import sys


def wavy_square(side, index_code):
    """Positions, normals and indices of side × side cells, as bytes; their numbers; the least and greatest height."""
    positions, normals, indices = array.array("f"), array.array("f"), array.array(index_code)
    for row in range(side + 1):
        for column in range(side + 1):
            x, z = column / side, row / side
            slope_x, slope_z = 0.3 * math.cos(6 * x), 0.2 * math.cos(5 * z)
            length = math.sqrt(1 + slope_x**2 + slope_z**2)
            positions.extend((x, 0.05 * math.sin(6 * x) + 0.04 * math.sin(5 * z), z))
            normals.extend((-slope_x / length, 1 / length, -slope_z / length))
    for row in range(side):
        for column in range(side):
            a = row * (side + 1) + column
            b = a + side + 1
            indices.extend((a, b, a + 1, a + 1, b, b + 1))
    heights = [min(positions[1::3]), max(positions[1::3])]
    for values in (positions, normals, indices):
        if sys.byteorder == "big":
            values.byteswap()
    parts = [values.tobytes() for values in (positions, normals, indices)]
    return parts, (side + 1)**2, 6 * side**2, heights


def asset(nodes, parts, vertices, corners, heights, index_type):
    """The JSON of the asset; the parts follow each other in its buffer, once per node."""
    across = math.ceil(math.sqrt(nodes))
    views, accessors, at = [], [], 0
    for _ in range(nodes):
        for part in parts:
            views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part)})
            at += len(part)
        first = len(views) - 3
        vectors = {"componentType": 5126, "count": vertices, "type": "VEC3"}
        accessors += [{"bufferView": first, **vectors, "min": [0, heights[0], 0], "max": [1, heights[1], 1]},
                      {"bufferView": first + 1, **vectors},
                      {"bufferView": first + 2, "componentType": index_type, "count": corners, "type": "SCALAR"}]
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(nodes))}],
        "nodes": [{"mesh": i, "translation": [1.1 * (i % across), 0, 1.1 * (i // across)]} for i in range(nodes)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 3 * i, "NORMAL": 3 * i + 1}, "indices": 3 * i + 2}]}
                   for i in range(nodes)],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": at}],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--nodes", type=int, default=2000)
    parser.add_argument("--triangles", type=int, default=5000, help="per node, at least: a square of cells is filled")
    parser.add_argument("--index-bits", type=int, choices=(16, 32), default=32)
    arguments = parser.parse_args()
    side = math.ceil(math.sqrt(arguments.triangles / 2))
    code, index_type = ("I", 5125) if arguments.index_bits == 32 else ("H", 5123)
    if arguments.index_bits == 16 and (side + 1)**2 > 65535:
        parser.error("--index-bits 16 is for meshes of up to 65535 vertices")
    parts, vertices, corners, heights = wavy_square(side, code)
    parts = [part + bytes(-len(part) % 4) for part in parts]
    header = json.dumps(asset(arguments.nodes, parts, vertices, corners, heights, index_type)).encode()
    header += b" " * (-len(header) % 4)
    data = b"".join(parts)
    size = len(data) * arguments.nodes
    with open(arguments.file, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(header) + 8 + size))
        file.write(struct.pack("<II", len(header), 0x4E4F534A) + header)
        file.write(struct.pack("<II", size, 0x004E4942))
        for _ in range(arguments.nodes):
            file.write(data)


main()
