/// Reading of <transform>: the operations of the scene format in double precision.

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "core/text.h"
#include "formats/dialect/object.h"
#include "image/vectors.h"

namespace etendue {
namespace {

/// A matrix counts as singular if the volume spanned by its unit columns is below this, where single precision breaks
/// down.
constexpr double kMinUnitVolume = 1e-9;

/// Volume spanned by the columns' directions, in [0,1]: independent of scale, so that tiny and huge scenes are fine.
double unit_volume(const glm::dmat4& m) {
  const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
  // Divided by the largest component first, or the squared length of a column of 1e-200 would vanish.
  const auto unit = [](const glm::dvec3& v) {
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return largest > 0.0 ? glm::normalize(v / largest) : glm::dvec3(0.0);
  };
  return std::abs(glm::dot(unit(x), glm::cross(unit(y), unit(z))));
}

glm::dvec3 read_triple(const XmlElement& element, const char* name) {
  const XmlAttribute& attribute = *element.find(name);
  try {
    return parse_triple(attribute.value);
  } catch (const ValueError& error) {
    throw ValueError{attribute.value_offset + (attribute.verbatim ? error.offset : 0),
                     fmt::format("\"{}\" of <{}>: {}", name, element.name, error.message)};
  }
}

glm::dmat4 read_rotate(const XmlElement& element) {
  const glm::dvec3 axis = read_triple(element, "axis");
  const XmlAttribute& attribute = *element.find("angle");
  double degrees = 0;
  const std::string_view token = text::trim(attribute.value);
  const text::NumberError error = text::parse_double(token, degrees);
  if (error != text::NumberError::none) {
    throw ValueError{attribute.value_offset,
                     fmt::format("\"angle\" of <rotate>: {}", text::describe(error, token, "a number"))};
  }
  const double turn = std::fmod(degrees, 360.0);
  if (turn == 0.0) return glm::dmat4(1.0);  // about any axis, even the zero vector, which some exporters write then
  const double largest = std::max({std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)});
  if (!(largest > 0.0))
    throw ValueError{element.find("axis")->value_offset,
                     "the axis of <rotate> has length 0; give a direction such as 0,1,0"};
  return glm::rotate(glm::dmat4(1.0), glm::radians(turn), glm::normalize(axis / largest));
}

glm::dmat4 read_matrix(const XmlElement& element) {
  const XmlAttribute& attribute = *element.find("value");
  std::vector<ListedNumber> numbers;
  try {
    numbers = parse_numbers(attribute.value);
  } catch (const ValueError& error) {
    throw ValueError{attribute.value_offset + (attribute.verbatim ? error.offset : 0),
                     "\"value\" of <matrix>: " + error.message};
  }
  if (numbers.size() != 16) {
    throw ValueError{attribute.value_offset,
                     fmt::format("<matrix> needs 16 numbers, row by row, found {}", numbers.size())};
  }
  glm::dmat4 m(1.0);
  for (int i = 0; i < 16; ++i) m[i % 4][i / 4] = numbers[static_cast<std::size_t>(i)].value;
  const bool affine = m[0][3] == 0.0 && m[1][3] == 0.0 && m[2][3] == 0.0 && m[3][3] == 1.0;
  if (!affine) {
    const std::size_t offset = attribute.verbatim ? numbers[12].offset : 0;
    throw ValueError{attribute.value_offset + offset,
                     fmt::format("the last row of <matrix> is {} {} {} {}; an affine matrix has 0 0 0 1", m[0][3],
                                 m[1][3], m[2][3], m[3][3])};
  }
  return m;
}

/// The axis most perpendicular to `dir`; among equals, the first of y, z, x.
glm::dvec3 other_up(const glm::dvec3& dir) {
  const glm::dvec3 along = glm::abs(dir);
  if (along.y <= along.z && along.y <= along.x) return {0.0, 1.0, 0.0};
  return along.z <= along.x ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
}

/// A vector along `v` whose length can be measured: scaled where squares would leave the range of a double; nothing for
/// (0, 0, 0).
std::optional<glm::dvec3> measurable(const glm::dvec3& v) {
  constexpr double kSafe = 1e100;
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0.0)) return std::nullopt;
  return largest > kSafe || largest < 1.0 / kSafe ? v / largest : v;
}

