#include "formats/gltf/gltf_schema.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/text.h"

namespace etendue {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr double kAboveZero = std::numeric_limits<double>::denorm_min();

/// One member of an object. Its type is one of
/// - boolean, string, number, count (a whole number from 0 on) or any;
/// - =a|b: one of these strings or numbers;
/// - >nodes: an index into that array of the document;
/// - the name of an object of this table;
/// - one of these followed by [3], an array of so many, or by [], an array of at least one; of indices, each once.
/// `!` at its end marks a member that must exist.
struct Rule {
  std::string_view object, member, type;
  double least = -kUnbounded, most = kUnbounded;
};

/// Members that have their own sentences in gltf_audit.cpp are not limited here.
constexpr Rule kRules[] = {
    {"document", "accessors", "accessor[]"},
    {"document", "animations", "animation[]"},
    {"document", "asset", "asset!"},
    {"document", "buffers", "buffer[]"},
    {"document", "bufferViews", "view[]"},
    {"document", "cameras", "camera[]"},
    {"document", "extensionsRequired", "string[]"},
    {"document", "extensionsUsed", "string[]"},
    {"document", "images", "image[]"},
    {"document", "materials", "material[]"},
    {"document", "meshes", "mesh[]"},
    {"document", "nodes", "node[]"},
    {"document", "samplers", "sampler[]"},
    {"document", "scene", ">scenes"},
    {"document", "scenes", "scene[]"},
    {"document", "skins", "skin[]"},
    {"document", "textures", "texture[]"},
    {"accessor", "bufferView", ">bufferViews"},
    {"accessor", "byteOffset", "count"},
    {"accessor", "componentType", "=5120|5121|5122|5123|5125|5126!"},
    {"accessor", "count", "count!", 1},
    {"accessor", "max", "number[]"},
    {"accessor", "min", "number[]"},
    {"accessor", "name", "string"},
    {"accessor", "normalized", "boolean"},
    {"accessor", "sparse", "sparse"},
    {"accessor", "type", "=SCALAR|VEC2|VEC3|VEC4|MAT2|MAT3|MAT4!"},
    {"sparse", "count", "count!", 1},
    {"sparse", "indices", "sparse indices!"},
    {"sparse", "values", "sparse values!"},
    {"sparse indices", "bufferView", ">bufferViews!"},
    {"sparse indices", "byteOffset", "count"},
    {"sparse indices", "componentType", "=5121|5123|5125!"},
    {"sparse values", "bufferView", ">bufferViews!"},
    {"sparse values", "byteOffset", "count"},
    {"animation", "channels", "channel[]!"},
    {"animation", "name", "string"},
    {"animation", "samplers", "animation sampler[]!"},
    {"channel", "sampler", "count!"},
    {"channel", "target", "target!"},
    {"target", "node", ">nodes"},
    {"target", "path", "=translation|rotation|scale|weights|pointer!"},
    {"animation sampler", "input", ">accessors!"},
    {"animation sampler", "interpolation", "=LINEAR|STEP|CUBICSPLINE"},
    {"animation sampler", "output", ">accessors!"},
    {"asset", "copyright", "string"},
    {"asset", "generator", "string"},
    {"asset", "minVersion", "string"},
    {"asset", "version", "string!"},
    {"buffer", "byteLength", "count", 1},
    {"buffer", "name", "string"},
    {"buffer", "uri", "string"},
    {"view", "buffer", ">buffers!"},
    {"view", "byteLength", "count!", 1},
    {"view", "byteOffset", "count"},
    {"view", "byteStride", "count", 4, 252},
    {"view", "name", "string"},
    {"view", "target", "=34962|34963"},
    {"camera", "name", "string"},
    {"camera", "orthographic", "orthographic"},
    {"camera", "perspective", "perspective"},
    {"camera", "type", "=perspective|orthographic!"},
    {"orthographic", "xmag", "number!"},
    {"orthographic", "ymag", "number!"},
    {"orthographic", "zfar", "number!", kAboveZero},
    {"orthographic", "znear", "number!", 0},
    {"perspective", "aspectRatio", "number"},
    {"perspective", "yfov", "number!", kAboveZero},
    {"perspective", "zfar", "number", kAboveZero},
    {"perspective", "znear", "number"},
    {"image", "bufferView", ">bufferViews"},
    {"image", "mimeType", "=image/jpeg|image/png|image/webp|image/ktx2|image/avif|image/vnd-ms.dds"},
    {"image", "name", "string"},
    {"image", "uri", "string"},
    {"material", "alphaCutoff", "number"},
    {"material", "alphaMode", "=OPAQUE|MASK|BLEND"},
    {"material", "doubleSided", "boolean"},
    {"material", "emissiveFactor", "number[3]", -kUnbounded, 1},
    {"material", "emissiveTexture", "texture reference"},
    {"material", "name", "string"},
    {"material", "normalTexture", "normal texture"},
    {"material", "occlusionTexture", "occlusion texture"},
    {"material", "pbrMetallicRoughness", "metallic-roughness"},
    {"metallic-roughness", "baseColorFactor", "number[4]"},
    {"metallic-roughness", "baseColorTexture", "texture reference"},
    {"metallic-roughness", "metallicFactor", "number"},
    {"metallic-roughness", "metallicRoughnessTexture", "texture reference"},
    {"metallic-roughness", "roughnessFactor", "number"},
    {"texture reference", "index", ">textures!"},
    {"texture reference", "texCoord", "count"},
    {"normal texture", "index", ">textures!"},
    {"normal texture", "scale", "number"},
    {"normal texture", "texCoord", "count"},
    {"occlusion texture", "index", ">textures!"},
    {"occlusion texture", "strength", "number", 0, 1},
    {"occlusion texture", "texCoord", "count"},
    {"mesh", "name", "string"},
    {"mesh", "primitives", "primitive[]!"},
    {"mesh", "weights", "number[]"},
    {"primitive", "attributes", "any!"},
    {"primitive", "indices", ">accessors"},
    {"primitive", "material", ">materials"},
    {"primitive", "mode", "=0|1|2|3|4|5|6"},
    {"primitive", "targets", "any[]"},
    {"node", "camera", ">cameras"},
    {"node", "children", ">nodes[]"},
    {"node", "matrix", "number[16]"},
    {"node", "mesh", ">meshes"},
    {"node", "name", "string"},
    {"node", "rotation", "number[4]"},
    {"node", "scale", "number[3]"},
    {"node", "skin", ">skins"},
    {"node", "translation", "number[3]"},
    {"node", "weights", "number[]"},
    {"sampler", "magFilter", "count"},
    {"sampler", "minFilter", "count"},
    {"sampler", "name", "string"},
    {"sampler", "wrapS", "=33071|33648|10497"},
    {"sampler", "wrapT", "=33071|33648|10497"},
    {"scene", "name", "string"},
    {"scene", "nodes", ">nodes[]"},
    {"skin", "inverseBindMatrices", ">accessors"},
    {"skin", "joints", ">nodes[]!"},
    {"skin", "name", "string"},
    {"skin", "skeleton", ">nodes"},
    {"texture", "name", "string"},
    {"texture", "sampler", ">samplers"},
    {"texture", "source", ">images"},
    {"KHR_lights_punctual", "lights", "light[]!"},
    {"light", "color", "number[3]", 0, 1},
    {"light", "intensity", "number", 0},
    {"light", "name", "string"},
    {"light", "range", "number", kAboveZero},
    {"light", "spot", "spot"},
    {"light", "type", "=directional|point|spot!"},
    {"spot", "innerConeAngle", "number", 0, std::numbers::pi / 2},
    {"spot", "outerConeAngle", "number", kAboveZero, std::numbers::pi / 2},
    {"KHR_materials_variants", "variants", "variant[]!"},
    {"variant", "name", "string!"},
    {"light of a node", "light", "count!"},
    {"EXT_mesh_gpu_instancing", "attributes", "any!"},
    {"KHR_node_hoverability", "hoverable", "boolean"},
    {"KHR_node_selectability", "selectable", "boolean"},
    {"KHR_node_visibility", "visible", "boolean"},
    {"KHR_draco_mesh_compression", "attributes", "any!"},
    {"KHR_draco_mesh_compression", "bufferView", ">bufferViews!"},
    {"variants of a primitive", "mappings", "mapping[]!"},
    {"mapping", "material", ">materials!"},
    {"mapping", "name", "string"},
    {"mapping", "variants", "count[]!"},
    {"other picture", "source", ">images!"},
    {"KHR_texture_transform", "offset", "number[2]"},
    {"KHR_texture_transform", "rotation", "number"},
    {"KHR_texture_transform", "scale", "number[2]"},
    {"KHR_texture_transform", "texCoord", "count"},
    {"KHR_animation_pointer", "pointer", "string!"},
    {"KHR_materials_anisotropy", "anisotropyRotation", "number"},
    {"KHR_materials_anisotropy", "anisotropyStrength", "number"},
    {"KHR_materials_anisotropy", "anisotropyTexture", "texture reference"},
    {"KHR_materials_clearcoat", "clearcoatFactor", "number"},
    {"KHR_materials_clearcoat", "clearcoatNormalTexture", "normal texture"},
    {"KHR_materials_clearcoat", "clearcoatRoughnessFactor", "number"},
    {"KHR_materials_clearcoat", "clearcoatRoughnessTexture", "texture reference"},
    {"KHR_materials_clearcoat", "clearcoatTexture", "texture reference"},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionColorFactor", "number[3]"},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture", "texture reference"},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionFactor", "number"},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionTexture", "texture reference"},
    {"KHR_materials_dispersion", "dispersion", "number"},
    {"KHR_materials_emissive_strength", "emissiveStrength", "number"},
    {"KHR_materials_ior", "ior", "number"},
    {"KHR_materials_iridescence", "iridescenceFactor", "number"},
    {"KHR_materials_iridescence", "iridescenceIor", "number"},
    {"KHR_materials_iridescence", "iridescenceTexture", "texture reference"},
    {"KHR_materials_iridescence", "iridescenceThicknessMaximum", "number"},
    {"KHR_materials_iridescence", "iridescenceThicknessMinimum", "number"},
    {"KHR_materials_iridescence", "iridescenceThicknessTexture", "texture reference"},
    {"KHR_materials_pbrSpecularGlossiness", "diffuseFactor", "number[4]"},
    {"KHR_materials_pbrSpecularGlossiness", "diffuseTexture", "texture reference"},
    {"KHR_materials_pbrSpecularGlossiness", "glossinessFactor", "number"},
    {"KHR_materials_pbrSpecularGlossiness", "specularFactor", "number[3]"},
    {"KHR_materials_pbrSpecularGlossiness", "specularGlossinessTexture", "texture reference"},
    {"KHR_materials_sheen", "sheenColorFactor", "number[3]"},
    {"KHR_materials_sheen", "sheenColorTexture", "texture reference"},
    {"KHR_materials_sheen", "sheenRoughnessFactor", "number"},
    {"KHR_materials_sheen", "sheenRoughnessTexture", "texture reference"},
    {"KHR_materials_specular", "specularColorFactor", "number[3]"},
    {"KHR_materials_specular", "specularColorTexture", "texture reference"},
    {"KHR_materials_specular", "specularFactor", "number"},
    {"KHR_materials_specular", "specularTexture", "texture reference"},
    {"KHR_materials_transmission", "transmissionFactor", "number"},
    {"KHR_materials_transmission", "transmissionTexture", "texture reference"},
    {"KHR_materials_volume", "attenuationColor", "number[3]"},
    {"KHR_materials_volume", "attenuationDistance", "number"},
    {"KHR_materials_volume", "thicknessFactor", "number"},
    {"KHR_materials_volume", "thicknessTexture", "texture reference"},
};

