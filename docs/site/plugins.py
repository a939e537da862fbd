"""Pages of objects: the tables of docs/scene_format.md, which are the plugin table (tests/unit/formats_docs.cpp sees to that), each with a
picture and with what docs/conventions.md says of its formulas."""
import re
import textwrap

PAGES = {
    "scene": ("Scenes and tests", ["scene", "test"], "The root of a file."),
    "integrators": ("Integrators", ["integrator"], "What is computed for a camera ray. [More about integrators](../integrators.md)."),
    "cameras": ("Cameras", ["camera", "keyframe"], "Where rays start. [More about cameras](../cameras.md)."),
    "samplers": ("Samplers", ["sampler"], "Where random numbers come from. [More about convergence](../convergence.md)."),
    "filters": ("Filters", ["rfilter"], "How samples are weighted around the centre of a pixel. The pictures show single pixels."),
    "shapes": ("Shapes", ["mesh"], "What rays hit. Other file formats have [their](../gltf.md) [own pages](../mitsuba.md)."),
    "emitters": ("Lights", ["emitter"], "What emits light. [More about lights](../lights.md)."),
    "materials": ("Materials", ["bsdf"], "What surfaces are made of. [More pictures](../materials.md)."),
    "textures": ("Textures", ["texture"], "What varies over a surface."),
}

# What has no picture, and why. Everything else has one: images/swatch-<type>.png of a material, images/plugin-<tag>-<type>.png of others.
WITHOUT_PICTURE = {
    ("scene", ""): None, ("test", "ttest"): None, ("test", "chi2test"): None, ("keyframe", ""): None,
    ("camera", "radiancemeter"): "It measures a single number.", ("camera", "irradiancemeter"): "It measures a single number.",
    ("bsdf", "null"): "It is invisible.",
}  # yapf: disable
# What computes the same as another, and shows its picture.
SAME = {
    "integrator": {
        "path": ["path_mats", "path_ems", "path_mis", "path_simple", "path_vol", "volpath", "vol_path", "vol_path_mats", "vol_path_mis",
                 "photonmapper", "bdpt", "mlt"],
        "direct": ["direct_ems", "direct_mats", "direct_mis"],
    },
    "mesh": {"instance": ["shapegroup"]},
    "emitter": {"directional": ["distant"]},
    "texture": {"checkerboard": ["checkerboard_color", "checker"]},
    "bsdf": {"blend": ["mixture"]},
}  # yapf: disable

# Where docs/conventions.md has the formula: a heading, and how the paragraph or item begins that says it (none: the whole section).
FORMULAS = {
    ("integrator", "path"): ("Path estimator", None),
    ("integrator", "direct"): ("Integrators", "- `direct`:"),
    ("integrator", "whitted"): ("Integrators", "- `whitted`:"),
    ("integrator", "simple"): ("Integrators", "- `simple`:"),
    ("integrator", "ao"): ("Integrators", "- `ao`, `av`:"),
    ("integrator", "av"): ("Integrators", "- `ao`, `av`:"),
    ("integrator", "normals"): ("Integrators", "- `normals`:"),
    ("integrator", "depth"): ("Integrators", "- `normals`:"),
    ("integrator", "distance"): ("Integrators", "- `normals`:"),
    ("camera", "perspective"): ("Camera and filter", "Pixel (0,0)"),
    ("camera", "thinlens"): ("Camera and filter", "- `thinlens`:"),
    ("camera", "orthographic"): ("Camera and filter", "- `orthographic`:"),
    ("camera", "radiancemeter"): ("Camera and filter", "- `orthographic`:"),
    ("camera", "spherical"): ("Camera and filter", "- `spherical`:"),
    ("camera", "irradiancemeter"): ("Camera and filter", "- `irradiancemeter`:"),
    ("sampler", "independent"): ("Random numbers", None),
    ("sampler", "sobol"): ("Random numbers", None),
    ("rfilter", "box"): ("Camera and filter", "The film position"),
    ("rfilter", "tent"): ("Camera and filter", "The film position"),
    ("rfilter", "gaussian"): ("Camera and filter", "The film position"),
    ("rfilter", "mitchell"): ("Camera and filter", "The film position"),
    ("rfilter", "lanczos"): ("Camera and filter", "The film position"),
    ("mesh", "disk"): ("Warps", "- Disk:"),
    ("mesh", "cylinder"): ("Warps", "- Cylinder:"),
    ("mesh", "sphere"): ("Warps", "- Sphere from outside:"),
    ("mesh", "instance"): ("Shared meshes", None),
    ("emitter", "area"): ("Emitters", "Every primitive"),
    ("emitter", "constant"): ("Environment", "- **Gradient**:"),
    ("emitter", "envmap"): ("Environment", "- **Picture**:"),
    ("emitter", "point"): ("Lights without extent", "- **point**:"),
    ("emitter", "spot"): ("Lights without extent", "- **spot**:"),
    ("emitter", "projector"): ("Lights without extent", "- **projector**:"),
    ("emitter", "directional"): ("Lights without extent", "- **directional**:"),
    ("emitter", "sky"): ("Environment", "- **Daylight**"),
    ("emitter", "sun"): ("Environment", "- **Daylight**"),
    ("emitter", "sunsky"): ("Environment", "- **Daylight**"),
    **{("bsdf", name): ("Materials", f"- **{name}**") for name in
       ("diffuse", "mirror", "dielectric", "conductor", "roughconductor", "microfacet", "roughdielectric", "thindielectric")},
    **{("bsdf", name): ("Coats", f"- **{name}**") for name in ("plastic", "roughplastic")},
    **{("bsdf", name): ("Adapters", f"- **{name}**") for name in ("twosided", "mask", "blend", "normalmap", "bumpmap", "null")},
    ("bsdf", "principled"): ("Principled", None),
    ("bsdf", "principledthin"): ("Principled", "**principledthin**"),
    ("bsdf", "gltf"): ("glTF", None),
    ("texture", "bitmap"): ("Textures", "- **Pictures**:"),
    ("texture", "checkerboard"): ("Textures", "- **Checkerboard**:"),
    ("texture", "mesh_attribute"): ("Textures", "- **Colours of a mesh**:"),
}  # yapf: disable
# Those that have no formula: what they are is said by the table.
WITHOUT_FORMULA = {("scene", ""), ("test", "ttest"), ("test", "chi2test"), ("keyframe", ""), ("mesh", "obj"), ("mesh", "ply"),
                   ("mesh", "rectangle"), ("mesh", "parallelogram"), ("mesh", "cube"), ("texture", "constant_color")}


