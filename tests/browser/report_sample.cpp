// Writes pictures and reports for the browser test: report_sample FOLDER makes a.exr, b.exr, compare.html, plain.html
// (without statistics) and values.json with the floats read back from the EXR files, which the report has to show.

#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>

#include <fmt/format.h>

#include "core/errors.h"
#include "validate/html_report.h"

namespace etendue {
namespace {

// A gradient with a bright disk, seen through the noise of `spp` exponential samples; `test` has a disk 6 % too bright.
Image picture(std::uint32_t width, std::uint32_t height, std::uint32_t spp, unsigned seed, bool test) {
  std::mt19937 rng(seed);
  std::gamma_distribution<double> mean_of_samples(spp, 1.0 / spp);
  Image image;
  image.width = width;
  image.height = height;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const double r = std::hypot(x - 0.35 * width, y - 0.5 * height) / height;
      const double disk = r < 0.22 ? (test ? 1.06 : 1.0) : 0.12;
      glm::vec3 value, error;
      for (int c = 0; c < 3; ++c) {
        const double expectation = disk * (0.3 + 0.5 * (c == 0   ? double(x) / width
                                                        : c == 1 ? double(y) / height
                                                                 : 0.6));
        value[c] = float(expectation * mean_of_samples(rng));
        error[c] = float(expectation / std::sqrt(double(spp)));
      }
      image.pixels.push_back(value);
      image.standard_error.push_back(error);
      image.sample_count.push_back(spp);
    }
  }
  image.metadata = {{"scene", "disk"},
                    {"seed", std::to_string(seed)},
                    {"samples", std::to_string(spp)},
                    {"note", test ? "<b>&" : ""}};
  return image;
}

void write(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw Error(ErrorKind::file, fmt::format("{}: cannot be written", path));
}

void make(const std::string& folder) {
  write_exr(folder + "/a.exr", picture(200, 120, 64, 1, true));
  write_exr(folder + "/b.exr", picture(200, 120, 64, 2, false));
  Image a = read_image(folder + "/a.exr"), b = read_image(folder + "/b.exr");
  write(folder + "/compare.html", comparison_html(compare_images(a, "a.exr", b, "b.exr"), a, b));
  Json values = Json::array();
  for (const auto& [x, y] : {std::pair{0u, 0u}, {100u, 60u}, {199u, 119u}, {70u, 61u}, {3u, 117u}}) {
    const std::size_t i = y * a.width + x;
    values.push_back({{"x", x},
                      {"y", y},
                      {"a", {a.pixels[i].x, a.pixels[i].y, a.pixels[i].z}},
                      {"b", {b.pixels[i].x, b.pixels[i].y, b.pixels[i].z}}});
  }
  write(folder + "/values.json", values.dump());
  a.standard_error.clear();
  a.pixels[0].x = std::nanf("");
  write(folder + "/plain.html", comparison_html(compare_images(a, "</script>.exr", b, "b.exr"), a, b));
}

}  // namespace
}  // namespace etendue

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    etendue::make(argv[1]);
  } catch (const etendue::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
