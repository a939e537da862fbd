#include "formats/gltf/gltf_audit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "core/text.h"
#include "formats/gltf/gltf_audit_parts.h"
#include "formats/gltf/gltf_document.h"
#include "formats/gltf/gltf_values.h"
#include "scene/diagnostics.h"

namespace etendue {
namespace gltf_audit {

const JsonValue* follow(const JsonValue& object, std::string_view path) {
  const JsonValue* at = &object;
  for (const std::string_view name : text::split(path, '/')) {
    at = at->find(name);
    if (at == nullptr) return nullptr;
  }
  return at;
}

const JsonValue::Array& list(const JsonValue& object, std::string_view name) {
  static const JsonValue::Array kNone;
  const JsonValue* value = object.find(name);
  return value == nullptr || value->array() == nullptr ? kNone : *value->array();
}

std::optional<double> number_in(const JsonValue& object, std::string_view name) {
  const JsonValue* value = object.find(name);
  return value == nullptr || value->number() == nullptr ? std::nullopt : std::optional(*value->number());
}

std::string string_in(const JsonValue& object, std::string_view name) {
  const JsonValue* value = object.find(name);
  return value == nullptr || value->string() == nullptr ? "" : *value->string();
}

bool is_true(const JsonValue& object, std::string_view name) {
  const JsonValue* value = object.find(name);
  return value != nullptr && value->boolean() != nullptr && *value->boolean();
}

const JsonValue* element_at(const JsonValue& root, std::string_view array, const JsonValue& index) {
  const JsonValue::Array& elements = list(root, array);
  const double* n = index.number();
  if (n == nullptr || !(*n >= 0.0 && *n < static_cast<double>(elements.size()))) return nullptr;
  const JsonValue& element = elements[static_cast<std::size_t>(*n)];
  return element.object() == nullptr ? nullptr : &element;
}

const JsonValue* element_of(const JsonValue& root, std::string_view array, const JsonValue& object,
                            std::string_view name) {
  const JsonValue* index = object.find(name);
  return index == nullptr ? nullptr : element_at(root, array, *index);
}

std::string_view kind_of_attribute(std::string_view name) {
  for (const std::string_view kind : {"TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"}) {
    if (name.starts_with(kind)) return kind;
  }
  return name;
}

std::string_view types_of_attribute(std::string_view kind) {
  struct Row {
    std::string_view kind, types;
  };
  constexpr Row kRows[] = {{"POSITION", "VEC3"},    {"NORMAL", "VEC3"},  {"TANGENT", "VEC4"}, {"TEXCOORD_", "VEC2"},
                           {"COLOR_", "VEC3 VEC4"}, {"JOINTS_", "VEC4"}, {"WEIGHTS_", "VEC4"}};
  const auto* found = std::ranges::find(kRows, kind, &Row::kind);
  return found == std::end(kRows) ? std::string_view() : found->types;
}

}  // namespace gltf_audit

namespace {

using namespace gltf_audit;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The allowed range of a member of a material, and what is done with values outside it.
struct Range {
  const char* path;
  double least, most;
  const char* otherwise = "the nearest of these is used";
};

constexpr Range kMaterialRanges[] = {
    {"alphaCutoff", 0.0, kInfinity, "it is used as it is"},
    {"emissiveFactor", 0.0, kInfinity},
    {"pbrMetallicRoughness/baseColorFactor", 0.0, 1.0},
    {"pbrMetallicRoughness/metallicFactor", 0.0, 1.0},
    {"pbrMetallicRoughness/roughnessFactor", 0.0, 1.0},
    {"extensions/KHR_materials_anisotropy/anisotropyStrength", 0.0, 1.0},
    {"extensions/KHR_materials_clearcoat/clearcoatFactor", 0.0, 1.0},
    {"extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", 0.0, 1.0},
    {"extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", 0.0, 1.0},
    {"extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor", 0.0, 1.0},
    {"extensions/KHR_materials_dispersion/dispersion", 0.0, kInfinity},
    {"extensions/KHR_materials_emissive_strength/emissiveStrength", 0.0, kInfinity},
    {"extensions/KHR_materials_iridescence/iridescenceFactor", 0.0, 1.0},
    {"extensions/KHR_materials_iridescence/iridescenceIor", 1.0, kInfinity},
    {"extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", 0.0, kInfinity},
    {"extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", 0.0, kInfinity},
    {"extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", 0.0, 1.0},
    {"extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", 0.0, 1.0},
    {"extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor", 0.0, 1.0},
    {"extensions/KHR_materials_sheen/sheenColorFactor", 0.0, 1.0},
    {"extensions/KHR_materials_sheen/sheenRoughnessFactor", 0.0, 1.0},
    {"extensions/KHR_materials_specular/specularFactor", 0.0, 1.0},
    {"extensions/KHR_materials_specular/specularColorFactor", 0.0, kInfinity},
    {"extensions/KHR_materials_transmission/transmissionFactor", 0.0, 1.0},
    {"extensions/KHR_materials_volume/attenuationColor", 0.0, 1.0},
    {"extensions/KHR_materials_volume/thicknessFactor", 0.0, kInfinity},
};

std::string_view name_of(const Range& range) {
  const std::string_view path = range.path;
  return path.substr(path.rfind('/') + 1);
}

bool is_known(std::string_view kind) {
  return !types_of_attribute(kind).empty();
}

/// Whether the standard allows this component type for the attribute.
bool may_have_type(std::string_view kind, double type, bool normalized, bool quantized) {
  const bool is_unsigned = type == kUnsignedByte || type == kUnsignedShort;
  if (kind == "JOINTS_") return is_unsigned && !normalized;
  if (type == kFloat || (normalized && is_unsigned && (kind == "COLOR_" || kind == "WEIGHTS_"))) return true;
  if (kind == "TEXCOORD_") return (normalized && is_unsigned) || (quantized && type <= kUnsignedShort);
  if (kind == "POSITION") return quantized && type <= kUnsignedShort;
  const bool is_signed = type == kByte || type == kShort;
  return (kind == "NORMAL" || kind == "TANGENT") && quantized && normalized && is_signed;
}

class GltfAuditor {
 public:
  GltfAuditor(const GltfDocument& document, Diagnostics& diagnostics)
      : document_(document),
        root_(document.root()),
        sink_(diagnostics),
        quantized_(declares("KHR_mesh_quantization")) {}

