"""The pictures of README.md and docs/gallery.md."""

PICTURES = {
    # name: (size, samples per pixel), as docs/gallery.md tells its readers to make them
    "materials": ((560, 245), 160),
    "cbox-ajax": ((400, 300), 43),
    "daylight": ((560, 315), 256),
    "still-life": ((560, 420), 400),
    "forest": ((640, 360), 256),
    "material-gallery": ((640, 352), 128),
    "bubble": ((480, 270), 288),
    "cbox-sphere": ((640, 480), 400),
}


def run(studio):
    rows = []
    for name, (size, spp) in PICTURES.items():
        render = studio.render(name, name, spp=studio.pick(spp, 1), size=studio.pick(size, (size[0] // 16, size[1] // 16)))
        studio.keep_picture(name, render.png())
        rows.append({"name": name, "width": size[0], "height": size[1], "spp": spp})
    studio.keep_data("gallery", {"rows": rows})
