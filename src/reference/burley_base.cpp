#include "reference/burley_base.h"

#include <algorithm>
#include <cmath>

#include "scene/limits.h"

namespace etendue::reference {
namespace {}  // namespace

double schlick_weight(double cosine) {
  return std::pow(1.0 - cosine, 5);
}

Vec3 schlick(const Vec3& normal, double cosine) {
  return normal + (1.0 - normal) * schlick_weight(cosine);
}

Vec3 tint_of(const Vec3& color) {
  const double l = luminance(color);
  return l > 0.0 ? color / l : Vec3(1.0);
}

Roughness burley_roughness(double roughness, double anisotropic) {
  const double squared = roughness * roughness, aspect = std::sqrt(1.0 - 0.9 * anisotropic);
  return {Roughness::Distribution::ggx, std::max(kMinRoughness, squared / aspect),
          std::max(kMinRoughness, squared * aspect)};
}

double burley_base(double roughness, double flatness, const BurleyAngles& angles) {
  const double fo = schlick_weight(angles.cos_o), fi = schlick_weight(angles.cos_i);
  const double retro = 2.0 * roughness * angles.cos_d * angles.cos_d;
  const double lambert = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo);
  const double reflected_back = retro * (fo + fi + fo * fi * (retro - 1.0));
  const double f90 = 0.5 * retro;
  const double flat =
      1.25 * (glm::mix(1.0, f90, fo) * glm::mix(1.0, f90, fi) * (1.0 / (angles.cos_o + angles.cos_i) - 0.5) + 0.5);
  return glm::mix(lambert + reflected_back, flat, flatness);
}

Vec3 burley_sheen(double tinted, const Vec3& color, const BurleyAngles& angles) {
  return schlick_weight(angles.cos_d) * glm::mix(Vec3(1.0), tint_of(color), tinted);
}

}  // namespace etendue::reference
