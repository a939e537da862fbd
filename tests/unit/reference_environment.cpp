/// Light from outside: what directions see, how they are sampled, and with what effect.

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "reference/environment.h"
#include "reference_scenes.h"
#include "scene/bounds.h"
#include "sky_pictures.h"

namespace etendue::reference::test {
namespace {

using etendue::test::make_random_sky;
using etendue::test::make_sky_picture;
using etendue::test::oblique_turn;
using Rows = SkyPicture::Rows;

Scene under(SkyPicture picture, const glm::dmat3& turn = glm::dmat3(1.0)) {
  Scene scene;
  scene.sky.picture = std::move(picture);
  scene.sky.world_from_sky = turn;
  return scene;
}

Vec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

/// Words and numbers of sample i, from another place than those of renderers.
SampleRandom::Environment numbers(std::uint32_t i) {
  const Words w = pcg4d({i, 77, 5, 2});
  return {w[0], w[1], unit_float(w[2]), unit_float(w[3])};
}

struct Size {
  std::uint32_t width, height;
};
constexpr Size kSizes[] = {{1, 1}, {3, 1}, {1, 3}, {2, 2}, {7, 5}, {64, 33}, {1021, 37}};

TEST(ReferenceEnvironment, TexelsLieWhereTheConventionsSay) {
  const auto number = [](std::uint32_t x, std::uint32_t y) { return glm::vec3(static_cast<float>(10 * y + x + 1)); };
  const Environment bands(under(make_sky_picture(8, 4, Rows::bands, number)), 0.0);
  const Environment circles(under(make_sky_picture(8, 5, Rows::circles, number)), 0.0);
  for (std::uint32_t y = 0; y < 4; ++y) {
    for (std::uint32_t x = 0; x < 8; ++x) {
      const double phi = 2.0 * kPi * (x + 0.5) / 8;
      EXPECT_NEAR(bands.radiance(direction(kPi * (y + 0.5) / 4, phi)).x, number(x, y).x, 1e-9) << x << " " << y;
      EXPECT_NEAR(circles.radiance(direction(kPi * y / 4, phi)).x, number(x, y).x, y > 0 ? 1e-9 : 8.0);
    }
  }
  // The left edge, between the last and the first column, is toward -Z; +X is a quarter further.
  EXPECT_NEAR(bands.radiance(direction(kPi / 8, 0.0)).x, 0.5 * (number(7, 0).x + number(0, 0).x), 1e-9);
  EXPECT_NEAR(bands.radiance(glm::normalize(Vec3(1, 0, 0))).x,
              0.25 * (number(1, 1).x + number(2, 1).x + number(1, 2).x + number(2, 2).x), 1e-9);
  // Half a band at each pole has the colour of its row; circles end at the poles.
  EXPECT_NEAR(bands.radiance(direction(0.01, 2.0 * kPi * 1.5 / 8)).x, number(1, 0).x, 1e-9);
  EXPECT_NEAR(bands.radiance(direction(kPi - 0.01, 2.0 * kPi * 1.5 / 8)).x, number(1, 3).x, 1e-9);
  EXPECT_NEAR(circles.radiance(direction(kPi / 8, 2.0 * kPi * 1.5 / 8)).x, 0.5 * (number(1, 0).x + number(1, 1).x),
              1e-9);
}

TEST(ReferenceEnvironment, DecodesAndScales) {
  Bitmap codes{.width = 1,
               .height = 1,
               .channels = 2,
               .format = BitmapFormat::u8,
               .color_space = ColorSpace::srgb,
               .texels = {std::byte{128}, std::byte{0}},
               .notes = {}};
  SkyPicture picture{.bitmap = std::make_shared<const Bitmap>(codes), .scale = 3.0};
  EXPECT_NEAR(Environment(under(picture), 0.0).radiance({0, 1, 0}).y, 3.0 * 0.2158605, 1e-6);
  codes.color_space = ColorSpace::linear;
  picture.bitmap = std::make_shared<const Bitmap>(codes);
  EXPECT_NEAR(Environment(under(picture), 0.0).radiance({0, 1, 0}).z, 3.0 * 128 / 255.0, 1e-6);
}

TEST(ReferenceEnvironment, TurnsWithItsTransform) {
  const glm::dmat3 turn = oblique_turn();
  const SkyPicture picture = make_random_sky(7, 5, Rows::bands);
  const Environment straight(under(picture), 0.0), turned(under(picture, turn), 0.0);
  for (std::uint32_t i = 1; i < 100; ++i) {  // not the pole itself, which lies on all meridians
    const Vec3 d = direction(0.03 * i, 1.7 * i);
    EXPECT_LT(glm::length(turned.radiance(0.5 * turn * d) - straight.radiance(d)), 1e-9);
    EXPECT_NEAR(turned.pdf_w(0.5 * turn * d), straight.pdf_w(d), 1e-9);
  }
}

/// Counts of samples in bins of equal solid angle against the integral of the density over each.
TEST(ReferenceEnvironment, SamplesFollowTheirDensityWhichIntegratesToOne) {
  constexpr int kAcross = 12, kDown = 8;
  constexpr std::uint32_t kSamples = 200000, kSteps = 60;
  for (const Rows rows : {Rows::bands, Rows::circles}) {
    for (const Size& size : kSizes) {
      SCOPED_TRACE(std::to_string(size.width) + "x" + std::to_string(size.height) +
                   (rows == Rows::bands ? " bands" : " circles"));
      const Environment environment(under(make_random_sky(size.width, size.height, rows), oblique_turn()), 0.0);
      const auto bin_of = [](const Vec3& d) {
        const int i = std::min(static_cast<int>((std::atan2(d.z, d.x) / (2.0 * kPi) + 0.5) * kAcross), kAcross - 1);
        return std::min(static_cast<int>((0.5 - 0.5 * d.y) * kDown), kDown - 1) * kAcross + i;
      };
      std::vector<double> expected(kAcross * kDown), counts(kAcross * kDown);
      const int across = kAcross * kSteps, down = kDown * kSteps;
      for (int j = 0; j < down; ++j) {
        for (int i = 0; i < across; ++i) {
          const double y = 1.0 - 2.0 * (j + 0.5) / down, r = std::sqrt(1.0 - y * y),
                       phi = 2.0 * kPi * (i + 0.5) / across;
          const Vec3 d(r * std::cos(phi), y, r * std::sin(phi));
          expected[bin_of(d)] += environment.pdf_w(d) * 4.0 * kPi / (across * down);
        }
      }
      EXPECT_NEAR(std::accumulate(expected.begin(), expected.end(), 0.0), 1.0, 0.02);
      for (std::uint32_t i = 0; i < kSamples; ++i) {
        const auto sample = environment.sample(numbers(i));
        ASSERT_TRUE(sample);
        ASSERT_GT(sample->pdf_w, 0.0);
        ++counts[bin_of(sample->wi)];
      }
      for (std::size_t k = 0; k < counts.size(); ++k) {
        const double mean = kSamples * expected[k];
        EXPECT_NEAR(counts[k], mean, 5.0 * std::sqrt(mean) + 10.0 + 0.02 * mean) << k;
      }
    }
  }
}

TEST(ReferenceEnvironment, SamplesAreWhatTheirDirectionsSee) {
  for (const Rows rows : {Rows::bands, Rows::circles}) {
    for (const Size& size : kSizes) {
      const Environment environment(under(make_random_sky(size.width, size.height, rows), oblique_turn()), 0.0);
      for (std::uint32_t i = 0; i < 3000; ++i) {
        const auto sample = environment.sample(numbers(i));
        ASSERT_TRUE(sample);
        EXPECT_LT(glm::length(sample->radiance - environment.radiance(sample->wi)),
                  1e-6 * (1.0 + glm::length(sample->radiance)));
        if (i % 2 == 0) continue;
        // At the edge of a cell rounding may find the next one.
        const double again = environment.pdf_w(sample->wi);
        if (again == sample->pdf_w) continue;
        EXPECT_TRUE(numbers(i).across < 1e-6 || numbers(i).down < 1e-6) << again << " " << sample->pdf_w;
      }
    }
  }
}

TEST(ReferenceEnvironment, WhatShinesIsSampled) {
  for (const Rows rows : {Rows::bands, Rows::circles}) {
    for (const Size& size : kSizes) {
      const Environment environment(under(make_random_sky(size.width, size.height, rows)), 0.0);
      for (std::uint32_t i = 0; i < 20000; ++i) {
        const Vec3 d = direction(kPi * numbers(i).across, 2.0 * kPi * numbers(i).down);
        if (is_zero(environment.radiance(d))) continue;
        ASSERT_GT(environment.pdf_w(d), 0.0) << size.width << "x" << size.height;
      }
    }
  }
}

TEST(ReferenceEnvironment, BlackIsNotSampled) {
  EXPECT_FALSE(Environment(Scene{}, 1.0).is_sampled());
  EXPECT_EQ(Environment(Scene{}, 1.0).lights_prob(), 1.0);
  const auto black = [](std::uint32_t, std::uint32_t) { return glm::vec3(0.0f); };
  EXPECT_FALSE(Environment(under(make_sky_picture(3, 2, Rows::bands, black)), 1.0).is_sampled());
}

TEST(ReferenceEnvironment, SharesTheChoiceByPower) {
  Scene scene = floor_scene(0.5);
  scene.sky.top = scene.sky.horizon = Vec3(1.0);
  const double r = typical_radius(scene), power = 4.0 * kPi * r * r;  // luminance 1 - 4e-5
  EXPECT_EQ(Environment(scene, 0.0).lights_prob(), 0.0);
  EXPECT_NEAR(Environment(scene, power).lights_prob(), 0.5, 1e-4);
  EXPECT_NEAR(Environment(scene, 3.0 * power).lights_prob(), 0.75, 1e-4);
  EXPECT_NEAR(Environment(scene, 1e9 * power).lights_prob(), 0.75, 1e-9);
  EXPECT_NEAR(Environment(scene, 1e-9 * power).lights_prob(), 0.25, 1e-9);
  std::uint32_t lights = 0;
  const Environment half(scene, power);
  for (std::uint32_t i = 0; i < 10000; ++i) lights += half.sample(numbers(i)) ? 0 : 1;
  EXPECT_NEAR(lights, 5000.0, 5.0 * 50.0);
}

TEST(ReferenceEnvironment, AConstantSkyLightsAPlaneByPiTimesItsRadiance) {
  Scene scene = floor_scene(0.5);
  scene.sky.picture = make_sky_picture(5, 3, Rows::bands, [](std::uint32_t, std::uint32_t) { return glm::vec3(2.0f); });
  scene.sky.world_from_sky = oblique_turn();
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    const Estimate e = estimate(scene, 100000);  // by chance every sample is the mean, but for rounding
    EXPECT_TRUE(e.t(0.5 * 2.0) < kMaxT || std::abs(e.mean - 1.0) < 1e-6) << strategy.name << " " << e.mean;
  }
}

/// A ball on a floor under a sun of 1e-4 sr beside a sky of 1.
TEST(ReferenceEnvironment, ASmallSunIsFound) {
  constexpr std::uint32_t kWidth = 512, kHeight = 256;  // a texel at 45 degrees fills 1.06e-4 sr
  Scene scene;
  scene.sky.picture = make_sky_picture(kWidth, kHeight, Rows::bands, [](std::uint32_t x, std::uint32_t y) {
    return x == 100 && y == kHeight / 4 ? glm::vec3(4e4f) : glm::vec3(1.0f);
  });
  add(scene, quad({-4, -1, -4}, {0, 0, 8}, {8, 0, 0}), diffuse(0.5));
  add(scene, Sphere{Vec3(0.0), 1.0}, diffuse(0.7));
  scene.integrator.max_depth = 2;
  scene.camera.width = 8;
  scene.camera.height = 6;
  scene.camera.fov = 20.0;
  scene.camera.world_from_camera = look_at({2, 3, 5}, {0, 0, 0}, {0, 1, 0});
  const auto standard_error = [&](bool nee, double& mean) {
    scene.integrator.nee = nee;
    Film film(8, 6, film_exponent(scene));
    std::vector<RejectedSample> rejected;
    make_reference_renderer(scene, {.seed = 3})->render({0, 4000}, film, {}, rejected);
    EXPECT_TRUE(rejected.empty());
    // Of the picture's mean; the variance between pixels is not noise.
    double variance = 0.0;
    mean = 0.0;
    for (const FilmPixel& pixel : film.pixels()) {
      const Moments m = moments(pixel, 1, film.exponent());
      variance += static_cast<double>(m.variance) / static_cast<double>(m.n);
      mean += static_cast<double>(m.mean);
    }
    mean /= 48.0;
    return std::sqrt(variance) / 48.0;
  };
  double by_chance = 0.0, sampled = 0.0;
  const double error_by_chance = standard_error(false, by_chance), error_sampled = standard_error(true, sampled);
  EXPECT_GT(error_by_chance, 20.0 * error_sampled);
  EXPECT_NEAR(by_chance, sampled, 4.0 * error_by_chance);
}

TEST(ReferenceEnvironment, TheFilmHoldsASunBesideItsSky) {
  Scene scene = under(make_sky_picture(512, 256, Rows::bands, [](std::uint32_t x, std::uint32_t y) {
    return x == 100 && y == 64 ? glm::vec3(1e9f) : glm::vec3(1.0f);
  }));
  const int exponent = film_exponent(scene);
  EXPECT_LT(1e9, std::ldexp(1.0, exponent + 24 - 8)) << "the sun itself, with room for weights";
  EXPECT_GT(1e-9, std::ldexp(1.0, exponent - 56)) << "what a dark corner reflects of the sky";
  // An even picture has the unit of a gradient.
  Scene even = under(make_sky_picture(4, 2, Rows::bands, [](std::uint32_t, std::uint32_t) { return glm::vec3(3.0f); }));
  Scene gradient;
  gradient.sky.top = Vec3(3.0);
  EXPECT_EQ(film_exponent(even), film_exponent(gradient));
}

}  // namespace
}  // namespace etendue::reference::test
