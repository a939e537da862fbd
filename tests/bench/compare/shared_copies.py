"""Has a Mitsuba scene keep a mesh once that many of its shapes show: `etendue convert` writes a shape for each instance."""

import os
import xml.etree.ElementTree

# Copies that would take less than this, in bytes of mesh files, stay: rays are faster without a second level.
WORTH_SHARING = 16 << 20


def is_mirrored(shape):
    values = [float(v) for v in shape.find('transform/matrix').get('value').replace(',', ' ').split()]
    (a, b, c), (d, e, f), (g, h, i) = (values[4 * row : 4 * row + 3] for row in range(3))
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0.0


def key_of(shape):
    """Equal for shapes that differ in their place only; None for those that instances cannot show: emitters, and mirrored
    meshes without normals, whose outside depends on the order of their corners."""
    faceted = shape.find("boolean[@name='face_normals']")
    if shape.get('type') != 'ply' or shape.find('emitter') is not None or shape.find('transform/matrix') is None:
        return None
    if faceted is not None and faceted.get('value') == 'true' and is_mirrored(shape):
        return None
    return b''.join(xml.etree.ElementTree.tostring(part).strip() for part in shape if part.tag != 'transform')


def share_copies(root, folder):
    """Changes the scene `root`, whose file names are relative to `folder`."""
    by_key = {}
    for shape in root.findall('shape'):
        key = key_of(shape)
        if key is not None:
            by_key.setdefault(key, []).append(shape)
    for number, shapes in enumerate(by_key.values()):
        file = os.path.join(folder, shapes[0].find("string[@name='filename']").get('value'))
        if (len(shapes) - 1) * os.path.getsize(file) >= WORTH_SHARING:
            share(root, shapes, f'shared-{number}')


def share(root, shapes, name):
    group = xml.etree.ElementTree.Element('shape', type='shapegroup', id=name)
    mesh = xml.etree.ElementTree.SubElement(group, 'shape', type='ply')
    mesh.extend(part for part in shapes[0] if part.tag != 'transform')
    root.insert(list(root).index(shapes[0]), group)
    for shape in shapes:
        transform = shape.find('transform')
        for part in list(shape):
            shape.remove(part)
        shape.attrib.clear()
        shape.set('type', 'instance')
        shape.text = transform.text = None  # there may be so many that indents are megabytes
        xml.etree.ElementTree.SubElement(shape, 'ref', id=name)
        shape.append(transform)
