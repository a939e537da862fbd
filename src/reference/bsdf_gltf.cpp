/// The material of glTF 2.0 and of the extensions of Khronos [Khronos2021], in layers, where the reflection of each is
/// subtracted from those below; docs/conventions.md, "glTF".

#include <algorithm>
#include <array>
#include <cmath>

#include "reference/bsdf.h"
#include "reference/burley_base.h"
#include "reference/frame.h"
#include "reference/fresnel.h"
#include "reference/microfacet_distribution.h"
#include "reference/sampling.h"
#include "reference/sheen.h"
#include "reference/thin_film.h"
#include "scene/limits.h"

namespace etendue::reference {
namespace {

double largest(const Vec3& v) {
  return std::max({v.x, v.y, v.z});
}
Vec3 turned(const Vec3& w, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * w.x - s * w.y, s * w.x + c * w.y, w.z};
}
double squared_roughness(double roughness) {
  return std::max(kMinRoughness, roughness * roughness);
}

/// α along and across the tangent.
Roughness facets_of(const GltfBsdf& b) {
  const double alpha = b.roughness.value * b.roughness.value;
  const double along = glm::mix(alpha, 1.0, b.anisotropy.value * b.anisotropy.value);
  return {Roughness::Distribution::ggx, std::max(kMinRoughness, along), std::max(kMinRoughness, alpha)};
}

/// An upper bound for the mean of (1 − c)⁵ over the visible GGX microfacets of this roughness.
double grazing_share(double cosine, double alpha) {
  const double rough = (1.0 - cosine) * (1.0 - cosine) / (1.0 + 16.0 * alpha);
  return std::min(1.0, 0.0026 + std::min(schlick_weight(cosine), rough));
}

/// The material seen from the side of `wo`. Directions are in the frame of its tangent, with z > 0 on the side of wo.
struct GltfView {
  /// In the order of sampling.
  enum Part { facets, front, behind, coat, sheen };
  static constexpr std::size_t kParts = 5;

  GltfView(const GltfBsdf& b, const Vec3& o)
      : bsdf(b),
        side(o.z < 0.0 ? -1.0 : 1.0),
        all_layers(side > 0.0 || b.thin),
        clear((1.0 - b.metallic.value) * b.transmission.value),
        opaque((1.0 - b.metallic.value) * (1.0 - b.transmission.value)),
        surface(facets_of(b)),
        coat_alpha(squared_roughness(b.clearcoat_roughness.value)),
        fibres(b.sheen_roughness.value),
        wo(inward(o)) {
    const double bending = b.met.bending_index > 0.0 ? b.met.bending_index : b.ior.value;
    const double ior = b.thin ? 1.0 : std::max(1.001, bending);
    coat_normal = inward(b.met.coat_normal);
    if (coat_normal.z < 0.0) coat_normal = -coat_normal;
    (side > 0.0 ? n_i : n_o) = ior;
    const double root = (b.ior.value - 1.0) / (b.ior.value + 1.0);
    along_normal = glm::min(b.specular_color.value * (root * root), 1.0) * b.specular.value;
    weights[facets] = clear;
    weights[behind] = opaque * b.diffuse_transmission.value;
    if (!all_layers) return;
    weights[facets] += b.metallic.value + opaque * std::max(0.1, largest(dielectric(wo.z)));
    weights[front] = opaque * (1.0 - b.diffuse_transmission.value);
    weights[coat] = b.clearcoat.value * std::max(0.1, coat_albedo(wo));
    weights[sheen] = largest(b.sheen_color.value) / 2.0;
  }

  Vec3 inward(const Vec3& w) const {
    const Vec3 t = turned(w, -bsdf.anisotropy_rotation);
    return {t.x, t.y, side * t.z};
  }
  Vec3 outward(const Vec3& w) const { return turned({w.x, w.y, side * w.z}, bsdf.anisotropy_rotation); }
  bool black() const { return wo.z <= 0.0 || (side < 0.0 && !may_refract(bsdf)); }
  double total() const { return weights[0] + weights[1] + weights[2] + weights[3] + weights[4]; }