/// Where an extension may stand, and what it is there. Others may stand anywhere and are not looked into.
struct Place {
  std::string_view object, extension, type;
};

constexpr Place kPlaces[] = {
    {"document", "KHR_lights_punctual", "KHR_lights_punctual"},
    {"document", "KHR_materials_variants", "KHR_materials_variants"},
    {"node", "EXT_mesh_gpu_instancing", "EXT_mesh_gpu_instancing"},
    {"node", "KHR_lights_punctual", "light of a node"},
    {"node", "KHR_node_hoverability", "KHR_node_hoverability"},
    {"node", "KHR_node_selectability", "KHR_node_selectability"},
    {"node", "KHR_node_visibility", "KHR_node_visibility"},
    {"primitive", "KHR_draco_mesh_compression", "KHR_draco_mesh_compression"},
    {"primitive", "KHR_materials_variants", "variants of a primitive"},
    {"view", "EXT_meshopt_compression", "any"},
    {"view", "KHR_meshopt_compression", "any"},
    {"buffer", "EXT_meshopt_compression", "any"},
    {"buffer", "KHR_meshopt_compression", "any"},
    {"texture", "EXT_texture_avif", "other picture"},
    {"texture", "EXT_texture_webp", "other picture"},
    {"texture", "KHR_texture_basisu", "other picture"},
    {"texture", "MSFT_texture_dds", "other picture"},
    {"texture reference", "KHR_texture_transform", "KHR_texture_transform"},
    {"normal texture", "KHR_texture_transform", "KHR_texture_transform"},
    {"occlusion texture", "KHR_texture_transform", "KHR_texture_transform"},
    {"target", "KHR_animation_pointer", "KHR_animation_pointer"},
    {"material", "KHR_materials_anisotropy", "KHR_materials_anisotropy"},
    {"material", "KHR_materials_clearcoat", "KHR_materials_clearcoat"},
    {"material", "KHR_materials_diffuse_transmission", "KHR_materials_diffuse_transmission"},
    {"material", "KHR_materials_dispersion", "KHR_materials_dispersion"},
    {"material", "KHR_materials_emissive_strength", "KHR_materials_emissive_strength"},
    {"material", "KHR_materials_ior", "KHR_materials_ior"},
    {"material", "KHR_materials_iridescence", "KHR_materials_iridescence"},
    {"material", "KHR_materials_pbrSpecularGlossiness", "KHR_materials_pbrSpecularGlossiness"},
    {"material", "KHR_materials_sheen", "KHR_materials_sheen"},
    {"material", "KHR_materials_specular", "KHR_materials_specular"},
    {"material", "KHR_materials_transmission", "KHR_materials_transmission"},
    {"material", "KHR_materials_unlit", "KHR_materials_unlit"},
    {"material", "KHR_materials_volume", "KHR_materials_volume"},
    {"material", "KHR_materials_volume_scatter", "any"},
};

