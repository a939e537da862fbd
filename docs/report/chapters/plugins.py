"""One small picture for every object of scene files that is no material: the pages of objects on the site (docs/site/plugins.py)."""
import numpy as np
from PIL import Image

COLORS = 128  # of a picture: it stays at some kilobytes
SIZE = (192, 144)

DAY = '<color name="sky_top" value="0.5 0.6 0.8"/><color name="sky_horizon" value="0.7 0.7 0.68"/>'
LAMP = """<mesh type="sphere"><point name="center" value="-3 5 4"/><float name="radius" value="1"/>
  <emitter type="area"><color name="radiance" value="14 13 11"/></emitter></mesh>"""
EYE = '<transform name="toWorld"><lookat origin="0 1.7 5" target="0 0.75 0" up="0 1 0"/></transform>'
CAMERA = f'<camera type="perspective"><float name="fov" value="38"/>{EYE}<rfilter type="tent"/></camera>'
PATH = '<integrator type="path"><integer name="maxDepth" value="8"/></integrator>'
FLOOR = """<mesh type="rectangle"><transform name="toWorld"><rotate angle="-90" axis="1 0 0"/><scale value="60 1 60"/></transform>
  <bsdf type="diffuse"><color name="albedo" value="0.45 0.45 0.45"/></bsdf></mesh>"""
MATT = '<bsdf type="diffuse"><color name="albedo" value="0.75 0.42 0.2"/></bsdf>'
TILES = """<bsdf type="diffuse"><texture name="albedo" type="checkerboard"><color name="color0" value="0.8 0.55 0.3"/>
  <color name="color1" value="0.25 0.3 0.4"/><transform name="to_uv"><scale value="4 4 1"/></transform></texture></bsdf>"""
BALL = f'<mesh type="sphere"><point name="center" value="-0.7 0.7 0"/><float name="radius" value="0.7"/>{MATT}</mesh>'
MIRROR = '<mesh type="sphere"><point name="center" value="0.85 0.55 0.5"/><float name="radius" value="0.55"/><bsdf type="mirror"/></mesh>'
WALL = """<mesh type="rectangle"><transform name="toWorld"><scale value="6 4 1"/><translate value="0 3 -1.6"/></transform>
  <bsdf type="diffuse"><color name="albedo" value="0.6 0.6 0.6"/></bsdf></mesh>"""


def scene(*parts, camera=CAMERA, integrator=PATH, sampler='<sampler type="sobol"/>'):
    return f"<scene>{integrator}{sampler}{camera}{''.join(parts)}</scene>"


def shape(kind, properties="", transform="", bsdf=TILES):
    return f'<mesh type="{kind}">{properties}<transform name="toWorld">{transform}</transform>{bsdf}</mesh>'


TURNED = '<rotate angle="35" axis="0 1 0"/>'
RAISED = '<translate value="0 0.9 0"/>'
# A roof of four sides, as a file.
PYRAMID = [(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1), (0, 1.6, 0)]
SIDES = [(3, 2, 4), (2, 1, 4), (1, 0, 4), (0, 3, 4)]
PYRAMID_COLORS = [(200, 60, 40), (230, 180, 60), (60, 140, 90), (60, 90, 190), (250, 250, 250)]


def obj_text():
    return "".join(f"v {x} {y} {z}\n" for x, y, z in PYRAMID) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in SIDES)


def ply_text():
    head = (f"ply\nformat ascii 1.0\nelement vertex {len(PYRAMID)}\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
            f"property uchar green\nproperty uchar blue\nelement face {len(SIDES)}\nproperty list uchar int vertex_indices\nend_header\n")
    return (head + "".join(f"{x} {y} {z} {r} {g} {b}\n" for (x, y, z), (r, g, b) in zip(PYRAMID, PYRAMID_COLORS)) +
            "".join(f"3 {a} {b} {c}\n" for a, b, c in SIDES))


def integrators():
    room = (FLOOR, WALL, BALL, MIRROR, LAMP, DAY)
    kinds = {"path": '<integer name="maxDepth" value="8"/>', "direct": "", "whitted": "", "normals": "", "ao": '<float name="length" value="2"/>',
             "av": '<float name="length" value="2"/>', "depth": "", "distance": "",
             "simple": '<point name="position" value="-2 4 4"/><color name="energy" value="900 850 800"/>'}  # yapf: disable
    for kind, properties in kinds.items():
        exposure = {"depth": 1.6, "distance": -3.2}.get(kind, 0.0)
        yield f"integrator-{kind}", scene(*room, integrator=f'<integrator type="{kind}">{properties}</integrator>'), 64, exposure


