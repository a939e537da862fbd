#include "formats/gltf/meshopt.h"

#include <string>

#include <fmt/format.h>
#include <meshoptimizer.h>

#include "core/text.h"

namespace etendue {
namespace {

enum class Mode { attributes, triangles, indices };

Mode mode_of(const JsonValue& extension) {
  const std::string mode = string_or(extension, "mode", "");
  if (mode == "ATTRIBUTES") return Mode::attributes;
  if (mode == "TRIANGLES") return Mode::triangles;
  if (mode == "INDICES") return Mode::indices;
  throw GltfError{&extension, fmt::format("the mode {} of the compression is unknown", text::quoted(mode))};
}

/// Checks what the decoder only asserts, and that a few bytes do not ask for gigabytes: at best, the same byte of 16
/// elements is packed into a quarter of a byte, and a triangle into one byte.
void check_size(const JsonValue& extension, Mode mode, std::uint64_t count, std::uint64_t stride, std::size_t packed) {
  const bool stride_fits =
      mode == Mode::attributes ? stride >= 4 && stride <= 256 && stride % 4 == 0 : stride == 2 || stride == 4;
  if (!stride_fits || (mode == Mode::triangles && count % 3 != 0))
    throw GltfError{&extension, fmt::format("this compression does not pack {} elements of {} bytes", count, stride)};
  constexpr std::uint64_t kMostPerByte = 64;
  if (count * stride > kMostPerByte * (std::uint64_t{packed} + 1))
    throw GltfError{&extension, fmt::format("{} bytes cannot hold {} compressed elements", packed, count)};
}

/// The codecs' streams begin with a byte of their kind and version, of which the library reads only the first ones.
void check_version(const JsonValue& extension, Mode mode, std::span<const std::byte> stream) {
  const unsigned head = stream.empty() ? 0u : std::to_integer<unsigned>(stream.front());
  const unsigned kind = mode == Mode::attributes ? 0xa0u : mode == Mode::triangles ? 0xe0u : 0xd0u;
  constexpr unsigned kNewestOfVertices = MESHOPTIMIZER_VERSION >= 230 ? 1u : 0u;
  const unsigned known = mode == Mode::attributes ? kNewestOfVertices : 1u;
  if ((head & 0xf0u) == kind && (head & 0x0fu) > known)
    throw GltfError{&extension,
                    fmt::format("the compressed stream has the version {} of its codec; versions up to {} are "
                                "read: compress with EXT_meshopt_compression",
                                head & 0x0fu, known)};
}

void undo_filter(const JsonValue& extension, std::vector<std::byte>& bytes, std::uint64_t count, std::uint64_t stride) {
  const std::string filter = string_or(extension, "filter", "NONE");
  if (filter == "NONE") return;
  const bool octahedral = filter == "OCTAHEDRAL", quaternion = filter == "QUATERNION";
  if (!octahedral && !quaternion && filter != "EXPONENTIAL")
    throw GltfError{&extension, fmt::format("the filter {} of the compression is not among those that are read: NONE, "
                                            "OCTAHEDRAL, QUATERNION and EXPONENTIAL",
                                            text::quoted(filter))};
  if ((octahedral && stride != 4 && stride != 8) || (quaternion && stride != 8))
    throw GltfError{&extension, fmt::format("the filter {} has no elements of {} bytes", filter, stride)};
  if (octahedral) {
    meshopt_decodeFilterOct(bytes.data(), count, stride);
  } else if (quaternion) {
    meshopt_decodeFilterQuat(bytes.data(), count, stride);
  } else {
    meshopt_decodeFilterExp(bytes.data(), count, stride);
  }
}

}  // namespace

std::vector<std::byte> decode_meshopt(const JsonValue& extension, std::span<const std::byte> stream) {
  const Mode mode = mode_of(extension);
  const std::uint64_t count = count_or(extension, "count", 0), stride = count_or(extension, "byteStride", 0);
  check_size(extension, mode, count, stride, stream.size());
  std::vector<std::byte> bytes(count * stride);
  if (count == 0) return bytes;
  const auto* packed = reinterpret_cast<const unsigned char*>(stream.data());
  int failure = 0;
  if (mode == Mode::attributes) {
    failure = meshopt_decodeVertexBuffer(bytes.data(), count, stride, packed, stream.size());
  } else if (mode == Mode::triangles) {
    failure = meshopt_decodeIndexBuffer(bytes.data(), count, stride, packed, stream.size());
  } else {
    failure = meshopt_decodeIndexSequence(bytes.data(), count, stride, packed, stream.size());
  }
  if (failure != 0) check_version(extension, mode, stream);
  if (failure != 0) throw GltfError{&extension, "the compressed stream is damaged"};
  if (mode == Mode::attributes) undo_filter(extension, bytes, count, stride);
  return bytes;
}

}  // namespace etendue