  /// Reflectance of the non-metallic part, as a function of the cosine outside.
  Vec3 dielectric(double c) const {
    return below_film(along_normal + (Vec3(bsdf.specular.value) - along_normal) * schlick_weight(c), along_normal, c);
  }
  Vec3 metal(double c) const { return below_film(schlick(bsdf.base_color.value, c), bsdf.base_color.value, c); }
  /// The reflectance of the base, changed by a film on it.
  Vec3 below_film(const Vec3& bare, const Vec3& normal, double c) const {
    if (bsdf.iridescence.value == 0.0) return bare;
    return glm::mix(bare, film(normal).reflectance(c), bsdf.iridescence.value);
  }
  ThinFilm film(const Vec3& normal) const {
    return {bsdf.iridescence_ior.value, bsdf.iridescence_thickness.value, normal};
  }
  /// The cosine by which a microfacet reflects: that on the outside.
  double outside(double wo_h) const { return n_i < n_o ? fresnel_dielectric(wo_h, n_o, n_i).cos_transmitted : wo_h; }
  /// The fraction of the microfacets' samples that transmit, if this much is reflected.
  double passing(double wo_h) const {
    const double c = outside(wo_h);
    if (weights[facets] == 0.0 || (n_i < n_o && c == 0.0)) return 0.0;
    return clear * (1.0 - largest(dielectric(c))) / weights[facets];
  }
  /// Upper bounds for what the boundary and the coat reflect of light from a direction.
  double boundary_albedo(double cosine) const {
    const double least = largest(along_normal), alpha = std::min(surface.alpha_u.value, surface.alpha_v.value);
    const double grazing = grazing_share(cosine, alpha), most = largest(film(along_normal).bound());
    return glm::mix(least + (bsdf.specular.value - least) * grazing, most + (1.0 - most) * grazing,
                    bsdf.iridescence.value);
  }
  /// An upper bound for what the coat reflects of light from a direction, by its own normal.
  double coat_albedo(const Vec3& w) const {
    return bsdf.clearcoat.value * (0.04 + 0.96 * grazing_share(std::abs(glm::dot(w, coat_normal)), coat_alpha));
  }

