#pragma once
/// Turns bsdfs of a Mitsuba scene into rows of a Scene's table of materials.

#include <cstdint>
#include <map>
#include <set>

#include "formats/mitsuba/mitsuba_object.h"
#include "formats/mitsuba/mitsuba_textures.h"
#include "scene/scene.h"

namespace etendue {

class MitsubaMaterials {
 public:
  MitsubaMaterials(const MitsubaContext& context, MitsubaTextures& textures, Scene& scene)
      : context_(context), textures_(textures), scene_(scene) {}

  /// The row of a <bsdf>, which is read at the first request.
  std::uint32_t row_of(const XmlElement& bsdf);
  /// The row for a shape without a material: grey, or black if it emits.
  std::uint32_t default_row(bool emits, const SourcePosition& shape);

 private:
  Bsdf read(const MitsubaObject& object);
  /// Returns nothing if this is not an adapter. The materials that the adapter refers to are read first.
  std::optional<Adapter> read_adapter(const MitsubaObject& object);
  /// The substitute for a diffuse base with Phong's or Ward's lobe.
  Adapter read_lobe(const MitsubaObject& object);
  /// A mixture of materials with weights.
  Adapter read_mixture(const MitsubaObject& object);
  /// Adds a material that the object needs in addition to its own, and returns its row.
  std::uint32_t add(Material material, const MitsubaObject& object);
  /// A normal or bump map.
  Adapter read_map(const MitsubaObject& object, std::uint32_t inner);
  /// A probability, which may be a texture.
  ScalarParameter share_of(const MitsubaObject& object, const char* name);
  template <typename Principled>
  Bsdf read_principled(const MitsubaObject& object);
  /// The substitute for an unsupported material.
  Bsdf read_substitute(const MitsubaObject& object);
  Bsdf read_diffuse(const MitsubaObject& object);
  template <typename Glass>
  Glass read_clear(const MitsubaObject& object);
  Bsdf read_conductor(const MitsubaObject& object);
  Bsdf read_rough_conductor(const MitsubaObject& object);
  template <typename Plastic>
  Plastic read_plastic(const MitsubaObject& object);
  Bsdf read_rough_plastic(const MitsubaObject& object);
  void read_metal(const MitsubaObject& object, ConductorIndex& index);
  Roughness::Distribution read_distribution(const MitsubaObject& object);
  void read_roughness(const MitsubaObject& object, Roughness& roughness);

  // Assign a property to a field of the material. If the field cannot be a texture but the property is one, grey is
  // assigned and noted.
  void assign(ColorParameter& field, const MitsubaObject& object, const char* name, SpectrumUse use);
  void assign(glm::dvec3& field, const MitsubaObject& object, const char* name, SpectrumUse use);
  void assign_alpha(ScalarParameter& field, const MitsubaObject& object, const char* name);
  double alpha(const MitsubaObject& object, const char* name);
  bool is_old() const { return context_.document.version().starts_with("0."); }

  const MitsubaContext& context_;
  MitsubaTextures& textures_;
  Scene& scene_;
  std::map<const XmlElement*, std::uint32_t> rows_;
  std::set<const XmlElement*> open_;  ///< elements that are being read or have been read
  std::optional<std::uint32_t> grey_, black_;
};

}  // namespace etendue
