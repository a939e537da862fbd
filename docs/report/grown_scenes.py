"""Scenes of as many triangles, lamps, instances or materials as asked for. `studio` has the folder `scratch`, the program `sculptor`, and the functions
`run` and `variant` of the class Studio."""
import math
import sys
from pathlib import Path

SCENES = Path(__file__).resolve().parents[2] / "scenes"
WHITE = '<color name="albedo" value="0.6, 0.6, 0.6"/>'
# With k materials the first k kinds in turn, each time with another colour.
KINDS = [
    ("diffuse", '<color name="albedo" value="{rgb}"/>'),
    ("roughconductor", '<string name="material" value="Au"/><float name="alpha" value="{number}"/>'),
    ("plastic", '<color name="diffuse_reflectance" value="{rgb}"/>'),
    ("dielectric", '<float name="intIOR" value="{index}"/>'),
    ("roughplastic", '<color name="diffuse_reflectance" value="{rgb}"/><float name="alpha" value="{number}"/>'),
    ("roughdielectric", '<float name="intIOR" value="{index}"/><float name="alpha" value="{number}"/>'),
    ("principled", '<color name="base_color" value="{rgb}"/><float name="roughness" value="{number}"/>'),
    ("conductor", '<string name="material" value="Cu"/>'),
]


def scene_file(studio, name, shapes, camera, sky=True):
    """A scene of its own in the scratch folder; `camera` is origin and target."""
    path = studio.scratch / f"{name}.xml"
    light = '<emitter type="constant"><color name="radiance" value="0.8, 0.9, 1"/></emitter>' if sky else ""
    path.write_text(
        f"""<scene>
<integrator type="path"><integer name="maxDepth" value="6"/></integrator>
<sampler type="independent"><integer name="sampleCount" value="16"/></sampler>
<camera type="perspective">
  <integer name="width" value="400"/><integer name="height" value="300"/><float name="fov" value="40"/>
  <transform name="toWorld"><lookat origin="{camera[0]}" target="{camera[1]}" up="0, 1, 0"/></transform>
  <rfilter type="box"/>
</camera>
{light}
{shapes}
</scene>
""", encoding="utf-8")  # yapf: disable
    return path


def mesh(studio, kind, triangles):
    path = studio.scratch / f"{kind}-{triangles}.obj"
    if not path.exists():
        print(f"{kind} of {triangles} triangles", file=sys.stderr, flush=True)
        studio.run(studio.sculptor, "--kind", kind, "--triangles", triangles, "-o", path)
    return path


def of_triangles(studio, count):
    """The bumpy sphere of cbox-bumpy with another number of triangles."""
    file = mesh(studio, "bumpy-sphere", count)

    def change(root):
        next(e for e in root.iter("string") if e.get("value") == "etendue:bumpy-sphere.obj").set("value", str(file))

    return studio.variant(SCENES / "cbox-bumpy.xml", f"triangles-{count}", change)


def of_lamps(studio, count):
    """Small lamps over a floor with a ball, together always as bright."""
    radiance = 3000.0 / count
    shapes = f"""<mesh type="obj"><string name="filename" value="{SCENES}/meshes/floor.obj"/><bsdf type="diffuse">{WHITE}</bsdf></mesh>
<mesh type="sphere"><point name="center" value="0.1, 0.2, -0.3"/><float name="radius" value="0.2"/><bsdf type="diffuse">{WHITE}</bsdf></mesh>
<mesh type="obj"><string name="filename" value="{mesh(studio, 'lamps', count)}"/>
  <emitter type="area"><color name="radiance" value="{radiance}, {radiance}, {radiance}"/></emitter></mesh>"""
    return scene_file(studio, f"lamps-{count}", shapes, ("0.15, 0.75, 2.1", "0, 0.02, 0.15"), sky=False)


def of_instances(studio, count):
    """Copies of a ball of 10 000 triangles on a square of fixed size, without changing how much of the picture they cover."""
    side = math.ceil(math.sqrt(count))
    scale = 0.8 / side
    file = mesh(studio, "bumpy-sphere", 10000)
    lines = ['<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="6"/></integrator>',
             '<sensor type="perspective"><float name="fov" value="40"/><transform name="to_world">'
             '<lookat origin="0, 1, 1.2" target="0, 0, 0" up="0, 1, 0"/></transform><sampler type="independent"/>'
             '<film type="hdrfilm"><integer name="width" value="400"/><integer name="height" value="300"/><rfilter type="box"/></film></sensor>',
             '<emitter type="constant"/><shape type="shapegroup" id="ball">'
             f'<shape type="obj"><string name="filename" value="{file}"/><bsdf type="diffuse"/></shape></shape>']  # yapf: disable
    for i in range(count):
        x, z = (i % side + 0.5) / side - 0.5, (i // side + 0.5) / side - 0.5
        lines.append(f'<shape type="instance"><ref id="ball"/><transform name="to_world"><rotate y="1" angle="{i * 137.5 % 360:.1f}"/>'
                     f'<scale value="{scale:.7g}"/><translate x="{x:.7g}" z="{z:.7g}"/></transform></shape>')
    path = studio.scratch / f"instances-{count}.xml"
    path.write_text("\n".join([*lines, "</scene>"]), encoding="utf-8")
    return path


def of_materials(studio, count):
    """A hundred balls that share so many materials."""
    shapes = [f'<mesh type="obj"><string name="filename" value="{SCENES}/meshes/floor.obj"/><bsdf type="diffuse">{WHITE}</bsdf></mesh>']
    for i in range(100):
        material = i % count
        kind, parameters = KINDS[material % len(KINDS)]
        share = (material + 1) / count
        parameters = parameters.format(rgb=f"{0.2 + 0.6 * share:.3f}, 0.5, {0.8 - 0.6 * share:.3f}", number=f"{0.1 + 0.4 * share:.3f}", index=f"{1.3 + 0.4 * share:.3f}")
        shapes.append(f'<mesh type="sphere"><point name="center" value="{i % 10 * 0.18 - 0.81:.3f}, 0.08, {i // 10 * 0.18 - 0.81:.3f}"/>'
                      f'<float name="radius" value="0.08"/><bsdf type="{kind}">{parameters}</bsdf></mesh>')
    return scene_file(studio, f"materials-{count}", "\n".join(shapes), ("0, 1.2, 1.9", "0, 0, 0.1"))
