#pragma once
/// The one table of everything a scene file can say: a row per tag and type, with its parameters, their defaults,
/// ranges and meaning. The reader validates by it, takes the defaults from it, and docs/scene_format.md prints it.

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "scene/limits.h"

namespace etendue {

enum class ParameterType { boolean, integer, real, string, number_list, point, vector, color, transform };

/// Tag of the property element: "float" for a real, "string" for a list of numbers.
const char* tag_of(ParameterType type);

/// Allowed values; applies to every number of a list, point or color.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_excluded = false;
  bool max_excluded = false;

  bool contains(double value) const;
  /// "1 … 65536", "> 0", "> 0, < 180", or "" without bounds.
  std::string describe() const;
};

struct Parameter {
  const char* name;
  ParameterType type;
  const char* default_text;  ///< as written in a file; nullptr: required
  Range range;
  const char* doc;
};

/// How many children of a tag an object takes.
struct ChildRule {
  const char* tag;
  std::size_t min;
  std::size_t max;
};

struct Plugin {
  const char* tag;
  const char* type;  ///< "" for <scene>
  const char* doc;
  std::vector<Parameter> parameters;
  std::vector<ChildRule> children;

  const Parameter* find(std::string_view parameter) const;
  const ChildRule* find_child(std::string_view child_tag) const;
  std::vector<std::string> parameter_names() const;
};

inline constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

const std::vector<Plugin>& plugins();
/// The row of a tag and type, or nullptr.
const Plugin* find_plugin(std::string_view tag, std::string_view type);
/// Types of a tag that can be used, in table order; empty for a tag that is no object.
std::vector<std::string> plugin_types(std::string_view tag);
/// True for types that other renderers of the dialect know and this one does not.
bool is_known_but_unsupported(std::string_view tag, std::string_view type);
/// Object tags of the table ("scene", "mesh", …).
const std::vector<std::string>& object_tags();
/// Object tags of the dialect without a usable type ("medium", …).
bool is_unsupported_tag(std::string_view tag);
/// The tags that may contain `tag`: "<mesh>" or "<scene>, <test>".
std::string parents_of(std::string_view tag);
/// Property tags ("float", …).
const std::vector<std::string>& property_tags();

using Value = std::variant<bool, std::int64_t, double, std::string, std::vector<double>, glm::dvec3>;

/// A value that cannot be read: where in its text, and why.
struct ValueError {
  std::size_t offset;
  std::string message;
};

/// Reads a value of any type but transform and holds it against the range. Throws ValueError.
Value parse_value(const Parameter& parameter, std::string_view text);
/// Numbers separated by any run of commas and blanks; each with its offset. Throws ValueError.
struct ListedNumber {
  double value;
  std::size_t offset;
};
std::vector<ListedNumber> parse_numbers(std::string_view text);
/// Exactly three numbers. Throws ValueError.
glm::dvec3 parse_triple(std::string_view text, const Range& range = {});

/// The parameter tables as Markdown, for docs/scene_format.md.
std::string parameter_tables();

}  // namespace etendue
