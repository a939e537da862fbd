#include "validate/html_report.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/text.h"
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

std::string escape_html(const std::string& raw) {
  return text::xml_escaped(text::printable(raw, text::kLongestLine));
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

/// Side of the squares that become one pixel of the report.
std::uint32_t reduction_of(const Image& image) {
  std::uint32_t side = 1;
  const auto blocks = [&](std::uint32_t length) { return (std::uint64_t{length} + side - 1) / side; };
  while (blocks(image.width) * blocks(image.height) > kReportPixels) ++side;
  return side;
}

/// Means of squares, cut off at the right and lower border. One NaN makes a mean NaN, so that it is seen.
std::vector<glm::vec3> reduced(const Image& image, std::uint32_t side) {
  if (side == 1) return image.pixels;
  const std::uint32_t columns = (image.width + side - 1) / side, rows = (image.height + side - 1) / side;
  std::vector<glm::vec3> out(std::size_t{columns} * rows);
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t right = std::min((x + 1) * side, image.width), low = std::min((y + 1) * side, image.height);
      glm::dvec3 sum(0.0);
      for (std::uint32_t v = y * side; v < low; ++v) {
        for (std::uint32_t u = x * side; u < right; ++u)
          sum += glm::dvec3(image.pixels[std::size_t{v} * image.width + u]);
      }
      out[std::size_t{y} * columns + x] = glm::vec3(sum / (double(right - x * side) * double(low - y * side)));
    }
  }
  return out;
}

/// `data` without what depends on the size of the report's pictures.
std::string page(Json data, const std::string& title, const Image& test, const Image& reference, bool with_scores) {
  const std::uint32_t side = reduction_of(test);
  data["reduction"] = side;
  data["fullWidth"] = test.width;
  data["fullHeight"] = test.height;
  data["width"] = (test.width + side - 1) / side;
  data["height"] = (test.height + side - 1) / side;
  std::string pixels_a = encode(reduced(test, side)), pixels_b = encode(reduced(reference, side));
  std::string scores = with_scores ? encode(pixel_scores(test, reference, side)) : "";
  return fill_page({{"@TITLE@", escape_html(title)},
                    {"@CSS@", std::string(assets::report_css)},
                    {"@JS@", std::string(assets::report_js)},
                    {"@DATA@", script_json(data)},
                    {"@PIXELS_A@", std::move(pixels_a)},
                    {"@PIXELS_B@", std::move(pixels_b)},
                    {"@SCORES@", std::move(scores)}});
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
                     {"labelA", short_name(c.test_name)},
                     {"labelB", short_name(c.reference_name)},
                     {"verdict", verdict_name(c.verdict)},
                     {"passed", c.passed()},
                     {"comparison", comparison_json(c)}};
  return page(data, title, test, reference, c.tests.has_value());
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
                               v.device_seed, v.reference_seed, version())},
      {"labelA", "device"},
      {"labelB", "reference"},
      {"verdict", verdict_name(v.verdict)},
      {"passed", v.passed()},
      {"comparison", comparison_json(c)},
      {"validation", validation_json(v)}};
  return page(data, title, v.device_image, v.reference_image, true);
}

}  // namespace etendue
