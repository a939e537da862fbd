"""One rendered swatch a material, and ladders of parameters: docs/materials.md."""
import xml.etree.ElementTree as xml

from PIL import Image

CELL = 2.4  # scene units from one ball to the next
COLORS = 128  # of a swatch: it stays at some kilobytes
SAND = {"base_color": "0.82 0.6 0.32"}

# By the word in the scene file; what follows are its properties, and a list for what stands in an adapter.
SWATCHES = {
    "diffuse": ("diffuse", {"albedo": "0.7 0.25 0.1"}),
    "mirror": ("mirror", {}),
    "dielectric": ("dielectric", {}),
    "microfacet": ("microfacet", {"kd": "0.1 0.45 0.15", "alpha": 0.2}),
    "conductor": ("conductor", {"material": "Au"}),
    "roughconductor": ("roughconductor", {"material": "Cu", "distribution": "ggx", "alpha": 0.25}),
    "roughdielectric": ("roughdielectric", {"distribution": "ggx", "alpha": 0.15}),
    "thindielectric": ("thindielectric", {}),
    "plastic": ("plastic", {"diffuse_reflectance": "0.7 0.08 0.06", "nonlinear": True}),
    "roughplastic": ("roughplastic", {"diffuse_reflectance": "0.06 0.16 0.6", "alpha": 0.2}),
    "principled": ("principled", {"base_color": "0.05 0.12 0.42", "metallic": 0.75, "roughness": 0.45, "clearcoat": 1.0, "clearcoat_gloss": 0.9}),
    "principledthin": ("principledthin", {"base_color": "0.9 0.82 0.62", "roughness": 0.7, "diff_trans": 1.0}),
    "gltf": ("gltf", {"metallic": 0.0, "roughness": 0.2, **SAND, "clearcoat": 1.0}),
    "gltf-sheen": ("gltf", {"metallic": 0.0, "roughness": 0.9, "base_color": "0.16 0.01 0.05", "sheen_color": "0.85 0.3 0.45",
                            "sheen_roughness": 0.4}),
    "gltf-film": ("gltf", {"base_color": "0.56 0.54 0.5", "roughness": 0.3, "iridescence": 1.0, "iridescence_ior": 2.0}),
    "gltf-solid": ("gltf", {"metallic": 0.0, "roughness": 0.1, "transmission": 1.0, "thin": False, "attenuation_color": "0.9 0.5 0.1",
                            "attenuation_distance": 0.8}),
    "gltf-leaf": ("gltf", {"metallic": 0.0, "roughness": 0.5, "base_color": "0.2 0.4 0.08", "diffuse_transmission": 0.6,
                           "diffuse_transmission_color": "0.5 0.7 0.1"}),
    "mask": ("mask", {"opacity": "checkerboard"}, [("twosided", {}, [("roughconductor", {"material": "Cr", "alpha": 0.2})])]),
    "blend": ("blend", {"weight": 0.5}, [("diffuse", {"albedo": "0.7 0.25 0.1"}), ("conductor", {"material": "Ag"})]),
    "twosided": ("twosided", {}, [("diffuse", {"albedo": "0.3 0.35 0.6"})]),
}

STEPS = [i / 6 for i in range(7)]
LADDERS = {
    "roughness": [("gltf", {**SAND, "metallic": 1.0, "roughness": x}) for x in STEPS],
    "index": [("gltf", {"metallic": 0.0, "roughness": 0.0, "transmission": 1.0, "thin": False, "ior": x})
              for x in (1.02, 1.1, 1.2, 1.33, 1.5, 1.8, 2.4)],
    "metallic": [("gltf", {**SAND, "metallic": x, "roughness": 0.3}) for x in STEPS],
    "sheen": [("gltf", {"metallic": 0.0, "roughness": 1.0, "base_color": "0.05 0.05 0.12", "sheen_color": "0.6 0.6 0.9", "sheen_roughness": x})
              for x in (0.1, *STEPS[1:])],
    "film": [("gltf", {"base_color": "0.6 0.6 0.6", "roughness": 0.25, "iridescence": 1.0, "iridescence_ior": 1.8,
                       "iridescence_thickness": x}) for x in (100, 200, 300, 400, 500, 700, 900)],
}


def add_property(parent, name, value):
    if value == "checkerboard":
        texture = xml.SubElement(parent, "texture", type="checkerboard", name=name)
        xml.SubElement(texture, "color", name="color0", value="1 1 1")
        xml.SubElement(texture, "color", name="color1", value="0 0 0")
        xml.SubElement(xml.SubElement(texture, "transform", name="to_uv"), "scale", value="6 3 1")
        return
    kind = "boolean" if isinstance(value, bool) else "float" if isinstance(value, (int, float)) else "color" if " " in value else "string"
    xml.SubElement(parent, kind, name=name, value=str(value).lower() if kind == "boolean" else str(value))


