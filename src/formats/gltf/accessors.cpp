#include "formats/gltf/accessors.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/text.h"
#include "formats/gltf/meshopt.h"

namespace etendue {
namespace {

/// How the numbers of an accessor are laid out in its view.
struct Layout {
  std::uint32_t component_type = 0;
  std::uint32_t component_bytes = 0;
  std::uint32_t columns = 1, rows = 1;  ///< a vector is one column
  std::uint32_t column_bytes = 0;       ///< columns of matrices are padded to multiples of four bytes
  bool normalized = false;

  std::uint32_t components() const { return columns * rows; }
  std::uint64_t element_bytes() const {
    return std::uint64_t{column_bytes} * (columns - 1) + std::uint64_t{component_bytes} * rows;
  }
};

std::uint32_t bytes_of_component(std::uint64_t type, const JsonValue& where) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      throw GltfError{&where,
                      fmt::format("the component type {} is unknown; the types are 5120 to 5123, 5125 and 5126", type)};
  }
}

void set_type(const std::string& type, const JsonValue& where, Layout& layout) {
  struct Type {
    const char* word;
    std::uint32_t columns, rows;
  };
  constexpr Type kTypes[] = {{"SCALAR", 1, 1}, {"VEC2", 1, 2}, {"VEC3", 1, 3}, {"VEC4", 1, 4},
                             {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};
  const auto* found = std::ranges::find_if(kTypes, [&](const Type& t) { return t.word == type; });
  if (found == std::end(kTypes))
    throw GltfError{&where, fmt::format("the type {} is unknown; the types are SCALAR, VEC2 to VEC4 and MAT2 to MAT4",
                                        text::quoted(type))};
  layout.columns = found->columns;
  layout.rows = found->rows;
}

Layout layout_of(const JsonValue& accessor) {
  Layout layout;
  const std::uint64_t type = count_or(accessor, "componentType", 0);
  layout.component_bytes = bytes_of_component(type, accessor);
  layout.component_type = static_cast<std::uint32_t>(type);
  set_type(string_or(accessor, "type", ""), accessor, layout);
  layout.normalized = bool_or(accessor, "normalized", false);
  layout.column_bytes = layout.component_bytes * layout.rows;
  if (layout.columns > 1) layout.column_bytes = (layout.column_bytes + 3) / 4 * 4;
  return layout;
}

/// Where the rows of an accessor are in its view.
struct Rows {
  std::shared_ptr<const ByteStore> bytes;
  std::uint64_t offset = 0, stride = 0, count = 0;
};

void check_range(const Rows& rows, std::uint64_t element_bytes, const JsonValue& where) {
  if (rows.stride < element_bytes)
    throw GltfError{&where, fmt::format("rows of {} bytes have a stride of {} bytes", element_bytes, rows.stride)};
  if (rows.count == 0) return;
  const std::uint64_t size = rows.bytes->size();
  const bool fits = rows.offset <= size && element_bytes <= size - rows.offset &&
                    rows.count - 1 <= (size - rows.offset - element_bytes) / rows.stride;
  if (!fits)
    throw GltfError{
        &where,
        fmt::format(
            "{} rows of {} bytes with a stride of {}, starting at byte {}, exceed their view, which has {} bytes",
            rows.count, element_bytes, rows.stride, rows.offset, size)};
}

/// Calls f(number of the row, its bytes) for each row. The file is read in pieces.
template <typename F>
void each_row(const Rows& rows, std::uint64_t element_bytes, F&& f) {
  constexpr std::uint64_t kPieceBytes = std::uint64_t{1} << 20;
  const std::uint64_t in_piece = std::max<std::uint64_t>(kPieceBytes / std::max<std::uint64_t>(rows.stride, 1), 1);
  std::vector<std::byte> piece;
  for (std::uint64_t begin = 0; begin < rows.count; begin += in_piece) {
    const std::uint64_t count = std::min(in_piece, rows.count - begin);
    piece.resize((count - 1) * rows.stride + element_bytes);
    rows.bytes->read(rows.offset + begin * rows.stride, piece);
    for (std::uint64_t i = 0; i < count; ++i) f(begin + i, piece.data() + i * rows.stride);
  }
}

template <typename T>
float to_float(T value, bool normalized) {
  if constexpr (std::is_floating_point_v<T>) {
    return value;
  } else {
    if (!normalized) return static_cast<float>(value);
    const double scaled = static_cast<double>(value) / static_cast<double>(std::numeric_limits<T>::max());
    return static_cast<float>(std::max(scaled, -1.0));
  }
}

/// Reads rows of numbers of type T.
template <typename T>
void read_as(const Rows& rows, const Layout& layout, float* out) {
  each_row(rows, layout.element_bytes(), [&](std::uint64_t row, const std::byte* bytes) {
    float* to = out + row * layout.components();
    for (std::uint32_t column = 0; column < layout.columns; ++column) {
      for (std::uint32_t i = 0; i < layout.rows; ++i) {
        T value;
        std::memcpy(&value, bytes + column * layout.column_bytes + i * sizeof(T), sizeof value);
        *to++ = to_float(value, layout.normalized);
      }
    }
  });
}

void read_floats(const Rows& rows, const Layout& layout, float* out) {
  switch (layout.component_type) {
    case 5120:
      return read_as<std::int8_t>(rows, layout, out);
    case 5121:
      return read_as<std::uint8_t>(rows, layout, out);
    case 5122:
      return read_as<std::int16_t>(rows, layout, out);
    case 5123:
      return read_as<std::uint16_t>(rows, layout, out);
    case 5125:
      return read_as<std::uint32_t>(rows, layout, out);
    default:
      return read_as<float>(rows, layout, out);
  }
}

/// Reads rows of one unsigned integer each.
void read_rows(const Rows& rows, std::uint32_t component_type, const JsonValue& where, std::uint32_t* out) {
  const auto read = [&]<typename T>(T) {
    each_row(rows, sizeof(T), [&](std::uint64_t row, const std::byte* bytes) {
      T value;
      std::memcpy(&value, bytes, sizeof value);
      out[row] = value;
    });
  };
  if (component_type == 5121) return read(std::uint8_t{});
  if (component_type == 5123) return read(std::uint16_t{});
  if (component_type == 5125) return read(std::uint32_t{});
  throw GltfError{&where,
                  fmt::format("indices have the component type {}; they must be 5121, 5123 or 5125", component_type)};
}

std::uint64_t count_of(const JsonValue& accessor, std::uint64_t most) {
  const auto count = find_count(accessor, "count");
  if (!count) throw GltfError{&accessor, "the accessor has no \"count\""};
  if (*count > most)
    throw GltfError{&accessor, fmt::format("the accessor has {} rows; at most {} are read", *count, most)};
  return *count;
}

/// Rows without gaps between them, in the view that `part` names.
Rows packed_rows(Accessors& accessors, const JsonValue& part, std::uint64_t count, std::uint64_t element_bytes) {
  const auto view = find_index(part, "bufferView");
  if (!view) throw GltfError{&part, "the sparse rows have no \"bufferView\""};
  Rows rows{accessors.view(*view, part), count_or(part, "byteOffset", 0), element_bytes, count};
  check_range(rows, element_bytes, part);
  return rows;
}

/// Rows of a sparse accessor, which replace those of its view.
struct SparseRows {
  std::vector<std::uint32_t> places;
  Rows values;
};

std::optional<SparseRows> sparse_rows(Accessors& accessors, const JsonValue& accessor, std::uint64_t rows,
                                      const Layout& layout) {
  const JsonValue* sparse = find_object(accessor, "sparse");
  if (sparse == nullptr) return std::nullopt;
  const std::uint64_t count = count_of(*sparse, rows);
  const JsonValue* indices = find_object(*sparse, "indices");
  const JsonValue* values = find_object(*sparse, "values");
  if (indices == nullptr || values == nullptr) throw GltfError{sparse, "the sparse rows have no indices or no values"};
  SparseRows result;
  const std::uint64_t type = count_or(*indices, "componentType", 0);
  const Rows places = packed_rows(accessors, *indices, count, bytes_of_component(type, *indices));
  result.values = packed_rows(accessors, *values, count, layout.element_bytes());
  result.places.resize(count);
  read_rows(places, static_cast<std::uint32_t>(type), *indices, result.places.data());
  for (const std::uint32_t place : result.places) {
    if (place >= rows)
      throw GltfError{indices, fmt::format("a sparse index is {}; the accessor has {} rows", place, rows)};
  }
  return result;
}

/// The rows of the accessor's view; nothing if it has no view, in which case all numbers are zero.
std::optional<Rows> dense_rows(Accessors& accessors, const GltfDocument& document, const JsonValue& accessor,
                               const Layout& layout) {
  const auto view = find_index(accessor, "bufferView");
  if (!view) return std::nullopt;
  const JsonValue& of = document.element("bufferViews", *view, accessor);
  Rows rows{accessors.view(*view, accessor), count_or(accessor, "byteOffset", 0),
            count_or(of, "byteStride", layout.element_bytes()), count_of(accessor, AccessorLimits::kMaxRows)};
  check_range(rows, layout.element_bytes(), accessor);
  return rows;
}

}  // namespace