  void run() {
    for (const std::string& remark : document_.remarks()) sink_.warning({document_.path(), 0, 0}, remark);
    audit_version();
    audit_scenes();
    for (const JsonValue& node : list(root_, "nodes")) audit_node(node);
    for (const JsonValue& mesh : list(root_, "meshes")) audit_mesh(mesh);
    for (const JsonValue& camera : list(root_, "cameras")) audit_camera(camera);
    for (const JsonValue& material : list(root_, "materials")) audit_material(material);
    for (const JsonValue& sampler : list(root_, "samplers")) audit_sampler(sampler);
    for (const JsonValue& animation : list(root_, "animations")) audit_animation(animation);
    for (const JsonValue& accessor : list(root_, "accessors")) audit_accessor(accessor);
    for (const JsonValue& buffer : list(root_, "buffers")) {
      if (buffer.find("byteLength") == nullptr) warn(buffer, "the buffer has no \"byteLength\"; all of it is used");
    }
    if (const JsonValue* lights = follow(root_, "extensions/KHR_lights_punctual")) {
      for (const JsonValue& light : list(*lights, "lights")) audit_light(light);
    }
    audit_extensions();
  }

 private:
  void warn(const JsonValue& where, const std::string& sentence) { sink_.warning(document_.position(where), sentence); }

  void audit_version() {
    const JsonValue* asset = root_.find("asset");
    const std::string version = asset == nullptr ? "" : string_in(*asset, "version");
    if (!version.empty() && version != "2.0")
      warn(*asset, fmt::format("the asset is glTF {}; it is read as glTF 2.0", text::quoted(version)));
  }

  void audit_scenes() {
    std::map<double, std::size_t> parent;
    const JsonValue::Array& nodes = list(root_, "nodes");
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      for (const JsonValue& child : list(nodes[node], "children")) {
        if (child.number() != nullptr) parent[*child.number()] = node;
      }
    }
    for (const JsonValue& scene : list(root_, "scenes")) {
      std::set<double> seen;
      for (const JsonValue& node : list(scene, "nodes")) {
        if (node.number() == nullptr) continue;
        const double index = *node.number();
        if (!seen.insert(index).second)
          warn(scene, fmt::format("the scene lists node {} twice; it shows it once", index));
        if (const auto known = parent.find(index); known != parent.end())
          warn(scene, fmt::format("node {} of the scene is no root but a child of node {}; it is shown once", index,
                                  known->second));
      }
    }
  }

