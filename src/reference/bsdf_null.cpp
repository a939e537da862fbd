/// Nothing: light goes straight on. Integrators pass such surfaces before they call this.

#include "reference/bsdf.h"

namespace etendue::reference {

Vec3 eval(const NullBsdf&, const Vec3&, const Vec3&) {
  return Vec3(0.0);
}

double pdf(const NullBsdf&, const Vec3&, const Vec3&) {
  return 0.0;
}

BsdfSample sample(const NullBsdf&, const Vec3& wo, double, const Vec2&) {
  return {.wi = -wo, .weight = Vec3(1.0), .pdf = 1.0, .lobe = Lobe::delta_transmission};
}

}  // namespace etendue::reference