class SchemaChecker {
 public:
  SchemaChecker(const JsonValue& root, const GltfComplaint& complain) : root_(root), complain_(complain) {
    for (const Rule& rule : kRules) rules_[rule.object].push_back(&rule);
    for (const Place& place : kPlaces) places_[place.extension].push_back(&place);
  }

  void check_object(const JsonValue& value, std::string_view type) {
    const auto known = rules_.find(type);
    const std::span<const Rule* const> rules = known == rules_.end() ? std::span<const Rule* const>() : known->second;
    for (const auto& [name, member] : *value.object()) {
      if (name == "extras") continue;
      if (name == "extensions") {
        check_extensions(member, type);
        continue;
      }
      const auto rule = std::ranges::find(rules, std::string_view(name), &Rule::member);
      if (rule == rules.end()) {
        complain_(member, fmt::format("{} has no member {}; it is ignored", with_article(type), text::quoted(name)));
      } else {
        check(member, **rule, without_mark((*rule)->type));
      }
    }
    for (const Rule* rule : rules) {
      if (rule->type.ends_with('!') && value.find(rule->member) == nullptr)
        complain_(value, fmt::format("{} has no \"{}\", which it must have", with_article(type), rule->member));
    }
  }

 private:
  static std::string_view without_mark(std::string_view type) {
    return type.ends_with('!') ? type.substr(0, type.size() - 1) : type;
  }
  static std::string with_article(std::string_view type) {
    if (type == "document" || type.starts_with("KHR_") || type.starts_with("EXT_"))
      return type == "document" ? "the document" : std::string(type);
    constexpr std::string_view kVowels = "aeio";
    return fmt::format("{} {}", kVowels.find(type.front()) == std::string_view::npos ? "a" : "an", type);
  }

