#pragma once
/// What the tests of src/image share: a folder that goes away, films of synthetic samples, errors as text.

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/errors.h"
#include "image/image.h"

namespace etendue::testing_image {

class TempFolder {
 public:
  TempFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "etendue.XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a temporary folder");
    path_ = pattern;
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::permissions(path_, std::filesystem::perms::owner_all, ignored);
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  std::string path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::string path_;
};

inline std::string slurp(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void spill(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

/// The sentence of the Error that `action` throws; fails the test when it throws none or one with another code.
inline std::string error_of(const std::function<void()>& action, ErrorKind kind = ErrorKind::file) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(kind)) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error was thrown";
  return "";
}

/// splitmix64: the same samples whatever the standard library.
inline std::uint64_t hash(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// A sample as a renderer would make it: a pure function of pixel and index, over eight powers of two, sometimes
/// negative, now and then NaN.
inline glm::vec3 synthetic_sample(std::uint64_t pixel, std::uint64_t sample) {
  glm::vec3 rgb;
  for (int c = 0; c < 3; ++c) {
    const std::uint64_t h = hash(pixel * 0x10000 + sample * 4 + static_cast<std::uint64_t>(c));
    rgb[c] = std::ldexp(static_cast<float>(h >> 40), -24 - static_cast<int>(h & 7)) * ((h & 0x78) == 0 ? -1.0f : 1.0f);
  }
  if (hash(pixel * 977 + sample) % 101 == 0) rgb.y = std::bit_cast<float>(0x7fc00000u);
  return rgb;
}

inline FilmFile synthetic_film(std::uint32_t width, std::uint32_t height,
                               std::vector<std::pair<std::uint32_t, std::uint32_t>> samples) {
  FilmFile file;
  file.film = Film(width, height, 3);
  for (const auto& [begin, end] : samples) {
    for (std::size_t pixel = 0; pixel < file.film.pixels().size(); ++pixel) {
      for (std::uint32_t s = begin; s < end; ++s) file.film.pixels()[pixel].add(synthetic_sample(pixel, s), 3);
    }
  }
  file.samples = std::move(samples);
  file.metadata = {
      {"software", "Etendue"}, {"version", "0.1.0"}, {"scene", "box.xml"}, {"sceneHash", "00c0ffee"},
      {"device", "A"},         {"driver", "D 1"},    {"seed", "7"},        {"integrator", "path maxDepth=16"}};
  return file;
}

}  // namespace etendue::testing_image
