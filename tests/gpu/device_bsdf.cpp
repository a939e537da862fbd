/// The contract of shaders/bsdf/bsdf.glsl, material by material: weight = eval/pdf, samples follow the pdf, energy,
/// delta lobes.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "device_test.h"
#include "validate/statistics.h"

namespace etendue::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr glm::vec3 kAlbedo{0.9f, 0.5f, 0.1f};

class DeviceBsdf : public DeviceTest {
 protected:
  std::vector<gpu::BsdfAnswer> evaluate(const std::vector<gpu::BsdfCase>& cases) {
    return run<gpu::BsdfAnswer>({kernels::bsdfs, "bsdfs", nullptr, {}}, cases);
  }
};

glm::vec3 direction(double cos_theta, double phi) {
  const double sin_theta = std::sqrt(1.0 - cos_theta * cos_theta);
  return glm::vec3(glm::dvec3(sin_theta * std::cos(phi), sin_theta * std::sin(phi), cos_theta));
}

// Cases of one material and one wo with random numbers and random wi over the whole sphere.
std::vector<gpu::BsdfCase> random_cases(gpu::BsdfCase material, const glm::vec3& wo, std::size_t n,
                                        std::uint64_t seed) {
  Random random(seed);
  std::vector<gpu::BsdfCase> cases;
  material.wo = wo;
  for (std::size_t i = 0; i < n; ++i) {
    material.u = {random.unit(), 0.0f};
    material.u.y = random.unit();
    material.u_lobe = random.unit();
    material.wi = glm::vec3(random.direction());
    cases.push_back(material);
  }
  return cases;
}

gpu::BsdfCase diffuse() {
  return {.albedo = kAlbedo, .header = gpu::kBsdfDiffuse | gpu::kMaterialOneSided};
}
gpu::BsdfCase mirror() {
  return {.header = gpu::kBsdfMirror | gpu::kMaterialDelta | gpu::kMaterialOneSided};
}
gpu::BsdfCase glass(double inside, double outside) {
  return {.header = gpu::kBsdfDielectric | gpu::kMaterialDelta,
          .int_ior = static_cast<float>(inside),
          .ext_ior = static_cast<float>(outside)};
}

TEST_F(DeviceBsdf, DiffuseSampleEvalAndPdfAgree) {
  for (const double cos_o : {1.0, 0.7, 0.05, 1e-4}) {
    const auto cases = random_cases(diffuse(), direction(cos_o, 0.4), 20000, 1);
    const auto answers = evaluate(cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const gpu::BsdfAnswer& a = answers[i];
      const double z = cases[i].wi.z;
      EXPECT_NEAR(a.eval_pdf, std::max(0.0, z) / kPi, 1e-7);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(a.eval[c], kAlbedo[c] * std::max(0.0, z) / kPi, 1e-7);
        if (a.pdf > 0.0f) {
          EXPECT_NEAR(a.weight[c] * a.pdf, a.eval_at_sample[c], 1e-6 * a.pdf);
        }
      }
      EXPECT_EQ(a.pdf, a.pdf_at_sample);
      EXPECT_EQ(a.lobe, a.pdf > 0.0f ? gpu::kLobeDiffuse : gpu::kLobeNone);
      EXPECT_EQ(a.eta_scale, 1.0f);
      EXPECT_EQ(a.is_delta, 0u);
      EXPECT_EQ(a.is_one_sided, 1u);
    }
  }
}

TEST_F(DeviceBsdf, DiffuseSamplesFollowThePdf) {
  constexpr int kRings = 10, kSectors = 20;
  const auto cases = random_cases(diffuse(), direction(0.3, 1.0), 1 << 17, 2);
  std::vector<double> observed(std::size_t{kRings} * kSectors, 0.0), expected;
  for (const auto& a : evaluate(cases)) {
    const double phi = std::atan2(a.wi.y, a.wi.x) / (2.0 * kPi) + 0.5;
    const int ring = std::clamp(static_cast<int>(a.wi.z * kRings), 0, kRings - 1);
    ++observed[ring * kSectors + std::clamp(static_cast<int>(phi * kSectors), 0, kSectors - 1)];
  }
  for (int ring = 0; ring < kRings; ++ring) {
    const double low = static_cast<double>(ring) / kRings, high = (ring + 1.0) / kRings;
    const double share = (high * high - low * low) / kSectors;  // ∫ cos θ/π dω over the cell
    expected.insert(expected.end(), kSectors, share * static_cast<double>(cases.size()));
  }
  EXPECT_GT(chi_square_test(observed, expected).p_value, kSmallestP);
}

