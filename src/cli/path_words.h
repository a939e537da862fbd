#pragma once
/// Describes what happened at a vertex of a path, for people and for programs.

#include <cstdint>
#include <string>

#include "core/json.h"
#include "render/renderer.h"

namespace etendue::cli {

struct VertexWords {
  std::string meets;     ///< "instance 4, 0", or "nothing"
  std::string light;     ///< the light that was chosen, "sky, 17" or "-"
  std::string reached;   ///< whether it is visible from here: "yes", "no" or "-"
  std::string lobe;      ///< "diffuse", "reflection" …
  std::string survives;  ///< result of Russian roulette
};
VertexWords words_of(const PathVertex& vertex);

/// The name of the light at a vertex: the number of an instance, "sky", or "point", whose number is that of the
/// primitive.
Json light_json(std::uint32_t instance);
Json to_json(const PathVertex& vertex);

}  // namespace etendue::cli
