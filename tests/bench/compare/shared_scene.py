"""The scene that all programs of a comparison render: with the box filter, and with materials that all have."""

import os
import xml.etree.ElementTree

from process import Run

# The beginning of the warning of `etendue convert --to mitsuba` when it replaces materials of glTF.
GLTF_REPLACED = 'materials of glTF are written as principled'
MICROFACET_IOR = '1.5046'  # of Nori's microfacet where the scene says nothing


def with_absolute_names(tree, scene):
    """Has a copy of `scene` find its files from anywhere; made files (etendue:…) are found everywhere."""
    for name in tree.iter('string'):
        if name.get('name') == 'filename' and not name.get('value').startswith('etendue:'):
            name.set('value', os.path.join(os.path.dirname(os.path.abspath(scene)), name.get('value')))


def write_copy(tree, scene, folder):
    """A changed scene, under its name in another folder."""
    os.makedirs(folder, exist_ok=True)
    copy = os.path.join(folder, os.path.basename(scene))
    tree.write(copy, encoding='utf-8', xml_declaration=True)
    return copy


def box_filtered(etendue, scene, folder):
    """The scene with the box filter: itself where it has no other, or a copy in `folder` with absolute file names. Of a
    scene of another format, or of Mitsuba's with another filter, what `etendue convert` makes of it."""
    os.makedirs(folder, exist_ok=True)
    cameras = []
    if scene.endswith('.xml'):
        tree = xml.etree.ElementTree.parse(scene)
        cameras = list(tree.iter('camera'))
        sensors = list(tree.iter('sensor'))
        if sensors and all([f.get('type') for f in s.iter('rfilter')] == ['box'] for s in sensors):
            return scene
    if not cameras:
        own = os.path.join(folder, os.path.splitext(os.path.basename(scene))[0] + '-own.xml')
        Run([etendue.path, 'convert', scene, own, '--force', '-q'], 1)
        return box_filtered(etendue, own, folder)
    if all([f.get('type') for f in camera.findall('rfilter')] == ['box'] for camera in cameras):
        return scene
    for camera in cameras:
        for other in camera.findall('rfilter'):
            camera.remove(other)
        xml.etree.ElementTree.SubElement(camera, 'rfilter', type='box')
    with_absolute_names(tree, scene)
    return write_copy(tree, scene, folder)


def without_microfacet(scene, folder):
    """The scene with roughplastic, which other programs have as well, in place of Nori's microfacet, and whether anything
    was replaced. Both are a diffuse base under a rough coat, with other weights: the picture is not the scene's own."""
    tree = xml.etree.ElementTree.parse(scene)
    found = [bsdf for bsdf in tree.iter('bsdf') if bsdf.get('type') == 'microfacet']
    for bsdf in found:
        bsdf.set('type', 'roughplastic')
        for parameter in bsdf:
            if parameter.get('name') == 'kd':
                parameter.set('name', 'diffuse_reflectance')
        if all(parameter.get('name') != 'intIOR' for parameter in bsdf):
            xml.etree.ElementTree.SubElement(bsdf, 'float', name='intIOR', value=MICROFACET_IOR)
    if not found:
        return scene, False
    with_absolute_names(tree, scene)
    return write_copy(tree, scene, folder), True


def with_common_materials(etendue, scene, folder):
    """The scene with materials that Mitsuba has, too, and what was replaced, as words for the table. A scene with
    materials of glTF becomes the file that Mitsuba gets, in which they are principled, for all."""
    changes = []
    scene, replaced = without_microfacet(scene, os.path.join(folder, 'without-microfacet'))
    if replaced:
        changes.append("roughplastic for Nori's microfacet")
    common = os.path.join(folder, 'common')
    os.makedirs(common, exist_ok=True)
    file = os.path.join(common, os.path.basename(scene))
    try:
        messages = Run([etendue.path, 'convert', scene, file, '--to', 'mitsuba', '--force', '-q'], 1).output
    except RuntimeError:
        return scene, changes  # the adapter will say why
    if GLTF_REPLACED in messages:
        return file, [*changes, 'principled for materials of glTF']
    return scene, changes