  const GltfBsdf& bsdf;
  double side;
  bool all_layers;
  double clear, opaque;
  Roughness surface;
  double coat_alpha;
  Sheen fibres;
  Vec3 wo;
  Vec3 coat_normal{0.0, 0.0, 1.0};
  double n_o = 1.0, n_i = 1.0;
  Vec3 along_normal{0.0};
  std::array<double, kParts> weights{};
};

/// A direction in the material's frame, with the half vector.
struct GltfMeeting {
  GltfMeeting(const GltfView& s, const Vec3& i) : wi(s.inward(i)), through(wi.z < 0.0) {
    image = s.bsdf.thin && through ? Vec3(wi.x, wi.y, -wi.z) : wi;
    h = glm::normalize(image.z > 0.0 ? s.wo + image : s.n_o * s.wo + s.n_i * image);
    if (h.z < 0.0) h = -h;
    wo_h = glm::dot(s.wo, h);
    wi_h = glm::dot(image, h);
    met = wo_h > 0.0 && wi_h * image.z > 0.0;
    possible = wi.z != 0.0 && (!through || may_refract(s.bsdf));
  }
  double normals_by_directions(const GltfView& s) const {
    if (image.z > 0.0) return 1.0 / (4.0 * wo_h);
    const double sum = s.n_o * wo_h + s.n_i * wi_h;
    return s.n_i * s.n_i * std::abs(wi_h) / (sum * sum);
  }
  Vec3 wi, image, h;
  double wo_h, wi_h;
  bool through, met, possible;
};

/// The light that coat and sheen leave to the layers below, and the factor that keeps the sheen from reflecting more
/// than arrives.
struct Layers {
  Layers(const GltfView& s, const GltfMeeting& m) {
    if (!s.all_layers && !m.through) return;
    double a = s.wo.z, b = std::abs(m.wi.z);
    if (m.through && !s.bsdf.thin) (s.side > 0.0 ? b : a) = s.side > 0.0 ? a : b;  // only one side has the layers
    const bool inside_too = m.through && !s.bsdf.thin;
    const Vec3& first = inside_too && s.side < 0.0 ? m.wi : s.wo;
    const Vec3& second = inside_too ? first : m.wi;
    below_coat = 1.0 - std::max(s.coat_albedo(first), s.coat_albedo(second));
    const double sheen = largest(s.bsdf.sheen_color.value);
    if (sheen == 0.0) return;
    const double most = std::max(s.fibres.albedo(a), s.fibres.albedo(b));
    below_sheen = 1.0 - sheen * std::min(1.0, most);
    norm = 1.0 / std::max(1.0, most);
  }
  double below_coat = 1.0, below_sheen = 1.0, norm = 1.0;
};

Vec3 base(const GltfView& s, const GltfMeeting& m) {
  const double cos_i = std::abs(m.wi.z), shared = s.bsdf.diffuse_transmission.value;
  const double lit = s.opaque * (1.0 - std::max(s.boundary_albedo(s.wo.z), s.boundary_albedo(cos_i))) * cos_i / kPi;
  if (m.through) return lit * shared * s.bsdf.diffuse_transmission_color.value;
  return s.all_layers ? lit * (1.0 - shared) * s.bsdf.base_color.value : Vec3(0.0);
}

double seen_facets(const Roughness& roughness, const GltfView& s, const GltfMeeting& m) {
  const MicrofacetDistribution d(roughness);
  return d.density(m.h) * d.masking(s.wo, m.h) * d.masking(m.image, m.h) * m.wo_h * m.normals_by_directions(s) / s.wo.z;
}

/// The coat's microfacets as seen along its own normal.
struct CoatView {
  CoatView(const GltfView& s, const GltfMeeting& m)
      : frame(s.coat_normal),
        wo(frame.to_local(s.wo)),
        wi(frame.to_local(m.wi)),
        h(frame.to_local(m.h)),
        wo_h(m.wo_h) {}
  bool met() const { return wo.z > 0.0 && h.z > 0.0; }
  double value(const MicrofacetDistribution& d) const {
    if (!met() || wi.z <= 0.0) return 0.0;
    return d.density(h) * d.masking(wo, h) * d.masking(wi, h) * wo_h * (1.0 / (4.0 * wo_h)) / wo.z;
  }
  double density(const MicrofacetDistribution& d) const {
    return met() ? d.visible_density(wo, h) / (4.0 * wo_h) : 0.0;
  }
  Frame frame;
  Vec3 wo, wi, h;
  double wo_h;
};

Vec3 microfacets(const GltfView& s, const GltfMeeting& m) {
  if (!m.met) return Vec3(0.0);
  const Vec3& color = s.bsdf.base_color.value;
  const Vec3 dielectric = s.dielectric(s.outside(m.wo_h));
  const double visible = seen_facets(s.surface, s, m), scaling = s.n_o / s.n_i;
  if (m.through) return s.clear * (1.0 - largest(dielectric)) * scaling * scaling * visible * color;
  if (!s.all_layers) return s.clear * visible * dielectric;
  return visible * glm::mix(dielectric, s.metal(m.wo_h), s.bsdf.metallic.value);
}

}  // namespace

Vec3 eval(const GltfBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  const GltfView s(bsdf, wo);
  if (s.black() || s.total() == 0.0) return Vec3(0.0);
  const GltfMeeting m(s, wi);
  if (!m.possible) return Vec3(0.0);
  const Layers layers(s, m);
  Vec3 value = layers.below_coat * layers.below_sheen * (base(s, m) + microfacets(s, m));
  if (m.through || !s.all_layers) return value;
  const Roughness coat{Roughness::Distribution::ggx, s.coat_alpha, s.coat_alpha};
  value += bsdf.clearcoat.value * schlick(Vec3(0.04), m.wo_h) * CoatView(s, m).value(MicrofacetDistribution(coat));
  return value + bsdf.sheen_color.value * (layers.below_coat * layers.norm * s.fibres.lobe(s.wo.z, m.wi.z, m.h.z));
}

