"""The statistics that judge two renderers' pictures find what is wrong and nothing else. No renderer is started.

Exit code 77: there is no numpy.
"""

import math
import struct
import sys
import tempfile
import unittest
import zlib

try:
    import numpy
except ModuleNotFoundError:
    sys.exit(77)

import agreement

HEIGHT, WIDTH = 60, 84


def expectation():
    """Bright above, dark below, coloured, with a lamp that has no noise at the top left."""
    rows = numpy.linspace(1.0, 0.1, HEIGHT)[:, None, None]
    return rows * numpy.array([1.0, 0.7, 0.4]) * numpy.ones((1, WIDTH, 1))


def estimate(seed, change=lambda picture: picture, pictures=3):
    """Noise as renderers make it: mostly dark with rare bright samples, stronger where the picture is bright."""
    random, out = numpy.random.default_rng(seed), agreement.Estimate()
    for _ in range(pictures):
        picture = expectation() * random.exponential(1.0, (HEIGHT, WIDTH, 3))
        picture[:5, :7] = 40.0
        out.add(change(picture))
    return out


def scaled(rows, columns, factor, channels=slice(None)):
    def change(picture):
        picture[rows, columns, channels] *= factor
        return picture

    return change


class EstimateTest(unittest.TestCase):
    def test_mean_and_variance_of_the_mean(self):
        out, values = agreement.Estimate(), (1.0, 2.0, 6.0)
        for value in values:
            out.add(numpy.full((2, 3, 3), value))
        self.assertTrue(numpy.allclose(out.mean, 3.0))
        self.assertTrue(numpy.allclose(out.variance(), 7.0 / 3.0))  # sample variance 7, of three

    def test_too_few_pictures(self):
        self.assertIsNone(estimate(1, pictures=1).variance())
        with self.assertRaisesRegex(ValueError, '3 at least'):
            agreement.compare(estimate(1, pictures=2), estimate(2))
        with self.assertRaisesRegex(ValueError, '3 at least'):
            agreement.compare(estimate(1), estimate(2, pictures=2))

    def test_other_sizes(self):
        small = agreement.Estimate()
        for _ in range(3):
            small.add(numpy.ones((6, 8, 3)))
        with self.assertRaisesRegex(ValueError, '8 × 6'):
            agreement.compare(small, estimate(1))
        with self.assertRaisesRegex(ValueError, '84 × 60 after one of 8 × 6'):
            small.add(numpy.ones((HEIGHT, WIDTH, 3)))


class CompareTest(unittest.TestCase):
    def test_chance_alone_is_chance_alone(self):
        """Of 20 pairs: deviation of z about 1, intervals hold 95 %, the largest z is below its bound but for a few."""
        results = [agreement.compare(estimate(2 * i), estimate(2 * i + 1)) for i in range(20)]
        self.assertTrue(all(agreement.agrees(r, 0.0) for r in results))
        self.assertAlmostEqual(sum(r['z_deviation'] for r in results) / len(results), 1.0, delta=0.05)
        self.assertLessEqual(sum(r['z_largest'] > r['z_largest_expected'] for r in results), 2)
        inside = sum(abs(b) <= h for r in results for b, h in zip(r['brighter'], r['brighter_95']))
        self.assertGreaterEqual(inside, 50)  # of 60
        self.assertEqual(results[0]['blocks'], 3 * (144 - 1), 'the lamp has no noise')

    def test_a_brighter_picture(self):
        result = agreement.compare(estimate(1, lambda p: 1.1 * p), estimate(2))
        for channel in range(3):
            self.assertGreater(result['brighter'][channel] - result['brighter_95'][channel], 0.01)
        self.assertFalse(agreement.agrees(result, 0.01))

    def test_a_wrong_channel(self):
        result = agreement.compare(estimate(1, scaled(slice(None), slice(None), 1.1, 2)), estimate(2))
        self.assertLess(abs(result['brighter'][1]), 0.05)
        self.assertFalse(agreement.agrees(result, 0.01))

    def test_a_wrong_block_though_the_mean_is_right(self):
        """One block of 144 twice as bright changes the mean by less than one percent."""
        result = agreement.compare(estimate(1, scaled(slice(50, 55), slice(70, 77), 2.5)), estimate(2))
        self.assertLess(max(map(abs, result['brighter'])), 0.03)
        self.assertEqual(result['z_largest_at'], [10, 10])
        self.assertGreater(result['z_largest'], result['z_largest_expected'])
        self.assertFalse(agreement.agrees(result, 0.01))

    def test_a_wrong_block_without_noise(self):
        result = agreement.compare(estimate(1, scaled(slice(0, 5), slice(0, 7), 1.05)), estimate(2))
        self.assertGreater(result['worst_excess'], 0.04)
        self.assertFalse(agreement.agrees(result, 0.01))
        self.assertTrue(agreement.agrees(result, 0.06))

    def test_pictures_without_any_noise(self):
        both = [agreement.Estimate(), agreement.Estimate()]
        for one in both:
            for _ in range(3):
                one.add(expectation())
        result = agreement.compare(*both)
        self.assertEqual((result['blocks'], result['z_deviation']), (0, None))
        self.assertTrue(agreement.agrees(result, 0.0))

    def test_rounding_is_no_noise(self):
        both = [agreement.Estimate(), agreement.Estimate()]
        random = numpy.random.default_rng(1)
        for one in both:
            for _ in range(3):
                one.add(expectation() * (1.0 + 1e-7 * random.standard_normal((HEIGHT, WIDTH, 3))))
        self.assertEqual(agreement.compare(*both)['blocks'], 0)

    def test_not_a_number(self):
        def spoil(picture):
            picture[3, 4, 1] = math.nan
            return picture

        with self.assertRaisesRegex(ValueError, 'not finite'):
            agreement.compare(estimate(1, spoil), estimate(2))

    def test_the_largest_of_many(self):
        self.assertAlmostEqual(agreement.largest_expected(1), 2.5758, places=3)
        self.assertAlmostEqual(agreement.largest_expected(432), 4.23, delta=0.02)


