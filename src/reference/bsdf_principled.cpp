/// Burley's principled material: the reflecting one of 2012 and its extension to refraction of 2015 [Burley2012]
/// [Burley2015], with Mitsuba's parameters.

#include <algorithm>
#include <cmath>

#include "reference/bsdf.h"
#include "reference/burley_base.h"
#include "reference/fresnel.h"
#include "reference/microfacet_distribution.h"
#include "reference/sampling.h"
#include "scene/limits.h"

namespace etendue::reference {
namespace {

/// The coat's microfacets: generalised Trowbridge–Reitz with γ = 1 [Burley2012, appendix B].
struct Coat {
  explicit Coat(double gloss) : alpha(glm::mix(0.1, 0.001, gloss)) {}
  double density(const Vec3& h) const {
    const double a2 = alpha * alpha;
    return (a2 - 1.0) / (kPi * std::log(a2) * (1.0 + (a2 - 1.0) * h.z * h.z));
  }
  /// Samples in proportion to D(h) h.z.
  Vec3 sample(const Vec2& u) const {
    const double a2 = alpha * alpha, z2 = (1.0 - std::pow(a2, 1.0 - u.x)) / (1.0 - a2);
    const double r = std::sqrt(std::max(0.0, 1.0 - z2)), phi = 2.0 * kPi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), std::sqrt(z2)};
  }
  double alpha;
};

/// The material seen from the side of `wo`, which is turned to z > 0.
struct PrincipledView {
  PrincipledView(const PrincipledBsdf& b, const Vec3& o)
      : bsdf(b),
        front(o.z > 0.0),
        side(front ? 1.0 : -1.0),
        wo(o.x, o.y, side * o.z),
        n_o(front ? 1.0 : b.eta.value),
        n_i(front ? b.eta.value : 1.0),
        metallic(b.metallic.value),
        clear((1.0 - metallic) * b.spec_trans.value),
        opaque((1.0 - metallic) * (1.0 - b.spec_trans.value)),
        facets(burley_roughness(b.roughness.value, b.anisotropic.value)),
        coat(b.clearcoat_gloss.value) {
    if (!front) return;
    const double mirrored = std::max(0.1, fresnel_dielectric(wo.z, n_o, n_i).reflectance);
    facet_weight = metallic + clear + opaque * mirrored;
    base_weight = opaque + (1.0 - metallic) * 0.25 * b.sheen.value;
    coat_weight = 0.25 * b.clearcoat.value;
  }
  bool black() const { return wo.z <= 0.0 || (!front && clear == 0.0); }
  double total() const { return facet_weight + base_weight + coat_weight; }
  /// The probability that a sample of the microfacets is transmitted by one of reflectance `f`.
  double passing(double f) const { return front ? clear * (1.0 - f) / facet_weight : 1.0 - f; }

  const PrincipledBsdf& bsdf;
  bool front;
  double side;
  Vec3 wo;
  double n_o, n_i, metallic, clear, opaque;
  MicrofacetDistribution facets;
  Coat coat;
  double facet_weight = 1.0, base_weight = 0.0, coat_weight = 0.0;
};

/// A pair of directions and their half vector.
struct PrincipledMeeting {
  PrincipledMeeting(const PrincipledView& s, const Vec3& i) : wi(i.x, i.y, s.side * i.z), reflected(wi.z > 0.0) {
    h = glm::normalize(reflected ? s.wo + wi : s.n_o * s.wo + s.n_i * wi);
    if (h.z < 0.0) h = -h;
    wo_h = glm::dot(s.wo, h);
    wi_h = glm::dot(wi, h);
    possible = wi.z != 0.0 && wo_h > 0.0 && wi_h * wi.z > 0.0 && (reflected || s.clear > 0.0);
    if (!possible) return;
    const Fresnel f = fresnel_dielectric(wo_h, s.n_o, s.n_i);
    fresnel = f.reflectance;
    outer = s.n_i < s.n_o ? f.cos_transmitted : wo_h;
  }
  double normals_by_directions(const PrincipledView& s) const {
    if (reflected) return 1.0 / (4.0 * wo_h);
    const double sum = s.n_o * wo_h + s.n_i * wi_h;
    return s.n_i * s.n_i * std::abs(wi_h) / (sum * sum);
  }
  Vec3 wi, h{0.0};
  bool reflected, possible = false;
  double wo_h = 0.0, wi_h = 0.0, fresnel = 0.0;
  double outer = 0.0;  ///< cosine on the side of the smaller index
};

