#pragma once
/// Interference in a thin film on a reflecting base [Belcour2017], in the form of Khronos; docs/conventions.md, "glTF".

#include "reference/vec.h"

namespace etendue::reference {

struct ThinFilm {
  double index;      ///< at least 1
  double thickness;  ///< nanometres
  Vec3 normal;       ///< reflectance of the base along the normal

  /// Of light from outside at this angle.
  Vec3 reflectance(double cosine) const;
  /// A bound of it along the normal, for any thickness.
  Vec3 bound() const;
};

}  // namespace etendue::reference