  /// Checks that the index `name` of `object`, if there is one, refers to an element of the root's array.
  void check_index(const JsonValue& object, std::string_view name, std::string_view array, std::size_t count) {
    const auto index = number_in(object, name);
    if (index && !(*index >= 0.0 && *index < static_cast<double>(count)))
      warn(object, fmt::format("{} refers to number {} of \"{}\", of which there are {}; it is ignored",
                               text::quoted(std::string(name)), *index, array, count));
  }

  void audit_node(const JsonValue& node) {
    const bool has_matrix = node.find("matrix") != nullptr;
    for (const char* part : {"translation", "rotation", "scale"}) {
      if (has_matrix && node.find(part) != nullptr)
        warn(node, fmt::format("the node has a \"matrix\" and a \"{}\"; the matrix is used", part));
    }
    check_rotation(node);
    if (const JsonValue* mesh = element_of(root_, "meshes", node, "mesh")) check_weights(node, *mesh);
  }

  void check_rotation(const JsonValue& node) {
    double square = 0.0;
    const JsonValue::Array& numbers = list(node, "rotation");
    for (const JsonValue& n : numbers) square += n.number() == nullptr ? 0.0 : *n.number() * *n.number();
    constexpr double kTolerance = 0.01;  // allows for quaternions rounded to bytes
    const double length = std::sqrt(square);
    if (numbers.empty() || std::abs(length - 1.0) <= kTolerance) return;
    warn(node, length == 0.0
                   ? "the node's rotation has the length 0; the node is not turned"
                   : fmt::format("the node's rotation has the length {:.3g} instead of 1; it is scaled to it", length));
  }

  /// `owner`: the mesh itself, or a node that shows it.
  void check_weights(const JsonValue& owner, const JsonValue& mesh) {
    if (owner.find("weights") == nullptr) return;
    const std::size_t weights = list(owner, "weights").size();
    const JsonValue::Array& primitives = list(mesh, "primitives");
    const std::size_t targets = primitives.empty() ? 0 : list(primitives.front(), "targets").size();
    if (weights != targets)
      warn(owner, fmt::format("there are {} weights for {} morph targets; those without a weight stay at 0", weights,
                              targets));
  }

  void audit_mesh(const JsonValue& mesh) {
    check_weights(mesh, mesh);
    const JsonValue::Array& primitives = list(mesh, "primitives");
    if (primitives.empty()) warn(mesh, "the mesh has no primitives");
    for (const JsonValue& primitive : primitives) {
      audit_variants(primitive);
      const JsonValue* attributes = primitive.find("attributes");
      if (attributes == nullptr || attributes->object() == nullptr) continue;
      audit_attributes(*attributes);
      for (const JsonValue& target : list(primitive, "targets")) {
        if (target.object() == nullptr) continue;
        for (const auto& [name, value] : *target.object()) check_attribute_name(target, name);
      }
    }
  }

  void audit_variants(const JsonValue& primitive) {
    const JsonValue* extension = follow(primitive, "extensions/KHR_materials_variants");
    const JsonValue* names = follow(root_, "extensions/KHR_materials_variants");
    if (extension == nullptr) return;
    const std::size_t count = names == nullptr ? 0 : list(*names, "variants").size();
    std::set<double> seen;
    for (const JsonValue& mapping : list(*extension, "mappings")) {
      for (const JsonValue& variant : list(mapping, "variants")) {
        const double n = variant.number() == nullptr ? -1.0 : *variant.number();
        if (!(n >= 0.0 && n < static_cast<double>(count)))
          warn(variant, fmt::format("variant {} does not exist; the asset has {}", n, count));
        if (!seen.insert(n).second)
          warn(variant, fmt::format("the primitive has two materials for variant {}; the first is used", n));
      }
    }
  }

  void check_attribute_name(const JsonValue& attributes, const std::string& name) {
    if (!name.starts_with('_') && !is_known(kind_of_attribute(name)))
      warn(attributes,
           fmt::format("the attribute {} is unknown and is ignored; names of an application begin with \"_\"",
                       text::quoted(name)));
  }

  /// Uses a set of names, because a hostile file may have very many.
  void audit_attributes(const JsonValue& attributes) {
    std::set<std::string_view> names;
    for (const auto& [name, value] : *attributes.object()) names.insert(name);
    for (const auto& [name, value] : *attributes.object()) {
      if (!sink_.wants_warnings()) return;
      check_attribute_name(attributes, name);
      check_companions(attributes, name, names);
      check_attribute_accessor(attributes, name, value);
    }
  }

