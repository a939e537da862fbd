"""Renders a scene of `etendue bench --export` with Cycles, inside Blender or in a Python that has Blender as its module
bpy:

    blender -b --factory-startup -P cycles_scene.py -- FOLDER OUT.exr SPP THREADS SEED
    python3 cycles_scene.py -- FOLDER OUT.exr SPP THREADS SEED

Blender 3.4 and later. No denoiser, no adaptive sampling, no clamping, no light threshold; box filter. The last line on
stdout that starts with CYCLES holds Blender's version and the seconds Cycles says it rendered, after its scene was
ready. Spheres are meshes of 20 480 smooth triangles: Cycles has no analytic ones.
"""

import json
import math
import os
import struct
import sys

import bpy  # first: where Blender is a Python module, bmesh and mathutils exist only once it is loaded
import bmesh
import mathutils
import numpy

SPHERE_SUBDIVISIONS = 6


def read_ply(path):
    """Vertices, normals (or None) and triangles of the one kind of PLY that etendue writes."""
    with open(path, 'rb') as file:
        data = file.read()
    end = data.index(b'end_header\n') + len(b'end_header\n')
    header = data[:end].decode('ascii').split('\n')
    count = {line.split()[1]: int(line.split()[2]) for line in header if line.startswith('element')}
    floats = sum(line.startswith('property float') for line in header)
    vertices = numpy.frombuffer(data, '<f4', count['vertex'] * floats, end).reshape(-1, floats)
    faces = numpy.frombuffer(data, [('n', 'u1'), ('v', '<i4', 3)], count['face'], end + vertices.nbytes)
    return vertices[:, :3], vertices[:, 3:6] if floats == 6 else None, faces['v']


