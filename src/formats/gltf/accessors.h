#pragma once
/// Numbers of a glTF asset: accessors to views of buffers. Every range is checked against the size of its buffer before
/// a byte is read, and memory is allocated only for what the file really contains.

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <vector>

#include <glm/glm.hpp>

#include "formats/gltf/gltf_document.h"

namespace etendue {

/// Rows of numbers, without gaps between them.
struct FloatTable {
  std::uint32_t components = 0;  ///< numbers in a row
  std::vector<float> numbers;

  std::size_t rows() const { return components == 0 ? 0 : numbers.size() / components; }
  const float* row(std::size_t i) const { return &numbers[i * components]; }
};

class Accessors {
 public:
  explicit Accessors(GltfDocument& document) : document_(document) {}

  // These throw GltfError, at `where` if there is no such accessor, otherwise at what is wrong in it. Normalised
  // integers are mapped to [0,1] or [-1,1]; other integers keep their values.
  FloatTable floats(std::uint32_t index, const JsonValue& where, std::initializer_list<std::uint32_t> components);
  std::vector<std::uint32_t> integers(std::uint32_t index, const JsonValue& where);
  /// The same in threes. One or two that are left over are left out.
  std::vector<glm::uvec3> triangles(std::uint32_t index, const JsonValue& where);
  /// The number of rows of an accessor, without reading them.
  std::uint64_t count(std::uint32_t index, const JsonValue& where) const;
  /// Throws what reading all rows would throw, but reads none.
  void check(std::uint32_t index, const JsonValue& where);
  /// The rows that a sparse accessor replaces, in the order of the file; none for others.
  std::vector<std::uint32_t> sparse_places(std::uint32_t index, const JsonValue& where);
  /// The bytes of bufferViews[index], decompressed.
  std::shared_ptr<const ByteStore> view(std::uint32_t index, const JsonValue& where);

 private:
  /// Writes the integers to what `room` returns for their number.
  void read_integers(std::uint32_t index, const JsonValue& where,
                     const std::function<std::uint32_t*(std::uint64_t count)>& room);

  GltfDocument& document_;
  std::map<std::uint32_t, std::shared_ptr<const ByteStore>> decompressed_;
  std::uint64_t decompressed_bytes_ = 0;
};

struct AccessorLimits {
  static constexpr std::uint64_t kMaxRows = std::uint64_t{1} << 27;
  /// Rows of an accessor without a view. They are all zero, so a few bytes of JSON could ask for gigabytes of them.
  static constexpr std::uint64_t kMaxZeroRows = std::uint64_t{1} << 22;
  /// Decompressed views are kept up to this size in total.
  static constexpr std::uint64_t kMaxKeptBytes = std::uint64_t{1} << 26;
};

}  // namespace etendue
