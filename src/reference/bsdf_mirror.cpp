/// Perfect mirror of reflectance 1 on the side of the normal.

#include "reference/bsdf.h"

namespace etendue::reference {

Vec3 eval(const MirrorBsdf&, const Vec3&, const Vec3&) {
  return Vec3(0.0);
}

double pdf(const MirrorBsdf&, const Vec3&, const Vec3&) {
  return 0.0;
}

BsdfSample sample(const MirrorBsdf&, const Vec3& wo, double, const Vec2&) {
  if (wo.z <= 0.0) return {};
  return {.wi = {-wo.x, -wo.y, wo.z}, .weight = Vec3(1.0), .pdf = 1.0, .lobe = Lobe::delta_reflection};
}

}  // namespace etendue::reference
