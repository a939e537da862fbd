#pragma once
/// Bsdfs of a Mitsuba scene as rows of a Scene's table.

#include <cstdint>
#include <map>

#include "formats/mitsuba/mitsuba_object.h"
#include "scene/scene.h"

namespace etendue {

class MitsubaMaterials {
 public:
  MitsubaMaterials(const MitsubaContext& context, Scene& scene) : context_(context), scene_(scene) {}

  /// The row of a <bsdf>, which is read when it is asked for the first time.
  std::uint32_t row_of(const XmlElement& bsdf);
  /// The row of what a shape has that names none: grey, or black where it emits.
  std::uint32_t default_row(bool emits, const SourcePosition& shape);

  /// A colour; of a texture that cannot be carried its mean, which is noted.
  glm::dvec3 constant(const MitsubaColor& color);

 private:
  Bsdf read(const XmlElement& element);
  Bsdf read_diffuse(const MitsubaObject& object);
  Bsdf read_dielectric(const MitsubaObject& object);
  Bsdf read_conductor(const MitsubaObject& object);
  Bsdf read_rough_conductor(const MitsubaObject& object);
  ConductorIndex read_metal(const MitsubaObject& object);
  Roughness read_roughness(const MitsubaObject& object);
  double alpha(const MitsubaObject& object, const char* name);
  /// Notes a property that is given and is not what the material does anyway.
  void require_white(const MitsubaObject& object, const char* name);

  const MitsubaContext& context_;
  Scene& scene_;
  std::map<const XmlElement*, std::uint32_t> rows_;
  std::optional<std::uint32_t> grey_, black_;
};

}  // namespace etendue
