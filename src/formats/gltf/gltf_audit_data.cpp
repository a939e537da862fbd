#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "core/text.h"
#include "formats/gltf/gltf_animation.h"
#include "formats/gltf/gltf_audit_parts.h"
#include "formats/gltf/uri.h"
#include "scene/diagnostics.h"

namespace etendue::gltf_audit {
namespace {

/// What accessors are for.
enum class Use { vertices, indices, bind_matrices, keyframes };

const char* name_of(Use as) {
  constexpr const char* kNames[] = {"attributes of vertices", "indices", "bind matrices", "keyframes"};
  return kNames[static_cast<int>(as)];
}

std::uint64_t bytes_of(double component_type) {
  return component_type <= kUnsignedByte ? 1 : component_type <= kUnsignedShort ? 2 : 4;
}

/// What the numbers of this type are divided by when they are normalised.
double divisor_of(double component_type) {
  return component_type == kByte            ? 127.0
         : component_type == kUnsignedByte  ? 255.0
         : component_type == kShort         ? 32767.0
         : component_type == kUnsignedShort ? 65535.0
                                            : 1.0;
}

/// The MIME type that the first bytes of a picture show; empty if they are none that is known.
std::string_view mime_type_of(const ByteStore& bytes) {
  char head[12] = {};
  bytes.read(0, std::as_writable_bytes(std::span(head)).first(std::min<std::uint64_t>(bytes.size(), sizeof head)));
  const std::string_view text(head, sizeof head);
  if (text.starts_with("\x89PNG")) return "image/png";
  if (text.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (text.starts_with("RIFF") && text.substr(8) == "WEBP") return "image/webp";
  if (text.starts_with("\xabKTX 20\xbb")) return "image/ktx2";
  return {};
}

class DataAuditor {
 public:
  DataAuditor(GltfDocument& document, Accessors& accessors, bool with_animations, const GltfComplaint& complain)
      : document_(document),
        root_(document.root()),
        accessors_(accessors),
        with_animations_(with_animations),
        warn_(complain) {}

  void run() {
    for (const JsonValue& mesh : list(root_, "meshes")) find_uses(mesh);
    for (const JsonValue& skin : list(root_, "skins")) use(skin, "inverseBindMatrices", Use::bind_matrices);
    for (const JsonValue& animation : list(root_, "animations")) {
      for (const JsonValue& sampler : list(animation, "samplers")) {
        use(sampler, "input", Use::keyframes);
        use(sampler, "output", Use::keyframes);
      }
    }
    each("buffers", [&](const JsonValue& json, std::uint32_t i) { audit_buffer(json, i); });
    each("bufferViews", [&](const JsonValue& json, std::uint32_t i) { audit_view(json, i); });
    each("accessors", [&](const JsonValue& json, std::uint32_t i) { audit_accessor(json, i); });
    each("images", [&](const JsonValue& json, std::uint32_t) { audit_image(json); });
    each("textures", [&](const JsonValue& json, std::uint32_t) { audit_texture(json); });
    for (const JsonValue& mesh : list(root_, "meshes")) audit_vertices(mesh);
    each("skins", [&](const JsonValue& json, std::uint32_t) { audit_skin(json); });
    each("animations", [&](const JsonValue& json, std::uint32_t i) { audit_animation(json, i); });
  }

 private:
  /// Calls f for each object of an array of the document. What cannot be read at all is a complaint, too.
  template <typename F>
  void each(const char* array, const F& f) {
    std::uint32_t i = 0;
    for (const JsonValue& json : list(root_, array)) {
      if (json.object() != nullptr) guarded([&] { f(json, i); });
      ++i;
    }
  }
  template <typename F>
  void guarded(const F& f) {
    try {
      f();
    } catch (const GltfError& error) {
      warn_(*error.where, error.message);
    }
  }

  /// The numbers of an accessor; none once very many have been read, because a small file can name the same bytes again
  /// and again.
  FloatTable numbers(std::uint32_t index, const JsonValue& where, std::initializer_list<std::uint32_t> components) {
    constexpr std::uint64_t kMostRows = std::uint64_t{1} << 27;
    read_rows_ += accessors_.count(index, where);
    return read_rows_ > kMostRows ? FloatTable{} : accessors_.floats(index, where, components);
  }

  void find_uses(const JsonValue& mesh) {
    for (const JsonValue& primitive : list(mesh, "primitives")) {
      use(primitive, "indices", Use::indices);
      std::vector<const JsonValue*> sets = {primitive.find("attributes")};
      for (const JsonValue& target : list(primitive, "targets")) sets.push_back(&target);
      for (const JsonValue* set : sets) {
        if (set == nullptr || set->object() == nullptr) continue;
        for (const auto& [name, value] : *set->object()) use(value, Use::vertices);
      }
    }
  }

  void use(const JsonValue& object, std::string_view name, Use as) {
    if (const JsonValue* index = object.find(name)) use(*index, as);
  }
  void use(const JsonValue& index, Use as) {
    const JsonValue* accessor = element_at(root_, "accessors", index);
    if (accessor == nullptr) return;
    uses_[accessor].insert(as);
    if (const JsonValue* view = element_of(root_, "bufferViews", *accessor, "bufferView")) {
      view_uses_[view].insert(as);
      if (as == Use::vertices) vertex_accessors_[view].insert(accessor);
    }
  }

  void audit_buffer(const JsonValue& json, std::uint32_t i) {
    const std::string uri = string_in(json, "uri");
    // What only compressed views refer to need not exist.
    if (json.find("uri") == nullptr && json.find("extensions") != nullptr) return;
    const std::shared_ptr<const ByteStore> bytes = document_.buffer(i, json);
    if (uri.starts_with("data:")) {
      const std::string_view type = std::string_view(uri).substr(5, uri.find_first_of(";,") - 5);
      if (type != "application/octet-stream" && type != "application/gltf-buffer")
        warn_(json, fmt::format("the buffer's data have the MIME type {}; it must be application/octet-stream or "
                                "application/gltf-buffer",
                                text::quoted(std::string(type))));
    }
    const double length = number_in(json, "byteLength").value_or(static_cast<double>(bytes->size()));
    if (json.find("uri") == nullptr && static_cast<double>(bytes->size()) > length + 3.0)
      warn_(json, fmt::format("the binary chunk has {} bytes, {} more than the buffer", bytes->size(),
                              static_cast<double>(bytes->size()) - length));
  }

  void audit_view(const JsonValue& json, std::uint32_t) {
    const double stride = number_in(json, "byteStride").value_or(0.0);
    if (std::fmod(stride, 4.0) != 0.0)
      warn_(json, fmt::format("\"byteStride\" is {}; it must be a multiple of 4", stride));
    const double end = number_in(json, "byteOffset").value_or(0.0) + number_in(json, "byteLength").value_or(0.0);
    const JsonValue* buffer = element_of(root_, "buffers", json, "buffer");
    const double length = buffer == nullptr ? end : number_in(*buffer, "byteLength").value_or(end);
    if (end > length) warn_(json, fmt::format("the view ends at byte {} of its buffer, which has {}", end, length));
    const auto known = view_uses_.find(&json);
    if (known == view_uses_.end()) return;
    const std::set<Use>& uses = known->second;
    const double target = number_in(json, "target").value_or(0.0);
    for (const Use as : uses) {
      if (as != Use::vertices && stride != 0.0)
        warn_(json, fmt::format("the view has a \"byteStride\" but holds {}, which must not have one", name_of(as)));
      if ((target == 34962.0 && as == Use::indices) || (target == 34963.0 && as == Use::vertices))
        warn_(json, fmt::format("\"target\" is {}, but the view holds {}", target, name_of(as)));
    }
    if (uses.contains(Use::vertices) && uses.contains(Use::indices))
      warn_(json, "the view holds both attributes of vertices and indices");
    if (stride == 0.0 && vertex_accessors_[&json].size() > 1)
      warn_(json, fmt::format("{} attributes of vertices share the view, which then must have a \"byteStride\"",
                              vertex_accessors_[&json].size()));
  }

  void audit_accessor(const JsonValue& json, std::uint32_t i) {
    const auto known = uses_.find(&json);
    if (known != uses_.end() && known->second.size() > 1)
      warn_(json, fmt::format("the accessor is used as {} and as {}", name_of(*known->second.begin()),
                              name_of(*known->second.rbegin())));
    if (json.find("bufferView") == nullptr && json.find("byteOffset") != nullptr)
      warn_(json, "the accessor has a \"byteOffset\" but no \"bufferView\"");
    audit_alignment(json, known != uses_.end() && known->second.contains(Use::vertices));
    // Compressed primitives may have accessors without data of their own.
    if (json.find("bufferView") == nullptr && json.find("sparse") == nullptr) return;
    const bool is_integer = number_in(json, "componentType") != kFloat;
    if (is_integer && json.find("min") == nullptr && json.find("max") == nullptr && json.find("sparse") == nullptr) {
      accessors_.check(i, json);  // that its bytes exist
      return;
    }
    if (json.find("bufferView") != nullptr) audit_numbers(json, numbers(i, json, {1, 2, 3, 4, 9, 16}));
    const std::vector<std::uint32_t> places = accessors_.sparse_places(i, json);
    if (std::ranges::adjacent_find(places, std::greater_equal<>()) != places.end())
      warn_(json, "the indices of the sparse rows do not increase; the last row for an index is used");
  }

  void audit_alignment(const JsonValue& json, bool of_vertices) {
    const JsonValue* view = element_of(root_, "bufferViews", json, "bufferView");
    if (view == nullptr) return;
    const bool four = of_vertices || string_in(json, "type").starts_with("MAT");
    const std::uint64_t size = four ? 4 : bytes_of(number_in(json, "componentType").value_or(0.0));
    const double offset = number_in(json, "byteOffset").value_or(0.0);
    const double begin = offset + number_in(*view, "byteOffset").value_or(0.0);
    const double stride = number_in(*view, "byteStride").value_or(0.0);
    const auto divides = [&](double n) { return std::fmod(n, static_cast<double>(size)) == 0.0; };
    if (!divides(offset)) {
      warn_(json, fmt::format("\"byteOffset\" is {}; it must be a multiple of {}", offset, size));
    } else if (!divides(begin)) {
      warn_(json,
            fmt::format("the accessor begins at byte {} of its buffer; that must be a multiple of {}", begin, size));
    }
    if (!divides(stride))
      warn_(json,
            fmt::format("the rows of the accessor are {} bytes apart; that must be a multiple of {}", stride, size));
  }

  void audit_numbers(const JsonValue& json, const FloatTable& table) {
    const std::size_t bad =
        static_cast<std::size_t>(std::ranges::count_if(table.numbers, [](float n) { return !std::isfinite(n); }));
    if (bad > 0) warn_(json, fmt::format("{} of {} numbers of the accessor are not finite", bad, table.numbers.size()));
    for (const bool is_min : {true, false}) {
      const char* name = is_min ? "min" : "max";
      const JsonValue::Array& bounds = list(json, name);
      if (bounds.empty()) continue;
      if (bounds.size() != table.components) {
        warn_(json, fmt::format("\"{}\" has {} numbers, the rows have {}", name, bounds.size(), table.components));
        continue;
      }
      for (std::uint32_t c = 0; c < table.components && bad == 0 && table.rows() > 0; ++c)
        check_bound(json, table, c, is_min, bounds[c]);
    }
  }

  void check_bound(const JsonValue& json, const FloatTable& table, std::uint32_t c, bool is_min,
                   const JsonValue& bound) {
    float extreme = table.row(0)[c];
    for (std::size_t i = c; i < table.numbers.size(); i += table.components)
      extreme = is_min ? std::min(extreme, table.numbers[i]) : std::max(extreme, table.numbers[i]);
    if (bound.number() == nullptr) return;
    const double declared = *bound.number();
    const double divisor =
        is_true(json, "normalized") ? divisor_of(number_in(json, "componentType").value_or(0.0)) : 1.0;
    const double actual = static_cast<double>(extreme) * divisor;
    // Exporters round bounds to six or seven digits.
    constexpr double kTolerance = 2e-6;
    if (std::abs(actual - declared) <= kTolerance * std::max({std::abs(actual), std::abs(declared), 1e-3})) return;
    warn_(bound, fmt::format("\"{}\" is {:.7g}, but the {} number {} of a row is {:.7g}; it is not used",
                             is_min ? "min" : "max", declared, is_min ? "smallest" : "largest", c, actual));
  }

  void audit_image(const JsonValue& json) {
    const JsonValue* view = json.find("bufferView");
    const JsonValue* uri = json.find("uri");
    if (view != nullptr && uri != nullptr)
      warn_(json, "the image has both a \"uri\" and a \"bufferView\"; the latter is used");
    if (view == nullptr && uri == nullptr) return warn_(json, "the image has neither a \"uri\" nor a \"bufferView\"");
    std::string declared = string_in(json, "mimeType");
    if (view != nullptr && declared.empty()) warn_(json, "the image has a \"bufferView\" but no \"mimeType\"");
    if (const JsonValue* of = element_of(root_, "bufferViews", json, "bufferView");
        of != nullptr && of->find("byteStride"))
      warn_(*of, "the view has a \"byteStride\" but holds an image, which must not have one");
    const std::string text = string_in(json, "uri");
    if (declared.empty() && view == nullptr && text.starts_with("data:"))
      declared = text.substr(5, text.find_first_of(";,") - 5);
    const std::shared_ptr<const ByteStore> bytes =
        view != nullptr ? accessors_.view(find_index(json, "bufferView").value_or(0), json)
                        : document_.resource(text, json);
    const std::string_view actual = mime_type_of(*bytes);
    types_[&json] = std::string(actual);
    if (!actual.empty() && !declared.empty() && actual != declared)
      warn_(json, fmt::format("the image has the MIME type {}, but its data are {}; they are read as such",
                              text::quoted(declared), actual));
  }

  /// Without an extension, a texture shows PNG or JPEG.
  void audit_texture(const JsonValue& json) {
    const JsonValue* image = element_of(root_, "images", json, "source");
    const auto known = types_.find(image);
    const std::string type = image == nullptr ? "" : string_in(*image, "mimeType");
    for (const std::string& t : {type, known == types_.end() ? std::string() : known->second}) {
      if (t.empty() || t == "image/png" || t == "image/jpeg") continue;
      return warn_(json, fmt::format("the \"source\" of the texture is {}; only an extension may name one that is "
                                     "neither PNG nor JPEG",
                                     t));
    }
  }

  void audit_vertices(const JsonValue& mesh) {
    for (const JsonValue& primitive : list(mesh, "primitives")) {
      const JsonValue* attributes = primitive.find("attributes");
      if (attributes == nullptr || attributes->object() == nullptr) continue;
      guarded([&] { audit_directions(*attributes, "NORMAL"); });
      guarded([&] { audit_directions(*attributes, "TANGENT"); });
      guarded([&] { audit_joints(*attributes); });
    }
  }

  /// The rows of an attribute; none if it is missing, compressed, or was looked at before.
  FloatTable once(const JsonValue& attributes, std::string_view name, std::uint32_t components) {
    const JsonValue* accessor = element_of(root_, "accessors", attributes, name);
    if (accessor == nullptr || accessor->find("bufferView") == nullptr ||
        !seen_.insert({accessor, std::string(name)}).second)
      return {};
    return numbers(*find_index(attributes, name), attributes, {components});
  }

  void audit_directions(const JsonValue& attributes, const char* name) {
    const bool is_tangent = std::string_view(name) == "TANGENT";
    const FloatTable table = once(attributes, name, is_tangent ? 4 : 3);
    std::size_t bad = 0, sides = 0;
    // Two units of a signed byte.
    constexpr float kTolerance = 0.016f;
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const float* row = table.row(i);
      const float length = glm::length(glm::vec3(row[0], row[1], row[2]));
      if (std::isfinite(length) && length > 0.0f && std::abs(length - 1.0f) > kTolerance) ++bad;
      if (is_tangent && std::abs(row[3]) != 1.0f) ++sides;
    }
    if (bad > 0)
      warn_(attributes, fmt::format("{} of {} rows of {} do not have the length 1; they are scaled to it", bad,
                                    table.rows(), name));
    if (sides > 0)
      warn_(attributes, fmt::format("{} of {} rows of TANGENT have a side other than 1 and -1; its sign is used", sides,
                                    table.rows()));
  }

  void audit_joints(const JsonValue& attributes) {
    std::vector<float> sums;
    std::size_t negative = 0, idle = 0, repeated = 0;
    bool complete = true;
    constexpr int kMostSets = 64;  // each is looked for among all attributes, of which there may be very many
    for (int set = 0; set < kMostSets && attributes.find(fmt::format("WEIGHTS_{}", set)) != nullptr; ++set) {
      const FloatTable weights = once(attributes, fmt::format("WEIGHTS_{}", set), 4);
      const FloatTable joints = once(attributes, fmt::format("JOINTS_{}", set), 4);
      sums.resize(std::max(sums.size(), weights.rows()), 0.0f);
      complete = complete && weights.rows() == sums.size();
      for (std::size_t i = 0; i < weights.rows(); ++i) {
        for (std::size_t k = 0; k < 4; ++k) {
          const float weight = weights.row(i)[k];
          sums[i] += weight;
          negative += weight < 0.0f ? 1 : 0;
          if (i >= joints.rows()) continue;
          const float* row = joints.row(i);
          idle += weight == 0.0f && row[k] != 0.0f ? 1 : 0;
          repeated += weight > 0.0f && std::find(row, row + k, row[k]) != row + k ? 1 : 0;
        }
      }
    }
    constexpr float kTolerance = 0.01f;
    const auto bad = std::ranges::count_if(sums, [](float sum) { return !(std::abs(sum - 1.0f) <= kTolerance); });
    const auto say = [&](std::size_t count, const char* what) {
      if (count > 0) warn_(attributes, fmt::format("{} {}", count, what));
    };
    say(negative, "weights of joints are below 0; they count as 0");
    say(idle, "joints without a weight are not joint 0; they move nothing");
    say(repeated, "joints are named twice for one vertex; their weights are added");
    if (complete)
      say(static_cast<std::size_t>(bad), "vertices have weights that do not add up to 1; they are scaled to it");
  }

  void audit_skin(const JsonValue& skin) {
    const auto index = find_index(skin, "inverseBindMatrices");
    if (!index) return;
    const FloatTable table = numbers(*index, skin, {16});
    if (table.components != 0 && table.rows() < list(skin, "joints").size())
      warn_(skin, fmt::format("the skin has {} joints and {} matrices", list(skin, "joints").size(), table.rows()));
    std::size_t bad = 0, flat = 0;
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const float* m = table.row(i);
      bad += m[3] != 0.0f || m[7] != 0.0f || m[11] != 0.0f || m[15] != 1.0f ? 1 : 0;
      const glm::dmat3 linear(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
      flat += glm::determinant(linear) == 0.0 ? 1 : 0;
    }
    if (bad > 0) warn_(skin, fmt::format("the last row of {} bind matrices is not 0 0 0 1; it is taken for that", bad));
    if (flat > 0) warn_(skin, fmt::format("{} bind matrices have no inverse", flat));
  }

  void audit_animation(const JsonValue& animation, std::uint32_t number) {
    for (const JsonValue& sampler : list(animation, "samplers")) audit_keyframes(sampler);
    for (const JsonValue& channel : list(animation, "channels")) audit_channel(animation, channel);
    Diagnostics unheard;  // what is not supported matters only once the animation is played
    const auto channels = static_cast<std::uint64_t>(list(animation, "channels").size());
    // Each channel reads its keyframes, which it may share with very many others.
    constexpr std::uint64_t kMostChannels = 20000;
    if (with_animations_ && channels <= kMostChannels) (void)gltf_pose(document_, accessors_, 0.0, number, unheard);
  }

  void audit_keyframes(const JsonValue& sampler) {
    const JsonValue* input = element_of(root_, "accessors", sampler, "input");
    if (input == nullptr) return;
    if (input->find("min") == nullptr || input->find("max") == nullptr)
      warn_(*input, "an accessor of keyframes has no \"min\" and \"max\", which it must have");
    if (number_in(*input, "componentType") != kFloat || string_in(*input, "type") != "SCALAR")
      return warn_(*input, "an accessor of keyframes must have the type SCALAR of the component type 5126");
    const FloatTable times = numbers(*find_index(sampler, "input"), sampler, {1});
    if (!times.numbers.empty() && times.numbers.front() < 0.0f)
      warn_(*input, fmt::format("the first keyframe is at {} s; times must not be below 0", times.numbers.front()));
    if (string_in(sampler, "interpolation") == "CUBICSPLINE" && times.rows() == 1)
      warn_(*input, "a CUBICSPLINE needs two keyframes or more");
  }

  void audit_channel(const JsonValue& animation, const JsonValue& channel) {
    const JsonValue* target = channel.find("target");
    const JsonValue* node = target == nullptr ? nullptr : element_of(root_, "nodes", *target, "node");
    if (node == nullptr) return;
    const std::string path = string_in(*target, "path");
    if (path != "weights" && node->find("skin") != nullptr)
      warn_(*target, "an animation moves the node of a skinned mesh, which only its joints move");
    const auto index = number_in(channel, "sampler");
    const JsonValue::Array& samplers = list(animation, "samplers");
    if (path != "rotation" || !index || !(*index >= 0.0 && *index < static_cast<double>(samplers.size()))) return;
    const JsonValue& sampler = samplers[static_cast<std::size_t>(*index)];
    const auto output = find_index(sampler, "output");
    if (!output || string_in(sampler, "interpolation") == "CUBICSPLINE") return;
    const FloatTable values = numbers(*output, sampler, {4});
    std::size_t bad = 0;
    for (std::size_t i = 0; i < values.rows(); ++i) {
      const float* q = values.row(i);
      bad += std::abs(glm::length(glm::vec4(q[0], q[1], q[2], q[3])) - 1.0f) > 0.01f ? 1 : 0;
    }
    if (bad > 0)
      warn_(sampler, fmt::format("{} of {} rotations of the animation do not have the length 1; they are scaled to it",
                                 bad, values.rows()));
  }

  GltfDocument& document_;
  const JsonValue& root_;
  Accessors& accessors_;
  bool with_animations_;
  const GltfComplaint& warn_;
  std::map<const JsonValue*, std::set<Use>> uses_, view_uses_;
  std::map<const JsonValue*, std::set<const JsonValue*>> vertex_accessors_;
  std::map<const JsonValue*, std::string> types_;
  std::set<std::pair<const JsonValue*, std::string>> seen_;
  std::uint64_t read_rows_ = 0;
};

}  // namespace

void audit_data(GltfDocument& document, Accessors& accessors, bool with_animations, const GltfComplaint& complain) {
  DataAuditor(document, accessors, with_animations, complain).run();
}

}  // namespace etendue::gltf_audit
