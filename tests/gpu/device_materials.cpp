/// Materials on the device against the reference, direction by direction: the same samples for the same numbers, the
/// same values and densities.

#include <algorithm>
#include <cmath>
#include <string>

#include "device_test.h"
#include "gpu/bsdf_probe.h"
#include "reference/material_probe.h"
#include "scene/metals.h"
#include "scene/test_patch.h"

namespace etendue::test {
namespace {

using Distribution = Roughness::Distribution;

class DeviceMaterials : public DeviceTest {};

struct Named {
  std::string name;
  Bsdf bsdf;
  double narrowest = 1.0;  ///< roughness
};

std::vector<Named> sheets() {
  return {{"paper", PrincipledThinBsdf{.base_color = {0.6, 0.3, 0.1}, .diff_trans = 0.8}},
          {"pane", PrincipledThinBsdf{.roughness = 0.3, .spec_trans = 1.0, .spec_tint = 0.5, .eta = 1.2}, 0.01},
          {"light pane",
           PrincipledThinBsdf{.base_color = {0.6, 0.3, 0.1}, .spec_trans = 1.0, .spec_tint = 1.0, .eta = 0.75}, 0.01},
          {"all of a sheet", PrincipledThinBsdf{.base_color = {0.2, 0.5, 0.7},
                                                .roughness = 0.7,
                                                .anisotropic = 0.4,
                                                .spec_trans = 0.4,
                                                .spec_tint = 0.3,
                                                .sheen = 0.5,
                                                .sheen_tint = 0.5,
                                                .flatness = 0.2,
                                                .diff_trans = 1.2,
                                                .eta = 1.8}}};
}

GltfBsdf gltf_glass(bool thin, double roughness) {
  return {.base_color = {0.8, 0.9, 1.0},
          .metallic = 0.0,
          .roughness = roughness,
          .transmission = 0.7,
          .diffuse_transmission = 0.4,
          .diffuse_transmission_color = {0.9, 0.5, 0.3},
          .clearcoat = 0.5,
          .clearcoat_roughness = 0.5,
          .thin = thin};
}

std::vector<Named> gltf_materials() {
  return {
      {"gltf metal",
       GltfBsdf{.base_color = {0.9, 0.6, 0.2}, .roughness = 0.5, .anisotropy = 0.7, .anisotropy_rotation = 1.0}, 0.25},
      {"gltf velvet",
       GltfBsdf{.base_color = {0.2, 0.5, 0.7},
                .metallic = 0.2,
                .roughness = 0.6,
                .specular = 0.8,
                .specular_color = {1.0, 0.7, 0.5},
                .clearcoat = 0.8,
                .clearcoat_roughness = 0.3,
                .sheen_color = {0.6, 0.3, 0.3},
                .sheen_roughness = 0.4},
       0.09},
      {"gltf film", GltfBsdf{.base_color = {0.9, 0.6, 0.4}, .metallic = 0.5, .roughness = 0.6, .iridescence = 0.9},
       0.36},
      {"gltf pane", gltf_glass(true, 0.4), 0.16},
      {"gltf solid", gltf_glass(false, 0.4), 0.05},
      {"gltf smooth solid", gltf_glass(false, 0.1), 5e-3}};
}

std::vector<Named> materials() {
  const ConductorIndex gold = *metal_index("Au");
  std::vector<Named> all{{"conductor", ConductorBsdf{gold, glm::dvec3(0.9, 0.8, 0.7)}},
                         {"white conductor", ConductorBsdf{}},
                         {"microfacet", MicrofacetBsdf{.kd = {0.1, 0.4, 0.2}}, 0.1},
                         {"narrow microfacet", MicrofacetBsdf{.kd = {0.1, 0.4, 0.2}, .alpha = 1e-3}, 1e-3}};
  all.push_back({"thin dielectric", ThinDielectricBsdf{.specular_transmittance = {0.2, 0.5, 0.9}}});
  all.push_back({"plastic", PlasticBsdf{.diffuse_reflectance = {0.2, 0.5, 0.9}}});
  all.push_back({"nonlinear plastic", PlasticBsdf{.diffuse_reflectance = {0.2, 0.5, 0.9}, .nonlinear = true}});
  all.push_back({"rough plastic", RoughPlasticBsdf{.diffuse_reflectance = {0.2, 0.5, 0.9}}, 0.1});
  all.push_back({"narrow plastic", RoughPlasticBsdf{.alpha = 1e-3}, 1e-3});
  all.push_back({"principled",
                 PrincipledBsdf{.base_color = {0.2, 0.5, 0.9},
                                .roughness = 0.6,
                                .metallic = 0.1,
                                .anisotropic = 0.4,
                                .spec_trans = 0.2,
                                .spec_tint = 0.3,
                                .sheen = 0.5,
                                .clearcoat = 1.0,
                                .sheen_tint = 0.5,
                                .flatness = 0.2},
                 0.1});
  all.push_back(
      {"principled metal", PrincipledBsdf{.base_color = {0.2, 0.5, 0.9}, .roughness = 0.5, .metallic = 1.0}, 0.25});
  all.push_back(
      {"principled glass", PrincipledBsdf{.base_color = {0.2, 0.5, 0.9}, .roughness = 0.3, .spec_trans = 1.0}, 0.03});
  for (Named& material : sheets()) all.push_back(std::move(material));
  for (Named& material : gltf_materials()) all.push_back(std::move(material));
  for (const Distribution d : {Distribution::beckmann, Distribution::ggx}) {
    for (const auto& [inside, outside] : {std::pair{1.5046, 1.000277}, {1.0, 2.4}, {1.02, 1.0}}) {
      for (const double alpha : {1e-3, 0.05, 0.5, 1.0})
        all.push_back({"rough dielectric " + std::to_string(inside) + ' ' + std::to_string(alpha),
                       RoughDielectricBsdf{.int_ior = inside, .ext_ior = outside, .roughness = {d, alpha, alpha}},
                       alpha * std::abs(inside / outside - 1.0)});
    }
    const std::string name = d == Distribution::ggx ? "ggx " : "beckmann ";
    for (const auto& [u, v] : {std::pair{1e-3, 1e-3}, {0.01, 0.4}, {0.3, 0.3}, {1.0, 1.0}})
      all.push_back({name + std::to_string(u), RoughConductorBsdf{gold, {d, u, v}, glm::dvec3(1.0)}, std::min(u, v)});
  }
  return all;
}

std::vector<glm::dvec3> directions() {
  std::vector<glm::dvec3> all;
  for (const double z : {1.0, 0.999, 0.7, 0.3, 0.03, 1e-3, -0.6})
    all.emplace_back(std::sqrt(1.0 - z * z) * 0.8, std::sqrt(1.0 - z * z) * -0.6, z);
  return all;
}

/// `share` of the sorted values lie below the result.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

TEST_F(DeviceMaterials, SampleLikeTheReference) {
  for (const Named& material : materials()) {
    const auto device = make_gpu_bsdf_probe(test_patch(material.bsdf), renderer_options());
    const auto reference = make_reference_bsdf_probe(test_patch(material.bsdf));
    for (const glm::dvec3& wo : directions()) {
      constexpr std::uint32_t kSamples = 20000;
      const auto a = device->sample(wo, 3, 0, kSamples), b = reference->sample(wo, 3, 0, kSamples);
      std::vector<double> direction, weight, pdf;
      std::uint32_t parted = 0;
      for (std::uint32_t i = 0; i < kSamples; ++i) {
        if (a[i].lobe != b[i].lobe) {
          ++parted;
          continue;
        }
        if (a[i].lobe == ProbeLobe::none) continue;
        direction.push_back(largest(a[i].wi - b[i].wi));
        weight.push_back(largest(a[i].weight - b[i].weight));
        pdf.push_back(std::abs(a[i].pdf / b[i].pdf - 1.0));
        ASSERT_TRUE(std::isfinite(a[i].pdf) && std::isfinite(largest(a[i].weight))) << material.name << wo.z;
      }
      const std::string where = material.name + " " + std::to_string(wo.z);
      EXPECT_LE(parted, 20u) << where;  // at the horizon rounding decides
      EXPECT_LT(quantile(direction, 0.5), 1e-6) << where;
      EXPECT_LT(quantile(direction, 0.999), 2e-3) << where;
      EXPECT_LT(quantile(weight, 0.5), 2e-5) << where;
      EXPECT_LT(quantile(weight, 0.999), 5e-3) << where;
      EXPECT_LT(quantile(pdf, 0.5), 1e-5) << where;
      EXPECT_LT(quantile(pdf, 0.99), 5e-3) << where;
    }
  }
}

TEST_F(DeviceMaterials, HaveTheReferencesValueAndDensity) {
  for (const Named& material : materials()) {
    const auto device = make_gpu_bsdf_probe(test_patch(material.bsdf), renderer_options());
    const auto reference = make_reference_bsdf_probe(test_patch(material.bsdf));
    for (const glm::dvec3& wo : directions()) {
      std::vector<BsdfQuery> queries;
      for (const BsdfDraw& draw : reference->sample(wo, 5, 0, 2000)) queries.push_back({draw.wi, 0});
      Random random(9);
      for (int i = 0; i < 500; ++i) queries.push_back({random.direction(), 0});
      const auto a = device->evaluate(wo, 5, queries, BsdfProbe::Part::mixture),
                 b = reference->evaluate(wo, 5, queries, BsdfProbe::Part::mixture);
      std::vector<double> eval, pdf;
      for (std::size_t i = 0; i < queries.size(); ++i) {
        if (std::abs(queries[i].wi.z) < 1e-6) continue;
        ASSERT_TRUE(std::isfinite(a[i].pdf) && a[i].pdf >= 0.0) << material.name << ' ' << wo.z;
        eval.push_back(largest(a[i].eval - b[i].eval) / (largest(b[i].eval) + 1e-3));
        pdf.push_back(std::abs(a[i].pdf - b[i].pdf) / (b[i].pdf + 1e-3));
      }
      // A direction in single precision is off by 6e-8; in units of the roughness that is more, and once more where
      // the two directions nearly cancel in the half vector.
      const double rounding = 2e-6 + 2e-6 / (material.narrowest * std::clamp(std::abs(wo.z), 0.02, 1.0));
      const std::string where = material.name + " " + std::to_string(wo.z);
      EXPECT_LT(quantile(eval, 0.9), rounding) << where;
      EXPECT_LT(quantile(pdf, 0.9), rounding) << where;
      // A refraction's half vector is a difference; where the indices are close it nearly vanishes.
      const double worst = std::holds_alternative<RoughDielectricBsdf>(material.bsdf) ? 200.0 : 30.0;
      EXPECT_LT(quantile(eval, 1.0), worst * rounding) << where;
      EXPECT_LT(quantile(pdf, 1.0), worst * rounding) << where;
    }
  }
}

}  // namespace
}  // namespace etendue::test
