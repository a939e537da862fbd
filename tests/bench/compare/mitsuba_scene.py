"""Renders a Mitsuba scene in several independent pictures, in a Python that has the module mitsuba (3.x):

    python3 mitsuba_scene.py VARIANT SCENE.xml OUT.npy SPP PICTURES SEED

SPP samples per pixel are spread over the pictures. OUT.npy has shape [2, height, width, 3]: their mean, and its standard
error as it follows from how the pictures differ. The last line on stdout says the version, the reconstruction filter
and the samples per pixel, as JSON. Only the box filter leaves pixels independent of each other. Films without colours are
not rendered, and have the filter "grey".
"""

import json
import sys

import mitsuba
import numpy


def main():
    variant, scene_file, out, spp, pictures, seed = sys.argv[1:]
    mitsuba.set_variant(variant)
    scene = mitsuba.load_file(scene_file)
    film = scene.sensors()[0].film()
    said = {'version': f'Mitsuba {mitsuba.__version__} ({variant})', 'filter': str(film.rfilter()).split('[')[0]}
    if 'luminance' in str(film):
        print(json.dumps({**said, 'filter': 'grey', 'samples': 0}))
        return
    each = max(1, int(spp) // int(pictures))
    count, mean, squares = 0, 0.0, 0.0  # Welford's sums
    for picture in range(int(pictures)):
        values = numpy.array(mitsuba.render(scene, spp=each, seed=int(seed) + picture))[:, :, :3].astype(numpy.float64)
        count += 1
        step = values - mean
        mean = mean + step / count
        squares = squares + step * (values - mean)
    numpy.save(out, numpy.stack([mean, numpy.sqrt(squares / (count * (count - 1)))]))
    print(json.dumps({**said, 'samples': each * count}))


main()
