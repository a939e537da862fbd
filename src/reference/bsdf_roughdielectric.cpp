/// Rough boundary between two clear media [Walter2007, eqs. 16, 17, 20, 21]. Paths carry radiance, which is
/// proportional to the squared index of its medium.

#include "reference/bsdf.h"
#include "reference/fresnel.h"
#include "reference/microfacet_distribution.h"

namespace etendue::reference {
namespace {

/// A pair of directions in the boundary's frame, where `wo` is on the side z > 0.
struct Meeting {
  Meeting(const RoughDielectricBsdf& bsdf, const Vec3& o, const Vec3& i) : facets(bsdf.roughness) {
    const double side = o.z < 0.0 ? -1.0 : 1.0;
    wo = {o.x, o.y, side * o.z};
    wi = {i.x, i.y, side * i.z};
    n_o = side > 0.0 ? bsdf.ext_ior : bsdf.int_ior;
    n_i = side > 0.0 ? bsdf.int_ior : bsdf.ext_ior;
    reflected = wi.z > 0.0;
    h = glm::normalize(reflected ? wo + wi : n_o * wo + n_i * wi);
    if (h.z < 0.0) h = -h;
    wo_h = glm::dot(wo, h);
    wi_h = glm::dot(wi, h);
    possible = wo.z > 0.0 && wi.z != 0.0 && wo_h > 0.0 && wi_h * wi.z > 0.0;
    reflectance = possible ? fresnel_dielectric(wo_h, n_o, n_i).reflectance : 0.0;
  }

  /// The derivative dω_h/dω_i.
  double normals_by_directions() const {
    if (reflected) return 1.0 / (4.0 * wo_h);
    const double sum = n_o * wo_h + n_i * wi_h;
    return n_i * n_i * std::abs(wi_h) / (sum * sum);
  }

  MicrofacetDistribution facets;
  Vec3 wo, wi, h;
  double n_o = 1.0, n_i = 1.0, wo_h = 0.0, wi_h = 0.0, reflectance = 0.0;
  bool reflected = false, possible = false;
};

}  // namespace

Vec3 eval(const RoughDielectricBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  const Meeting m(bsdf, wo, wi);
  if (!m.possible) return Vec3(0.0);
  const double common = m.facets.density(m.h) * m.facets.masking(m.wo, m.h) * m.facets.masking(m.wi, m.h) * m.wo_h *
                        m.normals_by_directions() / m.wo.z;
  if (m.reflected) return bsdf.specular_reflectance.value * (m.reflectance * common);
  const double scaling = m.n_o / m.n_i;
  return bsdf.specular_transmittance.value * ((1.0 - m.reflectance) * common * scaling * scaling);
}

double pdf(const RoughDielectricBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  const Meeting m(bsdf, wo, wi);
  if (!m.possible) return 0.0;
  const double chosen = m.reflected ? m.reflectance : 1.0 - m.reflectance;
  return chosen * m.facets.visible_density(m.wo, m.h) * m.normals_by_directions();
}

BsdfSample sample(const RoughDielectricBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u) {
  if (wo.z == 0.0) return {};
  const double side = wo.z < 0.0 ? -1.0 : 1.0;
  const Vec3 o(wo.x, wo.y, side * wo.z);
  const double n_o = side > 0.0 ? bsdf.ext_ior : bsdf.int_ior, n_i = side > 0.0 ? bsdf.int_ior : bsdf.ext_ior;
  const Vec3 h = MicrofacetDistribution(bsdf.roughness).sample_visible(o, u);
  const double cos_o = glm::dot(o, h);
  const Fresnel fresnel = fresnel_dielectric(cos_o, n_o, n_i);
  const bool reflected = u_lobe < fresnel.reflectance;
  Vec3 wi = reflected ? 2.0 * cos_o * h - o : (n_o / n_i * cos_o - fresnel.cos_transmitted) * h - n_o / n_i * o;
  if (reflected ? wi.z <= 0.0 : wi.z >= 0.0) return {};
  wi.z *= side;
  return weighed_by_all_lobes(bsdf, wo, wi, reflected ? Lobe::glossy_reflection : Lobe::glossy_transmission,
                              reflected ? 1.0 : n_i / n_o);
}

}  // namespace etendue::reference
