#include "formats/scene_objects.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/text.h"
#include "formats/mesh_formats.h"
#include "formats/mitsuba/mitsuba_reader.h"
#include "formats/mitsuba/plugins.h"
#include "scene/invariants.h"

namespace etendue {
namespace {

constexpr const char* kRootPlace = "dict:";

/// Types that stand for a colour; of the tag <spectrum> all but the first two.
constexpr std::string_view kColorTypes[] = {"rgb", "srgb",    "spectrum",  "uniform",
                                            "d65", "regular", "irregular", "blackbody"};

/// Tags of all objects that have this type, also of those that the reader only knows by name.
std::vector<std::string_view> tags_of(std::string_view type) {
  const Dialect& dialect = mitsuba_dialect();
  std::vector<std::string_view> tags;
  for (const Plugin& plugin : dialect.plugins) {
    if (plugin.type == type && *plugin.type != '\0') tags.emplace_back(plugin.tag);
  }
  for (const UnsupportedTypes& unsupported : dialect.unsupported_types) {
    if (std::ranges::find(unsupported.types, type) != unsupported.types.end()) tags.push_back(unsupported.tag);
  }
  return tags;
}

std::vector<std::string> all_types() {
  std::set<std::string> types = {"ref", "mesh"};
  for (const Plugin& plugin : mitsuba_dialect().plugins) types.insert(plugin.type);
  types.erase("");
  types.insert(std::begin(kColorTypes), std::end(kColorTypes));
  return {types.begin(), types.end()};
}

std::string numbers_text(const std::vector<double>& numbers) {
  return fmt::format("{}", fmt::join(numbers, ", "));
}

std::string matrix_text(const glm::dmat4& m) {
  std::vector<double> rows;
  for (int i = 0; i < 16; ++i) rows.push_back(m[i % 4][i / 4]);
  return numbers_text(rows);
}

/// Turns objects into the elements that a file would have, and keeps what no text can hold.
class ElementWriter {
 public:
  explicit ElementWriter(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  XmlElement root(SceneObject& scene) {
    const Plugin* row = mitsuba_dialect().find("scene", "");
    XmlElement element = begin("scene", kRootPlace);
    if (scene.type != "scene")
      diagnostics_.error({kRootPlace, 0, 0},
                         fmt::format("the outermost object has the type {}; it must be a scene, with this one inside",
                                     text::quoted(scene.type)));
    add_properties(element, scene, row, kRootPlace, 1);
    return element;
  }

  std::vector<std::string> places;  ///< of every element, by its offset
  std::map<std::string, TriangleMesh> meshes;
  std::map<std::string, Bitmap> bitmaps;

 private:
  XmlElement begin(std::string_view tag, const std::string& place) {
    places.push_back(place);
    return {std::string(tag), places.size() - 1, {}, {}};
  }
  static void set(XmlElement& element, const char* name, std::string value) {
    element.attributes.push_back({name, std::move(value), element.offset, element.offset, false});
  }

  void add_properties(XmlElement& element, SceneObject& object, const Plugin* row, const std::string& place,
                      std::size_t depth) {
    if (depth > kMaxObjectDepth)
      return diagnostics_.error(
          {place, 0, 0}, fmt::format("objects are nested deeper than {} levels; a scene needs 5", kMaxObjectDepth));
    for (auto& [name, value] : object.properties) {
      if (name == "type" || (name == "id" && std::holds_alternative<std::string>(value))) continue;
      const std::string inner = place + "/" + name;
      if (auto* held = std::get_if<std::shared_ptr<SceneObject>>(&value)) {
        if (std::optional<XmlElement> child = object_element(name, **held, row, inner, depth))
          element.children.push_back(std::move(*child));
      } else {
        element.children.push_back(value_element(name, value, row, inner));
      }
    }
  }

  /// The tag of a value, by the type of the property where that is known: an integer may stand for any number.
  XmlElement value_element(const std::string& name, const SceneValue& value, const Plugin* row,
                           const std::string& place) {
    const Parameter* parameter = row == nullptr ? nullptr : row->find(snake_case(name));
    const bool color = parameter != nullptr && parameter->type == ParameterType::color;
    const bool whole = parameter != nullptr && parameter->type == ParameterType::integer;
    const auto with = [&](const char* tag, std::string text) {
      XmlElement element = begin(tag, place);
      set(element, "name", name);
      set(element, "value", std::move(text));
      return element;
    };
    if (const auto* flag = std::get_if<bool>(&value)) return with("boolean", *flag ? "true" : "false");
    if (const auto* number = std::get_if<std::int64_t>(&value))
      return with(whole || parameter == nullptr ? "integer" : "float", fmt::format("{}", *number));
    if (const auto* number = std::get_if<double>(&value)) return with("float", fmt::format("{}", *number));
    if (const auto* words = std::get_if<std::string>(&value)) return with("string", *words);
    if (const auto* numbers = std::get_if<std::vector<double>>(&value))
      return with(color ? "rgb" : numbers->size() == 3 ? "vector" : "string", numbers_text(*numbers));
    XmlElement transform = begin("transform", place);
    set(transform, "name", name);
    XmlElement matrix = begin("matrix", place);
    set(matrix, "value", matrix_text(std::get<glm::dmat4>(value)));
    transform.children.push_back(std::move(matrix));
    return transform;
  }

  std::optional<XmlElement> object_element(const std::string& name, SceneObject& object, const Plugin* parent,
                                           const std::string& place, std::size_t depth) {
    if (object.type == "rgb" || object.type == "srgb" || object.type == "spectrum")
      return color_element(name, object, place);
    if (object.type == "ref") return reference(name, object, place);
    const bool mesh = object.type == "mesh";
    const std::optional<std::string_view> tag = mesh ? "shape" : tag_for(name, object, parent, place);
    if (!tag) return std::nullopt;
    XmlElement element = begin(*tag, place);
    const std::string type = mesh ? "ply" : object.type;
    set(element, "type", type);
    if (depth > 1) set(element, "name", name);
    if (const std::string id = id_of(object, depth == 1 ? name : ""); !id.empty()) set(element, "id", id);
    add_data(element, object, place);
    add_properties(element, object, mitsuba_dialect().find(*tag, type), place, depth + 1);
    return element;
  }

  static bool holds(const SceneObject& object, std::string_view name) {
    return std::ranges::any_of(object.properties, [&](const auto& property) { return property.first == name; });
  }
  static std::string id_of(const SceneObject& object, const std::string& otherwise) {
    for (const auto& [name, value] : object.properties) {
      const auto* id = std::get_if<std::string>(&value);
      if (name == "id" && id != nullptr) return *id;
    }
    return otherwise;
  }

  /// <rgb name="radiance" value="…"/>; the value is a text, a number or a list of them.
  std::optional<XmlElement> color_element(const std::string& name, const SceneObject& object,
                                          const std::string& place) {
    XmlElement element = begin(object.type, place);
    set(element, "name", name);
    for (const auto& [word, value] : object.properties) {
      if (word == "type" || word == "id") continue;
      if (word != "value" && !(word == "filename" && object.type == "spectrum")) {
        diagnostics_.error({place + "/" + word, 0, 0},
                           fmt::format("{} has no property {}; it has: value", object.type, text::quoted(word)));
        continue;
      }
      std::string text;
      if (const auto* number = std::get_if<double>(&value)) text = fmt::format("{}", *number);
      if (const auto* number = std::get_if<std::int64_t>(&value)) text = fmt::format("{}", *number);
      if (const auto* numbers = std::get_if<std::vector<double>>(&value)) text = numbers_text(*numbers);
      if (const auto* words = std::get_if<std::string>(&value)) text = *words;
      set(element, word.c_str(), std::move(text));
    }
    return element;
  }

  XmlElement reference(const std::string& name, const SceneObject& object, const std::string& place) {
    XmlElement element = begin("ref", place);
    set(element, "name", name);
    if (const std::string id = id_of(object, ""); !id.empty()) set(element, "id", id);
    return element;
  }

  /// The kind of an object: the one that fits where it stands, where several have its type.
  std::optional<std::string_view> tag_for(const std::string& name, const SceneObject& object, const Plugin* parent,
                                          const std::string& place) {
    if (std::ranges::find(kColorTypes, object.type) != std::end(kColorTypes)) return "spectrum";
    const std::vector<std::string_view> tags = tags_of(object.type);
    if (tags.empty()) {
      diagnostics_.error({place, 0, 0}, object.type.empty()
                                            ? "an object lacks its \"type\""
                                            : fmt::format("there is no type {}{}", text::quoted(object.type),
                                                          text::did_you_mean(object.type, all_types())));
      return std::nullopt;
    }
    const Parameter* parameter = parent == nullptr ? nullptr : parent->find(snake_case(name));
    for (const std::string_view tag : tags) {
      if (parameter != nullptr && tag == parameter->child) return tag;
    }
    for (const std::string_view tag : tags) {
      if (parent != nullptr && parent->find_child(tag) != nullptr) return tag;
    }
    return tags.front();
  }

  void add_data(XmlElement& element, SceneObject& object, const std::string& place) {
    if (object.mesh) {
      if (object.mesh->normals.empty() && !holds(object, "face_normals"))
        element.children.push_back(value_element("face_normals", true, nullptr, place));
      if (is_sound(*object.mesh, place)) meshes.emplace(place, std::move(*object.mesh));
    } else if (object.type == "mesh") {
      diagnostics_.error({place, 0, 0}, "a mesh lacks its triangles");
    }
    if (object.bitmap) bitmaps.emplace(place, std::move(*object.bitmap));
    if (object.mesh || object.bitmap)
      element.children.push_back(value_element("filename", std::string(place), nullptr, place));
  }

  /// Whether every index is one of a vertex, and every vertex has what any has.
  bool is_sound(const TriangleMesh& mesh, const std::string& place) {
    const std::size_t count = mesh.positions.size();
    const std::size_t errors_before = diagnostics_.error_count();
    const auto check = [&](std::size_t size, const char* what) {
      if (size != 0 && size != count)
        diagnostics_.error({place, 0, 0}, fmt::format("the mesh has {} positions and {} {}", count, size, what));
    };
    check(mesh.normals.size(), "normals");
    check(mesh.vertex_colors.size(), "colours of vertices");
    check(mesh.vertex_alphas.size(), "alphas of vertices");
    check(mesh.tangents.size(), "tangents");
    for (const std::vector<glm::vec2>& set : mesh.uv_sets) check(set.size(), "texture coordinates");
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const std::uint32_t largest = std::max({mesh.triangles[i].x, mesh.triangles[i].y, mesh.triangles[i].z});
      if (largest < count) continue;
      diagnostics_.error({place, 0, 0},
                         fmt::format("triangle {} has the vertex {}; there are {}, counted from 0", i, largest, count));
      break;
    }
    return diagnostics_.error_count() == errors_before;
  }

  Diagnostics& diagnostics_;
};

}  // namespace

std::optional<Scene> read_scene_objects(SceneObject root, const ReadOptions& options, Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  ElementWriter writer(diagnostics);
  XmlElement scene = writer.root(root);
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  auto document = std::make_unique<XmlDocument>(std::move(scene), kRootPlace, std::move(writer.places));
  MitsubaFiles files = mitsuba_files();
  files.mesh = [&](const MeshFormat& format, const std::string& path, const MeshContent& content, Diagnostics& sink) {
    const auto held = writer.meshes.find(path);
    return held == writer.meshes.end() ? read_mesh_file(format, path, content, sink)
                                       : std::optional<TriangleMesh>(held->second);
  };
  files.picture = [&](const std::string& path) {
    const auto held = writer.bitmaps.find(path);
    return held == writer.bitmaps.end() ? read_bitmap(path) : held->second;
  };
  std::optional<Scene> read = parse_mitsuba_scene(std::move(document), options, files, diagnostics);
  if (read) read->name = "scene";
  if (read) read->file.clear();
  return read;
}

}  // namespace etendue