def exr_file(compression):
    """A picture of 2 × 3 pixels, channels A, B, G and R, as scan lines; B is the column, G the row, R is 7."""

    def attribute(name, kind, value):
        return name.encode() + b'\0' + kind.encode() + b'\0' + struct.pack('<i', len(value)) + value

    channels = b''.join(name + b'\0' + struct.pack('<iiii', 2, 0, 1, 1) for name in (b'A', b'B', b'G', b'R')) + b'\0'
    window = struct.pack('<4i', 0, 0, 1, 2)
    header = (
        b'\x76\x2f\x31\x01\x02\0\0\0'
        + attribute('channels', 'chlist', channels)
        + attribute('compression', 'compression', bytes([compression]))
        + attribute('dataWindow', 'box2i', window)
        + b'\0'
    )
    rows = [b''.join(struct.pack('<2f', *line) for line in ((1, 1), (0, 1), (y, y), (7, 7))) for y in range(3)]
    blocks = rows if compression == 0 else [b''.join(rows)]
    if (
        compression == 3
    ):  # even bytes before odd ones, differences of neighbours plus 128, zlib; kept raw where that is longer
        parted = blocks[0][0::2] + blocks[0][1::2]
        steps = parted[:1] + bytes((b - a + 128) & 255 for a, b in zip(parted, parted[1:]))
        blocks = [min(zlib.compress(steps), blocks[0], key=len)]
    offsets, at = b'', len(header) + 8 * len(blocks)
    for block in blocks:
        offsets += struct.pack('<Q', at)
        at += 8 + len(block)
    return header + offsets + b''.join(struct.pack('<ii', y, len(block)) + block for y, block in enumerate(blocks))


class ReadTest(unittest.TestCase):
    def test_pfm_begins_at_the_bottom(self):
        for scale, order in ((-1.0, '<'), (1.0, '>')):
            with tempfile.NamedTemporaryFile(suffix='.pfm') as file:
                file.write(
                    f'PF\n2 3\n{scale}\n'.encode()
                    + b''.join(struct.pack(order + '3f', 7, 2 - row, column) for row in range(3) for column in range(2))
                )
                file.flush()
                picture = agreement.read_picture(file.name)
            self.assertEqual(picture.shape, (3, 2, 3))
            self.assertEqual(picture[2, 1].tolist(), [7.0, 2.0, 1.0])
        with tempfile.NamedTemporaryFile(suffix='.pfm') as file:
            file.write(b'Pf\n2 3\n-1\n')
            file.flush()
            with self.assertRaisesRegex(ValueError, 'no PFM picture'):
                agreement.read_picture(file.name)

    def test_pictures_of_other_programs(self):
        """Other channels beside the colours, no standard errors, with compression and without."""
        for compression in (0, 3):
            with tempfile.NamedTemporaryFile(suffix='.exr') as file:
                file.write(exr_file(compression))
                file.flush()
                picture = agreement.read_picture(file.name)
            self.assertEqual(picture.shape, (3, 2, 3))
            self.assertEqual(picture[2, 1].tolist(), [7.0, 2.0, 1.0])


if __name__ == '__main__':
    unittest.main()