  void check_companions(const JsonValue& attributes, const std::string& name, const std::set<std::string_view>& names) {
    const std::string_view kind = kind_of_attribute(name);
    const std::string number = name.substr(kind.size());
    const auto needs = [&](const std::string& other, const char* otherwise) {
      if (!names.contains(other)) warn(attributes, fmt::format("{} comes without {}; it {}", name, other, otherwise));
    };
    if (kind == "JOINTS_") needs("WEIGHTS_" + number, "moves nothing");
    if (kind == "WEIGHTS_") needs("JOINTS_" + number, "moves nothing");
    if (kind != name && number.size() == 1 && number[0] >= '1' && number[0] <= '9')
      needs(fmt::format("{}{}", kind, number[0] - '1'), "is not used");
  }

  void check_attribute_accessor(const JsonValue& attributes, const std::string& name, const JsonValue& value) {
    if (value.number() == nullptr) return;
    const JsonValue* found = element_at(root_, "accessors", value);
    if (found == nullptr)
      return warn(attributes,
                  fmt::format("{} refers to number {} of \"accessors\", of which there are {}; it is ignored",
                              text::quoted(name), *value.number(), list(root_, "accessors").size()));
    const std::string_view kind = kind_of_attribute(name);
    const JsonValue& accessor = *found;
    const bool is_normalized = is_true(accessor, "normalized");
    const double type = number_in(accessor, "componentType").value_or(0.0);
    if (!is_known(kind) || may_have_type(kind, type, is_normalized, quantized_)) return;
    const bool would_help = !quantized_ && may_have_type(kind, type, is_normalized, true);
    warn(accessor,
         fmt::format("{} has the component type {}{}, which the standard does not allow{}; it is read all the "
                     "same",
                     name, type, is_normalized ? ", normalized" : "",
                     would_help ? " without KHR_mesh_quantization" : ""));
  }

  void audit_camera(const JsonValue& camera) {
    if (camera.find("perspective") != nullptr && camera.find("orthographic") != nullptr)
      warn(camera, "the camera is both \"perspective\" and \"orthographic\"; its \"type\" decides");
    if (const JsonValue* o = camera.find("orthographic"); o != nullptr) {
      for (const char* size : {"xmag", "ymag"}) {
        if (number_in(*o, size).value_or(1.0) < 0.0)
          warn(*o, fmt::format("\"{}\" is below 0; its absolute value is used", size));
      }
    }
    const JsonValue* p = camera.find("perspective");
    if (p == nullptr || p->object() == nullptr) return;
    if (!(number_in(*p, "znear").value_or(0.0) > 0.0))
      warn(*p, "the camera has no \"znear\" above 0; nothing is cut off in front of it");
    const auto aspect = number_in(*p, "aspectRatio");
    if (aspect && !(*aspect > 0.0))
      warn(*p, fmt::format("\"aspectRatio\" is {}; it must be above 0 and is ignored", *aspect));
  }

  void audit_light(const JsonValue& light) {
    if (light.object() == nullptr) return;
    const bool is_spot = string_in(light, "type") == "spot";
    if (is_spot != (light.find("spot") != nullptr))
      warn(light, is_spot ? "the light is a spot but has no \"spot\"; 0 and pi/4 are its cone angles"
                          : "the light has a \"spot\" but is none; it is ignored");
  }