def add_mesh(name, vertices, normals, triangles):
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set('co', numpy.ascontiguousarray(vertices, 'f4').ravel())
    mesh.loops.add(3 * len(triangles))
    mesh.loops.foreach_set('vertex_index', numpy.ascontiguousarray(triangles, 'i4').ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set('loop_start', numpy.arange(0, 3 * len(triangles), 3, dtype='i4'))
    mesh.polygons.foreach_set('loop_total', numpy.full(len(triangles), 3, 'i4'))
    mesh.polygons.foreach_set('use_smooth', numpy.full(len(triangles), normals is not None))
    mesh.update(calc_edges=True)
    if normals is not None:
        if bpy.app.version < (4, 1, 0):  # from then on split normals are always used
            mesh.use_auto_smooth = True
        mesh.normals_split_custom_set_from_vertices(normals.tolist())
    return mesh


def add_sphere(name, center, radius):
    mesh = bpy.data.meshes.new(name)
    build = bmesh.new()
    bmesh.ops.create_icosphere(
        build, subdivisions=SPHERE_SUBDIVISIONS, radius=radius, matrix=mathutils.Matrix.Translation(center)
    )
    for face in build.faces:
        face.smooth = True
    build.to_mesh(mesh)
    build.free()
    return mesh


def make_sharp(node):
    """Reflects or refracts in one direction only: a distribution of its own before Blender 4.0, roughness 0 since."""
    names = node.bl_rna.properties['distribution'].enum_items.keys()
    if 'SHARP' in names:
        node.distribution = 'SHARP'
    else:
        node.inputs['Roughness'].default_value = 0.0


def surface_shader(tree, bsdf):
    if bsdf['type'] == 'diffuse':
        node = tree.nodes.new('ShaderNodeBsdfDiffuse')
        node.inputs['Color'].default_value = (*bsdf['albedo'], 1.0)
        node.inputs['Roughness'].default_value = 0.0
    elif bsdf['type'] == 'mirror':
        node = tree.nodes.new('ShaderNodeBsdfGlossy')
        make_sharp(node)
        node.inputs['Color'].default_value = (1.0, 1.0, 1.0, 1.0)
    else:
        node = tree.nodes.new('ShaderNodeBsdfGlass')
        make_sharp(node)
        node.inputs['Color'].default_value = (1.0, 1.0, 1.0, 1.0)
        node.inputs['IOR'].default_value = bsdf['int_ior'] / bsdf['ext_ior']
    return node.outputs['BSDF']


def emission_shader(tree, radiance):
    """Emits on the side of the normal only: the back is black."""
    strength = max(radiance)
    emission = tree.nodes.new('ShaderNodeEmission')
    emission.inputs['Color'].default_value = (*(r / strength for r in radiance), 1.0)
    geometry = tree.nodes.new('ShaderNodeNewGeometry')
    front = tree.nodes.new('ShaderNodeMath')
    front.operation = 'MULTIPLY_ADD'  # strength · (1 − backfacing)
    tree.links.new(geometry.outputs['Backfacing'], front.inputs[0])
    front.inputs[1].default_value = -strength
    front.inputs[2].default_value = strength
    tree.links.new(front.outputs[0], emission.inputs['Strength'])
    return emission.outputs['Emission']


def empty_node_tree(owner):
    """Of a material or a world; they have one from the start since Blender 5.0."""
    if bpy.app.version < (5, 0, 0):
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree


def make_material(name, shape):
    material = bpy.data.materials.new(name)
    tree = empty_node_tree(material)
    output = tree.nodes.new('ShaderNodeOutputMaterial')
    shader = surface_shader(tree, shape['bsdf'])
    if shape['radiance'] and max(shape['radiance']) > 0.0:
        both = tree.nodes.new('ShaderNodeAddShader')
        tree.links.new(shader, both.inputs[0])
        tree.links.new(emission_shader(tree, shape['radiance']), both.inputs[1])
        shader = both.outputs['Shader']
    tree.links.new(shader, output.inputs['Surface'])
    return material


def make_world(scene, sky):
    """mix(horizon, top, clamp(ω.y, 0, 1)); the ramp is linear in between."""
    world = bpy.data.worlds.new('sky')
    scene.world = world
    tree = empty_node_tree(world)
    output = tree.nodes.new('ShaderNodeOutputWorld')
    background = tree.nodes.new('ShaderNodeBackground')
    tree.links.new(background.outputs['Background'], output.inputs['Surface'])
    if sky['top'] == sky['horizon']:
        background.inputs['Color'].default_value = (*sky['top'], 1.0)
        return
    direction = tree.nodes.new('ShaderNodeTexCoord')
    separate = tree.nodes.new('ShaderNodeSeparateXYZ')
    mix = tree.nodes.new('ShaderNodeMixRGB')  # clamps its factor
    mix.inputs['Color1'].default_value = (*sky['horizon'], 1.0)
    mix.inputs['Color2'].default_value = (*sky['top'], 1.0)
    clamp = tree.nodes.new('ShaderNodeClamp')
    tree.links.new(direction.outputs['Generated'], separate.inputs[0])
    tree.links.new(separate.outputs['Y'], clamp.inputs['Value'])
    tree.links.new(clamp.outputs[0], mix.inputs[0])  # "Fac", or "Factor" in later versions
    tree.links.new(mix.outputs['Color'], background.inputs['Color'])


def make_camera(scene, camera):
    """Blender's cameras look along −Z, with +X to the right."""
    data = bpy.data.cameras.new('camera')
    data.sensor_fit = 'HORIZONTAL'
    data.angle = math.radians(camera['fov'])
    data.clip_start = camera['near']
    data.clip_end = camera['far']
    rows = mathutils.Matrix(camera['world_from_camera'])
    instance = bpy.data.objects.new('camera', data)
    instance.matrix_world = rows @ mathutils.Matrix.Diagonal((-1.0, 1.0, -1.0, 1.0))
    scene.collection.objects.link(instance)
    scene.camera = instance
    scene.render.resolution_x = camera['width']
    scene.render.resolution_y = camera['height']
    scene.render.resolution_percentage = 100


def configure(scene, max_depth, spp, threads, seed):
    scene.render.engine = 'CYCLES'
    scene.render.threads_mode = 'FIXED'
    scene.render.threads = threads
    cycles = scene.cycles
    cycles.device = 'CPU'
    cycles.samples = spp
    cycles.seed = seed
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.light_sampling_threshold = 0.0
    cycles.pixel_filter_type = 'BOX'
    # A path of N segments scatters N − 1 times; Cycles counts the bounces after the first.
    bounces = min(max_depth - 2, 1024)
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    scene.render.image_settings.file_format = 'OPEN_EXR'
    scene.render.image_settings.color_depth = '32'
    scene.render.film_transparent = False


def exr_text_attributes(path):
    """The string attributes of an OpenEXR header: Cycles leaves its times there."""
    with open(path, 'rb') as file:
        data = file.read(1 << 16)
    found, at = {}, 8
    while data[at] != 0:
        name_end = data.index(b'\0', at)
        type_end = data.index(b'\0', name_end + 1)
        size = struct.unpack_from('<i', data, type_end + 1)[0]
        value = data[type_end + 5 : type_end + 5 + size]
        if data[name_end + 1 : type_end] == b'string':
            found[data[at:name_end].decode()] = value.decode('utf-8', 'replace')
        at = type_end + 5 + size
    return found


def seconds(text):
    """'01:02.34' or '1:01:02.34' as seconds."""
    total = 0.0
    for part in text.split(':'):
        total = 60.0 * total + float(part)
    return total


def build(folder, spp, threads, seed):
    """Blender's scene, in place of whatever was there."""
    with open(os.path.join(folder, 'scene.json'), encoding='utf-8') as file:
        description = json.load(file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    for i, shape in enumerate(description['shapes']):
        name = f"shape-{i}"
        if 'sphere' in shape:
            mesh = add_sphere(name, shape['sphere']['center'], shape['sphere']['radius'])
        else:
            mesh = add_mesh(name, *read_ply(os.path.join(folder, shape['mesh']['file'])))
        mesh.materials.append(make_material(name, shape))
        scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    make_world(scene, description['sky'])
    make_camera(scene, description['camera'])
    configure(scene, description['integrator']['max_depth'], spp, threads, seed)
    return scene


def main():
    folder, out, spp, threads, seed = sys.argv[sys.argv.index('--') + 1 :]
    scene = build(folder, int(spp), int(threads), int(seed))
    scene.render.filepath = out
    bpy.ops.render.render(write_still=True)
    times = {
        key.rsplit('.', 1)[1]: seconds(value)
        for key, value in exr_text_attributes(out).items()
        if key.startswith('cycles.') and key.endswith('_time')
    }
    print(f"CYCLES {bpy.app.version_string} {times['render_time']:.2f}", flush=True)


if __name__ == '__main__':
    main()
