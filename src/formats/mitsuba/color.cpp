/// Reads colours: <rgb>, <srgb>, <spectrum> and plain numbers.

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/text.h"
#include "formats/mitsuba/mitsuba_object.h"
#include "formats/mitsuba/plugins.h"

namespace etendue {
namespace {

/// Calls `read` and turns offsets of its errors into offsets in the document.
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
    throw ValueError{0, fmt::format("{} is not a colour; write #rrggbb or three numbers", text::quoted(text))};
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

/// What a raw texture may have instead of a colour: three numbers, or x, y and z.
glm::dvec3 read_vector(const XmlElement& element) {
  if (const XmlAttribute* value = element.find("value"))
    return at_attribute(*value, [&] { return parse_triple(value->value); });
  glm::dvec3 vector(0.0);
  const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    if (const XmlAttribute* axis = element.find(axes[i]))
      vector[i] =
          at_attribute(*axis, [&] { return std::get<double>(parse_value(ParameterType::real, {}, axis->value)); });
  }
  return vector;
}

/// A property of <spectrum type="…">; nullptr if it is missing.
const XmlElement* property_of(const XmlElement& spectrum, std::initializer_list<std::string_view> names) {
  for (const XmlElement& child : spectrum.children) {
    const XmlAttribute* name = child.find("name");
    if (name != nullptr && std::ranges::find(names, snake_case(name->value)) != names.end()) return &child;
  }
  return nullptr;
}

double number_of(const XmlElement& spectrum, const char* name, double fallback) {
  const XmlElement* property = property_of(spectrum, {name});
  if (property == nullptr) return fallback;
  const XmlAttribute& value = required(*property, "value");
  return at_attribute(value, [&] { return std::get<double>(parse_value(ParameterType::real, {}, value.value)); });
}

std::vector<ListedNumber> numbers_of(const XmlElement& spectrum, const char* name) {
  const XmlElement* property = property_of(spectrum, {name});
  if (property == nullptr) throw ValueError{spectrum.offset, fmt::format("the spectrum lacks \"{}\"", name)};
  const XmlAttribute& value = required(*property, "value");
  return at_attribute(value, [&] { return parse_numbers(value.value); });
}

/// Pairs wavelengths, which must ascend, with values.
std::vector<SpectrumPoint> make_points(const std::vector<double>& wavelengths, const std::vector<double>& values,
                                       std::size_t offset) {
  if (wavelengths.size() != values.size() || values.size() < 2)
    throw ValueError{offset,
                     fmt::format("{} wavelengths and {} values; there must be equally many of both, and at least two",
                                 wavelengths.size(), values.size())};
  std::vector<SpectrumPoint> points;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0 && !(wavelengths[i] > wavelengths[i - 1]))
      throw ValueError{offset,
                       fmt::format("the wavelength {} does not come after {}", wavelengths[i], wavelengths[i - 1])};
    points.push_back({wavelengths[i], values[i]});
  }
  return points;
}

std::vector<double> plain(const std::vector<ListedNumber>& listed) {
  std::vector<double> values;
  for (const ListedNumber& number : listed) values.push_back(number.value);
  return values;
}

std::vector<SpectrumPoint> read_sampled(const XmlElement& element, bool evenly) {
  const std::vector<double> values = plain(numbers_of(element, "values"));
  std::vector<double> wavelengths;
  if (evenly) {
    const double first = number_of(element, "wavelength_min", 360.0),
                 last = number_of(element, "wavelength_max", 830.0);
    const double steps = std::max<double>(static_cast<double>(values.size()) - 1.0, 1.0);
    for (std::size_t i = 0; i < values.size(); ++i)
      wavelengths.push_back(std::lerp(first, last, static_cast<double>(i) / steps));
  } else {
    wavelengths = plain(numbers_of(element, "wavelengths"));
  }
  return make_points(wavelengths, values, element.offset);
}

/// The colour of a black body: its radiance in W·m⁻²·sr⁻¹·nm⁻¹ by Planck's law, with the constants of the SI.
glm::dvec3 blackbody(double kelvin, std::size_t offset, SpectrumUse use) {
  constexpr double kLeast = 100.0, kMost = 1e6;
  if (!(kelvin >= kLeast && kelvin <= kMost))
    throw ValueError{offset, fmt::format("a black body of {} kelvin; use {} to {}", kelvin, kLeast, kMost)};
  constexpr double kPlanck = 6.62607015e-34, kLight = 299792458.0, kBoltzmann = 1.380649e-23;
  std::vector<SpectrumPoint> points;
  for (int nanometres = 360; nanometres <= 830; ++nanometres) {
    const double wavelength = 1e-9 * nanometres;
    const double photons = std::expm1(kPlanck * kLight / (wavelength * kBoltzmann * kelvin));
    points.push_back({static_cast<double>(nanometres),
                      1e-9 * 2.0 * kPlanck * kLight * kLight / (std::pow(wavelength, 5.0) * photons)});
  }
  return to_rec709(points, use);
}

