/// What glTF's materials and lamps have beside others, against numbers that are known otherwise.

#include <gtest/gtest.h>
#include <algorithm>

#include <glm/gtc/matrix_transform.hpp>

#include "reference/bsdf.h"
#include "reference/sampling.h"
#include "reference_scenes.h"

namespace etendue::reference::test {
namespace {

/// Mean radiance of each component.
Vec3 mean_color(const Scene& scene, std::uint32_t samples, Vec3& error) {
  Film film(scene.camera.width, scene.camera.height, kExponent);
  std::vector<RejectedSample> rejected;
  make_reference_renderer(scene, {.seed = 3})->render({0, samples}, film, {}, rejected);
  Vec3 mean(0.0);
  for (int c = 0; c < 3; ++c) {
    const Moments m = film_moments(film, static_cast<std::size_t>(c));
    mean[c] = static_cast<double>(m.mean);
    error[c] = static_cast<double>(std::sqrt(m.variance / static_cast<long double>(m.n)));
  }
  return mean;
}

// A disk of radius R at height h above a floor sends the irradiance π R²/(R² + h²) straight down, from either side.
TEST(ReferenceGltf, DisksThatShineOnBothSides) {
  constexpr double kRadius = 0.7, kHeight = 1.3, kAlbedo = 0.5;
  const double expected = kAlbedo * kRadius * kRadius / (kRadius * kRadius + kHeight * kHeight);
  for (const bool facing : {false, true}) {
    for (const bool two_sided : {false, true}) {
      for (const Strategy& strategy : kStrategies) {
        for (const auto sampler : {Integrator::LightSampler::power, Integrator::LightSampler::tree}) {
          Scene scene = floor_scene(kAlbedo);
          scene.integrator.light_sampler = sampler;
          set_strategy(scene, strategy);
          const double up = facing ? -1.0 : 1.0;
          Instance& lamp = scene.add(Disk{}, diffuse(0.0), AreaEmitter{Vec3(1.0), {}, two_sided});
          lamp.world_from_object =
              glm::dmat4({kRadius, 0, 0, 0}, {0, 0, -up * kRadius, 0}, {0, up, 0, 0}, {0, kHeight, 0, 1});
          // Another, below the floor, so that there is a choice.
          scene.add(Disk{}, diffuse(0.0), AreaEmitter{Vec3(1.0)}).world_from_object[3] = {0, -2, 0, 1};
          const Estimate e = estimate(scene, 40000);
          if (facing || two_sided) {
            EXPECT_LT(e.t(expected), kMaxT) << strategy.name << " " << facing << ": " << e.mean << " " << expected;
          } else {
            EXPECT_EQ(e.mean, 0.0);
          }
        }
      }
    }
  }
}

// A ray that enters a prism along the normal of one face leaves the other, which is inclined by β, bent by
// asin(n sin β) − β. Nothing is reflected, and the sky's radiance is the sine of the elevation.
TEST(ReferenceGltf, APrismBendsEachColourByItsOwnIndex) {
  constexpr double kIndex = 1.5, kDispersion = 6.0, kBeta = 0.4;
  Scene scene;
  scene.sky = {.top = Vec3(1.0), .horizon = Vec3(0.0)};
  scene.integrator.rr_depth = 0;
  scene.integrator.max_depth = 8;
  // The ray goes along +x through the face x = 0; the other face ascends, so that it leaves upward or downward.
  const Vec3 apex(0.0, 5.0, 0.0), foot(0.0, -5.0, 0.0), corner(10.0 * std::tan(kBeta), -5.0, 0.0), z(0.0, 0.0, 10.0);
  TriangleMesh mesh;
  const auto face = [&](const Vec3& p, const Vec3& u, const Vec3& v) {
    const TriangleMesh q = quad(p - 0.5 * z, u, v);
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::dvec3& position : q.positions) mesh.positions.push_back(position);
    for (const glm::uvec3& t : q.triangles) mesh.triangles.push_back(t + base);
  };
  face(foot, z, apex - foot);      // normal −x
  face(corner, apex - corner, z);  // normal toward +x, +y
  GltfBsdf glass{.metallic = 0.0, .roughness = 0.0, .ior = kIndex, .specular = 0.0, .transmission = 1.0, .thin = false};
  glass.dispersion = kDispersion;
  add(scene, mesh, glass);
  scene.camera = pixel_camera({-1.0, -3.0, 0.0}, {0.0, -3.0, 0.0}, 1e-6, {0, 1, 0});
  // The normal of the second face is (cos β, sin β): light leaves at asin(n sin β) from it, below the x axis.
  scene.sky.world_from_sky = glm::dmat3(Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1));  // the sky is below
  Vec3 error(0.0);
  const Vec3 mean = mean_color(scene, 20000, error);
  const double spread = (kIndex - 1.0) * kDispersion / 20.0;  // of blue and red: (n − 1)/V, V = 20/dispersion
  for (int c = 0; c < 3; ++c) {
    const double n = kIndex + (c - 1) * spread / 2.0;
    const double expected = std::sin(std::asin(n * std::sin(kBeta)) - kBeta);
    EXPECT_NEAR(mean[c], expected, kMaxT * error[c] + 2e-4) << c;
    EXPECT_LT(error[c], 0.01);
  }
}

