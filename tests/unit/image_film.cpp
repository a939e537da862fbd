/// The film's integers and statistics against exact rational arithmetic.

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <boost/multiprecision/cpp_int.hpp>

#include "image_testing.h"

// Boost 1.74's rationals set this off at -O2 (their small integers are a union).
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

namespace etendue {
namespace {

using boost::multiprecision::cpp_int;
using boost::multiprecision::cpp_rational;
using testing_image::error_of;

cpp_rational power_of_two(int exponent) {
  const cpp_int power = cpp_int(1) << std::abs(exponent);
  return exponent >= 0 ? cpp_rational(power) : cpp_rational(1, power);
}

/// The exact value of a finite float.
template <typename T>
cpp_rational exact(T value) {
  int exponent = 0;
  const T fraction = std::frexp(value, &exponent);
  const auto digits = static_cast<long long>(std::ldexp(fraction, 62));
  // 62 bits hold a float or double; a long double may have one or two bits more.
  const auto rest = static_cast<long long>(std::ldexp(std::ldexp(fraction, 62) - static_cast<T>(digits), 10));
  return (cpp_rational(cpp_int(digits)) + cpp_rational(cpp_int(rest), 1024)) * power_of_two(exponent - 62);
}

cpp_int truncate(const cpp_rational& x) {
  return numerator(x) / denominator(x);
}

cpp_int signed_sum(const std::array<std::uint32_t, 4>& limbs) {
  cpp_int value = 0;
  for (int i = 3; i >= 0; --i) value = (value << 32) + limbs[static_cast<std::size_t>(i)];
  return (limbs[3] >> 31) != 0 ? cpp_int(value - (cpp_int(1) << 128)) : value;
}

cpp_int unsigned_sum(const std::array<std::uint32_t, 6>& limbs) {
  cpp_int value = 0;
  for (int i = 5; i >= 0; --i) value = (value << 32) + limbs[static_cast<std::size_t>(i)];
  return value;
}

/// The same bookkeeping as the film's, written with rationals.
struct Oracle {
  explicit Oracle(int film_exponent) : exponent(film_exponent) {}

  void add(const glm::vec3& rgb) {
    for (int c = 0; c < 3; ++c) {
      if (!std::isfinite(rgb[c]) || abs(exact(rgb[c])) >= power_of_two(exponent + 24)) {
        ++rejected;
        return;
      }
    }
    ++count;
    for (int c = 0; c < 3; ++c) {
      const cpp_int q = truncate(exact(rgb[c]) * power_of_two(56 - exponent));
      sum[c] += q;
      squares[c] += q * q;
    }
  }

  cpp_rational mean(int c) const { return cpp_rational(sum[c], count) * power_of_two(exponent - 56); }
  cpp_rational variance(int c) const {
    return cpp_rational(count * squares[c] - sum[c] * sum[c], cpp_int(count) * (count - 1)) *
           power_of_two(2 * (exponent - 56));
  }