std::uint64_t Accessors::count(std::uint32_t index, const JsonValue& where) const {
  return count_of(document_.element("accessors", index, where), AccessorLimits::kMaxRows);
}

void Accessors::check(std::uint32_t index, const JsonValue& where) {
  const JsonValue& accessor = document_.element("accessors", index, where);
  (void)dense_rows(*this, document_, accessor, layout_of(accessor));
}

std::vector<std::uint32_t> Accessors::sparse_places(std::uint32_t index, const JsonValue& where) {
  const JsonValue& accessor = document_.element("accessors", index, where);
  auto sparse = sparse_rows(*this, accessor, count_of(accessor, AccessorLimits::kMaxRows), layout_of(accessor));
  return sparse ? std::move(sparse->places) : std::vector<std::uint32_t>{};
}

std::shared_ptr<const ByteStore> Accessors::view(std::uint32_t index, const JsonValue& where) {
  const JsonValue& view = document_.element("bufferViews", index, where);
  const JsonValue* compression = find_extension(view, "EXT_meshopt_compression");
  if (compression == nullptr) compression = find_extension(view, "KHR_meshopt_compression");
  if (compression == nullptr) return document_.part_of_buffer(view);
  if (const auto known = decompressed_.find(index); known != decompressed_.end()) return known->second;
  const std::shared_ptr<const ByteStore> packed = document_.part_of_buffer(*compression);
  auto store = memory_store(decode_meshopt(*compression, packed->read(0, packed->size())));
  // Accessors of a mesh often share a view, so a few views are kept, but not those of the whole asset.
  if (decompressed_bytes_ + store->size() > AccessorLimits::kMaxKeptBytes) {
    decompressed_.clear();
    decompressed_bytes_ = 0;
  }
  decompressed_bytes_ += store->size();
  return decompressed_[index] = std::move(store);
}