// The coat's own normal: samples have the density that pdf() says, and nothing reflects more than arrives.
TEST(ReferenceGltf, CoatsWithANormalOfTheirOwn) {
  GltfBsdf bsdf{.base_color = Vec3(0.9),
                .metallic = 0.2,
                .roughness = 0.7,
                .clearcoat = 1.0,
                .clearcoat_roughness = 0.5,
                .coat_keeps_normal = true};
  bsdf.met.coat_normal = glm::normalize(Vec3(0.3, -0.2, 1.0));
  for (const Vec3& wo : {Vec3(0, 0, 1), glm::normalize(Vec3(0.8, 0.1, 0.5)), glm::normalize(Vec3(-0.7, 0.5, 0.4))}) {
    double density = 0.0, by_quadrature = 0.0, by_samples = 0.0, error = 0.0;
    constexpr int kRows = 400, kColumns = 800;
    for (int i = 0; i < kRows; ++i) {
      for (int k = 0; k < kColumns; ++k) {
        const double z = (i + 0.5) / kRows, phi = 2.0 * kPi * (k + 0.5) / kColumns, r = std::sqrt(1.0 - z * z);
        const Vec3 wi(r * std::cos(phi), r * std::sin(phi), z);
        density += pdf(bsdf, wo, wi) * 2.0 * kPi / (kRows * kColumns);
        by_quadrature += eval(bsdf, wo, wi).x * 2.0 * kPi / (kRows * kColumns);
      }
    }
    constexpr int kSamples = 100000;
    double kept = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      const double u = std::fmod(i * 0.754877666, 1.0), v = std::fmod(i * 0.569840291, 1.0), x = (i + 0.5) / kSamples;
      const BsdfSample sample = reference::sample(bsdf, wo, x, {u, v});
      if (sample.lobe == Lobe::none) continue;
      kept += 1.0 / kSamples;
      by_samples += sample.weight.x / kSamples;
      error = std::max(error, std::abs(sample.pdf / pdf(bsdf, wo, sample.wi) - 1.0));
    }
    EXPECT_LT(error, 1e-9);
    EXPECT_NEAR(density, kept, 3e-3) << wo.x;
    EXPECT_NEAR(by_samples, by_quadrature, 5e-3 * by_quadrature) << wo.x;
    EXPECT_LT(by_quadrature, 1.0);
  }
}

// Tangents of vertices: a normal map of one colour turns the normal toward u or v of the file, also where the bitangent
// is the other way round and where the instance is a mirror image.
TEST(ReferenceGltf, NormalMapsLieByTangentsOfVertices) {
  for (const bool mirrored : {false, true}) {
    for (const float w : {1.0f, -1.0f}) {
      Scene scene;
      scene.integrator.type = Integrator::Type::normals;
      scene.integrator.type = Integrator::Type::aov;
      scene.integrator.aov = Aov::shading_normal;
      TriangleMesh mesh = quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
      mesh.uv_sets = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
      mesh.tangents.assign(4, glm::vec4(0.0f, 1.0f, 0.0f, w));  // u grows along y, whatever the coordinates say
      scene.textures.push_back({.source = CheckerboardTexture{Vec3(0.5, 0.9, 0.8), Vec3(0.5, 0.9, 0.8)}});
      Instance& instance = scene.add(mesh, diffuse(0.5));
      scene.materials.push_back({.adapter = NormalMapAdapter{{Vec3(1.0), 0}, 0, true}});
      instance.material = 1;
      if (mirrored) instance.world_from_object[0][0] = -1.0;
      scene.camera = pixel_camera({0.1, 0.2, 1}, {0.1, 0.2, 0}, 1e-6, {0, 1, 0});
      Vec3 error(0.0);
      const Vec3 normal = mean_color(scene, 1, error);
      // b = w n × t, and the mirror image of it.
      const Vec3 b = Vec3(mirrored ? 1.0 : -1.0, 0, 0) * static_cast<double>(w);
      const Vec3 expected = glm::normalize(0.8 * b + Vec3(0, 0, 0.6));
      EXPECT_LT(glm::length(normal - expected), 1e-6) << mirrored << " " << w << " " << normal.x << " " << normal.y;
    }
  }
}

}  // namespace
}  // namespace etendue::reference::test