  int exponent;
  std::uint32_t count = 0, rejected = 0;
  std::array<cpp_int, 3> sum, squares;
};

void expect_equal(const FilmPixel& pixel, const Oracle& oracle) {
  EXPECT_EQ(pixel.count, oracle.count);
  EXPECT_EQ(pixel.rejected, oracle.rejected);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(signed_sum(pixel.sum[c]), oracle.sum[c]) << "channel " << c;
    EXPECT_EQ(unsigned_sum(pixel.sum_squares[c]), oracle.squares[c]) << "channel " << c;
  }
}

/// No other T is nearer to x, and at a tie the last bit of `rounded` is even.
template <typename T>
void expect_nearest(T rounded, const cpp_rational& x) {
  const cpp_rational error = abs(exact(rounded) - x);
  for (const T direction : {-std::numeric_limits<T>::infinity(), std::numeric_limits<T>::infinity()}) {
    const T neighbour = std::nextafter(rounded, direction);
    if (std::isinf(neighbour)) continue;
    const cpp_rational other = abs(exact(neighbour) - x);
    EXPECT_LE(error, other) << rounded << " is not the nearest to " << static_cast<long double>(x);
    if constexpr (sizeof(T) == 4) {
      if (error == other) {
        EXPECT_EQ(std::bit_cast<std::uint32_t>(rounded) & 1u, 0u) << rounded << " breaks a tie to odd";
      }
    }
  }
}

/// `rounded` is sqrt(square) rounded to nearest: sqrt(square) lies between the midpoints to the neighbours.
void expect_nearest_root(float rounded, const cpp_rational& square) {
  const float above = std::nextafter(rounded, std::numeric_limits<float>::infinity());
  if (!std::isinf(above)) {
    const cpp_rational middle = (exact(rounded) + exact(above)) / 2;
    EXPECT_LE(square, cpp_rational(middle * middle)) << rounded << " is too small";
  }
  if (rounded > 0) {
    const cpp_rational middle = (exact(rounded) + exact(std::nextafter(rounded, 0.0f))) / 2;
    EXPECT_GE(square, cpp_rational(middle * middle)) << rounded << " is too large";
  }
}

/// Floats at which an accumulator could go wrong: ends of the formats and both sides of the film's limits.
std::vector<float> nasty_floats(int exponent) {
  using Limits = std::numeric_limits<float>;
  std::vector<float> values = {0.0f,
                               -0.0f,
                               1.0f,
                               Limits::denorm_min(),
                               std::nextafter(Limits::min(), 0.0f),
                               Limits::min(),
                               Limits::max(),
                               Limits::infinity(),
                               Limits::quiet_NaN(),
                               Limits::signaling_NaN(),
                               0.1f,
                               std::bit_cast<float>(0x7f800001u),
                               std::bit_cast<float>(0xffffffffu)};
  // The unit, half of it, the largest value whose shift is not to the right, the exponent itself, the limit.
  for (const int power :
       {exponent - 57, exponent - 56, exponent - 33, exponent - 32, exponent, exponent + 23, exponent + 24}) {
    const float v = std::ldexp(1.0f, power);
    values.insert(values.end(), {v, std::nextafter(v, 0.0f), std::nextafter(v, Limits::infinity())});
  }
  const std::size_t count = values.size();
  for (std::size_t i = 0; i < count; ++i) values.push_back(-values[i]);
  return values;
}

const std::vector<int> kExponents = {-149, -126, -100, -31, -1, 0, 1, 8, 33, 64, 103, 104, 127, 128};

TEST(Film, AddsEveryFloatExactly) {
  for (const int exponent : kExponents) {
    for (const float value : nasty_floats(exponent)) {
      SCOPED_TRACE(::testing::Message() << "exponent " << exponent << " bits " << std::bit_cast<std::uint32_t>(value));
      FilmPixel pixel;
      Oracle oracle(exponent);
      for (const glm::vec3& rgb : {glm::vec3(value), glm::vec3(value), glm::vec3(0.0f, value, 0.0f)}) {
        pixel.add(rgb, exponent);
        oracle.add(rgb);
      }
      expect_equal(pixel, oracle);
    }
  }
}

TEST(Film, AddsRandomBitPatternsExactly) {
  std::mt19937 random(1);
  for (const int exponent : kExponents) {
    FilmPixel pixel;
    Oracle oracle(exponent);
    for (int i = 0; i < 1000; ++i) {
      // Patterns spread over the accepted powers of two, else nearly all would be rejected or zero.
      glm::vec3 rgb;
      for (int c = 0; c < 3; ++c) {
        const float fraction = std::bit_cast<float>(static_cast<std::uint32_t>(random() & 0x807fffffu) | 0x3f800000u);
        rgb[c] = std::ldexp(fraction, exponent + 25 - static_cast<int>(random() % 110));
      }
      pixel.add(rgb, exponent);
      oracle.add(rgb);
    }
    EXPECT_GT(pixel.count, 200u);
    EXPECT_GT(pixel.rejected, 0u);
    expect_equal(pixel, oracle);
  }
}

TEST(Film, RejectsFromTheLimitOn) {
  const float limit = std::ldexp(1.0f, 2 + 24);
  FilmPixel pixel;
  pixel.add(glm::vec3(std::nextafter(limit, 0.0f), 1.0f, -std::nextafter(limit, 0.0f)), 2);
  EXPECT_EQ(pixel.count, 1u);
  const FilmPixel before = pixel;
  for (const glm::vec3& rgb :
       {glm::vec3(limit, 0, 0), glm::vec3(0, -limit, 0), glm::vec3(0, 0, INFINITY), glm::vec3(0, 0, NAN)}) {
    pixel.add(rgb, 2);
  }
  EXPECT_EQ(pixel.rejected, 4u);
  FilmPixel sums = pixel;
  sums.rejected = 0;
  EXPECT_EQ(sums, before) << "a rejected sample left something in the sums";
}

TEST(Film, GivesTheSameBytesInAnyOrderAndGrouping) {
  std::vector<glm::vec3> samples;
  for (std::uint64_t s = 0; s < 500; ++s) samples.push_back(testing_image::synthetic_sample(3, s));
  samples.push_back(glm::vec3(1e7f, -1e7f, 1e-30f));
  FilmPixel once;
  for (const glm::vec3& sample : samples) once.add(sample, 3);

  std::mt19937 random(2);
  for (int round = 0; round < 20; ++round) {
    std::shuffle(samples.begin(), samples.end(), random);
    std::vector<FilmPixel> parts(1 + random() % 7);
    for (const glm::vec3& sample : samples) parts[random() % parts.size()].add(sample, 3);
    std::shuffle(parts.begin(), parts.end(), random);
    while (parts.size() > 1) {  // merge neighbours: a random tree, not a chain
      const std::size_t i = random() % (parts.size() - 1);
      parts[i].merge(parts[i + 1]);
      parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
    EXPECT_EQ(parts[0], once);
  }
}

TEST(Film, RoundsMeanAndStandardErrorOnce) {
  std::mt19937 random(3);
  for (const int exponent : kExponents) {
    for (int n = 1; n < 40; ++n) {
      Film film(1, 1, exponent);
      Oracle oracle(exponent);
      const int spread = n % 3 == 0 ? 2 : n % 3 == 1 ? 20 : 80;
      for (int i = 0; i < n; ++i) {
        glm::vec3 rgb;
        for (int c = 0; c < 3; ++c) {
          const float fraction = std::bit_cast<float>(static_cast<std::uint32_t>(random() & 0x807fffffu) | 0x3f800000u);
          rgb[c] = std::ldexp(fraction, exponent + 22 - static_cast<int>(random() % static_cast<unsigned>(spread)));
        }
        if (exponent + 22 > 127) rgb = glm::vec3(std::ldexp(rgb.x, -24));
        film.pixels()[0].add(rgb, exponent);
        oracle.add(rgb);
      }
      if (oracle.count == 0) continue;
      for (int c = 0; c < 3; ++c) {
        expect_nearest(film.mean(0)[c], oracle.mean(c));
        const Moments m = moments(film.pixels()[0], c, exponent);
        EXPECT_EQ(m.n, oracle.count);
        expect_nearest(m.mean, oracle.mean(c));
        if (oracle.count < 2) continue;
        expect_nearest_root(film.standard_error(0)[c], oracle.variance(c) / oracle.count);
        expect_nearest(m.variance, oracle.variance(c));
      }
    }
  }
}

TEST(Film, MeanBreaksTiesToEven) {
  // 1 + 2^-24 lies half way between 1 and its successor, 1 + 3 · 2^-24 between two later floats.
  for (const auto& [a, b] : {std::pair{1.0f, 1.0f + 0x1p-23f}, std::pair{1.0f + 0x1p-23f, 1.0f + 0x1p-22f}}) {
    Film film(1, 1, 0);
    film.pixels()[0].add(glm::vec3(a), 0);
    film.pixels()[0].add(glm::vec3(b), 0);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(film.mean(0).x) & 1u, 0u);
    expect_nearest(film.mean(0).x, (exact(a) + exact(b)) / 2);
  }
}

TEST(Film, ConstantSamplesHaveNoVarianceAtAll) {
  for (const glm::vec3& value :
       {glm::vec3(0.1f, -0.1f, 1e-12f), glm::vec3(1.0f / 3.0f, 1e6f, -8388607.0f), glm::vec3(0.0f)}) {
    Film film(1, 1, 0);
    for (int n = 1; n <= 1000; ++n) {
      film.pixels()[0].add(value, 0);
      if (n < 2) continue;
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(film.standard_error(0)[c], 0.0f);
        ASSERT_EQ(moments(film.pixels()[0], c, 0).variance, 0.0L);
      }
    }
    EXPECT_EQ(film.mean(0).x, value.x);
    EXPECT_EQ(film_moments(film, 0).variance, 0.0L);
  }
}

