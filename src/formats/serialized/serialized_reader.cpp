#include "formats/serialized/serialized_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

#include "formats/input_file.h"
#include "formats/mesh/mesh_content.h"
#include "scene/limits.h"

namespace etendue {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little-endian");

/// Bytes of a whole file.
constexpr std::uint64_t kMaxFile = std::uint64_t{1} << 32;
constexpr std::uint16_t kMagic = 0x041c;
constexpr std::size_t kMaxName = 4096;  ///< bytes
constexpr std::size_t kHeader = 4;      ///< bytes: magic number and version

enum Flags : std::uint32_t {
  kNormals = 0x0001,
  kTexCoords = 0x0002,
  kColors = 0x0008,
  kFaceNormals = 0x0010,
  kSingle = 0x1000,
  kDouble = 0x2000,
};

struct BadFile {
  std::string message;
};

template <typename T>
T read_at(std::span<const std::byte> bytes, std::uint64_t offset) {
  T value;
  if (offset > bytes.size() || bytes.size() - offset < sizeof(T))
    throw BadFile{fmt::format("the file ends where byte {} should be; is it complete?", offset + sizeof(T))};
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// A compressed stream, read front to back.
class Inflater {
 public:
  explicit Inflater(std::span<const std::byte> bytes) {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));  // zlib does not write there
    stream_.avail_in = static_cast<uInt>(std::min<std::size_t>(bytes.size(), 0xffffffffu));
    if (inflateInit(&stream_) != Z_OK) throw BadFile{"zlib cannot be started"};
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  void read(void* target, std::size_t size) {
    stream_.next_out = static_cast<Bytef*>(target);
    stream_.avail_out = static_cast<uInt>(size);
    while (stream_.avail_out > 0) {
      const int code = inflate(&stream_, Z_SYNC_FLUSH);
      if (code == Z_OK && (stream_.avail_in > 0 || stream_.avail_out == 0)) continue;
      if (stream_.avail_out > 0)
        throw BadFile{code == Z_STREAM_END || code == Z_OK || code == Z_BUF_ERROR
                          ? "a mesh is shorter than it announces; is the file complete?"
                          : "a mesh cannot be decompressed; the file is damaged"};
    }
  }
  template <typename T>
  T value() {
    T value;
    read(&value, sizeof(T));
    return value;
  }
  /// `count` values, of which memory is spent only for those that are there.
  template <typename T>
  std::vector<T> values(std::uint64_t count) {
    constexpr std::uint64_t kChunk = 1 << 16;
    std::vector<T> all;
    while (all.size() < count) {
      const std::size_t begin = all.size();
      all.resize(begin + static_cast<std::size_t>(std::min(kChunk, count - begin)));
      read(all.data() + begin, (all.size() - begin) * sizeof(T));
    }
    return all;
  }

 private:
  z_stream stream_{};
};

std::vector<double> read_reals(Inflater& stream, std::uint64_t count, bool doubles) {
  std::vector<double> reals;
  if (doubles) {
    reals = stream.values<double>(count);
  } else {
    const std::vector<float> floats = stream.values<float>(count);
    reals.assign(floats.begin(), floats.end());
  }
  if (std::ranges::any_of(reals, [](double x) { return !std::isfinite(x); }))
    throw BadFile{"a number of a vertex is not finite"};
  return reals;
}

std::vector<glm::dvec3> read_triples(Inflater& stream, std::uint64_t count, bool doubles) {
  const std::vector<double> reals = read_reals(stream, 3 * count, doubles);
  std::vector<glm::dvec3> triples;
  for (std::size_t i = 0; i < reals.size(); i += 3) triples.emplace_back(reals[i], reals[i + 1], reals[i + 2]);
  return triples;
}

std::vector<glm::dvec3> read_normals(Inflater& stream, std::uint64_t count, bool doubles) {
  std::vector<glm::dvec3> normals = read_triples(stream, count, doubles);
  for (glm::dvec3& n : normals) {
    const double length = glm::length(n);
    n = length > 0.0 ? n / length : glm::dvec3(0.0, 0.0, 1.0);
  }
  return normals;
}

std::vector<glm::vec2> read_uv(Inflater& stream, std::uint64_t count, bool doubles) {
  const std::vector<double> reals = read_reals(stream, 2 * count, doubles);
  std::vector<glm::vec2> uv;
  for (std::size_t i = 0; i < reals.size(); i += 2) uv.emplace_back(reals[i], reals[i + 1]);
  return uv;
}

std::vector<glm::uvec3> read_triangles(Inflater& stream, std::uint64_t count, std::uint64_t vertices) {
  const std::vector<std::uint32_t> indices = stream.values<std::uint32_t>(3 * count);
  std::vector<glm::uvec3> triangles;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const glm::uvec3 t(indices[i], indices[i + 1], indices[i + 2]);
    if (std::max({t.x, t.y, t.z}) >= vertices)
      throw BadFile{fmt::format("triangle {} has the vertex {}, of which there are {}", i / 3,
                                std::max({t.x, t.y, t.z}), vertices)};
    triangles.push_back(t);
  }
  return triangles;
}

