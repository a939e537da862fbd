#include "formats/model/mtl_reader.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/text.h"
#include "formats/input_file.h"
#include "formats/line_reader.h"

namespace etendue {
namespace {

/// Warnings of one file; nobody reads more.
constexpr std::size_t kMaxWarnings = 20;

struct MtlError {
  std::string message;
};

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t", at);
    if (begin == std::string_view::npos) break;
    at = std::min(line.find_first_of(" \t", begin), line.size());
    words.push_back(line.substr(begin, at - begin));
  }
  return words;
}

double number(std::string_view word) {
  double value = 0.0;
  const text::NumberError error = text::parse_double(word, value);
  if (error != text::NumberError::none) throw MtlError{text::describe(error, word, "a number")};
  constexpr double kMost = 1e9;
  if (!(std::abs(value) <= kMost)) throw MtlError{fmt::format("{} is beyond {}", value, kMost)};
  return value;
}

class MtlParser {
 public:
  MtlParser(const ByteSource& source, const std::string& file, std::map<std::string, MtlMaterial>& materials,
            Diagnostics& diagnostics)
      : lines_(source, file, MtlLimits::kMaxLine), materials_(materials), diagnostics_(diagnostics) {}

  void parse() {
    try {
      while (lines_.next()) parse_line_or_warn();
    } catch (const LineReader::TooLong& error) {
      diagnostics_.warning(error.position, fmt::format("this line has more than {} bytes; the library is read no "
                                                       "further",
                                                       MtlLimits::kMaxLine));
    }
  }

 private:
  void parse_line_or_warn() {
    try {
      parse_line();
    } catch (const MtlError& error) {
      if (warnings_++ < kMaxWarnings)
        diagnostics_.warning(lines_.position(0), fmt::format("{}; the line is left out", error.message));
    }
  }

  void parse_line() {
    std::string_view line = text::trim(lines_.line());
    if (line.empty() || line.front() == '#') return;
    const std::vector<std::string_view> words = split(line);
    const std::string_view keyword = words[0];
    if (keyword == "newmtl") return begin_material(text::trim(line.substr(keyword.size())));
    if (material_ == nullptr) return;
    MtlMaterial& m = *material_;
    if (keyword == "Kd") m.diffuse = glm::clamp(color(words), 0.0, 1.0);
    if (keyword == "Ks") m.specular = glm::clamp(color(words), 0.0, 1.0);
    if (keyword == "Ke") m.emission = glm::max(color(words), 0.0);
    if (keyword == "Ns") m.exponent = std::max(0.0, value(words));
    if (keyword == "Ni") m.index = value(words);
    if (keyword == "d") m.opacity = std::clamp(value(words), 0.0, 1.0);
    if (keyword == "Tr") m.opacity = 1.0 - std::clamp(value(words), 0.0, 1.0);
    if (keyword == "illum") m.illumination = static_cast<int>(std::clamp(value(words), 0.0, 100.0));
    if (keyword == "Pr") m.roughness = std::clamp(value(words), 0.0, 1.0);
    if (keyword == "Pm") m.metallic = std::clamp(value(words), 0.0, 1.0);
    if (keyword == "map_Kd") m.diffuse_map = map(line, words);
    if (keyword == "map_Ke") m.emission_map = map(line, words);
    if (keyword == "map_d") m.opacity_map = map(line, words);
  }

  void begin_material(std::string_view name) {
    material_ = nullptr;
    if (materials_.size() >= MtlLimits::kMaxMaterials)
      throw MtlError{fmt::format("there are more than {} materials", MtlLimits::kMaxMaterials)};
    const auto [place, is_new] = materials_.try_emplace(std::string(name));
    if (!is_new) throw MtlError{fmt::format("the material {} is there already", text::quoted(name))};
    material_ = &place->second;
    material_->position = lines_.position(0);
  }

  static double value(const std::vector<std::string_view>& words) {
    const bool halo = words.size() > 2 && words[1] == "-halo";
    if (words.size() < 2) throw MtlError{fmt::format("{} has no number", words[0])};
    return number(words[halo ? 2 : 1]);
  }

  static glm::dvec3 color(const std::vector<std::string_view>& words) {
    if (words.size() > 1 && (words[1] == "spectral" || words[1] == "xyz"))
      throw MtlError{fmt::format("{} as {} is not read", words[0], words[1])};
    if (words.size() == 2) return glm::dvec3(number(words[1]));
    if (words.size() < 4) throw MtlError{fmt::format("{} needs 1 or 3 numbers", words[0])};
    return {number(words[1]), number(words[2]), number(words[3])};
  }

  /// Options and then the file's name, which may hold blanks.
  static MtlMap map(std::string_view line, const std::vector<std::string_view>& words) {
    MtlMap map;
    std::size_t i = 1;
    while (i < words.size() && words[i].size() > 1 && words[i].front() == '-') i = read_option(words, i, map);
    if (i >= words.size()) throw MtlError{fmt::format("{} names no picture", words[0])};
    map.filename = std::string(text::trim(line.substr(static_cast<std::size_t>(words[i].data() - line.data()))));
    std::ranges::replace(map.filename, '\\', '/');
    return map;
  }

  /// Returns the word behind it.
  static std::size_t read_option(const std::vector<std::string_view>& words, std::size_t i, MtlMap& map) {
    const std::string_view option = words[i++];
    if (option == "-clamp") {
      map.clamp = i < words.size() && words[i] == "on";
      return i + 1;
    }
    if (option == "-s" || option == "-o" || option == "-t") {
      for (int axis = 0; axis < 3 && i < words.size(); ++axis, ++i) {
        double n = 0.0;
        if (text::parse_double(words[i], n) != text::NumberError::none || !(std::abs(n) <= 1e6)) break;
        if (option == "-s") map.scale[axis] = n;
        if (option == "-o") map.offset[axis] = n;
      }
      return i;
    }
    return option == "-mm" ? i + 2 : i + 1;
  }

  LineReader lines_;
  std::map<std::string, MtlMaterial>& materials_;
  Diagnostics& diagnostics_;
  MtlMaterial* material_ = nullptr;
  std::size_t warnings_ = 0;
};

}  // namespace

void read_mtl(const ByteSource& source, const std::string& file, std::map<std::string, MtlMaterial>& materials,
              Diagnostics& diagnostics) {
  MtlParser(source, file, materials, diagnostics).parse();
}

void read_mtl(const std::string& path, std::map<std::string, MtlMaterial>& materials, Diagnostics& diagnostics) {
  InputFile file(path);
  read_mtl([&](char* buffer, std::size_t capacity) { return file.read(buffer, capacity); }, path, materials,
           diagnostics);
}

}  // namespace etendue