TEST_F(DeviceBsdf, DiffuseConservesEnergyAndIsReciprocal) {
  const auto cases = random_cases(diffuse(), direction(0.6, 0.0), 1 << 16, 3);
  const auto answers = evaluate(cases);
  RunningMoments pdf, red;
  std::vector<gpu::BsdfCase> swapped;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    pdf.add(4.0 * kPi * answers[i].eval_pdf);  // uniform directions: density 1/4π
    red.add(4.0 * kPi * answers[i].eval.r);
    if (cases[i].wi.z > 0.01f) {
      gpu::BsdfCase s = cases[i];
      std::swap(s.wo, s.wi);
      swapped.push_back(s);
    }
  }
  EXPECT_LT(std::abs(pdf.mean() - 1.0), 4.5 * pdf.standard_error());
  EXPECT_LT(std::abs(red.mean() - kAlbedo.r), 4.5 * red.standard_error());
  const auto back = evaluate(swapped);
  for (std::size_t i = 0; i < swapped.size(); ++i) {  // f(wo, wi) = f(wi, wo), eval carries the cosine of its wi
    EXPECT_NEAR(back[i].eval.g / swapped[i].wi.z, kAlbedo.g / kPi, 1e-6);
  }
}

TEST_F(DeviceBsdf, OneSidedMaterialsAreBlackFromBehindAndBelow) {
  for (const gpu::BsdfCase& material : {diffuse(), mirror()}) {
    for (const double cos_o : {-1.0, -0.3, 0.0}) {
      for (const auto& a : evaluate(random_cases(material, direction(cos_o, 0.3), 500, 4))) {
        EXPECT_EQ(a.pdf, 0.0f);
        EXPECT_EQ(a.lobe, gpu::kLobeNone);
        EXPECT_EQ(a.eval, glm::vec3(0.0f));
        EXPECT_EQ(a.eval_pdf, 0.0f);
        EXPECT_EQ(a.is_one_sided, 1u);
      }
    }
  }
}

TEST_F(DeviceBsdf, MirrorReflectsEverythingIntoOneDirection) {
  for (const double cos_o : {1.0, 0.5, 1e-3}) {
    const glm::vec3 wo = direction(cos_o, 2.0);
    for (const auto& a : evaluate(random_cases(mirror(), wo, 500, 5))) {
      EXPECT_EQ(a.wi, glm::vec3(-wo.x, -wo.y, wo.z));
      EXPECT_EQ(a.weight, glm::vec3(1.0f));
      EXPECT_EQ(a.pdf, 1.0f);
      EXPECT_EQ(a.lobe, gpu::kLobeDeltaReflection);
      EXPECT_EQ(a.eval, glm::vec3(0.0f));
      EXPECT_EQ(a.eval_pdf, 0.0f);
      EXPECT_EQ(a.is_delta, 1u);
    }
  }
}

// Reflectance from Maxwell's equations in the cosines, double precision.
double reflectance(double cos_o, double n_o, double n_t) {
  const double sin_t = n_o / n_t * std::sqrt(1.0 - cos_o * cos_o);
  if (sin_t >= 1.0) return 1.0;
  const double cos_t = std::sqrt(1.0 - sin_t * sin_t);
  const double s = (n_o * cos_o - n_t * cos_t) / (n_o * cos_o + n_t * cos_t);
  const double p = (n_t * cos_o - n_o * cos_t) / (n_t * cos_o + n_o * cos_t);
  return 0.5 * (s * s + p * p);
}

