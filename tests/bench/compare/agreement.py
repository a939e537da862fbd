"""Whether two renderers draw the same picture: means of the whole and of blocks of it, judged by what chance explains.

Each renderer draws the picture several times with different seeds. The variance of a pixel's mean over these is
estimated from them; the variance of a block's mean follows, as pixels are independent with a box filter. Three pictures
are the fewest that will do: with two, rare bright samples that fall into the same pixel twice look like certainty, and
z of 5 to 8 is seen where chance alone is at work. Needs numpy.
"""

import math
import os
import sys

import numpy

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', '..', 'docs', 'report'))
import exr

BLOCKS = 12  # along each side
LEAST_PICTURES = 3
NORMAL_95 = 1.959964


def read_pfm(path):
    """Three floats a pixel, the bottom row first; a negative scale means little-endian."""
    with open(path, 'rb') as file:
        kind, size, scale = file.readline().strip(), file.readline().split(), float(file.readline())
        if kind != b'PF' or len(size) != 2:
            raise ValueError(f'{path} is no PFM picture in colour')
        width, height = int(size[0]), int(size[1])
        values = numpy.frombuffer(file.read(), '<f4' if scale < 0 else '>f4')
    return values.reshape(height, width, 3)[::-1].astype(numpy.float64)


def read_picture(path):
    """R, G and B of a PFM or EXR file as float64 [height, width, 3], the top row first."""
    if path.endswith('.pfm'):
        return read_pfm(path)
    planes = exr.read(path)
    return numpy.stack([planes[c].astype(numpy.float64) for c in 'RGB'], axis=-1)


def size_text(picture):
    return f'{picture.shape[1]} × {picture.shape[0]}'


class Estimate:
    """The mean of several pictures of one renderer, and the variance of that mean, pixel by pixel."""

    def __init__(self):
        self.count, self.mean, self.squares = 0, 0.0, 0.0  # squares: sum of squared deviations from the mean (Welford)

    def add(self, picture):
        if self.count and picture.shape != self.mean.shape:
            raise ValueError(f'a picture is {size_text(picture)} after one of {size_text(self.mean)}')
        self.count += 1
        step = picture - self.mean
        self.mean = self.mean + step / self.count
        self.squares = self.squares + step * (picture - self.mean)

    def variance(self):
        """Of the mean; None after one picture, which says nothing about chance."""
        return self.squares / (self.count * (self.count - 1)) if self.count > 1 else None


def block_means(values, blocks):
    """Mean of each of blocks × blocks parts of [height, width, 3], as [blocks × blocks, 3], and the pixels of each."""
    rows = [round(i * values.shape[0] / blocks) for i in range(blocks + 1)]
    columns = [round(i * values.shape[1] / blocks) for i in range(blocks + 1)]
    parts = [
        values[rows[i] : rows[i + 1], columns[j] : columns[j + 1]].reshape(-1, 3)
        for i in range(blocks)
        for j in range(blocks)
    ]
    return numpy.array([p.mean(axis=0) for p in parts]), numpy.array([len(p) for p in parts])


def largest_expected(count):
    """What the largest of |z| of `count` independent normal numbers stays below 99 times in 100."""
    level, low, high = 1.0 - 0.99 ** (1.0 / max(count, 1)), 0.0, 40.0
    for _ in range(80):
        middle = (low + high) / 2.0
        low, high = (middle, high) if math.erfc(middle / math.sqrt(2.0)) > level else (low, middle)
    return high


def compare(test, reference, blocks=BLOCKS):
    """Two Estimates of the same size, as a dictionary: per channel the means, how much brighter `test` is (a fraction)
    and the half-width of the 95 % interval of that; and z of the blocks' means, all channels together: their number,
    deviation from 0 (root mean square; chance alone makes it 1), largest magnitude, where that is (row and column of
    the block, from the top left) and what chance alone stays below in 99 of 100 pictures. `worst_excess` is the largest
    relative difference of a block beyond five standard errors. Blocks without noise (a lamp, a black sky) are judged by
    that alone. Raises ValueError for sizes that differ, pixels that are not finite, or fewer than three pictures.
    """
    fewest = min(test.count, reference.count)
    if fewest < LEAST_PICTURES:
        raise ValueError(
            f'{fewest} pictures of a renderer say too little about chance: {LEAST_PICTURES} at least are needed'
        )
    if test.mean.shape != reference.mean.shape:
        raise ValueError(f'one picture is {size_text(test.mean)}, the other {size_text(reference.mean)}')
    if not (numpy.isfinite(test.mean).all() and numpy.isfinite(reference.mean).all()):
        raise ValueError('a picture has pixels that are not finite')
    variance = test.variance() + reference.variance()
    blocks = min(blocks, *test.mean.shape[:2])
    (a, pixels), (b, _), (v, _) = (
        block_means(test.mean, blocks),
        block_means(reference.mean, blocks),
        block_means(variance, blocks),
    )
    error = numpy.sqrt(v / pixels[:, None])
    difference = a - b
    noisy = error > 1e-6 * numpy.maximum(b, 1e-12)  # else rounding is all the noise there is
    z = numpy.where(noisy, difference / numpy.where(noisy, error, 1.0), 0.0)
    excess = numpy.maximum(numpy.abs(difference) - 5.0 * error, 0.0) / numpy.maximum(b, 1e-6 * max(b.max(), 1e-12))
    mean, total_error = reference.mean.mean(axis=(0, 1)), numpy.sqrt(variance.sum(axis=(0, 1))) / (variance.size / 3)
    worst = int(numpy.abs(z).max(axis=1).argmax())
    count = int(noisy.sum())
    return {
        'mean': test.mean.mean(axis=(0, 1)).tolist(),
        'reference_mean': mean.tolist(),
        'brighter': ((test.mean.mean(axis=(0, 1)) - mean) / numpy.maximum(mean, 1e-12)).tolist(),
        'brighter_95': (NORMAL_95 * total_error / numpy.maximum(mean, 1e-12)).tolist(),
        'blocks': count,
        'z_deviation': math.sqrt((z**2).sum() / count) if count else None,
        'z_largest': float(numpy.abs(z).max()) if count else None,
        'z_largest_at': [worst // blocks, worst % blocks],
        'z_largest_expected': largest_expected(count) if count else None,
        'worst_excess': float(excess.max()),
    }


def agrees(result, tolerance):
    """Whether no mean, of the whole or of a block, is off by more than chance and the tolerance (a fraction) explain.
    Chance: twice the 95 % interval for the three means of the whole, five standard errors for a block; either is beyond
    that in one of thousands of comparisons.
    """
    return (
        all(abs(b) <= tolerance + 2.0 * half for b, half in zip(result['brighter'], result['brighter_95']))
        and result['worst_excess'] <= tolerance
    )
