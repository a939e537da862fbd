#include "formats/gltf/gltf_animation.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>

#include "core/text.h"

namespace etendue {
namespace {

enum class Interpolation { step, linear, cubic };

/// The value of a channel at one time.
using PropertyValue = std::vector<double>;

/// Evaluates the sampler of a channel, at or between its keyframes.
class AnimationSampler {
 public:
  /// `components`: of one value. Throws GltfError.
  AnimationSampler(Accessors& accessors, const JsonValue& json, std::uint32_t components)
      : json_(json), interpolation_(interpolation_of(json)), components_(components) {
    times_ = table(accessors, "input", {1}).numbers;
    if (times_.empty()) throw GltfError{&json, "the sampler of an animation has no keyframes"};
    check_times();
    values_ = table(accessors, "output", {1, 2, 3, 4}).numbers;
    const std::size_t wanted = times_.size() * components * (interpolation_ == Interpolation::cubic ? 3 : 1);
    if (values_.size() != wanted)
      throw GltfError{&json, fmt::format("the sampler of an animation has {} keyframes and {} numbers; it needs {}",
                                         times_.size(), values_.size(), wanted)};
    for (const float value : values_) {
      if (!std::isfinite(value))
        throw GltfError{&json, fmt::format("the sampler of an animation has the value {}", value)};
    }
  }

  double end() const { return static_cast<double>(times_.back()); }

  /// `turns`: whether the values are unit quaternions.
  PropertyValue at(double time, bool turns) const {
    const auto after = std::ranges::upper_bound(times_, time, {}, [](float t) { return static_cast<double>(t); });
    const auto next = static_cast<std::size_t>(after - times_.begin());
    if (next == 0) return value(0);
    if (next == times_.size() || interpolation_ == Interpolation::step) return value(next - 1);
    const double from = times_[next - 1], length = static_cast<double>(times_[next]) - from;
    const double s = (time - from) / length;
    if (interpolation_ == Interpolation::cubic) return cubic(next - 1, s, length);
    if (turns) return turned(value(next - 1), value(next), s);
    PropertyValue out = value(next - 1);
    const PropertyValue to = value(next);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += s * (to[i] - out[i]);
    return out;
  }

 private:
  static Interpolation interpolation_of(const JsonValue& json) {
    const std::string name = string_or(json, "interpolation", "LINEAR");
    if (name == "LINEAR") return Interpolation::linear;
    if (name == "STEP") return Interpolation::step;
    if (name == "CUBICSPLINE") return Interpolation::cubic;
    throw GltfError{&json, fmt::format("the interpolation {} is unknown; known are LINEAR, STEP and CUBICSPLINE",
                                       text::quoted(name))};
  }

  FloatTable table(Accessors& accessors, const char* name, std::initializer_list<std::uint32_t> components) const {
    const auto index = find_index(json_, name);
    if (!index) throw GltfError{&json_, fmt::format("the sampler of an animation has no \"{}\"", name)};
    return accessors.floats(*index, json_, components);
  }

  void check_times() const {
    for (std::size_t i = 0; i < times_.size(); ++i) {
      if (!std::isfinite(times_[i]))
        throw GltfError{&json_,
                        fmt::format("keyframe {} of an animation is at {} s, which is not a time", i, times_[i])};
      if (i > 0 && !(times_[i] > times_[i - 1]))
        throw GltfError{&json_, fmt::format("keyframe {} of an animation is at {} s, which is not later than the one "
                                            "before it, at {} s",
                                            i, times_[i], times_[i - 1])};
    }
  }

  /// `part`: for cubic splines 0 is the in-tangent, 1 the value and 2 the out-tangent.
  PropertyValue row(std::size_t key, std::size_t part) const {
    const std::size_t rows = interpolation_ == Interpolation::cubic ? 3 : 1;
    const auto begin = values_.begin() + static_cast<std::ptrdiff_t>((key * rows + part) * components_);
    return {begin, begin + static_cast<std::ptrdiff_t>(components_)};
  }
  PropertyValue value(std::size_t key) const { return row(key, interpolation_ == Interpolation::cubic ? 1 : 0); }

  PropertyValue cubic(std::size_t key, double s, double length) const {
    const PropertyValue from = value(key), to = value(key + 1), leaves = row(key, 2), arrives = row(key + 1, 0);
    const double s2 = s * s, s3 = s2 * s;
    PropertyValue out(components_);
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = (2.0 * s3 - 3.0 * s2 + 1.0) * from[i] + length * (s3 - 2.0 * s2 + s) * leaves[i] +
               (3.0 * s2 - 2.0 * s3) * to[i] + length * (s3 - s2) * arrives[i];
    return out;
  }

  // Along the shorter arc, as the standard demands.
  PropertyValue turned(const PropertyValue& a, const PropertyValue& b, double s) const {
    const glm::dquat from(a[3], a[0], a[1], a[2]), to(b[3], b[0], b[1], b[2]);
    if (!(glm::length(from) > 0.0) || !(glm::length(to) > 0.0))
      throw GltfError{&json_, "the sampler of an animation has a rotation of length 0"};
    const glm::dquat q = glm::slerp(glm::normalize(from), glm::normalize(to), s);
    return {q.x, q.y, q.z, q.w};
  }