def cameras():
    row = "".join(f'<mesh type="sphere"><point name="center" value="{-1.2 + 0.8 * i} 0.4 {1.6 - 1.5 * i}"/><float name="radius" value="0.4"/>'
                  f'{TILES}</mesh>' for i in range(4))
    wide = '<transform name="toWorld"><scale value="2.2 2.2 1"/><lookat origin="0 2 6" target="0 0.8 0" up="0 1 0"/></transform>'
    inside = '<transform name="toWorld"><lookat origin="0 0.9 1.2" target="0 0.9 0" up="0 1 0"/></transform>'
    kinds = {"perspective": f'<float name="fov" value="38"/>{EYE}',
             "thinlens": f'<float name="fov" value="38"/><float name="apertureRadius" value="0.16"/><float name="focusDistance" value="4.2"/>{EYE}',
             "orthographic": wide, "spherical": inside}  # yapf: disable
    for kind, properties in kinds.items():
        camera = f'<camera type="{kind}">{properties}<rfilter type="tent"/></camera>'
        yield f"camera-{kind}", scene(FLOOR, row, LAMP, DAY, camera=camera), 64, 0.0


def samplers_and_filters():
    for kind in ("independent", "sobol"):
        yield f"sampler-{kind}", scene(FLOOR, WALL, BALL, LAMP, DAY, sampler=f'<sampler type="{kind}"/>'), 16, 0.0
    for kind in ("box", "tent", "gaussian", "mitchell", "lanczos"):
        camera = f'<camera type="perspective"><float name="fov" value="38"/>{EYE}<rfilter type="{kind}"/></camera>'
        tiles = FLOOR.replace('<color name="albedo" value="0.45 0.45 0.45"/>', """<texture name="albedo" type="checkerboard">
          <color name="color0" value="0.9 0.9 0.9"/><color name="color1" value="0 0 0"/><transform name="to_uv"><scale value="120 120 1"/></transform>
          </texture>""")
        yield f"rfilter-{kind}", scene(tiles, DAY, camera=camera), 256, 0.0


def shapes():
    file = '<string name="filename" value="{}"/>'
    fir = shape("obj", file.format("pyramid.obj"), '<scale value="0.5 0.7 0.5"/>', MATT)
    group = f'<mesh type="shapegroup" id="hut">{fir}</mesh>' + "".join(
        f'<mesh type="instance"><ref id="hut"/><transform name="toWorld"><rotate angle="{37 * i}" axis="0 1 0"/>'
        f'<translate value="{-1.6 + 1.05 * (i % 4)} 0 {0.9 - 1.3 * (i // 4)}"/></transform></mesh>' for i in range(12))
    ball = f'<mesh type="sphere"><point name="center" value="0 0.9 0"/><float name="radius" value="0.9"/>{TILES}</mesh>'
    colors = '<bsdf type="diffuse"><texture name="albedo" type="mesh_attribute"/></bsdf>'
    kinds = {
        "obj": shape("obj", file.format("pyramid.obj"), TURNED, MATT),
        "ply": shape("ply", file.format("pyramid.ply"), TURNED, colors),
        "rectangle": shape("rectangle", transform='<rotate angle="-20" axis="1 0 0"/>' + TURNED + RAISED),
        "parallelogram": shape("parallelogram", '<point name="origin" value="-1.1 0.1 0.5"/><vector name="u" value="1.7 0 -0.4"/>'
                               '<vector name="v" value="0.5 1.5 -0.2"/>'),
        "cube": shape("cube", transform='<scale value="0.7 0.7 0.7"/>' + TURNED + '<translate value="0 0.7 0"/>'),
        "disk": shape("disk", transform='<rotate angle="-25" axis="1 0 0"/>' + TURNED + RAISED),
        "cylinder": shape("cylinder", '<point name="p0" value="0 0 0"/><point name="p1" value="0 1.5 0"/><float name="radius" value="0.7"/>'),
        "sphere": ball,
        "instance": group,
    }  # yapf: disable
    for kind, parts in kinds.items():
        yield f"mesh-{kind}", scene(FLOOR, parts, LAMP, DAY), 64, 0.0


def emitters():
    sun = '<vector name="sunDirection" value="-0.6 0.7 0.5"/>'
    along = '<transform name="toWorld"><lookat origin="-1.5 3 4" target="0 0.6 -0.5" up="0 1 0"/></transform>'
    kinds = {
        "area": ('<mesh type="sphere"><point name="center" value="0.3 1.5 0.9"/><float name="radius" value="0.25"/><emitter type="area">'
                 '<color name="radiance" value="22 19 14"/></emitter></mesh>', 0.0),
        "constant": ('<emitter type="constant"><color name="radiance" value="0.8 0.85 0.9"/></emitter>', 0.0),
        "envmap": ('<emitter type="envmap"><string name="filename" value="sky.hdr"/></emitter>', 0.0),
        "point": ('<emitter type="point"><point name="position" value="0.4 2.2 1.5"/><color name="intensity" value="9 8 6"/></emitter>', 0.0),
        "spot": (f'<emitter type="spot">{along}<color name="intensity" value="90 80 60"/><float name="cutoffAngle" value="16"/></emitter>', 0.0),
        "projector": (f'<emitter type="projector">{along}<float name="fov" value="36"/><texture name="irradiance" type="checkerboard">'
                      '<color name="color0" value="60 45 12"/><color name="color1" value="6 16 40"/><transform name="to_uv">'
                      '<scale value="4 4 1"/></transform></texture></emitter>', 0.0),
        "directional": ('<emitter type="directional"><vector name="direction" value="1 -1.4 -1"/><color name="irradiance" value="2.6 2.4 2"/>'
                        '</emitter>', 0.0),
        "sky": (f'<emitter type="sky">{sun}</emitter>', 2.5),
        "sun": (f'<emitter type="sun">{sun}<float name="sunRadiusScale" value="4"/></emitter>', 1.0),
        "sunsky": (f'<emitter type="sunsky">{sun}</emitter>', 1.0),
    }  # yapf: disable
    for kind, (light, exposure) in kinds.items():
        yield f"emitter-{kind}", scene(FLOOR, "" if kind in ("envmap", "sky", "sun", "sunsky") else WALL, BALL, MIRROR, light), 128, exposure


