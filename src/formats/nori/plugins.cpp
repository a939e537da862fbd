#include "formats/nori/plugins.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/text.h"

namespace etendue {
namespace {

using enum ParameterType;

constexpr double kUint32Max = 4294967295.0;
constexpr double kMaxDepth = 1 << 30;

Range any() {
  return {};
}
Range between(double min, double max) {
  return {min, max, false, false};
}
Range inside(double min, double max) {
  return {min, max, true, true};
}
Range above(double min) {
  return {min, std::numeric_limits<double>::infinity(), true, false};
}
Range above_up_to(double min, double max) {
  return {min, max, true, false};
}

Parameter world_transform() {
  return {"toWorld", transform, "", any(), "object space to world space; the operations apply in the order listed"};
}

Parameter light_sampler() {
  return {
      "lightSampler", string, "auto", any(),
      "how next-event estimation chooses a light: power, by its power alone; tree, by what it can contribute to the "
      "point; auto, tree for 10 or more emitting primitives, else power"};
}

std::vector<Parameter> alias_parameters() {
  return {{"maxDepth", integer, "1073741824", between(1, kMaxDepth), "path segments; the default is without limit"},
          {"rrDepth", integer, "5", between(1, kMaxDepth), "Russian roulette from this segment on"},
          light_sampler()};
}

std::vector<Plugin> scene_plugins() {
  return {
      {"scene",
       "",
       "The root of a rendered file.",
       {{"sky_top", color, "0 0 0", between(0, kMaxRadiance), "radiance from straight above"},
        {"sky_horizon", color, "0 0 0", between(0, kMaxRadiance), "radiance from the horizon and below"},
        {"nee", boolean, "true", any(), "next-event estimation, unless the integrator says"}},
       {{"integrator", 1, 1}, {"camera", 1, 1}, {"sampler", 0, 1}, {"mesh", 0, kAnyNumber}}},
      {"integrator",
       "path",
       "Path tracing.",
       {{"maxDepth", integer, "16", between(1, kMaxDepth),
         "path segments; the camera ray is the first, so 1 is emitted light only and 2 adds direct light"},
        {"nee", boolean, "true", any(), "next-event estimation: one shadow ray to a light at every diffuse vertex"},
        {"mis", boolean, "true", any(), "multiple importance sampling of lights and materials; no effect without nee"},
        {"rrDepth", integer, "5", between(0, kMaxDepth), "Russian roulette from this segment on; 0 is off"},
        light_sampler()},
       {}},
      {"integrator",
       "path_mats",
       "Path tracing by material sampling only: path with nee off, and no depth limit.",
       alias_parameters(),
       {}},
      {"integrator",
       "path_ems",
       "Path tracing with light sampling only at diffuse vertices: path with nee on and mis off, and no depth limit.",
       alias_parameters(),
       {}},
      {"integrator",
       "path_mis",
       "Path tracing with multiple importance sampling: path with nee and mis on, and no depth limit.",
       alias_parameters(),
       {}},
      {"integrator", "normals", "The shading normal of the first hit as a colour, (n + 1)/2.", {}, {}},
  };
}

std::vector<Plugin> view_plugins() {
  return {
      {"camera",
       "perspective",
       "A pinhole camera: +Z forward, +Y up, +X to the left of the image.",
       {{"width", integer, "1280", between(1, 65536), "pixels; width · height is at most 67108864"},
        {"height", integer, "720", between(1, 65536), "pixels"},
        {"fov", real, "30", inside(0, 180), "horizontal field of view in degrees"},
        {"nearClip", real, "1e-4", between(0, kMaxCoordinate), "nearest visible distance along the camera's +Z"},
        {"farClip", real, "1e4", above(0), "farthest visible distance along the camera's +Z; more than nearClip"},
        world_transform()},
       {{"rfilter", 0, 1}}},
      {"sampler",
       "independent",
       "Independent random numbers.",
       {{"sampleCount", integer, "1", between(1, kUint32Max), "samples per pixel"}},
       {}},
      {"sampler",
       "sobol",
       "Owen-scrambled Sobol points: less noise for the same number of samples. A pixel's samples come in sets of "
       "setSize that are independent of each other; standard errors, films and tests count sets.",
       {{"sampleCount", integer, "1", between(1, kUint32Max), "samples per pixel; rounded up to whole sets"},
        {"setSize", integer, "16", between(2, 4096), "samples in a set, a power of two"}},
       {}},
      {"rfilter", "box", "The pixel's square; the default.", {}, {}},
      {"rfilter", "tent", "A tent of radius 1 pixel.", {}, {}},
      {"rfilter",
       "gaussian",
       "A Gaussian, lowered to reach zero at the radius.",
       {{"radius", real, "2", above_up_to(0, 32), "pixels"},
        {"stddev", real, "0.5", above_up_to(0, 32), "standard deviation in pixels"}},
       {}},
      {"rfilter",
       "mitchell",
       "The filter of Mitchell and Netravali; its lobes are negative.",
       {{"radius", real, "2", above_up_to(0, 32), "pixels"},
        {"B", real, "0.3333333333333333", between(-8, 8), "blur"},
        {"C", real, "0.3333333333333333", between(-8, 8), "ringing"}},
       {}},
  };
}

std::vector<Plugin> object_plugins() {
  return {
      {"mesh",
       "obj",
       "Triangles from a Wavefront OBJ file.",
       {{"filename", string, nullptr, any(), "the OBJ file, relative to the folder of the scene file"},
        world_transform()},
       {{"bsdf", 0, 1}, {"emitter", 0, 1}}},
      {"mesh",
       "sphere",
       "An exact sphere.",
       {{"center", point, "0 0 0", between(-kMaxCoordinate, kMaxCoordinate), "world space"},
        {"radius", real, "1", above_up_to(0, kMaxCoordinate), "scene units"}},
       {{"bsdf", 0, 1}, {"emitter", 0, 1}}},
      {"bsdf",
       "diffuse",
       "Lambertian reflection on the side of the normal; black from behind.",
       {{"albedo", color, "0.5 0.5 0.5", between(-1000, 1000),
         "reflected share of the light; outside 0 … 1 there is a warning"}},
       {}},
      {"bsdf", "mirror", "Perfect reflection on the side of the normal; black from behind.", {}, {}},
      {"bsdf",
       "dielectric",
       "A smooth boundary between two clear media; the normal points to the exterior.",
       {{"intIOR", real, "1.5046", between(1e-3, 1000), "index of refraction inside"},
        {"extIOR", real, "1.000277", between(1e-3, 1000), "index of refraction outside"}},
       {}},
      {"emitter",
       "area",
       "Makes its mesh a light that shines on the side of the geometric normal.",
       {{"radiance", color, nullptr, between(0, kMaxRadiance), "emitted radiance, the same in all directions"}},
       {}},
      {"test",
       "ttest",
       "Do mean values agree with references? Run by `etendue ttest`. With scenes: one reference for each. With bsdfs: "
       "one for each bsdf and angle.",
       {{"references", number_list, nullptr, any(), "expected mean luminance, in the order of the children"},
        {"angles", number_list, "", between(0, 180),
         "angles of incidence in degrees from the normal, beyond 90 from behind, but not 90; with bsdfs only"},
        {"significanceLevel", real, "0.01", inside(0, 1), "probability of a false alarm of the whole test"},
        {"sampleCount", integer, "100000", between(2, 1e12), "samples per scene, or per bsdf and angle"}},
       {{"scene", 0, kAnyNumber}, {"bsdf", 0, kAnyNumber}}},
      {"test",
       "chi2test",
       "Does sampling follow its density? Run by `etendue chi2`.",
       {{"significanceLevel", real, "0.01", inside(0, 1), "probability of a false alarm of the whole test"},
        {"resolution", integer, "10", between(2, 1000), "cells in the cosine of the polar angle; twice as many around"},
        {"minExpFrequency", real, "5", between(1, 1e6), "cells that expect fewer samples are pooled"},
        {"sampleCount", integer, "0", between(0, 1e12), "samples per test; 0 is 5000 for each cell"},
        {"testCount", integer, "5", between(1, 1e6), "directions of incidence for each bsdf"}},
       {{"bsdf", 1, kAnyNumber}}},
  };
}

std::vector<Plugin> make_plugins() {
  std::vector<Plugin> rows = scene_plugins();
  for (Plugin& row : view_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : object_plugins()) rows.push_back(std::move(row));
  return rows;
}

struct UnsupportedTypes {
  std::string_view tag;
  std::vector<std::string_view> types;
};

const std::vector<UnsupportedTypes>& unsupported_types() {
  static const std::vector<UnsupportedTypes> kTypes = {
      {"integrator",
       {"av", "ao", "simple", "whitted", "direct", "direct_ems", "direct_mats", "direct_mis", "photonmapper", "volpath",
        "path_vol", "vol_path_mats", "vol_path_mis", "bdpt"}},
      {"camera", {"thinlens", "orthographic", "environment", "fisheye"}},
      {"sampler", {"stratified", "halton", "ldsampler", "multijitter"}},
      {"rfilter", {"lanczos", "catmullrom"}},
      {"mesh", {"ply", "serialized", "instance", "cube", "rectangle", "disk", "cylinder", "heightfield"}},
      {"bsdf",
       {"microfacet", "roughconductor", "roughdielectric", "conductor", "plastic", "roughplastic", "phong", "disney",
        "principled", "twosided", "normalmap", "bumpmap", "blend", "mask", "null", "thindielectric"}},
      {"emitter", {"point", "spot", "directional", "distant", "constant", "envmap", "environment"}},
  };
  return kTypes;
}

std::string number(double value) {
  return fmt::format("{}", value);
}

}  // namespace

const char* tag_of(ParameterType type) {
  switch (type) {
    case boolean:
      return "boolean";
    case integer:
      return "integer";
    case real:
      return "float";
    case string:
    case number_list:
      return "string";
    case point:
      return "point";
    case vector:
      return "vector";
    case color:
      return "color";
    case transform:
      return "transform";
  }
  return "";
}

bool Range::contains(double value) const {
  return (min_excluded ? value > min : value >= min) && (max_excluded ? value < max : value <= max);
}

std::string Range::describe() const {
  const bool has_min = std::isfinite(min), has_max = std::isfinite(max);
  if (has_min && has_max && !min_excluded && !max_excluded) return number(min) + " … " + number(max);
  std::string text;
  if (has_min) text += (min_excluded ? "> " : "≥ ") + number(min);
  if (has_min && has_max) text += ", ";
  if (has_max) text += (max_excluded ? "< " : "≤ ") + number(max);
  return text;
}

const Parameter* Plugin::find(std::string_view parameter) const {
  const auto found =
      std::find_if(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.name == parameter; });
  return found == parameters.end() ? nullptr : &*found;
}