  const JsonValue& json_;
  Interpolation interpolation_;
  std::uint32_t components_;
  std::vector<float> times_, values_;
};

class PoseReader {
 public:
  PoseReader(const GltfDocument& document, Accessors& accessors, double time, Diagnostics& diagnostics)
      : document_(document), accessors_(accessors), time_(time), sink_(diagnostics) {}

  void add(const JsonValue& animation, std::uint32_t number) {
    if (animation.object() == nullptr)
      throw GltfError{&animation, fmt::format("\"animations\" holds {}; it must hold objects", animation.kind())};
    for (const JsonValue& channel : array_of(animation, "channels")) {
      if (channel.object() == nullptr)
        throw GltfError{&channel, fmt::format("\"channels\" holds {}; it must hold objects", channel.kind())};
      add_channel(animation, number, channel);
    }
  }

  GltfPose pose;

 private:
  void add_channel(const JsonValue& animation, std::uint32_t number, const JsonValue& channel) {
    const JsonValue* target = find_object(channel, "target");
    if (target == nullptr) throw GltfError{&channel, "a channel of an animation has no \"target\""};
    const std::string path = string_or(*target, "path", "");
    const auto node = find_index(*target, "node");
    if (!node && path != "pointer") return;  // the standard says to ignore such channels
    if (path != "translation" && path != "rotation" && path != "scale" && path != "weights") {
      if (unknown_++ == 0)
        sink_.warning(document_.position(*target),
                      fmt::format("an animation moves {}, which is not supported and stays still",
                                  path.empty() ? "nothing" : text::quoted(path)));
      return;
    }
    const JsonValue& moved = document_.element("nodes", *node, *target);
    if (path != "weights" && moved.find("matrix") != nullptr)
      throw GltfError{target, fmt::format("an animation moves node {}, which has a matrix; it must have translation, "
                                          "rotation and scale",
                                          *node)};
    if (!is_first(*node, path, number, *target)) return;
    const std::uint32_t components = path == "rotation" ? 4 : path == "weights" ? weights_of(moved, *target) : 3;
    const AnimationSampler sampler(accessors_, sampler_of(animation, channel), components);
    pose.end = std::max(pose.end, sampler.end());
    set(pose.nodes[*node], path, sampler.at(time_, path == "rotation"));
  }

  static const JsonValue& sampler_of(const JsonValue& animation, const JsonValue& channel) {
    const JsonValue::Array& samplers = array_of(animation, "samplers");
    const auto index = find_index(channel, "sampler");
    if (!index) throw GltfError{&channel, "a channel of an animation has no \"sampler\""};
    if (*index >= samplers.size())
      throw GltfError{&channel, fmt::format("this refers to number {} of the \"samplers\" of its animation, of which "
                                            "there are {}",
                                            *index, samplers.size())};
    if (samplers[*index].object() == nullptr)
      throw GltfError{&samplers[*index],
                      fmt::format("\"samplers\" holds {}; it must hold objects", samplers[*index].kind())};
    return samplers[*index];
  }

  /// The number of morph targets of a node's mesh.
  std::uint32_t weights_of(const JsonValue& node, const JsonValue& where) const {
    const auto mesh = find_index(node, "mesh");
    if (!mesh) throw GltfError{&where, "an animation moves the weights of a node without a mesh"};
    const JsonValue::Array& primitives = array_of(document_.element("meshes", *mesh, node), "primitives");
    const std::size_t count = primitives.empty() ? 0 : array_of(primitives.front(), "targets").size();
    if (count == 0) throw GltfError{&where, "an animation moves the weights of a mesh without morph targets"};
    return static_cast<std::uint32_t>(count);
  }

  bool is_first(std::uint32_t node, const std::string& path, std::uint32_t number, const JsonValue& where) {
    const auto [known, is_new] = movers_.try_emplace({node, path}, number);
    if (is_new) return true;
    if (known->second == number)
      throw GltfError{&where, fmt::format("two channels of an animation move the {} of node {}", path, node)};
    if (conflicts_++ == 0)
      sink_.warning(
          document_.position(where),
          fmt::format("animations {} and {} both move the {} of node {}; the first is used; --animation chooses one",
                      known->second, number, path, node));
    return false;
  }

  static void set(GltfNodePose& node, const std::string& path, PropertyValue value) {
    if (path == "translation") node.translation = glm::dvec3(value[0], value[1], value[2]);
    if (path == "scale") node.scale = glm::dvec3(value[0], value[1], value[2]);
    if (path == "rotation") node.rotation = glm::dvec4(value[0], value[1], value[2], value[3]);
    if (path == "weights") node.weights = std::move(value);
  }

  const GltfDocument& document_;
  Accessors& accessors_;
  double time_;
  Diagnostics& sink_;
  std::map<std::pair<std::uint32_t, std::string>, std::uint32_t>
      movers_;  ///< the animation that moves a property of a node
  std::size_t unknown_ = 0, conflicts_ = 0;
};

}  // namespace

GltfPose gltf_pose(const GltfDocument& document, Accessors& accessors, double time,
                   std::optional<std::uint32_t> animation, Diagnostics& diagnostics) {
  PoseReader reader(document, accessors, time, diagnostics);
  const JsonValue::Array& animations = array_of(document.root(), "animations");
  for (std::uint32_t i = 0; i < animations.size(); ++i) {
    if (!animation || i == *animation) reader.add(animations[i], i);
  }
  return std::move(reader.pose);
}

}  // namespace etendue