/// Reflectance of microfacets: a mixture of a metal of the base's colour, a dielectric, and a dielectric with tinted
/// reflection.
Vec3 facet_reflectance(const PrincipledView& s, const PrincipledMeeting& m) {
  if (!s.front) return Vec3(s.clear * m.fresnel);
  const double tinted = s.bsdf.spec_tint.value, r0 = std::pow((s.n_i - s.n_o) / (s.n_i + s.n_o), 2);
  const Vec3 dielectric =
      (1.0 - tinted) * Vec3(m.fresnel) + tinted * schlick(r0 * tint_of(s.bsdf.base_color.value), m.outer);
  return s.metallic * schlick(s.bsdf.base_color.value, m.wo_h) + (1.0 - s.metallic) * dielectric;
}

/// f of the base and the sheen.
Vec3 base_and_sheen(const PrincipledView& s, const PrincipledMeeting& m) {
  const BurleyAngles angles{s.wo.z, m.wi.z, m.wi_h};
  const Vec3& color = s.bsdf.base_color.value;
  return s.opaque / kPi * burley_base(s.bsdf.roughness.value, s.bsdf.flatness.value, angles) * color +
         (1.0 - s.metallic) * s.bsdf.sheen.value * burley_sheen(s.bsdf.sheen_tint.value, color, angles);
}

}  // namespace

Vec3 eval(const PrincipledBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  const PrincipledView s(bsdf, wo);
  if (s.black()) return Vec3(0.0);
  const PrincipledMeeting m(s, wi);
  if (!m.possible) return Vec3(0.0);
  const double visible = s.facets.density(m.h) * s.facets.masking(s.wo, m.h) * s.facets.masking(m.wi, m.h) * m.wo_h *
                         m.normals_by_directions(s) / s.wo.z;
  if (!m.reflected) {
    const double scaling = s.n_o / s.n_i;  // radiance scaling
    return glm::sqrt(bsdf.base_color.value) * (s.clear * (1.0 - m.fresnel) * visible * scaling * scaling);
  }
  Vec3 value = facet_reflectance(s, m) * visible;
  if (!s.front) return value;
  value += base_and_sheen(s, m) * m.wi.z;
  const MicrofacetDistribution quarter({Roughness::Distribution::ggx, 0.25, 0.25});
  const double coat =
      schlick(Vec3(0.04), m.wo_h).x * s.coat.density(m.h) * quarter.masking(s.wo, m.h) * quarter.masking(m.wi, m.h);
  return value + Vec3(0.25 * bsdf.clearcoat.value * coat * m.wi.z);
}

double pdf(const PrincipledBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  const PrincipledView s(bsdf, wo);
  if (s.black()) return 0.0;
  const PrincipledMeeting m(s, wi);
  if (!m.possible) return 0.0;
  const double passing = s.passing(m.fresnel);
  const double facets =
      (m.reflected ? 1.0 - passing : passing) * s.facets.visible_density(s.wo, m.h) * m.normals_by_directions(s);
  if (!m.reflected) return s.facet_weight * facets / s.total();
  return (s.facet_weight * facets + s.base_weight * m.wi.z / kPi +
          s.coat_weight * s.coat.density(m.h) * m.h.z / (4.0 * m.wo_h)) /
         s.total();
}

BsdfSample sample(const PrincipledBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u) {
  const PrincipledView s(bsdf, wo);
  if (s.black()) return {};
  const double x = u_lobe * s.total();
  Lobe lobe = Lobe::glossy_reflection;
  Vec3 wi;
  if (x < s.facet_weight) {
    const Vec3 h = s.facets.sample_visible(s.wo, u);
    const double cos_o = glm::dot(s.wo, h);
    const Fresnel fresnel = fresnel_dielectric(cos_o, s.n_o, s.n_i);
    const double ratio = s.n_o / s.n_i;
    wi = 2.0 * cos_o * h - s.wo;
    if (x >= s.facet_weight * (1.0 - s.passing(fresnel.reflectance))) {
      lobe = Lobe::glossy_transmission;
      wi = (ratio * cos_o - fresnel.cos_transmitted) * h - ratio * s.wo;
    }
  } else if (x < s.facet_weight + s.base_weight) {
    lobe = Lobe::diffuse_reflection;
    wi = square_to_cosine_hemisphere(u);
  } else {
    const Vec3 h = s.coat.sample(u);
    wi = 2.0 * glm::dot(s.wo, h) * h - s.wo;
  }
  const bool through = lobe == Lobe::glossy_transmission;
  if (through ? wi.z >= 0.0 : wi.z <= 0.0) return {};
  wi.z *= s.side;
  return weighed_by_all_lobes(bsdf, wo, wi, lobe, through ? s.n_i / s.n_o : 1.0);
}

}  // namespace etendue::reference