double pdf(const GltfBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  const GltfView s(bsdf, wo);
  if (s.black() || s.total() == 0.0) return 0.0;
  const GltfMeeting m(s, wi);
  if (!m.possible) return 0.0;
  double density = s.weights[m.through ? GltfView::behind : GltfView::front] * std::abs(m.wi.z) / kPi;
  if (m.met) {
    const double passing = s.passing(m.wo_h), chosen = m.through ? passing : 1.0 - passing;
    density += s.weights[GltfView::facets] * chosen * MicrofacetDistribution(s.surface).visible_density(s.wo, m.h) *
               m.normals_by_directions(s);
  }
  if (!m.through) {
    const MicrofacetDistribution coat({Roughness::Distribution::ggx, s.coat_alpha, s.coat_alpha});
    density += s.weights[GltfView::coat] * CoatView(s, m).density(coat) + s.weights[GltfView::sheen] / (2.0 * kPi);
  }
  return density / s.total();
}

namespace {

/// A direction sampled from the microfacets; z = 0 if there is none.
Vec3 sample_facets(const GltfView& s, double x, const Vec2& u, Lobe& lobe) {
  const Vec3 h = MicrofacetDistribution(s.surface).sample_visible(s.wo, u);
  const double wo_h = glm::dot(s.wo, h);
  const Vec3 reflected = 2.0 * wo_h * h - s.wo;
  if (x < s.weights[GltfView::facets] * (1.0 - s.passing(wo_h))) {
    lobe = Lobe::glossy_reflection;
    return reflected;
  }
  lobe = Lobe::glossy_transmission;
  if (s.bsdf.thin) return {reflected.x, reflected.y, -reflected.z};
  const double ratio = s.n_o / s.n_i;
  return (ratio * wo_h - fresnel_dielectric(wo_h, s.n_o, s.n_i).cos_transmitted) * h - ratio * s.wo;
}

/// A direction sampled from the other lobe that x chooses.
Vec3 sample_rest(const GltfView& s, double x, const Vec2& u, Lobe& lobe) {
  lobe = Lobe::diffuse_reflection;
  if (x < s.weights[GltfView::front]) return square_to_cosine_hemisphere(u);
  x -= s.weights[GltfView::front];
  if (x < s.weights[GltfView::behind]) {
    lobe = Lobe::diffuse_transmission;
    const Vec3 w = square_to_cosine_hemisphere(u);
    return {w.x, w.y, -w.z};
  }
  if (x - s.weights[GltfView::behind] < s.weights[GltfView::coat]) {
    lobe = Lobe::glossy_reflection;
    const Frame frame(s.coat_normal);
    const MicrofacetDistribution coat({Roughness::Distribution::ggx, s.coat_alpha, s.coat_alpha});
    const Vec3 h = frame.to_world(coat.sample_visible(frame.to_local(s.wo), u));
    return 2.0 * glm::dot(s.wo, h) * h - s.wo;
  }
  const double z = 1.0 - u.x, r = std::sqrt(std::max(0.0, 1.0 - z * z)), phi = 2.0 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

}  // namespace

BsdfSample sample(const GltfBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u) {
  const GltfView s(bsdf, wo);
  if (s.black() || s.total() == 0.0) return {};
  const double x = u_lobe * s.total();
  Lobe lobe = Lobe::none;
  const bool facets = x < s.weights[GltfView::facets];
  const Vec3 local = facets ? sample_facets(s, x, u, lobe) : sample_rest(s, x - s.weights[GltfView::facets], u, lobe);
  const bool through = lobe == Lobe::glossy_transmission || lobe == Lobe::diffuse_transmission;
  if (through ? local.z >= 0.0 : local.z <= 0.0) return {};
  const Vec3 wi = s.outward(local);
  return weighed_by_all_lobes(bsdf, wo, wi, lobe, through ? s.n_i / s.n_o : 1.0);
}

}  // namespace etendue::reference