  /// Members of materials that do not fit together.
  void audit_combinations(const JsonValue& material) {
    const auto extension = [&](std::string_view name) {
      return follow(material, fmt::format("extensions/KHR_materials_{}", name));
    };
    const auto number = [&](std::string_view name, std::string_view member, double otherwise) {
      const JsonValue* e = extension(name);
      return e == nullptr ? otherwise : number_in(*e, member).value_or(otherwise);
    };
    if (material.find("alphaCutoff") != nullptr && string_in(material, "alphaMode") != "MASK")
      warn(material, "the material has an \"alphaCutoff\" but not the alpha mode MASK; it is not used");
    const JsonValue* extensions = material.find("extensions");
    const bool alone = extensions == nullptr || extensions->object() == nullptr || extensions->object()->size() < 2;
    for (const std::string_view name : {"unlit", "pbrSpecularGlossiness"}) {
      if (extension(name) != nullptr && !alone && !are_allowed_with(name, *extensions))
        warn(material, fmt::format("the material has KHR_materials_{} and other extensions, which are ignored", name));
    }
    if (number("dispersion", "dispersion", 0.0) > 0.0 && extension("volume") == nullptr)
      warn(material, "the material has dispersion but no KHR_materials_volume; it is not shown");
    const bool transmits = extension("transmission") != nullptr || extension("diffuse_transmission") != nullptr;
    const bool is_solid = number("volume", "thicknessFactor", 0.0) > 0.0;
    if (extension("volume") != nullptr && !transmits)
      warn(material, "the material has a volume, but no light enters it: it has no transmission");
    if (is_solid && is_true(material, "doubleSided"))
      warn(material, "the material has a volume and is \"doubleSided\"; solids have an inside and an outside");
    const JsonValue::Array& glow = list(material, "emissiveFactor");
    const bool dark = std::ranges::all_of(glow, [](const JsonValue& v) { return v.number() && *v.number() == 0.0; });
    if (extension("emissive_strength") != nullptr && dark)
      warn(material, "the material has an \"emissiveStrength\", but its \"emissiveFactor\" is 0; it does not glow");
    if (const JsonValue* film = extension("iridescence"); film != nullptr) audit_film(*film);
  }

  /// Unlit surfaces and the older model ignore all extensions but these.
  static bool are_allowed_with(std::string_view model, const JsonValue& extensions) {
    return std::ranges::all_of(*extensions.object(), [&](const auto& member) {
      const std::string_view name = member.first;
      return !name.starts_with("KHR_materials_") || name.ends_with(model) ||
             (model != "unlit" && (name.ends_with("unlit") || name.ends_with("emissive_strength")));
    });
  }

  void audit_film(const JsonValue& film) {
    const double least = number_in(film, "iridescenceThicknessMinimum").value_or(100.0);
    const double most = number_in(film, "iridescenceThicknessMaximum").value_or(400.0);
    const bool has_texture = film.find("iridescenceThicknessTexture") != nullptr;
    if (has_texture && least > most)
      warn(film, fmt::format("the film's least thickness, {}, is above its greatest, {}", least, most));
    if (has_texture && least == most)
      warn(film, "the film has a texture of its thickness, but its least and greatest thickness are equal");
    if (!has_texture && film.find("iridescenceThicknessMinimum") != nullptr)
      warn(film, "the film has an \"iridescenceThicknessMinimum\" but no texture of its thickness; it is not used");
  }

  void audit_material(const JsonValue& material) {
    for (const Range& range : kMaterialRanges) {
      const JsonValue* value = follow(material, range.path);
      if (value == nullptr) continue;
      check_range(*value, range);
      if (value->array() == nullptr) continue;
      const auto beyond = [&](const JsonValue& v) { return check_range(v, range); };
      (void)std::ranges::find_if(*value->array(), beyond);  // one warning is enough
    }
    if (const JsonValue* ior = follow(material, "extensions/KHR_materials_ior/ior");
        ior != nullptr && ior->number() != nullptr && *ior->number() != 0.0 && !(*ior->number() >= 1.0))
      warn(*ior, fmt::format("\"ior\" is {}; it must be 0 or at least 1; 1 is used", *ior->number()));
    if (const JsonValue* distance = follow(material, "extensions/KHR_materials_volume/attenuationDistance");
        distance != nullptr && distance->number() != nullptr && !(*distance->number() > 0.0))
      warn(*distance,
           fmt::format("\"attenuationDistance\" is {}; it must be above 0; the volume is clear", *distance->number()));
    audit_combinations(material);
  }

  bool check_range(const JsonValue& value, const Range& range) {
    const double* n = value.number();
    if (n == nullptr || (*n >= range.least && *n <= range.most)) return false;
    const std::string bounds = range.most == kInfinity ? fmt::format("at least {}", range.least)
                                                       : fmt::format("between {} and {}", range.least, range.most);
    warn(value, fmt::format("\"{}\" is {}; it must be {}; {}", name_of(range), *n, bounds, range.otherwise));
    return true;
  }

