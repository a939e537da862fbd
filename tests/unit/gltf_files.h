#pragma once
/// Small glTF assets, put together by the tests that read them.

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "formats/gltf/gltf_reader.h"
#include "formats_testing.h"

namespace etendue::testing {

/// The bytes of buffer 0, with the views and accessors that name them.
class GltfBuffer {
 public:
  /// A view of numbers one after the other; returns its index.
  template <typename T>
  int view(const std::vector<T>& numbers, const std::string& more = "") {
    while (bytes_.size() % 4 != 0) bytes_ += '\0';
    const std::size_t offset = bytes_.size(), size = numbers.size() * sizeof(T);
    bytes_.append(reinterpret_cast<const char*>(numbers.data()), size);
    views_.push_back(fmt::format(R"({{"buffer":0,"byteOffset":{},"byteLength":{}{}}})", offset, size, more));
    return static_cast<int>(views_.size() - 1);
  }
  /// An accessor of a new view.
  template <typename T>
  int accessor(const std::vector<T>& numbers, const char* type, int components, const std::string& more = "") {
    const int index = view(numbers);
    return add_accessor(fmt::format(R"("bufferView":{},"componentType":{},"count":{},"type":"{}"{})", index,
                                    component_type<T>(), numbers.size() / static_cast<std::size_t>(components), type,
                                    more));
  }
  int add_accessor(const std::string& members) {
    accessors_.push_back("{" + members + "}");
    return static_cast<int>(accessors_.size() - 1);
  }

  const std::string& bytes() const { return bytes_; }
  /// The members of the document that describe it.
  std::string json(const std::string& uri = "") const {
    return fmt::format(R"("buffers":[{{"byteLength":{}{}}}],"bufferViews":[{}],"accessors":[{}])", bytes_.size(),
                       uri.empty() ? "" : fmt::format(R"(,"uri":"{}")", uri), fmt::join(views_, ","),
                       fmt::join(accessors_, ","));
  }

 private:
  template <typename T>
  static int component_type() {
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    return 5126;
  }

  std::string bytes_;
  std::vector<std::string> views_, accessors_;
};

/// A binary asset.
inline std::string glb(std::string json, std::string binary) {
  while (json.size() % 4 != 0) json += ' ';
  while (binary.size() % 4 != 0) binary += '\0';
  const auto word = [](std::size_t n) {
    const auto value = static_cast<std::uint32_t>(n);
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  return "glTF" + word(2) + word(12 + 8 + json.size() + 8 + binary.size()) + word(json.size()) + "JSON" + json +
         word(binary.size()) + std::string("BIN\0", 4) + binary;
}

/// A document of glTF 2 with those members.
inline std::string document(const std::string& members) {
  return R"({"asset":{"version":"2.0"},)" + members + "}";
}

struct GltfRead {
  std::optional<Scene> scene;
  Diagnostics diagnostics;
  std::string messages() const { return all_messages(diagnostics); }
  const TriangleMesh& mesh(std::size_t shape = 0) const {
    return std::get<TriangleMesh>(scene.value().shapes.at(shape));
  }
};

/// Reads bytes as an asset that can open no other file.
inline GltfRead read_asset(const std::string& bytes, const ReadOptions& options = {}) {
  std::vector<std::byte> copy(bytes.size());
  std::memcpy(copy.data(), bytes.data(), bytes.size());
  GltfRead result;
  result.scene = read_gltf(
      memory_store(std::move(copy)), "a.gltf",
      [](const std::string&) -> std::shared_ptr<const ByteStore> {
        throw Error(ErrorKind::file, "no other file may be opened");
      },
      options, result.diagnostics);
  return result;
}

/// One node that shows one primitive.
inline std::string one_primitive(const GltfBuffer& buffer, const std::string& primitive, const std::string& more = "") {
  return document(fmt::format(
      R"("scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{{}}}]}}],{}{})",
      primitive, buffer.json(), more));
}

inline std::vector<float> right_triangle() {
  return {0, 0, 0, 1, 0, 0, 0, 1, 0};
}

}  // namespace etendue::testing