FloatTable Accessors::floats(std::uint32_t index, const JsonValue& where,
                             std::initializer_list<std::uint32_t> components) {
  const JsonValue& accessor = document_.element("accessors", index, where);
  const Layout layout = layout_of(accessor);
  if (std::ranges::find(components, layout.components()) == components.end())
    throw GltfError{&where, fmt::format("the rows of accessor {} have {} numbers; {} are needed here", index,
                                        layout.components(), fmt::join(components, " or "))};
  const std::optional<Rows> dense = dense_rows(*this, document_, accessor, layout);
  const std::uint64_t rows = dense ? dense->count : count_of(accessor, AccessorLimits::kMaxZeroRows);
  FloatTable table{layout.components(), std::vector<float>(rows * layout.components())};
  if (dense) read_floats(*dense, layout, table.numbers.data());
  if (const auto sparse = sparse_rows(*this, accessor, rows, layout)) {
    std::vector<float> values(sparse->places.size() * layout.components());
    read_floats(sparse->values, layout, values.data());
    for (std::size_t i = 0; i < sparse->places.size(); ++i)
      std::copy_n(&values[i * layout.components()], layout.components(),
                  &table.numbers[std::size_t{sparse->places[i]} * layout.components()]);
  }
  return table;
}

void Accessors::read_integers(std::uint32_t index, const JsonValue& where,
                              const std::function<std::uint32_t*(std::uint64_t)>& room) {
  const JsonValue& accessor = document_.element("accessors", index, where);
  const Layout layout = layout_of(accessor);
  if (layout.components() != 1)
    throw GltfError{
        &where, fmt::format("the rows of accessor {} have {} numbers; indices have one", index, layout.components())};
  const std::optional<Rows> dense = dense_rows(*this, document_, accessor, layout);
  const std::uint64_t count = dense ? dense->count : count_of(accessor, AccessorLimits::kMaxZeroRows);
  std::uint32_t* const numbers = room(count);
  if (dense) read_rows(*dense, layout.component_type, accessor, numbers);
  if (const auto sparse = sparse_rows(*this, accessor, count, layout)) {
    std::vector<std::uint32_t> values(sparse->places.size());
    read_rows(sparse->values, layout.component_type, accessor, values.data());
    for (std::size_t i = 0; i < values.size(); ++i) numbers[sparse->places[i]] = values[i];
  }
}

std::vector<std::uint32_t> Accessors::integers(std::uint32_t index, const JsonValue& where) {
  std::vector<std::uint32_t> numbers;
  read_integers(index, where, [&](std::uint64_t count) {
    numbers.resize(count);
    return numbers.data();
  });
  return numbers;
}

std::vector<glm::uvec3> Accessors::triangles(std::uint32_t index, const JsonValue& where) {
  static_assert(sizeof(glm::uvec3) == 3 * sizeof(std::uint32_t));
  std::vector<glm::uvec3> triangles;
  std::uint64_t whole = 0;
  read_integers(index, where, [&](std::uint64_t count) {
    whole = count / 3;
    triangles.resize((count + 2) / 3);
    return reinterpret_cast<std::uint32_t*>(triangles.data());
  });
  triangles.resize(whole);
  return triangles;
}

}  // namespace etendue
