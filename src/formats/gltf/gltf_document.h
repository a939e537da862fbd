#pragma once
/// A glTF asset, .gltf or .glb: its JSON, its buffers, and the positions of things in the file.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/gltf/byte_store.h"
#include "formats/gltf/gltf_values.h"
#include "scene/source_position.h"

namespace etendue {

/// Opens a file that a URI names, relative to the asset. Throws Error, and UriError for URIs that are not followed.
using GltfFileOpener = std::function<std::shared_ptr<const ByteStore>(const std::string& uri)>;

class GltfDocument {
 public:
  /// Throws Error(scene), with the position, if this is not glTF 2.
  GltfDocument(std::string path, std::shared_ptr<const ByteStore> file, GltfFileOpener open);

  const JsonValue& root() const { return root_; }
  const std::string& path() const { return path_; }
  /// What is wrong with the container of a .glb and was passed over.
  const std::vector<std::string>& remarks() const { return remarks_; }
  /// For a .glb, the line and column within its JSON.
  SourcePosition position(const JsonValue& value) const;

  /// An element of one of the root's arrays. Throws GltfError at `where` if it does not exist.
  const JsonValue& element(std::string_view array, std::uint32_t index, const JsonValue& where) const;
  /// The bytes of buffers[index]. Throws GltfError at `where`.
  std::shared_ptr<const ByteStore> buffer(std::uint32_t index, const JsonValue& where);
  /// The data that `uri` contains or the file that it names. Throws GltfError at `where`.
  std::shared_ptr<const ByteStore> resource(const std::string& uri, const JsonValue& where);
  /// The part of a buffer that `view` describes with its members buffer, byteOffset and byteLength; `view` is a
  /// bufferView or an extension of one.
  std::shared_ptr<const ByteStore> part_of_buffer(const JsonValue& view);

 private:
  void read_container(const ByteStore& file, std::shared_ptr<const ByteStore> shared);
  void remark_on_chunk(std::size_t number, std::uint32_t type, std::uint64_t size, std::uint64_t at);
  void parse(std::string text);
  void check_version() const;
  [[noreturn]] void refuse(const std::string& message) const;

  std::string path_;
  GltfFileOpener open_;
  JsonValue root_;
  std::optional<LineIndex> lines_;
  std::shared_ptr<const ByteStore> binary_chunk_;
  std::vector<std::string> remarks_;
  std::map<std::uint32_t, std::shared_ptr<const ByteStore>> buffers_;
};

struct GltfLimits {
  static constexpr std::uint64_t kMaxJsonBytes = std::uint64_t{1} << 29;
};

/// Whether a path has the extension of a glTF asset, .gltf or .glb.
bool is_gltf(const std::string& path);

}  // namespace etendue
