"""The pictures of README.md and docs/gallery.md."""

LARGE = (1280, 720)
# scene: (size, samples per pixel, further options), as docs/gallery.md tells its readers to make them
PICTURES = {
    "gallery/window": (LARGE, 256, "--tonemap aces"),
    "still-life": (LARGE, 48, "-D sampler.type=sobol --camera 0.55,1.9,2.75,0.05,0.3,0.1,36"),
    "materials": ((560, 245), 160, ""),
    "cbox-ajax": ((400, 300), 43, ""),
    "daylight": ((560, 315), 256, ""),
    "forest": (LARGE, 128, "-D sampler.type=sobol"),
    "material-gallery": ((640, 352), 128, ""),
    "bubble": ((480, 270), 288, ""),
    "cbox-sphere": ((640, 480), 400, ""),
}


def run(studio):
    rows = []
    for scene, (size, spp, options) in PICTURES.items():
        name = scene.split("/")[-1]
        render = studio.render(scene, name, spp=studio.pick(spp, 1), size=studio.pick(size, (size[0] // 16, size[1] // 16)),
                               more=options.split())  # yapf: disable
        keep = studio.keep_photo if size == LARGE else studio.keep_picture
        file = keep(name, render.png())
        more = f" {options}" if options else ""
        rows.append({"picture": file.name, "command": f"etendue render scenes/{scene}.xml --size {size[0]}x{size[1]} --spp {spp}{more} -o {name}.png"})
    studio.keep_data("gallery", {"rows": rows})