/// Where the stream of a mesh lies.
std::span<const std::byte> find_mesh(std::span<const std::byte> bytes, std::int64_t index, std::uint16_t version) {
  const std::size_t width = version == 3 ? 4 : 8;
  const auto count = read_at<std::uint32_t>(bytes, bytes.size() - 4);
  if (index < 0 || index >= count)
    throw BadFile{fmt::format("the file has {} meshes; there is no number {}, counted from 0", count, index)};
  const std::uint64_t table = std::uint64_t{count} * width + 4;
  if (table > bytes.size()) throw BadFile{"the table of meshes at the end is longer than the file; is it complete?"};
  const std::uint64_t entry = bytes.size() - table + static_cast<std::uint64_t>(index) * width;
  const std::uint64_t begin = width == 4 ? read_at<std::uint32_t>(bytes, entry) : read_at<std::uint64_t>(bytes, entry);
  if (begin > bytes.size() - kHeader || read_at<std::uint16_t>(bytes, begin) != kMagic)
    throw BadFile{fmt::format("there is no mesh where the table says, at byte {}; the file is damaged", begin)};
  return bytes.subspan(begin + kHeader);
}

SerializedMesh decode(std::span<const std::byte> bytes, std::int64_t index) {
  if (bytes.size() < kHeader + 4 || read_at<std::uint16_t>(bytes, 0) != kMagic)
    throw BadFile{"this is no .serialized file: it does not begin with 1c 04"};
  const auto version = read_at<std::uint16_t>(bytes, 2);
  if (version != 3 && version != 4)
    throw BadFile{fmt::format("the file has version {} of its format; 3 and 4 are supported", version)};
  Inflater stream(find_mesh(bytes, index, version));
  const auto flags = stream.value<std::uint32_t>();
  if (version == 4) {
    std::size_t name = 0;
    while (stream.value<char>() != '\0') {
      if (++name > kMaxName) throw BadFile{fmt::format("the name of the mesh has over {} bytes", kMaxName)};
    }
  }
  const auto vertices = stream.value<std::uint64_t>(), triangles = stream.value<std::uint64_t>();
  if (vertices > kMaxVertices || triangles > kMaxTriangles)
    throw BadFile{fmt::format("the mesh has {} vertices and {} triangles; at most {} and {} are supported", vertices,
                              triangles, kMaxVertices, kMaxTriangles)};
  const bool doubles = (flags & kDouble) != 0;
  if (doubles == ((flags & kSingle) != 0)) throw BadFile{"the mesh declares neither float nor double, or both"};
  SerializedMesh result{.mesh = {}, .face_normals = (flags & kFaceNormals) != 0};
  TriangleMesh& mesh = result.mesh;
  mesh.positions = read_triples(stream, vertices, doubles);
  if ((flags & kNormals) != 0) mesh.normals = read_normals(stream, vertices, doubles);
  narrow_vectors(mesh);
  if ((flags & kTexCoords) != 0) mesh.uv_sets = {read_uv(stream, vertices, doubles)};
  if ((flags & kColors) != 0) {
    for (const glm::dvec3& color : read_triples(stream, vertices, doubles)) mesh.vertex_colors.emplace_back(color);
  }
  mesh.triangles = read_triangles(stream, triangles, vertices);
  return result;
}

}  // namespace

std::optional<SerializedMesh> read_serialized(std::span<const std::byte> bytes, const std::string& file,
                                              std::int64_t index, Diagnostics& diagnostics) {
  try {
    return decode(bytes, index);
  } catch (const BadFile& error) {
    diagnostics.error({file, 0, 0}, error.message);
    return std::nullopt;
  }
}

std::optional<SerializedMesh> read_serialized(const std::string& path, std::int64_t index, Diagnostics& diagnostics) {
  InputFile file(path);
  if (file.size() > kMaxFile) {
    diagnostics.error({path, 0, 0},
                      fmt::format("the file has {} bytes; at most {} are supported", file.size(), kMaxFile));
    return std::nullopt;
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(file.size()));
  std::size_t size = 0;
  while (size < bytes.size()) {
    const std::size_t count = file.read(reinterpret_cast<char*>(bytes.data()) + size, bytes.size() - size);
    if (count == 0) break;  // somebody shortens the file while it is read
    size += count;
  }
  return read_serialized(std::span(bytes).first(size), path, index, diagnostics);
}

}  // namespace etendue