/// The form of 0.6: a temperature, optionally followed by a K, and a factor.
glm::dvec3 read_old_blackbody(const XmlElement& element, SpectrumUse use) {
  const auto number = [](const XmlAttribute& attribute) {
    return at_attribute(attribute, [&] {
      std::string_view text = text::trim(attribute.value);
      if (text.ends_with('K') || text.ends_with('k')) text.remove_suffix(1);
      return std::get<double>(parse_value(ParameterType::real, {}, text));
    });
  };
  const XmlAttribute* scale = element.find("scale");
  const double kelvin = number(required(element, "temperature"));
  return (scale == nullptr ? 1.0 : number(*scale)) * blackbody(kelvin, element.offset, use);
}

/// As in Mitsuba's RGB variants, in which D65 and uniform spectra are grey.
glm::dvec3 read_typed(const XmlElement& element, std::string_view type, SpectrumUse use,
                      const MitsubaContext& context) {
  if (type == "uniform" || type == "rawconstant") return glm::dvec3(number_of(element, "value", 1.0));
  if (type == "d65") return glm::dvec3(number_of(element, "scale", 1.0));
  if (type == "blackbody") return blackbody(number_of(element, "temperature", 5000.0), element.offset, use);
  if (type == "regular" || type == "irregular") return to_rec709(read_sampled(element, type == "regular"), use);
  const XmlElement* color = property_of(element, {"value", "color"});
  if ((type == "rgb" || type == "srgb") && color != nullptr && color->name != "spectrum")
    return read_color(*color, use, context);
  context.missing.add(fmt::format("spectrum {}", type), context.document.position(element), "white");
  return glm::dvec3(1.0);
}

/// Each line has a wavelength and its value; # begins a comment.
glm::dvec3 read_spectrum_file(const XmlAttribute& file, SpectrumUse use, const MitsubaContext& context) {
  const std::string path = context.document.resolve(file.value);
  std::string text;
  try {
    text = context.load_text(path);
  } catch (const Error& error) {
    throw ValueError{file.value_offset, fmt::format("spectrum {}", error.what())};
  }
  std::vector<double> wavelengths, values;
  std::size_t number = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = text::trim(rest.substr(0, std::min(end, rest.find('#'))));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++number;
    if (line.empty()) continue;
    std::vector<ListedNumber> pair;
    try {
      pair = parse_numbers(line);
    } catch (const ValueError& error) {
      throw ValueError{file.value_offset, fmt::format("{}:{}: {}", path, number, error.message)};
    }
    if (pair.size() != 2)
      throw ValueError{file.value_offset, fmt::format("{}:{}: expected a wavelength and a value, found {} numbers",
                                                      path, number, pair.size())};
    wavelengths.push_back(pair[0].value);
    values.push_back(pair[1].value);
  }
  return to_rec709(make_points(wavelengths, values, file.value_offset), use);
}

glm::dvec3 read_spectrum(const XmlElement& element, SpectrumUse use, const MitsubaContext& context) {
  if (const XmlAttribute* type = element.find("type")) return read_typed(element, type->value, use, context);
  if (const XmlAttribute* file = element.find("filename")) return read_spectrum_file(*file, use, context);
  const XmlAttribute& value = required(element, "value");
  return at_attribute(value, [&] {
    if (value.value.find(':') != std::string::npos) return to_rec709(read_points(value.value), use);
    // In 0.6 three numbers are linear RGB.
    if (const std::vector<ListedNumber> list = parse_numbers(value.value); list.size() == 3) {
      if (context.document.version().starts_with("0.")) return glm::dvec3(list[0].value, list[1].value, list[2].value);
      throw ValueError{list[1].offset,
                       "a spectrum is one number or a list like 400:0.1, 700:0.5; three numbers are an <rgb>"};
    }
    return to_rec709(std::get<double>(parse_value(ParameterType::real, {}, value.value)), use);
  });
}

}  // namespace

glm::dvec3 read_color(const XmlElement& element, SpectrumUse use, const MitsubaContext& context) {
  if (element.name == "spectrum") return read_spectrum(element, use, context);
  if (element.name == "blackbody") return read_old_blackbody(element, use);
  if (element.name == "vector") return read_vector(element);
  const bool known = element.name == "rgb" || element.name == "srgb" || element.name == "color" ||
                     element.name == "float" || element.name == "integer";
  if (!known)
    throw ValueError{element.offset, fmt::format("<{}> is not a colour; write <rgb> or <spectrum>", element.name)};
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
