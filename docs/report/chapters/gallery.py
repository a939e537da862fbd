"""The pictures of README.md and docs/gallery.md."""

LARGE = (1280, 720)
MATERIALS = (560, 245)
FOLDER = "build/release/share/etendue/meshes"  # where the build puts the robot
# scene: (size, samples per pixel, further options), as docs/gallery.md tells its readers to make them
PICTURES = {
    "gallery/window": (LARGE, 256, "--tonemap aces"),
    "gallery/row": (LARGE, 192, "--tonemap aces"),
    "robot.glb": (LARGE, 192, "--tonemap aces"),
    "gallery/glass": (LARGE, 160, "--tonemap aces"),
    "gallery/hall": (LARGE, 64, "--tonemap aces --exposure 0.7"),
    "gallery/terrace": (LARGE, 48, "--tonemap aces"),
    "forest": (LARGE, 128, "-D sampler.type=sobol"),
    "still-life": (LARGE, 48, "-D sampler.type=sobol --camera 0.55,1.9,2.75,0.05,0.3,0.1,36"),
    "material-gallery": (LARGE, 80, "-D sampler.type=sobol"),
    "materials": (MATERIALS, 160, ""),
}


def run(studio):
    rows = []
    for scene, (size, spp, options) in PICTURES.items():
        asset = scene.endswith(".glb")
        name = scene.split("/")[-1].removesuffix(".glb")
        file = f"{FOLDER}/{scene}" if asset else f"scenes/{scene}.xml"
        render = studio.render(studio.asset(scene) if asset else scene, name, spp=studio.pick(spp, 1),
                               size=studio.pick(size, (size[0] // 16, size[1] // 16)), more=options.split())  # yapf: disable
        keep = studio.keep_photo if size == LARGE else studio.keep_picture
        picture = keep(name, render.png()).name
        more = f" {options}" if options else ""
        rows.append({"picture": picture, "command": f"etendue render {file} --size {size[0]}x{size[1]} --spp {spp}{more} -o {name}.png"})
    studio.keep_data("gallery", {"rows": rows})