  void audit_sampler(const JsonValue& sampler) {
    constexpr double kMagnifying[] = {9728, 9729}, kMinifying[] = {9728, 9729, 9984, 9985, 9986, 9987};
    const auto mag = number_in(sampler, "magFilter"), min = number_in(sampler, "minFilter");
    if (mag && std::ranges::find(kMagnifying, *mag) == std::end(kMagnifying))
      warn(sampler, fmt::format("\"magFilter\" is {}; it must be 9728 or 9729; 9729 is used", *mag));
    if (min && std::ranges::find(kMinifying, *min) == std::end(kMinifying))
      warn(sampler, fmt::format("\"minFilter\" is {}; it must be 9728, 9729 or 9984 to 9987; it is ignored", *min));
  }

  void audit_animation(const JsonValue& animation) {
    const JsonValue::Array& samplers = list(animation, "samplers");
    for (const JsonValue& channel : list(animation, "channels"))
      check_index(channel, "sampler", "samplers", samplers.size());
  }

  void audit_accessor(const JsonValue& accessor) {
    const double type = number_in(accessor, "componentType").value_or(0.0);
    if (is_true(accessor, "normalized") && (type == kFloat || type == kUnsignedInt))
      warn(*accessor.find("normalized"), fmt::format("numbers of the component type {} cannot be normalized", type));
  }

  bool lists(std::string_view array, std::string_view extension) const {
    return std::ranges::any_of(list(root_, array),
                               [&](const JsonValue& v) { return v.string() != nullptr && *v.string() == extension; });
  }
  bool declares(std::string_view extension) const {
    return lists("extensionsUsed", extension) || lists("extensionsRequired", extension);
  }

  void audit_extensions() {
    std::set<std::string> used;
    for (const JsonValue& name : list(root_, "extensionsUsed")) {
      if (name.string() != nullptr) used.insert(*name.string());
    }
    for (const JsonValue& name : list(root_, "extensionsRequired")) {
      if (name.string() != nullptr && used.insert(*name.string()).second)
        warn(
            *root_.find("extensionsRequired"),
            fmt::format("the extension {} is required but not among \"extensionsUsed\"", text::quoted(*name.string())));
    }
    if (quantized_ && !lists("extensionsRequired", "KHR_mesh_quantization"))
      warn(*root_.find("extensionsUsed"), "the extension KHR_mesh_quantization must be among \"extensionsRequired\"");
    find_undeclared(root_, used);
    for (const JsonValue& name : list(root_, "extensionsRequired")) {
      if (name.string() != nullptr && *name.string() != "KHR_mesh_quantization" && !met_.contains(*name.string()))
        warn(
            *root_.find("extensionsRequired"),
            fmt::format("the extension {} is required, but nothing in the asset has it", text::quoted(*name.string())));
    }
  }

  /// The recursion ends because the depth of the JSON is limited.
  void find_undeclared(const JsonValue& value, std::set<std::string>& declared) {
    if (value.array() != nullptr) {
      for (const JsonValue& element : *value.array()) find_undeclared(element, declared);
    }
    if (value.object() == nullptr) return;
    for (const auto& [name, member] : *value.object()) {
      if (name == "extras") continue;
      if (name == "extensions") check_declared(member, declared);
      find_undeclared(member, declared);
    }
  }

  void check_declared(const JsonValue& extensions, std::set<std::string>& declared) {
    if (extensions.object() == nullptr)
      return warn(extensions, fmt::format("\"extensions\" is {}; it must be an object", extensions.kind()));
    for (const auto& [name, value] : *extensions.object()) {
      met_.insert(name);
      if (declared.insert(name).second)
        warn(value, fmt::format("the extension {} is not among \"extensionsUsed\"", text::quoted(name)));
    }
  }

  const GltfDocument& document_;
  const JsonValue& root_;
  Diagnostics& sink_;
  bool quantized_;
  std::set<std::string> met_;  ///< extensions that are in use
};

}  // namespace

void audit_gltf(GltfDocument& document, Accessors& accessors, bool with_animations, Diagnostics& diagnostics) {
  // The same is often wrong in several ways, or in a part that many others use.
  std::set<std::string> said;
  const GltfComplaint complain = [&](const JsonValue& where, const std::string& sentence) {
    if (!diagnostics.wants_warnings()) return;
    const SourcePosition position = document.position(where);
    if (said.insert(to_string(position) + sentence).second) diagnostics.warning(position, sentence);
  };
  check_gltf_schema(document.root(), complain);
  GltfAuditor(document, diagnostics).run();
  audit_links(document.root(), complain);
  audit_data(document, accessors, with_animations, complain);
}

}  // namespace etendue
