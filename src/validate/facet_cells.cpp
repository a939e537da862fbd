#include "validate/facet_cells.h"

#include <algorithm>
#include <cmath>

namespace etendue {
namespace {

constexpr double kNarrow = 0.2;  // a lobe of this roughness covers several cells of ten rings

std::optional<Roughness> if_narrow(const Roughness& roughness) {
  return std::min(roughness.alpha_u.value, roughness.alpha_v.value) < kNarrow ? std::optional(roughness) : std::nullopt;
}

Roughness isotropic(double alpha) {
  return {Roughness::Distribution::ggx, std::max(1e-3, alpha), std::max(1e-3, alpha)};
}
Roughness burley(double roughness, double anisotropic) {
  const double squared = roughness * roughness, aspect = std::sqrt(1.0 - 0.9 * anisotropic);
  return {Roughness::Distribution::ggx, std::max(1e-3, squared / aspect), std::max(1e-3, squared * aspect)};
}
/// For two kinds of facets, cells that resolve the narrower one also resolve the other.
std::optional<Roughness> narrower(const Roughness& a, const Roughness& b) {
  const auto least = [](const Roughness& r) { return std::min(r.alpha_u.value, r.alpha_v.value); };
  return if_narrow(least(a) <= least(b) ? a : b);
}

struct RoughnessOf {
  std::optional<Roughness> operator()(const DiffuseBsdf&) const { return std::nullopt; }
  std::optional<Roughness> operator()(const MirrorBsdf&) const { return std::nullopt; }
  std::optional<Roughness> operator()(const DielectricBsdf&) const { return std::nullopt; }
  std::optional<Roughness> operator()(const ConductorBsdf&) const { return std::nullopt; }
  std::optional<Roughness> operator()(const MicrofacetBsdf& bsdf) const {
    return if_narrow({Roughness::Distribution::beckmann, bsdf.alpha, bsdf.alpha});
  }
  std::optional<Roughness> operator()(const PrincipledBsdf& bsdf) const {
    const Roughness coat = isotropic(0.1 - 0.099 * bsdf.clearcoat_gloss.value);
    return narrower(burley(bsdf.roughness.value, bsdf.anisotropic.value),
                    bsdf.clearcoat.value > 0.0 ? coat : isotropic(1.0));
  }
  std::optional<Roughness> operator()(const PrincipledThinBsdf& bsdf) const {
    const double scaled = (0.65 * bsdf.eta.value - 0.35) * bsdf.roughness.value;
    if (bsdf.spec_trans.value == 0.0) return std::nullopt;
    return narrower(burley(bsdf.roughness.value, bsdf.anisotropic.value), burley(scaled, bsdf.anisotropic.value));
  }
  std::optional<Roughness> operator()(const GltfBsdf& bsdf) const {
    // Light that is scattered behind a boundary that bends it also goes where no facet would send it.
    if (!bsdf.thin && bsdf.diffuse_transmission.value > 0.0) return std::nullopt;
    const double coat = bsdf.clearcoat.value > 0.0 ? bsdf.clearcoat_roughness.value : 1.0;
    return narrower(isotropic(bsdf.roughness.value * bsdf.roughness.value), isotropic(coat * coat));
  }
  std::optional<Roughness> operator()(const NullBsdf&) const { return std::nullopt; }
  std::optional<Roughness> operator()(const ThinDielectricBsdf&) const { return std::nullopt; }
  std::optional<Roughness> operator()(const PlasticBsdf&) const { return std::nullopt; }
  std::optional<Roughness> operator()(const RoughPlasticBsdf& bsdf) const {
    return if_narrow({bsdf.distribution, bsdf.alpha, bsdf.alpha});
  }
  std::optional<Roughness> operator()(const RoughDielectricBsdf& bsdf) const { return if_narrow(bsdf.roughness); }
  std::optional<Roughness> operator()(const RoughConductorBsdf& bsdf) const { return if_narrow(bsdf.roughness); }
};

}  // namespace

std::optional<Roughness> narrow_roughness(const Bsdf& bsdf) {
  return std::visit(RoughnessOf{}, bsdf);
}

FacetCells::FacetCells(const Roughness& roughness, const glm::dvec3& wo, double eta)
    : roughness_(roughness), wo_(wo.x, wo.y, std::abs(wo.z)), eta_(eta), turned_(wo.z < 0.0) {}

FacetCell FacetCells::cell_of(const glm::dvec3& direction) const {
  const glm::dvec3 wi(direction.x, direction.y, turned_ ? -direction.z : direction.z);
  const bool reflected = wi.z >= 0.0;
  glm::dvec3 h = reflected ? wo_ + wi : eta_ == 1.0 ? wo_ + glm::dvec3(wi.x, wi.y, -wi.z) : wo_ + eta_ * wi;
  if (h.z < 0.0) h = -h;
  const double x = h.x / (roughness_.alpha_u.value * h.z), y = h.y / (roughness_.alpha_v.value * h.z);
  const double root = std::sqrt(std::hypot(x, y)), height = std::isfinite(root) ? root / (1.0 + root) : 1.0;
  return {reflected ? height : -height, std::atan2(y, x)};
}

FacetCells::Direction FacetCells::direction_of(const FacetCell& cell) const {
  const double q = std::abs(cell.height), root = q / (1.0 - q), slope = root * root;
  const double x = roughness_.alpha_u.value * slope * std::cos(cell.phi),
               y = roughness_.alpha_v.value * slope * std::sin(cell.phi);
  const glm::dvec3 h = glm::normalize(glm::dvec3(x, y, 1.0));
  // Slopes per (q, φ): ρ dρ dφ with dρ/dq = 2 root/(1 − q)²; solid angle of h per slopes: h.z³.
  const double of_h = roughness_.alpha_u.value * roughness_.alpha_v.value * slope * 2.0 * root /
                      ((1.0 - q) * (1.0 - q)) * h.z * h.z * h.z;
  const double wo_h = glm::dot(wo_, h);
  if (wo_h <= 0.0) return {};
  Direction out;
  if (cell.height >= 0.0 || eta_ == 1.0) {
    out = {2.0 * wo_h * h - wo_, of_h * 4.0 * wo_h};
    if (out.wi.z < 0.0) return {};
    if (cell.height < 0.0) out.wi.z = -out.wi.z;
  } else {
    const double cos2 = 1.0 - (1.0 - wo_h * wo_h) / (eta_ * eta_);
    if (cos2 <= 0.0) return {};
    const double wi_h = -std::sqrt(cos2), sum = wo_h + eta_ * wi_h;
    out = {(wo_h / eta_ + wi_h) * h - wo_ / eta_, of_h * sum * sum / (eta_ * eta_ * -wi_h)};
    if (out.wi.z >= 0.0) return {};
  }
  if (turned_) out.wi.z = -out.wi.z;
  return out;
}

}  // namespace etendue
