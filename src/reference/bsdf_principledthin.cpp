/// Burley's material of a thin sheet [Burley2015, §5], with Mitsuba's parameters: transmitted light is distributed like
/// the mirror image of reflected light.

#include <algorithm>
#include <cmath>

#include "reference/bsdf.h"
#include "reference/burley_base.h"
#include "reference/fresnel.h"
#include "reference/microfacet_distribution.h"
#include "reference/sampling.h"

namespace etendue::reference {
namespace {

Vec3 mirrored(const Vec3& w) {
  return {w.x, w.y, -w.z};
}

/// The sheet seen from the side of `wo`, which is turned to z > 0.
struct Sheet {
  Sheet(const PrincipledThinBsdf& b, const Vec3& o)
      : bsdf(b),
        wo(o.z < 0.0 ? mirrored(o) : o),
        clear(b.spec_trans.value),
        behind((1.0 - clear) * b.diff_trans.value / 2.0),
        front((1.0 - clear) * (1.0 - b.diff_trans.value / 2.0)) {
    const double f = fresnel_dielectric(wo.z, 1.0, b.eta.value).reflectance;
    weights[0] = clear * std::max(f, 0.1);
    weights[1] = clear * std::max(1.0 - f, 0.1);
    weights[2] = front * (1.0 + b.sheen.value / 4.0);
    weights[3] = behind;
  }
  MicrofacetDistribution facets(bool through) const {
    const double scale = through ? 0.65 * bsdf.eta.value - 0.35 : 1.0;
    return MicrofacetDistribution(burley_roughness(scale * bsdf.roughness.value, bsdf.anisotropic.value));
  }
  double total() const { return weights[0] + weights[1] + weights[2] + weights[3]; }

  const PrincipledThinBsdf& bsdf;
  Vec3 wo;
  double clear, behind, front;
  double weights[4];  ///< sampling weights: reflecting and transmitting microfacets, the base in front and behind
};

/// `wi` in the sheet's frame, and mirrored to the side of wo.
struct Turned {
  Turned(const Vec3& o, const Vec3& i) : wi(o.z < 0.0 ? mirrored(i) : i), through(wi.z < 0.0) {
    image = through ? mirrored(wi) : wi;
  }
  Vec3 wi;
  bool through;
  Vec3 image;
};

/// Reflectance of microfacets at this angle, partly in the tint of the base.
Vec3 reflectance(const PrincipledThinBsdf& bsdf, double wo_h) {
  const double eta = bsdf.eta.value, tinted = bsdf.spec_tint.value, r0 = std::pow((eta - 1.0) / (eta + 1.0), 2);
  const Fresnel fresnel = fresnel_dielectric(wo_h, 1.0, eta);
  const double outer = eta < 1.0 ? fresnel.cos_transmitted : wo_h;
  return (1.0 - tinted) * Vec3(fresnel.reflectance) + tinted * schlick(r0 * tint_of(bsdf.base_color.value), outer);
}

}  // namespace

Vec3 eval(const PrincipledThinBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z == 0.0 || wi.z == 0.0) return Vec3(0.0);
  const Sheet sheet(bsdf, wo);
  const Turned to(wo, wi);
  const Vec3 h = glm::normalize(sheet.wo + to.image), &color = bsdf.base_color.value;
  const double wo_h = glm::dot(sheet.wo, h);
  const MicrofacetDistribution facets = sheet.facets(to.through);
  double glossy =
      sheet.clear * facets.density(h) * facets.masking(sheet.wo, h) * facets.masking(to.image, h) / (4.0 * sheet.wo.z);
  if (to.through) {
    if (glm::dot(to.wi, h) >= 0.0) glossy = 0.0;
    glossy *= 1.0 - fresnel_dielectric(wo_h, 1.0, bsdf.eta.value).reflectance;
    return color * (glossy + sheet.behind * to.image.z / kPi);
  }
  const BurleyAngles angles{sheet.wo.z, to.wi.z, wo_h};
  const Vec3 base = color * (burley_base(bsdf.roughness.value, bsdf.flatness.value, angles) / kPi) +
                    bsdf.sheen.value * burley_sheen(bsdf.sheen_tint.value, color, angles);
  return glossy * reflectance(bsdf, wo_h) + sheet.front * to.wi.z * base;
}

double pdf(const PrincipledThinBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z == 0.0 || wi.z == 0.0) return 0.0;
  const Sheet sheet(bsdf, wo);
  const Turned to(wo, wi);
  const Vec3 h = glm::normalize(sheet.wo + to.image);
  const double facets = sheet.facets(to.through).visible_density(sheet.wo, h) / (4.0 * glm::dot(sheet.wo, h));
  const double base = to.image.z / kPi;
  return (sheet.weights[to.through ? 1 : 0] * facets + sheet.weights[to.through ? 3 : 2] * base) / sheet.total();
}

BsdfSample sample(const PrincipledThinBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u) {
  if (wo.z == 0.0) return {};
  const Sheet sheet(bsdf, wo);
  double x = u_lobe * sheet.total();
  int chosen = 0;
  while (chosen < 3 && x >= sheet.weights[chosen]) x -= sheet.weights[chosen++];
  const bool through = chosen == 1 || chosen == 3;
  Vec3 wi;
  if (chosen < 2) {
    const Vec3 h = sheet.facets(through).sample_visible(sheet.wo, u);
    wi = 2.0 * glm::dot(sheet.wo, h) * h - sheet.wo;
  } else {
    wi = square_to_cosine_hemisphere(u);
  }
  if (wi.z <= 0.0) return {};
  if (through != (wo.z < 0.0)) wi = mirrored(wi);
  constexpr Lobe kLobes[] = {Lobe::glossy_reflection, Lobe::glossy_transmission, Lobe::diffuse_reflection,
                             Lobe::diffuse_transmission};
  return weighed_by_all_lobes(bsdf, wo, wi, kLobes[chosen]);
}

}  // namespace etendue::reference
