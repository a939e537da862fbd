/// film_add on the device against FilmPixel::add on the host, bit for bit.

#include <bit>
#include <cmath>
#include <limits>

#include "device_test.h"
#include "image/film.h"

namespace etendue::test {
namespace {

class DeviceFilm : public DeviceTest {
 protected:
  // Adds each run of kFilmSequence samples to a pixel on both sides and compares the 128 bytes.
  void compare(const std::vector<gpu::FilmCase>& cases) {
    const auto slots = run<FilmPixel>({kernels::film_sums, "film_sums", nullptr, {}}, cases, gpu::kFilmSequence);
    for (std::size_t i = 0; i < slots.size(); ++i) {
      FilmPixel expected;
      for (std::size_t k = 0; k < gpu::kFilmSequence; ++k) {
        const gpu::FilmCase& c = cases[i * gpu::kFilmSequence + k];
        expected.add(c.rgb, c.exponent);
      }
      ASSERT_EQ(slots[i], expected) << "sequence " << i << " with exponent " << cases[i * gpu::kFilmSequence].exponent
                                    << " beginning with " << cases[i * gpu::kFilmSequence].rgb.r;
    }
  }
};

// Fills up to whole sequences with zeros.
void pad(std::vector<gpu::FilmCase>& cases, int exponent) {
  while (cases.size() % gpu::kFilmSequence != 0) cases.push_back({glm::vec3(0.0f), exponent});
}

TEST_F(DeviceFilm, EdgesOfTheNumberFormat) {
  for (const int exponent : {0, 6, -20, 40, 66, -60}) {
    std::vector<gpu::FilmCase> cases;
    const auto add = [&](float x) {
      for (const float v : {x, -x}) {
        cases.push_back({{v, 1.0f, 0.5f}, exponent});
        cases.push_back({{-0.25f, v, v}, exponent});
        pad(cases, exponent);
      }
    };
    constexpr float kInf = std::numeric_limits<float>::infinity();
    for (const float x : {0.0f, std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::min(), 1.0f,
                          std::numeric_limits<float>::max(), kInf, std::numeric_limits<float>::quiet_NaN()}) {
      add(x);
    }
    // Around the unit of the film, the limb borders and the first value that is refused.
    for (const int power : {-56, -33, -32, -31, -24, -1, 0, 8, 23, 24, 25}) {
      const float x = std::ldexp(1.0f, power + exponent);
      if (!std::isfinite(x)) continue;
      add(x), add(std::nextafter(x, 0.0f)), add(std::nextafter(x, kInf));
    }
    compare(cases);
  }
}

TEST_F(DeviceFilm, EveryShiftOfEveryMantissaPattern) {
  std::vector<gpu::FilmCase> cases;
  for (const std::uint32_t mantissa : {0u, 1u, 0x7fffffu, 0x400000u, 0x2aaaaau, 0x555555u}) {
    for (std::uint32_t biased = 0; biased < 256; ++biased) {
      for (const std::uint32_t sign : {0u, 1u}) {
        const float x = std::bit_cast<float>(sign << 31 | biased << 23 | mantissa);
        cases.push_back({{x, 0.0f, 0.0f}, 3});
        cases.push_back({{0.0f, -x, x * 0.5f}, 3});
        pad(cases, 3);
      }
    }
  }
  compare(cases);
}

TEST_F(DeviceFilm, CarriesRunThroughAllLimbs) {
  // Long sums of large values of both signs: every carry of the sums and of the squares happens.
  Random random(1);
  std::vector<gpu::FilmCase> cases;
  const int exponent = 5;
  for (int i = 0; i < 4096; ++i) {
    for (gpu::uint k = 0; k < gpu::kFilmSequence; ++k) {
      const auto value = [&] {
        const int power = static_cast<int>(random.below(82)) - 58 + exponent;
        return std::ldexp(random.uniform(-1.0f, 1.0f), power + 1);
      };
      const float r = value(), g = value(), b = value();
      cases.push_back({{r, g, b}, exponent});
    }
  }
  compare(cases);
}

TEST_F(DeviceFilm, ArbitraryBitPatterns) {
  Random random(2);
  std::vector<gpu::FilmCase> cases;
  for (int i = 0; i < 1 << 16; ++i) {
    const auto bits = [&] { return std::bit_cast<float>(random.word()); };
    const float r = bits(), g = bits(), b = bits();
    // Two of three small, so that most samples are not refused because of their neighbours.
    cases.push_back({i % 3 == 0   ? glm::vec3(r, 0.3f, 0.1f)
                     : i % 3 == 1 ? glm::vec3(0.7f, g, 1e-9f)
                                  : glm::vec3(r, g, b),
                     12});
  }
  compare(cases);
}

}  // namespace
}  // namespace etendue::test