TEST_F(DeviceBsdf, DielectricSplitsByFresnelAndBendsBySnell) {
  for (const auto& [inside, outside] : {std::pair{1.5046, 1.000277}, {1.0, 1.5}, {2.4, 1.33}}) {
    for (const double cos_o : {1.0, 0.8, 0.4, 0.1, -1.0, -0.8, -0.4, -0.1}) {
      const glm::vec3 wo = direction(cos_o, 0.7);
      const double n_o = cos_o > 0 ? outside : inside, n_i = cos_o > 0 ? inside : outside;
      const double f = reflectance(std::abs(cos_o), n_o, n_i);
      std::uint64_t reflected = 0;
      const auto answers = evaluate(random_cases(glass(inside, outside), wo, 20000, 6));
      for (const auto& a : answers) {
        ASSERT_EQ(a.eval, glm::vec3(0.0f));
        ASSERT_EQ(a.eval_pdf, 0.0f);
        ASSERT_NEAR(glm::length(a.wi), 1.0f, 1e-6f);
        if (a.lobe == gpu::kLobeDeltaReflection) {
          ++reflected;
          EXPECT_EQ(a.wi, glm::vec3(-wo.x, -wo.y, wo.z));
          EXPECT_EQ(a.weight, glm::vec3(1.0f));
          EXPECT_EQ(a.eta_scale, 1.0f);
          EXPECT_NEAR(a.pdf, f, 1e-5);
        } else {
          ASSERT_EQ(a.lobe, gpu::kLobeDeltaTransmission);
          EXPECT_LT(a.wi.z * wo.z, 0.0f);
          EXPECT_NEAR(n_i * a.wi.x, -n_o * wo.x, 2e-6);  // Snell, with the direction kept in the plane of incidence
          EXPECT_NEAR(n_i * a.wi.y, -n_o * wo.y, 2e-6);
          EXPECT_NEAR(a.weight.r, n_o * n_o / (n_i * n_i), 1e-5);
          EXPECT_NEAR(a.weight.r * a.eta_scale, 1.0f, 1e-6f);
          EXPECT_NEAR(a.pdf, 1.0 - f, 1e-5);
        }
      }
      if (f == 1.0) {
        EXPECT_EQ(reflected, answers.size()) << "total internal reflection at " << cos_o;
      } else {
        EXPECT_GT(binomial_two_sided(reflected, answers.size(), f), kSmallestP)
            << cos_o << ' ' << inside << '/' << outside;
      }
    }
  }
}

TEST_F(DeviceBsdf, EqualIndicesLetEverythingThrough) {
  for (const double cos_o : {1.0, 0.2, -0.6}) {
    const glm::vec3 wo = direction(cos_o, 0.1);
    for (const auto& a : evaluate(random_cases(glass(1.3, 1.3), wo, 200, 7))) {
      EXPECT_EQ(a.lobe, gpu::kLobeDeltaTransmission);
      EXPECT_NEAR(glm::length(a.wi + wo), 0.0f, 1e-6f);
      EXPECT_EQ(a.weight, glm::vec3(1.0f));
    }
  }
}

TEST_F(DeviceBsdf, GrazingDirectionsStayFinite) {
  for (const gpu::BsdfCase& material : {diffuse(), mirror(), glass(1.5, 1.0)}) {
    for (const float z : {0.0f, 1e-38f, 1e-20f, 1e-7f, -1e-7f, -1e-20f, -1e-38f}) {
      for (const auto& a : evaluate(random_cases(material, glm::vec3(std::sqrt(1.0f - z * z), 0.0f, z), 64, 8))) {
        for (int c = 0; c < 3; ++c)
          ASSERT_TRUE(std::isfinite(a.weight[c]) && std::isfinite(a.wi[c])) << material.header << ' ' << z;
        ASSERT_TRUE(std::isfinite(a.pdf) && a.pdf >= 0.0f);
        EXPECT_TRUE(a.pdf > 0.0f || a.lobe == gpu::kLobeNone);
      }
    }
  }
}

}  // namespace
}  // namespace etendue::test