TEST(Film, OneDifferentLastBitIsSeenInAMillionSamples) {
  Film film(1, 1, 0);
  const glm::vec3 value(0.7f);
  for (int n = 0; n < 1000000; ++n) film.pixels()[0].add(value, 0);
  film.pixels()[0].add(glm::vec3(std::nextafter(0.7f, 1.0f)), 0);
  // variance = d² / N for one deviation d among N = 1000001 samples.
  const long double d = static_cast<long double>(std::nextafter(0.7f, 1.0f)) - 0.7f;
  EXPECT_NEAR(static_cast<double>(moments(film.pixels()[0], 0, 0).variance / (d * d / 1000001)), 1.0, 1e-12);
}

TEST(Film, HoldsTheWidestSums) {
  // 2^32 − 1 samples of the largest magnitude 2^80 − 2^56: once all equal, once half of them negative.
  const cpp_int q = (cpp_int(1) << 80) - (cpp_int(1) << 56);
  const std::uint32_t n = 0xfffffffeu;
  const auto store = [](auto& limbs, cpp_int value) {
    if (value < 0) value += cpp_int(1) << 128;
    for (auto& limb : limbs) {
      limb = static_cast<std::uint32_t>(value & 0xffffffffu);
      value >>= 32;
    }
  };
  Film film(2, 1, 0);
  FilmPixel& pixel = film.pixels()[0];
  pixel.count = n;
  store(pixel.sum[0], q * n);
  store(pixel.sum[1], -q * n);
  store(pixel.sum[2], 0);
  for (auto& squares : pixel.sum_squares) store(squares, q * q * n);
  const float largest = std::nextafter(0x1p24f, 0.0f);
  EXPECT_EQ(film.mean(0), glm::vec3(largest, -largest, 0.0f));
  EXPECT_EQ(film.standard_error(0).x, 0.0f);
  EXPECT_EQ(film.standard_error(0).y, 0.0f);
  expect_nearest_root(film.standard_error(0).z, exact(largest) * exact(largest) / (n - 1));
  expect_nearest(moments(pixel, 2, 0).variance, exact(largest) * exact(largest) * n / (n - 1));

  film.pixels()[1] = pixel;
  std::swap(film.pixels()[1].sum[0], film.pixels()[1].sum[1]);
  const Moments all = film_moments(film, 0);
  EXPECT_EQ(all.n, 2 * std::uint64_t{n});
  EXPECT_EQ(all.mean, 0.0L);
  expect_nearest(all.variance, exact(largest) * exact(largest) * (2 * cpp_int(n)) / (2 * cpp_int(n) - 1));
}

