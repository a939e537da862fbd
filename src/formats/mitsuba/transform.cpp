/// Reads <transform> in Mitsuba's dialect, whose operations have their numbers in one attribute or in one for each
/// axis.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "core/text.h"
#include "formats/mitsuba/mitsuba_object.h"
#include "image/vectors.h"

namespace etendue {
namespace {

/// Calls `read` and turns offsets of its errors into offsets in the document.
template <typename Read>
auto at_attribute(const XmlElement& element, const XmlAttribute& attribute, Read read) {
  try {
    return read();
  } catch (const ValueError& error) {
    throw ValueError{attribute.value_offset + (attribute.verbatim ? error.offset : 0),
                     fmt::format("\"{}\" of <{}>: {}", attribute.name, element.name, error.message)};
  }
}

double read_real(const XmlElement& element, const XmlAttribute& attribute) {
  return at_attribute(element, attribute,
                      [&] { return std::get<double>(parse_value(ParameterType::real, {}, attribute.value)); });
}

/// `value` with three numbers or one for all axes, or x, y and z, each of which is `missing` by default.
glm::dvec3 read_axes(const XmlElement& element, double missing) {
  if (const XmlAttribute* value = element.find("value")) {
    return at_attribute(element, *value, [&] {
      const std::vector<ListedNumber> numbers = parse_numbers(value->value);
      if (numbers.size() == 1) return glm::dvec3(numbers[0].value);
      return parse_triple(value->value);
    });
  }
  glm::dvec3 axes(missing);
  const char* names[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    if (const XmlAttribute* attribute = element.find(names[i])) axes[i] = read_real(element, *attribute);
  }
  return axes;
}

/// Rodrigues' formula, which turns about an axis of length 1.
glm::dmat4 rodrigues(const glm::dvec3& axis, double radians) {
  const double s = std::sin(radians), c = std::cos(radians);
  glm::dmat3 m = c * glm::dmat3(1.0) + (1.0 - c) * glm::outerProduct(axis, axis);
  m += s *
       glm::dmat3(glm::dvec3(0.0, axis.z, -axis.y), glm::dvec3(-axis.z, 0.0, axis.x), glm::dvec3(axis.y, -axis.x, 0.0));
  return glm::dmat4(m);
}

bool is_unit(const glm::dvec3& axis) {
  constexpr double kMisprint = 1e-3;  // axes have few digits
  return std::abs(glm::length(axis) - 1.0) <= kMisprint;
}

glm::dmat4 read_rotate(const XmlElement& element, RotationAxes axes) {
  const double turn = std::fmod(read_real(element, required(element, "angle")), 360.0);
  const glm::dvec3 axis = read_axes(element, 0.0);
  if (turn == 0.0) return glm::dmat4(1.0);
  const double largest = std::max({std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)});
  if (!(largest > 0.0))
    throw ValueError{element.offset, "the axis of <rotate> has length 0; give x, y or z, such as y=\"1\""};
  return rodrigues(axes == RotationAxes::as_given ? axis : glm::normalize(axis / largest), glm::radians(turn));
}

/// Mitsuba 2 and 3 take an axis as it is given: where its length is not 1, the result is no rotation.
void warn_of_axis(const XmlElement& element, RotationAxes axes, const MitsubaContext& context) {
  const glm::dvec3 axis = read_axes(element, 0.0);
  if (is_unit(axis)) return;
  const char* here = axes == RotationAxes::as_given ? "so that this is no rotation, here either"
                                                    : "so that this is no rotation there; here it is one";
  context.sink.warning(context.document.position(element),
                       fmt::format("the axis of <rotate> has length {:.4g}, and Mitsuba does not normalize it, {}; "
                                   "divide x, y and z by {:.4g}",
                                   glm::length(axis), here, glm::length(axis)));
}

/// 16 numbers row by row, or the nine of the upper left part.
glm::dmat4 read_matrix(const XmlElement& element) {
  const XmlAttribute& value = required(element, "value");
  const std::vector<ListedNumber> numbers = at_attribute(element, value, [&] { return parse_numbers(value.value); });
  const int side = numbers.size() == 16 ? 4 : 3;
  if (numbers.size() != 16 && numbers.size() != 9)
    throw ValueError{value.value_offset,
                     fmt::format("<matrix> needs 16 or 9 numbers, row by row, found {}", numbers.size())};
  glm::dmat4 m(1.0);
  for (int i = 0; i < side * side; ++i) m[i % side][i / side] = numbers[static_cast<std::size_t>(i)].value;
  if (m[0][3] != 0.0 || m[1][3] != 0.0 || m[2][3] != 0.0 || m[3][3] != 1.0)
    throw ValueError{value.value_offset, "the last row of <matrix> is not 0 0 0 1; only affine matrices are supported"};
  return m;
}

/// Mitsuba's default for `up`, a direction perpendicular to `dir`; 0.6 has a different one than later versions.
glm::dvec3 default_up(const glm::dvec3& dir, bool old) {
  if (old) {
    const bool by_x = std::abs(dir.x) > std::abs(dir.y);
    const glm::dvec3 c = by_x ? glm::dvec3(dir.z, 0.0, -dir.x) : glm::dvec3(0.0, dir.z, -dir.y);
    return glm::cross(glm::normalize(c), dir);
  }
  const double sign = std::signbit(dir.z) ? -1.0 : 1.0, a = -1.0 / (sign + dir.z);  // [Duff2017]
  return {1.0 + sign * dir.x * dir.x * a, sign * dir.x * dir.y * a, -sign * dir.x};
}

glm::dmat4 read_lookat(const XmlElement& element, bool old) {
  const auto triple = [&](const char* name) {
    const XmlAttribute& attribute = required(element, name);
    return at_attribute(element, attribute, [&] { return parse_triple(attribute.value); });
  };
  const glm::dvec3 origin = triple("origin"), target = triple("target");
  if (!(glm::length(target - origin) > 0.0))
    throw ValueError{element.offset, "<lookat> has its target at its origin; move one of them"};
  const glm::dvec3 dir = glm::normalize(target - origin);
  const glm::dvec3 up = element.find("up") == nullptr ? default_up(dir, old) : triple("up");
  const glm::dvec3 side = glm::cross(up, dir);
  if (!(glm::length(side) > 1e-9 * glm::length(up)))
    throw ValueError{element.offset, "\"up\" of <lookat> is 0 or parallel to the direction of view; give another one"};
  const glm::dvec3 left = glm::normalize(side);
  return {glm::dvec4(left, 0.0), glm::dvec4(glm::cross(dir, left), 0.0), glm::dvec4(dir, 0.0), glm::dvec4(origin, 1.0)};
}

glm::dmat4 read_operation(const XmlElement& element, bool old, RotationAxes axes) {
  if (element.name == "translate") return glm::translate(glm::dmat4(1.0), read_axes(element, 0.0));
  if (element.name == "scale") return glm::scale(glm::dmat4(1.0), read_axes(element, 1.0));
  if (element.name == "rotate") return read_rotate(element, axes);
  if (element.name == "matrix") return read_matrix(element);
  if (element.name == "lookat" || element.name == "lookAt" || element.name == "look_at")
    return read_lookat(element, old);
  const std::vector<std::string> known = {"translate", "scale", "rotate", "matrix", "lookat"};
  throw ValueError{element.offset,
                   fmt::format("<transform> has no operation {}{}; known are: {}", text::quoted(element.name),
                               text::did_you_mean(element.name, known), text::join(known))};
}

}  // namespace

glm::dmat4 read_mitsuba_transform(const XmlElement& element, const MitsubaContext& context, RotationAxes axes) {
  glm::dmat4 product(1.0);
  const bool old = context.document.version().starts_with("0.");
  const RotationAxes used = old ? RotationAxes::unit : axes;
  for (const XmlElement& child : element.children) {
    if (!context.sink.wants_errors()) break;
    try {
      product = read_operation(child, old, used) * product;
      if (child.name == "rotate" && !old) warn_of_axis(child, axes, context);
    } catch (const ValueError& error) {
      context.sink.error(context.document.position(error.offset), error.message);
    }
  }
  if (is_finite(product)) return product + glm::dmat4(0.0);  // no negative zeros, which files would not preserve
  context.sink.error(context.document.position(element), "the product of this <transform> overflows; check its scales");
  return glm::dmat4(1.0);
}

glm::dmat3 read_mitsuba_uv_transform(const XmlElement& element, const MitsubaContext& context) {
  const glm::dmat4 m = read_mitsuba_transform(element, context);
  return {glm::dvec3(m[0][0], m[0][1], 0.0), glm::dvec3(m[1][0], m[1][1], 0.0), glm::dvec3(m[3][0], m[3][1], 1.0)};
}

}  // namespace etendue
