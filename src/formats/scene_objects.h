#pragma once
/// Scenes put together in memory as objects with properties, in the words of scenes for Mitsuba (docs/mitsuba.md): what
/// a file says in elements, without text. They go through the reader of such files, with its defaults, ranges and
/// references.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "formats/read_options.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

struct SceneObject;

/// What an object has under a name. Numbers are a point, a vector, a colour (three of them) or a list; a matrix is that
/// of a transform, in the plane of textures with x, y and translation alone.
using SceneValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>, glm::dmat4,
                                std::shared_ptr<SceneObject>>;

/// One object. The kinds of objects need not be named: a type says whether it is a shape or an integrator.
struct SceneObject {
  /// A type of docs/mitsuba.md; "ref", with the id of another object; "rgb" or "spectrum", with a "value"; or "mesh".
  std::string type;
  /// In the order of a file. The name of an object that the scene holds is its id, unless it has an "id" of its own.
  std::vector<std::pair<std::string, SceneValue>> properties;
  /// Of the type "mesh": used up. Without normals it is flat, unless "face_normals" is false; `v` counts from a
  /// picture's first row, unless "flip_tex_coords" is true.
  std::optional<TriangleMesh> mesh;
  /// Of textures and environments, in place of a "filename": used up.
  std::optional<Bitmap> bitmap;
};

/// Deepest nesting of objects.
inline constexpr std::size_t kMaxObjectDepth = 32;

/// The scene of an object of the type "scene"; nothing after an error. Places of findings are paths of names:
/// "dict:/lamp/emitter/radiance". Files that it names are looked for from the working directory.
std::optional<Scene> read_scene_objects(SceneObject root, const ReadOptions& options, Diagnostics& diagnostics);

}  // namespace etendue