TEST(Film, MomentsOfTheWholeFilmAreThoseOfAllItsSamples) {
  Film film(7, 5, 3);
  Oracle oracle(3);
  for (std::size_t pixel = 0; pixel < film.pixels().size(); ++pixel) {
    for (std::uint64_t s = 0; s < 11; ++s) {
      // Mostly below zero, so that the sum of the film is negative too.
      const glm::vec3 sample = testing_image::synthetic_sample(pixel, s) - glm::vec3(0.75f, 0.0f, 3.0f);
      film.pixels()[pixel].add(sample, 3);
      oracle.add(sample);
    }
  }
  EXPECT_GT(oracle.rejected, 0u);
  EXPECT_EQ(film.rejected(), oracle.rejected);
  for (int c = 0; c < 3; ++c) {
    const Moments m = film_moments(film, c);
    EXPECT_EQ(m.n, oracle.count);
    expect_nearest(m.mean, oracle.mean(c));
    expect_nearest(m.variance, oracle.variance(c));
  }
  EXPECT_LT(film_moments(film, 0).mean, 0.0L);
}

TEST(Film, SaysWhatItKnowsOfFewSamples) {
  Film film(2, 1, 0);
  EXPECT_EQ(film.mean(0), glm::vec3(0.0f));
  EXPECT_TRUE(std::isinf(film.standard_error(0).x));
  film.pixels()[1].add(glm::vec3(0.25f), 0);
  EXPECT_EQ(film.mean(1), glm::vec3(0.25f));
  EXPECT_TRUE(std::isinf(film.standard_error(1).x));
  EXPECT_EQ(moments(film.pixels()[1], 0, 0).variance, 0.0L);
  EXPECT_EQ(film_moments(Film(3, 3, 0), 0).n, 0u);
}

TEST(Film, MergesOnlyFilmsOfOneKind) {
  Film film(2, 3, 1);
  const std::string size = error_of([&] { film.merge(Film(3, 2, 1)); }, ErrorKind::usage);
  EXPECT_NE(size.find("3x2"), std::string::npos) << size;
  EXPECT_NE(size.find("2x3"), std::string::npos) << size;
  const std::string exponent = error_of([&] { film.merge(Film(2, 3, -4)); }, ErrorKind::usage);
  EXPECT_NE(exponent.find("-4"), std::string::npos) << exponent;
  const FilmFile a = testing_image::synthetic_film(4, 3, {{0, 5}}), b = testing_image::synthetic_film(4, 3, {{5, 9}});
  Film sum = a.film;
  sum.merge(b.film);
  EXPECT_EQ(sum.pixels(), testing_image::synthetic_film(4, 3, {{0, 9}}).film.pixels());
}

}  // namespace
}  // namespace etendue
