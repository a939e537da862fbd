"""A room as a glTF asset whose surfaces have pictures: what an artist's tool would export, in small."""

import json
import math
import struct

# Name, picture by etendue-sculpt, roughness, metalness.
MATERIALS = [
    ('floor', 'wood', 0.35, 0.0),
    ('walls', 'cloth', 0.9, 0.0),
    ('table', 'wood', 0.25, 0.0),
    ('porcelain', 'porcelain', 0.15, 0.0),
    ('fruit', 'orange', 0.5, 0.0),
    ('metal', None, 0.3, 1.0),
    ('lamp', None, 1.0, 0.0),
]
TEXELS = 1024
RADIANCE = 15.0  # of the lamp
LOW, HIGH = (-2.0, 0.0, -2.0), (2.0, 2.6, 2.4)
# Corners of a box, counterclockwise from outside; bits 4, 2 and 1 of a number say which of x, y and z are high.
SIDES = {'-x': (0, 1, 3, 2), '+x': (5, 4, 6, 7), '-z': (4, 0, 2, 6), '+z': (1, 5, 7, 3), '+y': (3, 7, 6, 2), '-y': (0, 4, 5, 1)}
ALL = tuple(SIDES)


class Mesh:
    """The triangles of one material."""

    def __init__(self):
        self.positions, self.normals, self.uvs, self.indices = [], [], [], []

    def quad(self, corners):
        """Counterclockwise; a picture covers a square of side 1."""
        right, up = ([b - a for a, b in zip(corners[0], corners[k])] for k in (1, 3))
        normal = [right[i - 2] * up[i - 1] - right[i - 1] * up[i - 2] for i in range(3)]
        width, height = math.hypot(*right), math.hypot(*up)
        first = len(self.positions)
        self.positions += corners
        self.normals += [[n / (width * height) for n in normal]] * 4
        self.uvs += [(0.0, height), (width, height), (width, 0.0), (0.0, 0.0)]
        self.indices += [first + k for k in (0, 1, 2, 0, 2, 3)]

    def box(self, low, high, sides=ALL, inward=False):
        for side in sides:
            corners = [tuple((low, high)[k >> (2 - i) & 1][i] for i in range(3)) for k in SIDES[side]]
            self.quad(corners[::-1] if inward else corners)

    def ball(self, center, radius, rows=48):
        columns, first = 2 * rows, len(self.positions)
        for row in range(rows + 1):
            for column in range(columns + 1):
                theta, phi = math.pi * row / rows, 2.0 * math.pi * column / columns
                normal = (math.sin(theta) * math.cos(phi), math.cos(theta), -math.sin(theta) * math.sin(phi))
                self.positions.append([c + radius * n for c, n in zip(center, normal)])
                self.normals.append(normal)
                self.uvs.append((column / columns, row / rows))
        for row in range(rows):
            for column in range(columns):
                a = first + row * (columns + 1) + column
                b = a + columns + 1
                self.indices += [a, b, a + 1] * (row > 0) + [a + 1, b, b + 1] * (row < rows - 1)


def furnished():
    """Meshes by the name of their material."""
    meshes = {name: Mesh() for name, *_ in MATERIALS}
    meshes['floor'].box(LOW, HIGH, ['-y'], inward=True)
    meshes['walls'].box(LOW, HIGH, ['-x', '+x', '-z', '+z', '+y'], inward=True)
    meshes['lamp'].box((-0.5, 2.55, -0.7), (0.5, 2.58, 0.3))
    meshes['table'].box((-0.9, 0.7, -1.2), (0.9, 0.76, 0.0))
    for x in (-0.8, 0.74):
        for z in (-1.1, -0.16):
            meshes['table'].box((x, 0.0, z), (x + 0.06, 0.7, z + 0.06), ALL[:4])
    for x, z in ((-0.55, -0.7), (0.1, -0.9)):
        meshes['porcelain'].ball((x, 0.96, z), 0.2)
    for x, z in ((-0.2, -0.35), (0.02, -0.3), (0.25, -0.4)):
        meshes['fruit'].ball((x, 0.84, z), 0.08)
    meshes['metal'].ball((0.55, 0.94, -0.6), 0.18)
    return meshes


class Buffer:
    """Accessors and what they refer to."""

    def __init__(self):
        self.data, self.views, self.accessors = b'', [], []

    def add(self, values, kind, code, component, **more):
        """The number of the accessor."""
        flat = [v for value in values for v in value] if kind != 'SCALAR' else values
        packed = struct.pack(f'<{len(flat)}{code}', *flat)
        self.views.append({'buffer': 0, 'byteOffset': len(self.data), 'byteLength': len(packed)})
        self.data += packed
        view = len(self.views) - 1
        self.accessors.append({'bufferView': view, 'componentType': component, 'count': len(values), 'type': kind, **more})
        return view

    def primitive(self, mesh, material):
        axes = list(zip(*mesh.positions))
        bounds = {'min': [min(axis) for axis in axes], 'max': [max(axis) for axis in axes]}
        attributes = {
            'POSITION': self.add(mesh.positions, 'VEC3', 'f', 5126, **bounds),
            'NORMAL': self.add(mesh.normals, 'VEC3', 'f', 5126),
            'TEXCOORD_0': self.add(mesh.uvs, 'VEC2', 'f', 5126),
        }
        return {'attributes': attributes, 'indices': self.add(mesh.indices, 'SCALAR', 'I', 5125), 'material': material}


def materials(pictures):
    result = []
    for name, picture, roughness, metalness in MATERIALS:
        surface = {'roughnessFactor': roughness, 'metallicFactor': metalness}
        if picture:
            surface['baseColorTexture'] = {'index': pictures.index(picture)}
        material = {'name': name, 'pbrMetallicRoughness': surface}
        if name == 'lamp':
            strength = {'KHR_materials_emissive_strength': {'emissiveStrength': RADIANCE}}
            material.update(emissiveFactor=[1.0, 0.9, 0.75], extensions=strength)
        result.append(material)
    return result


def write(workshop):
    """room.gltf with its buffer and pictures in the workshop's folder."""
    pictures = sorted({picture for _, picture, *_ in MATERIALS if picture})
    files = [workshop.sculpted('.png', '--picture', picture, '--size', TEXELS) for picture in pictures]
    buffer = Buffer()
    primitives = [buffer.primitive(mesh, number) for number, mesh in enumerate(furnished().values())]
    camera = {'type': 'perspective', 'perspective': {'yfov': 0.9, 'aspectRatio': 4 / 3, 'znear': 0.01, 'zfar': 100.0}}
    asset = {
        'asset': {'version': '2.0'},
        'extensionsUsed': ['KHR_materials_emissive_strength'],
        'scene': 0,
        'scenes': [{'nodes': [0, 1]}],
        'nodes': [{'mesh': 0}, {'camera': 0, 'translation': [0.0, 1.35, 2.3]}],
        'cameras': [camera],
        'meshes': [{'primitives': primitives}],
        'materials': materials(pictures),
        'textures': [{'source': number} for number in range(len(files))],
        'images': [{'uri': file.name} for file in files],
        'accessors': buffer.accessors,
        'bufferViews': buffer.views,
        'buffers': [{'uri': 'room.bin', 'byteLength': len(buffer.data)}],
    }
    (workshop.scratch / 'room.bin').write_bytes(buffer.data)
    path = workshop.scratch / 'room.gltf'
    path.write_text(json.dumps(asset), encoding='utf-8')
    return path