  void check(const JsonValue& value, const Rule& rule, std::string_view type) {
    const std::size_t bracket = type.rfind('[');
    if (bracket != std::string_view::npos)
      return check_array(value, rule, type.substr(0, bracket), type.substr(bracket));
    if (type == "any") return;
    if (type.starts_with('=')) return check_choice(value, rule, type.substr(1));
    if (type.starts_with('>')) return check_index(value, rule, type.substr(1));
    if (type == "boolean") return check_kind(value, rule, value.boolean() != nullptr, "true or false");
    if (type == "string") return check_kind(value, rule, value.string() != nullptr, "a string");
    if (type == "number" || type == "count") return check_number(value, rule, type == "count");
    if (check_kind(value, rule, value.object() != nullptr, "an object"), value.object() != nullptr)
      check_object(value, type);
  }

  void check_kind(const JsonValue& value, const Rule& rule, bool good, std::string_view wanted) {
    if (!good) complain_(value, fmt::format("\"{}\" is {}; it must be {}", rule.member, value.kind(), wanted));
  }

  void check_array(const JsonValue& value, const Rule& rule, std::string_view type, std::string_view length) {
    check_kind(value, rule, value.array() != nullptr, "an array");
    if (value.array() == nullptr) return;
    const JsonValue::Array& elements = *value.array();
    if (elements.empty())
      return complain_(value, fmt::format("\"{}\" is empty; it must have an element or be left out", rule.member));
    if (length != "[]" && length != fmt::format("[{}]", elements.size()))
      complain_(value, fmt::format("\"{}\" has {} numbers; it must have {}", rule.member, elements.size(),
                                   length.substr(1, length.size() - 2)));
    for (const JsonValue& element : elements) check(element, rule, type);
    // Nodes of scenes are counted in gltf_audit.cpp.
    if (rule.object != "scene" && (type.starts_with('>') || type == "string")) check_repetition(value, rule);
  }

