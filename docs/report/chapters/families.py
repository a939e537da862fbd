"""The pictures of docs/lights.md, cameras.md, integrators.md and aovs.md: small ones, a row or sheet for each page."""
import numpy as np
from PIL import Image

import exr

SHEETS = {
    # page: (size of a picture, samples, columns, [(scene, definitions)])
    "page-lights": ((300, 169), 64, 2, [("stage", []), ("lights/noon", []), ("lights/light-probe", []), ("lamps", [])]),
    "page-cameras": ((300, 169), 64, 2, [("cameras/depth-of-field", []), ("cameras/depth-of-field", ["camera.apertureRadius=0"]),
                                         ("lights/noon", ["camera.type=spherical"]), ("stage", ["camera.type=orthographic"])]),
    "page-integrators": ((200, 150), 64, 3, [
        ("cbox-sphere", []), ("cbox-sphere", ["integrator.type=direct"]), ("cbox-sphere", ["integrator.type=whitted"]),
        ("cbox-sphere", ["integrator.type=ao"]), ("cbox-sphere", ["integrator.type=normals"]),
        ("cbox-sphere", ["integrator.type=depth"])]),
}  # yapf: disable
AOVS = ["depth", "position", "shading_normal", "uv", "instance", "material", "normal", "albedo", "direct", "indirect"]


def sheet(tiles, columns):
    """Pictures of one size, row by row, a white line between them."""
    height, width = tiles[0].shape[:2]
    rows = -(-len(tiles) // columns)
    out = np.full((rows * (height + 4) - 4, columns * (width + 4) - 4, 3), 255, np.uint8)
    for i, tile in enumerate(tiles):
        y, x = i // columns * (height + 4), i % columns * (width + 4)
        out[y:y + height, x:x + width] = tile
    return out


def keep_sheet(studio, name, tiles, columns):
    path = studio.scratch / f"{name}.png"
    Image.fromarray(sheet(tiles, columns)).save(path)
    studio.keep_picture(name, path)


def tile_of(picture):
    return np.asarray(Image.open(picture).convert("RGB"))


def colours(numbers):
    """A colour of its own for each number; black for none."""
    turns = (numbers.astype(np.float64) * 0.618034) % 1.0
    hue = np.stack([np.clip(np.abs((turns + shift) % 1.0 * 6 - 3) - 1, 0, 1) for shift in (0.0, 2 / 3, 1 / 3)], axis=-1)
    return np.where(numbers[..., None] > 0, 0.25 + 0.75 * hue, 0.0)


def shown(name, planes):
    """One AOV as an array between 0 and 1."""
    layer = [planes[f"{name}.{letter}"] for letter in "RGBXYZUV" if f"{name}.{letter}" in planes]
    if name in ("instance", "material"):
        return colours(layer[0])
    values = np.stack([plane.astype(np.float64) for plane in layer] + [np.zeros_like(layer[0], np.float64)] * (3 - len(layer)), axis=-1)
    if name == "depth":
        depth = values[..., 0]
        met = depth < 1e9
        near, far = depth[met].min(), depth[met].max()
        return np.repeat(np.where(met, 1 - 0.9 * (depth - near) / (far - near), 0.0)[..., None], 3, axis=-1)
    if name == "position":
        return np.clip(values - np.floor(values.min()), 0, None) % 1.0
    if name in ("normal", "shading_normal"):
        return 0.5 + 0.5 * values
    return values if name != "uv" else values % 1.0


def aovs(studio):
    size = studio.pick((200, 150), (20, 15))
    render = studio.render("cbox-sphere", "page-aovs", spp=studio.pick(256, 2), size=size, device=studio.pick(None, "reference"),
                           more=["--aov", ",".join(AOVS)])
    planes = exr.read(render.path)
    tiles = []
    for name in AOVS:
        values = np.clip(shown(name, planes), 0.0, 1.0)
        linear = name in ("albedo", "direct", "indirect")
        encoded = np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055) if linear else values
        tiles.append((255 * encoded + 0.5).astype(np.uint8))
    keep_sheet(studio, "page-aovs", tiles, 5)


def turntable(studio):
    tiles = [tile_of(studio.render("cameras/turntable", f"page-turntable-{second}", spp=studio.pick(64, 1), size=studio.pick((203, 114), (20, 12)),
                                   device=studio.pick(None, "reference"), more=["--at", str(second)]).png()) for second in range(4)]  # yapf: disable
    keep_sheet(studio, "page-turntable", tiles, 4)


def run(studio):
    for name, (size, spp, columns, scenes) in SHEETS.items():
        size = studio.pick(size, (size[0] // 10, size[1] // 10))
        tiles = [tile_of(studio.render(scene, f"{name}-{i}", spp=studio.pick(spp, 1), size=size, define=define,
                                       device=studio.pick(None, "reference")).png())
                 for i, (scene, define) in enumerate(scenes)]  # yapf: disable
        keep_sheet(studio, name, tiles, columns)
    turntable(studio)
    aovs(studio)