def add_material(parent, material):
    bsdf = xml.SubElement(parent, "bsdf", type=material[0])
    for name, value in material[1].items():
        add_property(bsdf, name, value)
    for inner in material[2] if len(material) > 2 else ():
        add_material(bsdf, inner)


def add_wall(scene, width, height):
    """A target behind the balls, which clear ones show bent."""
    wall = xml.SubElement(scene, "mesh", type="rectangle")
    transform = xml.SubElement(wall, "transform", name="toWorld")
    xml.SubElement(transform, "scale", value=f"{2 * max(width, height)} {2 * max(width, height)} 1")
    xml.SubElement(transform, "rotate", angle="180", axis="0 1 0")
    xml.SubElement(transform, "translate", value="0 0 1.6")
    bsdf = xml.SubElement(wall, "bsdf", type="diffuse")
    texture = xml.SubElement(bsdf, "texture", type="checkerboard", name="albedo")
    xml.SubElement(texture, "color", name="color0", value="0.5 0.5 0.5")
    xml.SubElement(texture, "color", name="color1", value="0.3 0.3 0.32")
    xml.SubElement(xml.SubElement(texture, "transform", name="to_uv"), "scale", value=f"{2 * max(width, height) / 0.8} {2 * max(width, height) / 0.8} 1")


def board(rows):
    """A scene of balls in rows, seen from the front without perspective."""
    columns = max(map(len, rows))
    width, height = columns * CELL, len(rows) * CELL
    scene = xml.Element("scene")
    xml.SubElement(scene, "color", name="sky_top", value="1.1 1.15 1.25")
    xml.SubElement(scene, "color", name="sky_horizon", value="0.35 0.32 0.3")
    integrator = xml.SubElement(scene, "integrator", type="path")
    xml.SubElement(integrator, "integer", name="maxDepth", value="10")
    camera = xml.SubElement(scene, "camera", type="orthographic")
    transform = xml.SubElement(camera, "transform", name="toWorld")
    xml.SubElement(transform, "scale", value=f"{width / 2} {width / 2} 1")
    xml.SubElement(transform, "lookat", origin="0 0 -20", target="0 0 0", up="0 1 0")
    xml.SubElement(camera, "rfilter", type="tent")
    xml.SubElement(scene, "sampler", type="sobol")
    add_wall(scene, width, height)
    for y, row in enumerate(rows):
        for x, material in enumerate(row):
            ball = xml.SubElement(scene, "mesh", type="sphere")
            xml.SubElement(ball, "point", name="center", value=f"{width / 2 - (x + 0.5) * CELL} {height / 2 - (y + 0.5) * CELL} 0")
            xml.SubElement(ball, "float", name="radius", value="1")
            add_material(ball, material)
    lamp = xml.SubElement(scene, "mesh", type="sphere")
    xml.SubElement(lamp, "point", name="center", value=f"{width} {height + 8} -26")
    xml.SubElement(lamp, "float", name="radius", value="9")
    xml.SubElement(xml.SubElement(lamp, "bsdf", type="diffuse"), "color", name="albedo", value="0 0 0")
    xml.SubElement(xml.SubElement(lamp, "emitter", type="area"), "color", name="radiance", value="8 7.5 7")
    return xml.ElementTree(scene), columns, len(rows)


def shoot(studio, name, rows):
    """The board's picture, and how many pixels a cell has."""
    tree, columns, lines = board(rows)
    path = studio.scratch / f"{name}.xml"
    tree.write(path)
    cell = studio.pick(96, 8)
    render = studio.render(path, name, spp=studio.pick(64, 1), size=(columns * cell, lines * cell))
    return Image.open(render.png()).convert("RGB"), cell


def run(studio):
    names, columns = list(SWATCHES), 5
    rows = [[SWATCHES[name] for name in names[i:i + columns]] for i in range(0, len(names), columns)]
    picture, cell = shoot(studio, "swatches", rows)
    for i, name in enumerate(names):
        left, top = i % columns * cell, i // columns * cell
        studio.keep_image(f"swatch-{name}", picture.crop((left, top, left + cell, top + cell)), COLORS)
    picture, cell = shoot(studio, "ladders", list(LADDERS.values()))
    for i, name in enumerate(LADDERS):
        studio.keep_image(f"ladder-{name}", picture.crop((0, i * cell, picture.width, (i + 1) * cell)), COLORS)