glm::dmat4 read_lookat(const XmlElement& element, ReadContext& context) {
  const glm::dvec3 origin = read_triple(element, "origin");
  const glm::dvec3 target = read_triple(element, "target");
  const glm::dvec3 up = read_triple(element, "up");
  const std::optional<glm::dvec3> toward = measurable(target - origin);
  if (!toward) {
    throw ValueError{element.find("target")->value_offset, "<lookat> has its target at its origin; move one of them"};
  }
  const glm::dvec3 dir = glm::normalize(*toward);
  const std::optional<glm::dvec3> upward = measurable(up);
  const std::size_t up_offset = element.find("up")->value_offset;
  if (!upward) throw ValueError{up_offset, "\"up\" of <lookat> has length 0; give a direction such as 0,1,0"};
  glm::dvec3 side = glm::cross(*upward / glm::length(*upward), dir);
  if (!(glm::length(side) > kMinUnitVolume)) {
    const glm::dvec3 other = other_up(dir);
    side = glm::cross(other, dir);
    context.diagnostics.warning(
        context.document.position(up_offset),
        fmt::format("\"up\" of <lookat> is parallel to the direction of view; {} {} {} is taken instead, write it to "
                    "keep this picture",
                    other.x, other.y, other.z));
  }
  const glm::dvec3 left = glm::normalize(side);
  const glm::dvec3 new_up = glm::cross(dir, left);
  return {glm::dvec4(left, 0.0), glm::dvec4(new_up, 0.0), glm::dvec4(dir, 0.0), glm::dvec4(origin, 1.0)};
}

glm::dmat4 read_operation(const XmlElement& element, ReadContext& context) {
  if (element.name == "translate") return glm::translate(glm::dmat4(1.0), read_triple(element, "value"));
  if (element.name == "scale") return glm::scale(glm::dmat4(1.0), read_triple(element, "value"));
  if (element.name == "rotate") return read_rotate(element);
  if (element.name == "matrix") return read_matrix(element);
  return read_lookat(element, context);
}

struct Operation {
  std::string name;
  std::vector<std::string> attributes;
};

const std::vector<Operation>& operations() {
  static const std::vector<Operation> kOperations = {{"translate", {"value"}},
                                                     {"scale", {"value"}},
                                                     {"rotate", {"angle", "axis"}},
                                                     {"matrix", {"value"}},
                                                     {"lookat", {"origin", "target", "up"}}};
  return kOperations;
}

/// The operation's row, or nullptr after a report.
const Operation* find_operation(const XmlElement& element, ReadContext& context) {
  std::vector<std::string> names;
  for (const Operation& operation : operations()) {
    if (operation.name == element.name) return &operation;
    names.push_back(operation.name);
  }
  context.diagnostics.error(context.document.position(element.offset),
                            fmt::format("<transform> has no operation {}{}; known are: {}", text::quoted(element.name),
                                        text::did_you_mean(element.name, names), text::join(names)));
  return nullptr;
}

}  // namespace

glm::dmat4 read_transform(const XmlElement& element, ReadContext& context) {
  glm::dmat4 product(1.0);
  for (const XmlElement& child : element.children) {
    if (!context.diagnostics.wants_errors()) break;
    const Operation* operation = find_operation(child, context);
    if (operation == nullptr) continue;
    if (!child.children.empty()) {
      context.diagnostics.error(context.document.position(child.children.front().offset),
                                fmt::format("<{}> cannot hold elements; close it with />", child.name));
    }
    if (!check_attributes(child, operation->attributes, context)) continue;
    try {
      const glm::dmat4 m = read_operation(child, context);
      if (!is_finite(m) || unit_volume(m) < kMinUnitVolume) {
        throw ValueError{
            child.offset,
            fmt::format("<{}> is singular: it flattens space; give a matrix that can be inverted", child.name)};
      }
      product = m * product;
    } catch (const ValueError& error) {
      context.diagnostics.error(context.document.position(error.offset), error.message);
    }
  }
  const bool usable = is_finite(product) && is_finite(glm::inverse(product)) && unit_volume(product) >= kMinUnitVolume;
  if (usable) return product;
  context.diagnostics.error(context.document.position(element.offset),
                            "the product of this <transform> is singular or overflows; check its scales");
  return glm::dmat4(1.0);
}

}  // namespace etendue
