#pragma once
/// Helpers of the scene tests: scenes from text, meshes from memory.

#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "formats/nori/nori_reader.h"
#include "formats/obj/obj_reader.h"
#include "formats/read_scene.h"
#include "scene/check.h"
#include "scene/diagnostics.h"

namespace etendue::testing {

/// A folder that is removed with everything in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "etendue-test-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    path_ = name;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, std::string_view content) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path(name);
  }

 private:
  std::filesystem::path path_;
};

inline ByteSource memory_source(std::string_view text, std::size_t chunk = std::string_view::npos) {
  return [text, chunk](char* buffer, std::size_t capacity) mutable {
    const std::size_t count = std::min({text.size(), capacity, chunk});
    std::memcpy(buffer, text.data(), count);
    text.remove_prefix(count);
    return count;
  };
}

/// One triangle in the plane z = 0; stands for any mesh file.
inline std::optional<TriangleMesh> load_triangle(const MeshFormat&, const std::string& path, const MeshContent&,
                                                 Diagnostics& sink) {
  return read_obj(memory_source("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), path, {}, sink);
}

struct Parsed {
  std::optional<SceneFile> file;
  Diagnostics diagnostics;
  const Scene& scene() const { return std::get<Scene>(file.value()); }
};

inline Parsed parse(std::string_view text, const ReadOptions& options = {}) {
  Parsed result;
  result.file = parse_scene_file(std::string(text), "s.xml", options, load_triangle, result.diagnostics);
  return result;
}

inline std::string all_messages(const Diagnostics& diagnostics) {
  std::string text;
  for (const Diagnostic& d : diagnostics.list()) text += to_string(d) + "\n";
  return text;
}

/// A scene with the least it needs around `content`, all in line 1 up to `content` in line 2.
inline std::string scene_around(std::string_view content) {
  return "<scene><integrator type=\"path\"/><camera type=\"perspective\"/>\n" + std::string(content) + "\n</scene>";
}

}  // namespace etendue::testing