def textures():
    bitmap = '<texture name="{}" type="bitmap"><string name="filename" value="{}"/>{}</texture>'
    kinds = {
        "checkerboard": TILES,
        "bitmap": f'<bsdf type="diffuse">{bitmap.format("albedo", "porcelain.png", "")}</bsdf>',
        "constant_color": '<bsdf type="diffuse"><texture name="albedo" type="constant_color"><color name="value" value="0.75 0.42 0.2"/></texture></bsdf>',
    }
    for kind, bsdf in kinds.items():
        ball = f'<mesh type="sphere"><point name="center" value="0 0.9 0"/><float name="radius" value="0.9"/>{bsdf}</mesh>'
        yield f"texture-{kind}", scene(FLOOR, ball, LAMP, DAY), 64, 0.0
    colored = shape("ply", '<string name="filename" value="pyramid.ply"/>', TURNED,
                    '<bsdf type="diffuse"><texture name="albedo" type="mesh_attribute"/></bsdf>')
    yield "texture-mesh_attribute", scene(FLOOR, colored, LAMP, DAY), 64, 0.0


def bumps(size):
    """The heights of a field of knobs, 0 to 1."""
    x, y = np.meshgrid(np.arange(size) / size, np.arange(size) / size)
    return np.clip(np.sin(12 * np.pi * x) * np.sin(6 * np.pi * y), 0, 1)**0.5


def normals_of(heights):
    """Their normal map, the slopes being those of knobs a fiftieth as high as the picture is wide."""
    scale = heights.shape[0] / 50
    slope_y, slope_x = np.gradient(heights * scale)
    normal = np.stack([-slope_x, slope_y, np.ones_like(heights)], axis=-1)
    return 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def maps(studio):
    heights = bumps(studio.pick(512, 16))
    for name, values in (("bumps", heights), ("normals", normals_of(heights))):
        Image.fromarray((255 * values + 0.5).astype(np.uint8)).save(studio.scratch / f"{name}.png")
    gold = '<bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.2"/></bsdf>'
    file = '<string name="filename" value="{}.png"/><boolean name="raw" value="true"/>'
    kinds = {
        "normalmap": f'<texture name="normalmap" type="bitmap">{file.format("normals")}</texture>',
        "bumpmap": f'<texture name="displacement" type="bitmap">{file.format("bumps")}</texture><float name="scale" value="0.12"/>',
    }
    near = CAMERA.replace('value="38"', 'value="24"')
    for kind, texture in kinds.items():
        ball = (f'<mesh type="sphere"><point name="center" value="0 0.9 0"/><float name="radius" value="0.9"/><bsdf type="{kind}">{texture}{gold}'
                '</bsdf></mesh>')
        yield f"swatch-{kind}", scene(FLOOR, ball, LAMP, DAY, camera=near), 64, 0.0


def shoot(studio, name, text, spp, exposure, size):
    zoom = 4 if "rfilter" in name else 1  # pixels that can be told apart
    size = (size[0] // zoom, size[1] // zoom)
    path = studio.scratch / f"{name}.xml"
    path.write_text(text, encoding="utf-8")
    render = studio.render(path, name, spp=studio.pick(spp, 16), size=studio.pick(size, (8, 6)), more=["--exposure", exposure])
    picture = Image.open(render.png()).convert("RGB")
    studio.keep_image(name, picture.resize((picture.width * zoom, picture.height * zoom), Image.Resampling.NEAREST), COLORS)


def run(studio):
    (studio.scratch / "pyramid.obj").write_text(obj_text(), encoding="utf-8")
    (studio.scratch / "pyramid.ply").write_text(ply_text(), encoding="utf-8")
    studio.run(studio.sculptor, "--kind", "sky", "--height", studio.pick(256, 16), "-o", studio.scratch / "sky.hdr")
    studio.run(studio.sculptor, "--picture", "porcelain", "--size", studio.pick(512, 16), "-o", studio.scratch / "porcelain.png")
    for pictures in (integrators, cameras, samplers_and_filters, shapes, emitters, textures):
        for name, *rest in pictures():
            shoot(studio, f"plugin-{name}", *rest, SIZE)
    for name, *rest in maps(studio):
        shoot(studio, name, *rest, (96, 96))