const ChildRule* Plugin::find_child(std::string_view child_tag) const {
  const auto found =
      std::find_if(children.begin(), children.end(), [&](const ChildRule& rule) { return rule.tag == child_tag; });
  return found == children.end() ? nullptr : &*found;
}

std::vector<std::string> Plugin::parameter_names() const {
  std::vector<std::string> names;
  for (const Parameter& parameter : parameters) names.emplace_back(parameter.name);
  return names;
}

const std::vector<Plugin>& plugins() {
  static const std::vector<Plugin> kPlugins = make_plugins();
  return kPlugins;
}

const Plugin* find_plugin(std::string_view tag, std::string_view type) {
  for (const Plugin& plugin : plugins()) {
    if (plugin.tag == tag && plugin.type == type) return &plugin;
  }
  return nullptr;
}

std::vector<std::string> plugin_types(std::string_view tag) {
  std::vector<std::string> types;
  for (const Plugin& plugin : plugins()) {
    if (plugin.tag == tag) types.emplace_back(plugin.type);
  }
  return types;
}

bool is_known_but_unsupported(std::string_view tag, std::string_view type) {
  for (const UnsupportedTypes& row : unsupported_types()) {
    if (row.tag == tag) return std::find(row.types.begin(), row.types.end(), type) != row.types.end();
  }
  return false;
}

