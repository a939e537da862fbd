#pragma once
/// Numbers of a glTF asset: accessors over views of buffers. Every range is held against what its buffer has before a
/// byte is read, and memory is spent only for what the file holds.

#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <vector>

#include "formats/gltf/gltf_document.h"

namespace etendue {

/// Rows of numbers, one after the other.
struct FloatTable {
  std::uint32_t components = 0;  ///< of a row
  std::vector<float> numbers;

  std::size_t rows() const { return components == 0 ? 0 : numbers.size() / components; }
  const float* row(std::size_t i) const { return &numbers[i * components]; }
};

class Accessors {
 public:
  explicit Accessors(GltfDocument& document) : document_(document) {}

  // Each throws GltfError: at `where` if there is no such accessor, else at what is wrong in it. Normalised integers
  // become numbers in [0,1] or [-1,1], others stay as they are.
  FloatTable floats(std::uint32_t index, const JsonValue& where, std::initializer_list<std::uint32_t> components);
  std::vector<std::uint32_t> integers(std::uint32_t index, const JsonValue& where);
  /// Rows of an accessor, without reading them.
  std::uint64_t count(std::uint32_t index, const JsonValue& where) const;
  /// The bytes of bufferViews[index], decompressed.
  std::shared_ptr<const ByteStore> view(std::uint32_t index, const JsonValue& where);

 private:
  GltfDocument& document_;
  std::map<std::uint32_t, std::shared_ptr<const ByteStore>> decompressed_;
  std::uint64_t decompressed_bytes_ = 0;
};

struct AccessorLimits {
  static constexpr std::uint64_t kMaxRows = std::uint64_t{1} << 27;
  /// Of accessors that no view of a buffer fills: zeros, of which a few bytes could ask for gigabytes.
  static constexpr std::uint64_t kMaxZeroRows = std::uint64_t{1} << 22;
  /// Of decompressed views, which are forgotten beyond that.
  static constexpr std::uint64_t kMaxKeptBytes = std::uint64_t{1} << 26;
};

}  // namespace etendue
