#pragma once
/// Materials. The contract, the same for every one of them:
/// - directions are unit vectors in the local shading frame, +Z is `ns`, and point away from the surface;
/// - `eval` is f · |cos θ_i| and `pdf` the density of `sample` w.r.t. solid angle; both are 0 for delta lobes;
/// - `sample` returns `weight` = eval / pdf; `pdf` = 0 and lobe `none` mean that there is no sample; delta lobes return
///   their discrete probability as `pdf`; every random number is in [0,1).

#include <cstdint>
#include <variant>

#include "reference/vec.h"
#include "scene/materials.h"
#include "scene/scene.h"

namespace etendue::reference {

/// Values are those of the path signature.
enum class Lobe : std::uint32_t {
  none = 0,
  diffuse_reflection = 1,
  delta_reflection = 2,
  delta_transmission = 3,
  glossy_reflection = 4,
  glossy_transmission = 5,
  passed = 6,  ///< the ray passed the surface
  diffuse_transmission = 7
};

inline bool is_delta(Lobe lobe) {
  return lobe == Lobe::delta_reflection || lobe == Lobe::delta_transmission;
}

struct BsdfSample {
  Vec3 wi{0.0};
  Vec3 weight{0.0};
  double pdf = 0.0;
  Lobe lobe = Lobe::none;
  double eta = 1.0;  ///< n_i / n_o: ratio of the index on the side of `wi` to that on the side of `wo`
};

Vec3 eval(const DiffuseBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const DiffuseBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const DiffuseBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const MirrorBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const MirrorBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const MirrorBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const DielectricBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const DielectricBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const DielectricBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const MicrofacetBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const MicrofacetBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const MicrofacetBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const ConductorBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const ConductorBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const ConductorBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const RoughConductorBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const RoughConductorBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const RoughConductorBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const RoughDielectricBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const RoughDielectricBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const RoughDielectricBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const ThinDielectricBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const ThinDielectricBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const ThinDielectricBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const PlasticBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const PlasticBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const PlasticBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const RoughPlasticBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const RoughPlasticBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const RoughPlasticBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const NullBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const NullBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const NullBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const PrincipledBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const PrincipledBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const PrincipledBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const PrincipledThinBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const PrincipledThinBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const PrincipledThinBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

Vec3 eval(const GltfBsdf& bsdf, const Vec3& wo, const Vec3& wi);
double pdf(const GltfBsdf& bsdf, const Vec3& wo, const Vec3& wi);
BsdfSample sample(const GltfBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u);

/// The result of `sample` for a material with overlapping lobes: whichever lobe proposed `wi`, the weight uses the
/// density of all. No sample if that density is zero.
template <typename T>
BsdfSample weighed_by_all_lobes(const T& bsdf, const Vec3& wo, const Vec3& wi, Lobe lobe, double eta = 1.0) {
  const double density = pdf(bsdf, wo, wi);
  if (density == 0.0) return {};
  return {.wi = wi, .weight = eval(bsdf, wo, wi) / density, .pdf = density, .lobe = lobe, .eta = eta};
}

inline Vec3 eval(const Bsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  return std::visit([&](const auto& b) { return eval(b, wo, wi); }, bsdf);
}
inline double pdf(const Bsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  return std::visit([&](const auto& b) { return pdf(b, wo, wi); }, bsdf);
}
inline BsdfSample sample(const Bsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u) {
  return std::visit([&](const auto& b) { return sample(b, wo, u_lobe, u); }, bsdf);
}

/// Properties of a material that hold at every point and for all directions; every material must state them.
struct BsdfTraits {
  bool delta = false;         ///< only delta lobes scatter, so light sampling finds nothing
  bool one_sided = false;     ///< the side behind the normal is black
  bool transmissive = false;  ///< light from both sides is scattered to both, and not only by delta lobes
};
constexpr BsdfTraits traits(const DiffuseBsdf&) {
  return {.delta = false, .one_sided = true};
}
constexpr BsdfTraits traits(const MirrorBsdf&) {
  return {.delta = true, .one_sided = true};
}
constexpr BsdfTraits traits(const DielectricBsdf&) {
  return {.delta = true, .one_sided = false};
}
constexpr BsdfTraits traits(const MicrofacetBsdf&) {
  return {.delta = false, .one_sided = true};
}
constexpr BsdfTraits traits(const ConductorBsdf&) {
  return {.delta = true, .one_sided = true};
}
constexpr BsdfTraits traits(const RoughConductorBsdf&) {
  return {.delta = false, .one_sided = true};
}
constexpr BsdfTraits traits(const RoughDielectricBsdf&) {
  return {.delta = false, .one_sided = false, .transmissive = true};
}
constexpr BsdfTraits traits(const ThinDielectricBsdf&) {
  return {.delta = true, .one_sided = false};
}
constexpr BsdfTraits traits(const PlasticBsdf&) {
  return {.delta = false, .one_sided = true};
}
constexpr BsdfTraits traits(const RoughPlasticBsdf&) {
  return {.delta = false, .one_sided = true};
}
constexpr BsdfTraits traits(const NullBsdf&) {
  return {.delta = true, .one_sided = false};
}
inline BsdfTraits traits(const PrincipledBsdf& bsdf) {
  const bool refracts = may_refract(bsdf);
  return {.delta = false, .one_sided = !refracts, .transmissive = refracts};
}
constexpr BsdfTraits traits(const PrincipledThinBsdf&) {
  return {.delta = false, .one_sided = false, .transmissive = true};
}
inline BsdfTraits traits(const GltfBsdf& bsdf) {
  const bool passes = may_refract(bsdf);
  return {.delta = false, .one_sided = !passes, .transmissive = passes};
}
inline BsdfTraits traits(const Bsdf& bsdf) {
  return std::visit([](const auto& b) { return traits(b); }, bsdf);
}
inline bool is_delta(const Bsdf& bsdf) {
  return traits(bsdf).delta;
}
inline bool is_one_sided(const Bsdf& bsdf) {
  return traits(bsdf).one_sided;
}

}  // namespace etendue::reference
