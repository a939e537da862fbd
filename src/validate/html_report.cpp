#include "validate/html_report.h"

#include <bit>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/version.h"
#include "report_assets.h"

namespace etendue {
namespace {

// The browser reads the values as little-endian float32.
static_assert(std::endian::native == std::endian::little, "float values are embedded as they lie in memory");
static_assert(sizeof(glm::vec3) == 12);

std::string encode(const std::vector<glm::vec3>& values) {
  return base64(values.data(), values.size() * sizeof(glm::vec3));
}

std::string escape_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// Replaces each @NAME@ of the page by its value, in one pass: values are never searched.
std::string fill_page(const std::vector<std::pair<std::string_view, std::string>>& values) {
  std::string out;
  std::string_view rest = assets::report_html;
  while (!rest.empty()) {
    std::size_t first = std::string_view::npos;
    const std::pair<std::string_view, std::string>* found = nullptr;
    for (const auto& value : values) {
      const std::size_t at = rest.find(value.first);
      if (at < first) {
        first = at;
        found = &value;
      }
    }
    out += rest.substr(0, first);
    if (!found) break;
    out += found->second;
    rest.remove_prefix(first + found->first.size());
  }
  return out;
}

std::string page(const Json& data, const std::string& title, const Image& test, const Image& reference,
                 const std::vector<glm::vec3>& scores) {
  return fill_page({{"@TITLE@", escape_html(title)},
                    {"@CSS@", std::string(assets::report_css)},
                    {"@JS@", std::string(assets::report_js)},
                    {"@DATA@", script_json(data)},
                    {"@PIXELS_A@", encode(test.pixels)},
                    {"@PIXELS_B@", encode(reference.pixels)},
                    {"@SCORES@", encode(scores)}});
}

/// "folder/cbox.exr" → "cbox.exr": what fits on a button.
std::string short_name(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

}  // namespace

std::string base64(const void* bytes, std::size_t size) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto* in = static_cast<const std::uint8_t*>(bytes);
  std::string out;
  out.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const std::size_t left = size - i;
    const std::uint32_t word = static_cast<std::uint32_t>(in[i]) << 16 |
                               (left > 1 ? static_cast<std::uint32_t>(in[i + 1]) << 8 : 0u) |
                               (left > 2 ? static_cast<std::uint32_t>(in[i + 2]) : 0u);
    out += kDigits[word >> 18];
    out += kDigits[word >> 12 & 63];
    out += left > 1 ? kDigits[word >> 6 & 63] : '=';
    out += left > 2 ? kDigits[word & 63] : '=';
  }
  return out;
}

std::string script_json(const Json& json) {
  const std::string text = json.dump();
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "\\u003c";  // so that no value can close the script element
    } else {
      out += c;
    }
  }
  return out;
}

std::string comparison_html(const Comparison& c, const Image& test, const Image& reference) {
  const std::string title = fmt::format("{} against {}", short_name(c.test_name), short_name(c.reference_name));
  const Json data = {{"title", title},
                     {"subtitle", fmt::format("{} × {} pixels · etendue {} compare", c.width, c.height, version())},
                     {"width", c.width},
                     {"height", c.height},
                     {"labelA", short_name(c.test_name)},
                     {"labelB", short_name(c.reference_name)},
                     {"verdict", verdict_name(c.verdict)},
                     {"passed", c.passed()},
                     {"comparison", comparison_json(c)}};
  return page(data, title, test, reference, c.tests ? c.tests->z : std::vector<glm::vec3>{});
}

std::string validation_html(const Validation& v, const MetricOptions& metrics) {
  CompareOptions options;
  options.metrics = metrics;
  options.significance = v.tests.significance;
  const Comparison c = compare_images(v.device_image, v.device, v.reference_image, v.reference, options);
  const std::string title = fmt::format("{}: device against reference", short_name(v.scene));
  const Json data = {
      {"title", title},
      {"subtitle", fmt::format("{} ({}) against {} ({}) · {} samples per pixel, seeds {} and {} · etendue {} validate",
                               v.device, v.device_driver, v.reference, v.reference_driver, v.samples_per_pixel,
                               v.seed + 1, v.seed + 2, version())},
      {"width", v.device_image.width},
      {"height", v.device_image.height},
      {"labelA", "device"},
      {"labelB", "reference"},
      {"verdict", verdict_name(v.verdict)},
      {"passed", v.passed()},
      {"comparison", comparison_json(c)},
      {"validation", validation_json(v)}};
  return page(data, title, v.device_image, v.reference_image, v.tests.z);
}

}  // namespace etendue