def original(tag, kind):
    """The type that this one is another word for, or a special case of; else itself."""
    return next((name for name, others in SAME.get(tag, {}).items() if kind in others), kind)


def picture_of(tag, kind):
    """The file in docs/images, or None."""
    if (tag, kind) in WITHOUT_PICTURE:
        return None
    kind = original(tag, kind)
    return f"swatch-{kind}.png" if tag == "bsdf" else f"plugin-{tag}-{kind}.png"


def anchor(heading):
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


class Conventions:
    """The sections of docs/conventions.md, by heading."""

    def __init__(self, text):
        parts = re.split(r"^#{2,3} (.+)$", text, flags=re.M)
        self.sections = dict(zip(parts[1::2], parts[2::2]))

    def block(self, heading, start):
        """The item or paragraph of a section that begins so."""
        blocks = re.split(r"\n(?=- )|\n\n+", self.sections[heading])
        found = [block for block in blocks if block.startswith(start)]
        if len(found) != 1:
            raise SystemExit(f"docs/conventions.md, '{heading}': {len(found)} blocks begin with '{start}'; docs/site/plugins.py expects one")
        block = found[0].removeprefix("- ")
        # Links of that page to itself and to its neighbours.
        block = re.sub(r"\]\(#", "](../conventions.md#", textwrap.dedent("\n".join(line.strip() for line in block.splitlines())))
        return re.sub(r"\]\((?!\.\./|[a-z]+:)", "](../", block)

    def formula(self, key):
        heading, start = FORMULAS[key]
        where = f"[{heading}](../conventions.md#{anchor(heading)})"
        if start is None:
            return f"**Formulas**: {where}."
        return f"**Formulas** ({where}):\n\n> " + self.block(heading, start).replace("\n", "\n> ")


def entry(tag, kind, body, conventions, root):
    """One object's part of its page."""
    shown = f"{tag} type=\"{kind}\"" if kind else tag
    out = [f"## {kind or tag}", "", f"`<{shown}>`", ""]
    picture = picture_of(tag, kind)
    if picture:
        if not (root / "docs/images" / picture).exists():
            raise SystemExit(f"docs/images/{picture} is missing; the chapters 'plugins' and 'swatches' of ./run figures make such pictures")
        said = re.split(r"[.:;]", " ".join(body.split()))[0]
        out += [f"![{kind}: {said}](../images/{picture})", ""]
    elif WITHOUT_PICTURE[tag, kind]:
        out += [WITHOUT_PICTURE[tag, kind], ""]
    out += [body.strip(), ""]
    key = (tag, original(tag, kind))
    if key in FORMULAS:
        out += [conventions.formula(key), ""]
    elif key not in WITHOUT_FORMULA:
        raise SystemExit(f"docs/site/plugins.py does not know where the formula of {shown} is")
    return "\n".join(out)


def generated(page):
    """Where the tables of docs/scene_format.md begin and end."""
    return page.index("<!-- begin generated -->"), page.index("<!-- end generated -->")


def objects_of(page):
    """(tag, type, text with the table) of every object."""
    begin, end = generated(page)
    parts = re.split(r"^### `<(\w+)(?: type=\"([^\"]+)\")?>`$", page[begin:end], flags=re.M)
    return [(parts[i], parts[i + 1] or "", parts[i + 2]) for i in range(1, len(parts), 3)]


def pictures(page):
    """The files in docs/images that the pages of objects show."""
    return {picture_of(tag, kind) for tag, kind, _ in objects_of(page)} - {None}


def split(page, root):
    """docs/scene_format.md without its tables, and the pages that have them: {name: text}."""
    begin, end = generated(page)
    conventions = Conventions((root / "docs/conventions.md").read_text(encoding="utf-8"))
    objects = objects_of(page)
    pages = {name: [f"# {title}", "", lead, ""] for name, (title, _, lead) in PAGES.items()}
    page_of = {tag: name for name, (_, tags, _) in PAGES.items() for tag in tags}
    for tag, kind, body in objects:
        if tag not in page_of:
            raise SystemExit(f"docs/site/plugins.py has no page for <{tag}>")
        pages[page_of[tag]].append(entry(tag, kind, body, conventions, root))
    where = ", ".join(f"[{title}](plugins/{name}.md)" for name, (title, _, _) in PAGES.items())
    return page[:begin] + where + "." + page[end + len("<!-- end generated -->"):], {name: "\n".join(lines) for name, lines in pages.items()}
