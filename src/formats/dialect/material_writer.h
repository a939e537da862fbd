#pragma once
/// Common code of the writers of scene files: materials, which the dialects write alike except for some words.

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <type_traits>

#include "formats/dialect/scene_files.h"
#include "formats/xml/xml_writer.h"
#include "scene/parameters.h"
#include "scene/scene.h"

namespace etendue {

class MaterialWriter {
 protected:
  /// The dialects' words for the same things.
  struct Words {
    const char *color, *albedo, *mirror, *blend, *int_ior, *ext_ior;
    const char* lacking;  ///< end of the sentence about what the dialect cannot express: "which Mitsuba does not have"
  };

  MaterialWriter(const std::string& path, const Scene& scene, const Words& words)
      : scene_(scene), words_(words), files_(path, scene) {}
  virtual ~MaterialWriter() = default;
  MaterialWriter(const MaterialWriter&) = delete;
  MaterialWriter& operator=(const MaterialWriter&) = delete;

  /// Throws Error(scene).
  [[noreturn]] void refuse(const std::string& what) const;

  void color(const char* name, const glm::dvec3& value) { xml_.property(words_.color, name, shortest(value)); }
  void color(const char* name, const ColorParameter& parameter);
  /// The texture in the squares of a checkerboard.
  static ColorParameter square(const glm::dvec3& color, const std::optional<std::uint32_t>& texture) {
    return texture ? ColorParameter(color, *texture) : ColorParameter(color);
  }
  void number(const char* name, double value) { xml_.number(name, value); }
  void number(const char* name, const ScalarParameter& parameter);

  /// Of a material whose parameters have the names that they have in the scene.
  template <typename T>
  void write_parameters(const T& bsdf) {
    each_parameter(bsdf, [&](const char* name, const auto& parameter) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(parameter)>, ColorParameter>)
        color(name, parameter);
      else
        number(name, parameter);
    });
  }

  /// The set of texture coordinates by which an instance shows its textures. Refuses instances with several, because
  /// mesh files hold one.
  std::uint32_t uv_set_of(const Instance& instance) const;
  /// Refuses a texture that does not use the first set, if there is no mesh file to hold that set in its place.
  void require_first_set(const Texture& texture) const {
    if (keeps_names_ && texture.uv_set > 0) refuse("a texture uses the second texture coordinates of a mesh");
  }

  /// Writes all materials of instances, in the order of their first use.
  void write_materials();
  /// A material and what it chooses from, to be pasted into a file: known by the names that they have there, and so are
  /// pictures.
  std::string material_alone(std::uint32_t row);
  /// The material that an instance shows.
  void refer_to(std::uint32_t row) { xml_.leaf("ref", {{"id", material_id(row)}}); }
  void open_bsdf(const std::string& id, const char* type) { xml_.open("bsdf", {{"type", type}, {"id", id}}); }
  template <typename Glass>
  void write_indices(const Glass& bsdf) {
    number(words_.int_ior, bsdf.int_ior);
    number(words_.ext_ior, bsdf.ext_ior);
  }

  const Scene& scene_;
  const Words words_;
  SceneFiles files_;
  XmlWriter xml_;

 private:
  /// The texture that is the value of a property, multiplied by `factor`; for numbers, one channel of it.
  virtual void write_texture(const char* name, std::uint32_t row, const glm::dvec3& factor,
                             std::optional<TextureChannel> channel) = 0;
  /// Opens the element, like write_bsdf.
  virtual void write_microfacet(const std::string& id, const MicrofacetBsdf& bsdf) = 0;
  virtual void write_gltf(const std::string& id, const GltfBsdf& bsdf) = 0;
  /// Notes that a normal map follows vertex tangents.
  virtual void write_vertex_tangents() = 0;

  void write_turned(const TurnedNormals& turned);
  std::string material_id(std::uint32_t row) const;
  void write_material(std::uint32_t row);
  // Each opens an element, which the caller closes.
  void write_adapter(const std::string& id, const TwoSidedAdapter& adapter);
  void write_adapter(const std::string& id, const MaskAdapter& adapter);
  void write_adapter(const std::string& id, const NormalMapAdapter& adapter);
  void write_adapter(const std::string& id, const BumpMapAdapter& adapter);
  void write_adapter(const std::string& id, const BlendAdapter& adapter);
  void write_bsdf(const std::string& id, const DiffuseBsdf& bsdf);
  void write_bsdf(const std::string& id, const MirrorBsdf& bsdf);
  void write_bsdf(const std::string& id, const PrincipledBsdf& bsdf);
  void write_bsdf(const std::string& id, const PrincipledThinBsdf& bsdf);
  void write_bsdf(const std::string& id, const NullBsdf& bsdf);
  void write_bsdf(const std::string& id, const DielectricBsdf& bsdf);
  void write_bsdf(const std::string& id, const ConductorBsdf& bsdf);
  void write_bsdf(const std::string& id, const RoughConductorBsdf& bsdf);
  void write_bsdf(const std::string& id, const RoughDielectricBsdf& bsdf);
  void write_bsdf(const std::string& id, const ThinDielectricBsdf& bsdf);
  void write_bsdf(const std::string& id, const PlasticBsdf& bsdf);
  void write_bsdf(const std::string& id, const RoughPlasticBsdf& bsdf);
  void write_bsdf(const std::string& id, const MicrofacetBsdf& bsdf) { write_microfacet(id, bsdf); }
  void write_bsdf(const std::string& id, const GltfBsdf& bsdf) { write_gltf(id, bsdf); }
  template <typename Metal>
  void write_metal(const Metal& bsdf);
  template <typename Glass>
  void write_clear(const Glass& bsdf);
  template <typename Plastic>
  void write_plastic(const Plastic& bsdf);
  void write_distribution(Roughness::Distribution distribution);
  void write_roughness(const Roughness& roughness);

  std::set<std::uint32_t> written_;  ///< materials
  bool keeps_names_ = false;
};

}  // namespace etendue