const std::vector<std::string>& object_tags() {
  static const std::vector<std::string> kTags = [] {
    std::vector<std::string> tags;
    for (const Plugin& plugin : plugins()) {
      if (std::find(tags.begin(), tags.end(), plugin.tag) == tags.end()) tags.emplace_back(plugin.tag);
    }
    return tags;
  }();
  return kTags;
}

bool is_unsupported_tag(std::string_view tag) {
  return tag == "medium" || tag == "phase" || tag == "texture";
}

std::string parents_of(std::string_view tag) {
  std::vector<std::string> parents;
  for (const Plugin& plugin : plugins()) {
    const std::string name = fmt::format("<{}>", plugin.tag);
    const bool listed = std::find(parents.begin(), parents.end(), name) != parents.end();
    if (plugin.find_child(tag) != nullptr && !listed) parents.push_back(name);
  }
  return fmt::format("{}", fmt::join(parents, " or "));
}

const std::vector<std::string>& property_tags() {
  static const std::vector<std::string> kTags = {"boolean", "integer", "float", "string",
                                                 "point",   "vector",  "color", "transform"};
  return kTags;
}

std::vector<ListedNumber> parse_numbers(std::string_view text) {
  const auto is_separator = [](char c) { return c == ',' || text::is_blank(c); };
  std::vector<ListedNumber> numbers;
  for (std::size_t i = 0; i < text.size();) {
    if (is_separator(text[i])) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    while (i < text.size() && !is_separator(text[i])) ++i;
    const std::string_view token = text.substr(begin, i - begin);
    double value = 0;
    const text::NumberError error = text::parse_double(token, value);
    if (error != text::NumberError::none) throw ValueError{begin, text::describe(error, token, "a number")};
    numbers.push_back({value, begin});
  }
  return numbers;
}

