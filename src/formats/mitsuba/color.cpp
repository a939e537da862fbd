/// Reading of colours: <rgb>, <srgb>, <spectrum> and plain numbers.

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "core/text.h"
#include "formats/mitsuba/mitsuba_object.h"

namespace etendue {
namespace {

/// Error offsets are those of the document from here on.
template <typename Read>
auto at_attribute(const XmlAttribute& attribute, Read read) {
  try {
    return read();
  } catch (const ValueError& error) {
    throw ValueError{attribute.value_offset + (attribute.verbatim ? error.offset : 0), error.message};
  }
}

glm::dvec3 read_hex(std::string_view text) {
  std::uint32_t code = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + 1, end, code, 16);
  if (text.size() != 7 || error != std::errc() || stop != end)
    throw ValueError{0, fmt::format("{} is no colour; write #rrggbb or three numbers", text::quoted(text))};
  const auto component = [&](int shift) { return linear_of_srgb(((code >> shift) & 0xff) / 255.0); };
  return {component(16), component(8), component(0)};
}

/// One or three numbers.
glm::dvec3 read_components(std::string_view text) {
  const std::vector<ListedNumber> numbers = parse_numbers(text);
  if (numbers.size() == 1) return glm::dvec3(numbers[0].value);
  if (numbers.size() == 3) return {numbers[0].value, numbers[1].value, numbers[2].value};
  throw ValueError{0, fmt::format("expected 1 or 3 numbers, found {}", numbers.size())};
}

/// "400:0.3, 500:0.4".
std::vector<SpectrumPoint> read_points(std::string_view text) {
  std::string numbers(text);
  std::ranges::replace(numbers, ':', ' ');
  const std::vector<ListedNumber> listed = parse_numbers(numbers);
  const auto colons = static_cast<std::size_t>(std::ranges::count(text, ':'));
  if (listed.size() != 2 * colons || colons < 2)
    throw ValueError{0, fmt::format("expected at least two pairs such as 400:0.5, found {} numbers and {} colons",
                                    listed.size(), colons)};
  std::vector<SpectrumPoint> points;
  for (std::size_t i = 0; i < listed.size(); i += 2) {
    if (!points.empty() && listed[i].value <= points.back().wavelength)
      throw ValueError{listed[i].offset, fmt::format("the wavelength {} does not come after {}", listed[i].value,
                                                     points.back().wavelength)};
    points.push_back({listed[i].value, listed[i + 1].value});
  }
  return points;
}

const XmlAttribute& required(const XmlElement& element, const char* name) {
  if (const XmlAttribute* attribute = element.find(name)) return *attribute;
  throw ValueError{element.offset, fmt::format("<{}> lacks its attribute \"{}\"", element.name, name)};
}

glm::dvec3 read_spectrum(const XmlElement& element, SpectrumUse use, const MitsubaContext& context) {
  if (const XmlAttribute* type = element.find("type")) {
    context.missing.add(fmt::format("spectrum {}", type->value), context.document.position(element), "white");
    return glm::dvec3(1.0);
  }
  if (const XmlAttribute* file = element.find("filename")) {
    context.missing.add(fmt::format("spectrum in a file, {}", file->value), context.document.position(element),
                        "white");
    return glm::dvec3(1.0);
  }
  const XmlAttribute& value = required(element, "value");
  return at_attribute(value, [&] {
    if (value.value.find(':') != std::string::npos) return to_rec709(read_points(value.value), use);
    return to_rec709(std::get<double>(parse_value(ParameterType::real, {}, value.value)), use);
  });
}

}  // namespace

glm::dvec3 read_color(const XmlElement& element, SpectrumUse use, const MitsubaContext& context) {
  if (element.name == "spectrum") return read_spectrum(element, use, context);
  if (element.name == "blackbody") {
    context.missing.add("blackbody", context.document.position(element), "white");
    return glm::dvec3(1.0);
  }
  const bool known = element.name == "rgb" || element.name == "srgb" || element.name == "color" ||
                     element.name == "float" || element.name == "integer";
  if (!known)
    throw ValueError{element.offset, fmt::format("<{}> is no colour; write <rgb> or <spectrum>", element.name)};
  const XmlAttribute& value = required(element, "value");
  return at_attribute(value, [&] {
    const std::string_view text = text::trim(value.value);
    if (text.starts_with('#')) return read_hex(text);
    const glm::dvec3 components = read_components(value.value);
    if (element.name != "srgb") return components;
    return glm::dvec3(linear_of_srgb(components.x), linear_of_srgb(components.y), linear_of_srgb(components.z));
  });
}

}  // namespace etendue
