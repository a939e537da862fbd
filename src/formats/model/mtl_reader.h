#pragma once
/// Libraries of materials beside OBJ files (.mtl), read as a stream.

#include <map>
#include <optional>
#include <string>

#include <glm/glm.hpp>

#include "formats/byte_source.h"
#include "scene/diagnostics.h"
#include "scene/source_position.h"

namespace etendue {

/// A picture in place of a value, or as its factor.
struct MtlMap {
  std::string filename;
  glm::dvec3 scale{1.0};   ///< -s
  glm::dvec3 offset{0.0};  ///< -o
  bool clamp = false;      ///< -clamp on
};

/// What a material of a library says, as far as it means anything here.
struct MtlMaterial {
  SourcePosition position;
  glm::dvec3 diffuse{0.6};                                       ///< Kd
  glm::dvec3 specular{0.0};                                      ///< Ks
  glm::dvec3 emission{0.0};                                      ///< Ke
  double exponent = 0.0;                                         ///< Ns, of Phong's lobe
  double index = 1.5;                                            ///< Ni
  double opacity = 1.0;                                          ///< d, or 1 − Tr
  int illumination = 2;                                          ///< illum
  std::optional<double> roughness, metallic;                     ///< Pr, Pm: extensions
  std::optional<MtlMap> diffuse_map, emission_map, opacity_map;  ///< map_Kd, map_Ke, map_d
};

struct MtlLimits {
  static constexpr std::size_t kMaxLine = std::size_t{1} << 16;  ///< bytes
  static constexpr std::size_t kMaxMaterials = 65536;
  static constexpr std::size_t kMaxBytes = std::size_t{1} << 28;  ///< of all libraries of one file
};

/// By name. What is wrong is a warning: the line is left out, the model is shown without it. The first material of a
/// name counts.
void read_mtl(const ByteSource& source, const std::string& file, std::map<std::string, MtlMaterial>& materials,
              Diagnostics& diagnostics);
/// Throws Error if the file cannot be opened or read.
void read_mtl(const std::string& path, std::map<std::string, MtlMaterial>& materials, Diagnostics& diagnostics);

}  // namespace etendue