glm::dvec3 parse_triple(std::string_view text, const Range& range) {
  const std::vector<ListedNumber> numbers = parse_numbers(text);
  if (numbers.size() != 3) throw ValueError{0, fmt::format("expected 3 numbers, found {}", numbers.size())};
  for (const ListedNumber& n : numbers) {
    if (!range.contains(n.value))
      throw ValueError{n.offset, fmt::format("{} is out of range; allowed is {}", n.value, range.describe())};
  }
  return {numbers[0].value, numbers[1].value, numbers[2].value};
}

namespace {

template <typename T>
T parse_scalar(std::string_view text, const Range& range, text::NumberError (*parse)(std::string_view, T&),
               const char* kind) {
  const std::string_view token = text::trim(text);
  const std::size_t offset = token.empty() ? 0 : static_cast<std::size_t>(token.data() - text.data());
  T value{};
  const text::NumberError error = parse(token, value);
  if (error != text::NumberError::none) throw ValueError{offset, text::describe(error, token, kind)};
  if (!range.contains(static_cast<double>(value))) {
    throw ValueError{offset, fmt::format("{} is out of range; allowed is {}", token, range.describe())};
  }
  return value;
}

bool parse_boolean(std::string_view text) {
  const std::string_view token = text::trim(text);
  if (text::equal_ignoring_case(token, "true")) return true;
  if (text::equal_ignoring_case(token, "false")) return false;
  throw ValueError{0, fmt::format("{} is not a boolean; write true or false", text::quoted(token))};
}

std::vector<double> parse_list(std::string_view text, const Range& range) {
  std::vector<double> values;
  for (const ListedNumber& n : parse_numbers(text)) {
    if (!range.contains(n.value))
      throw ValueError{n.offset, fmt::format("{} is out of range; allowed is {}", n.value, range.describe())};
    values.push_back(n.value);
  }
  return values;
}

}  // namespace

Value parse_value(const Parameter& parameter, std::string_view text) {
  switch (parameter.type) {
    case boolean:
      return parse_boolean(text);
    case integer:
      return parse_scalar<std::int64_t>(text, parameter.range, text::parse_whole_number, "an integer");
    case real:
      return parse_scalar<double>(text, parameter.range, text::parse_double, "a number");
    case string:
      return std::string(text);
    case number_list:
      return parse_list(text, parameter.range);
    case point:
    case vector:
    case color:
      return parse_triple(text, parameter.range);
    case transform:
      break;
  }
  throw ValueError{0, "a transform has no value; it holds operations"};
}

std::string parameter_tables() {
  std::string out;
  for (const Plugin& plugin : plugins()) {
    const std::string heading = *plugin.type == '\0' ? fmt::format("<{}>", plugin.tag)
                                                     : fmt::format("<{} type=\"{}\">", plugin.tag, plugin.type);
    out += fmt::format("### `{}`\n\n{}\n\n", heading, plugin.doc);
    if (!plugin.parameters.empty()) {
      out += "| property | type | default | allowed | meaning |\n|---|---|---|---|---|\n";
      for (const Parameter& p : plugin.parameters) {
        const std::string default_text = p.default_text == nullptr ? "required"
                                         : *p.default_text == '\0' ? "none"
                                                                   : fmt::format("`{}`", p.default_text);
        out += fmt::format("| `{}` | {} | {} | {} | {} |\n", p.name, tag_of(p.type), default_text, p.range.describe(),
                           p.doc);
      }
      out += '\n';
    }
    if (!plugin.children.empty()) {
      std::vector<std::string> rules;
      for (const ChildRule& rule : plugin.children) {
        const char* count = rule.min == 1   ? (rule.max == 1 ? "exactly one" : "one or more")
                            : rule.max == 1 ? "at most one"
                                            : "any number of";
        rules.push_back(fmt::format("{} `<{}>`", count, rule.tag));
      }
      out += fmt::format("Children: {}.\n\n", text::join(rules));
    }
  }
  return out;
}

}  // namespace etendue