  void check_repetition(const JsonValue& value, const Rule& rule) {
    std::set<std::string> seen;
    for (const JsonValue& element : *value.array()) {
      const std::string text = element.string() != nullptr   ? text::quoted(*element.string())
                               : element.number() != nullptr ? fmt::format("{}", *element.number())
                                                             : "";
      if (!text.empty() && !seen.insert(text).second)
        return complain_(element, fmt::format("\"{}\" lists {} twice", rule.member, text));
    }
  }

  void check_choice(const JsonValue& value, const Rule& rule, std::string_view choices) {
    const bool is_text = value.string() != nullptr, is_number = value.number() != nullptr;
    const std::string word = is_text ? *value.string() : is_number ? fmt::format("{}", *value.number()) : "";
    const bool wants_text = choices.find_first_of("0123456789") != 0;
    if (wants_text ? !is_text : !is_number) return check_kind(value, rule, false, wants_text ? "a string" : "a number");
    const std::vector<std::string_view> words = text::split(choices, '|');
    if (std::ranges::find(words, std::string_view(word)) != words.end()) return;
    complain_(value, fmt::format("\"{}\" is {}; it must be one of {}", rule.member, is_text ? text::quoted(word) : word,
                                 fmt::join(words, ", ")));
  }

  void check_number(const JsonValue& value, const Rule& rule, bool is_count) {
    if (value.number() == nullptr) return check_kind(value, rule, false, "a number");
    const double n = *value.number();
    if (is_count && !(n >= 0.0 && n == std::floor(n)))
      return complain_(value, fmt::format("\"{}\" is {}; it must be a whole number from 0 on", rule.member, n));
    if (is_count && value.has_point())
      complain_(value, fmt::format("\"{}\" is written with a decimal point; it must be a whole number", rule.member));
    if (n >= rule.least && n <= rule.most) return;
    const std::string least = rule.least == kAboveZero ? "above 0" : fmt::format("at least {}", rule.least);
    const std::string most = fmt::format("at most {:.6g}", rule.most);
    complain_(value, fmt::format("\"{}\" is {}; it must be {}", rule.member, n,
                                 rule.most == kUnbounded     ? least
                                 : rule.least == -kUnbounded ? most
                                                             : fmt::format("{} and {}", least, most)));
  }

  void check_index(const JsonValue& value, const Rule& rule, std::string_view array) {
    check_number(value, rule, true);
    if (value.number() == nullptr) return;
    const JsonValue* elements = root_.find(array);
    const std::size_t count = elements == nullptr || elements->array() == nullptr ? 0 : elements->array()->size();
    if (*value.number() >= static_cast<double>(count))
      complain_(value, fmt::format("\"{}\" refers to number {} of \"{}\", of which there are {}; it is ignored",
                                   rule.member, *value.number(), array, count));
  }

  /// gltf_audit.cpp reports extensions that are not declared.
  void check_extensions(const JsonValue& value, std::string_view owner) {
    if (value.object() == nullptr) return;
    if (value.object()->empty()) complain_(value, "\"extensions\" is empty; it must have an element or be left out");
    for (const auto& [name, extension] : *value.object()) {
      const auto places = places_.find(name);
      if (places == places_.end()) continue;
      const auto place = std::ranges::find(places->second, owner, &Place::object);
      if (place == places->second.end()) {
        complain_(extension, fmt::format("{} cannot have the extension {}; it is ignored", with_article(owner), name));
      } else if (extension.object() == nullptr) {
        complain_(extension, fmt::format("\"{}\" is {}; it must be an object", name, extension.kind()));
      } else if ((*place)->type != "any") {
        check_object(extension, (*place)->type);
      }
    }
  }

  const JsonValue& root_;
  const GltfComplaint& complain_;
  std::map<std::string_view, std::vector<const Rule*>> rules_;
  std::map<std::string_view, std::vector<const Place*>> places_;
};

}  // namespace

void check_gltf_schema(const JsonValue& root, const GltfComplaint& complain) {
  if (root.object() != nullptr) SchemaChecker(root, complain).check_object(root, "document");
}

}  // namespace etendue
