"""One fixed sample, several fixed samples, several random samples a pixel, and what they are after."""
import numpy as np

NAMES = {"one": "one, in the middle", "grid": "16 on a 4×4 grid", "random": "16 at random"}


def centre_samples(studio, name, size):
    """Every sample at the middle of its pixel: a filter a millionth of a pixel wide."""

    def narrow(root):
        rfilter = root.find("camera").find("rfilter")
        rfilter.set("type", "gaussian")
        rfilter.append(rfilter.makeelement("float", {"name": "radius", "value": "1e-6"}))

    scene = studio.variant("siemens-star", "star-centre", narrow)
    return studio.render(scene, name, spp=1, size=size).rgb()[0]


def run(studio):
    size = studio.pick(160, 40)
    grid = 4
    fine = centre_samples(studio, "star-grid", (size * grid, size * grid))
    pictures = {
        "one": centre_samples(studio, "star-one", (size, size)),
        "grid": fine.reshape(size, grid, size, grid, 3).mean(axis=(1, 3)),
        "random": studio.render("siemens-star", "star-random", spp=grid * grid, size=(size, size)).rgb()[0],
    }
    wanted, noise = studio.render("siemens-star", "star-wanted", spp=studio.pick(1024, 64), size=(size, size), seed=1).rgb()
    y, x = np.mgrid[0:size, 0:size] + 0.5 - size / 2
    radius = np.hypot(x, y) / size
    rings = {"middle": radius < 0.07, "rest": (radius >= 0.07) & (radius < 0.5)}
    middle = (size // 4, size // 4, size // 2, size // 2)  # what the report shows
    rows = []
    for name, picture in pictures.items():
        studio.keep_picture(f"antialiasing-{name}", picture, crop=middle, zoom=3)
        row = {"name": NAMES[name]}
        for ring, inside in rings.items():
            row[ring] = float(np.sqrt(np.mean((picture - wanted)[inside] ** 2)))
        rows.append(row)
    studio.keep_picture("antialiasing-wanted", wanted, crop=middle, zoom=3)
    studio.keep_data("antialiasing", {"size": size, "rows": rows, "reference_error": float(np.sqrt(np.mean(noise**2)))})
