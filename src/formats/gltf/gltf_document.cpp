#include "formats/gltf/gltf_document.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "core/text.h"
#include "formats/gltf/uri.h"

namespace etendue {
namespace {

constexpr std::uint32_t kMagic = 0x46546c67;        // "glTF", little-endian
constexpr std::uint32_t kChunkJson = 0x4e4f534a;    // "JSON"
constexpr std::uint32_t kChunkBinary = 0x004e4942;  // "BIN"
constexpr std::uint64_t kHeaderBytes = 12, kChunkHeaderBytes = 8;

template <std::size_t N>
std::array<std::uint32_t, N> words_at(const ByteStore& file, std::uint64_t offset) {
  std::array<std::uint32_t, N> words{};
  file.read(offset, std::as_writable_bytes(std::span(words)));
  return words;
}

}  // namespace

GltfDocument::GltfDocument(std::string path, std::shared_ptr<const ByteStore> file, GltfFileOpener open)
    : path_(std::move(path)), open_(std::move(open)) {
  if (file->size() >= kHeaderBytes && words_at<1>(*file, 0)[0] == kMagic) {
    read_container(*file, file);
  } else {
    if (file->size() > GltfLimits::kMaxJsonBytes)
      refuse(fmt::format("the file has {} bytes; at most {} of JSON are read; geometry belongs in buffers",
                         file->size(), GltfLimits::kMaxJsonBytes));
    std::string text(file->size(), '\0');
    file->read(0, std::as_writable_bytes(std::span(text)));
    parse(std::move(text));
  }
  check_version();
}

void GltfDocument::refuse(const std::string& message) const {
  throw Error(ErrorKind::scene, fmt::format("{}: {}", path_, message));
}

void GltfDocument::read_container(const ByteStore& file, std::shared_ptr<const ByteStore> shared) {
  const auto [magic, version, length] = words_at<3>(file, 0);
  if (version != 2) refuse(fmt::format("this is a GLB file of version {}, at byte 4; version 2 is read", version));
  if (length > file.size())
    refuse(fmt::format("the GLB file announces {} bytes, at byte 8, but has {}: it is truncated", length, file.size()));
  if (length < file.size())
    remarks_.push_back(fmt::format("the GLB file announces {} bytes, at byte 8, but has {}; the rest is ignored",
                                   length, file.size()));
  std::optional<std::string> text;
  std::uint64_t at = kHeaderBytes;
  for (std::size_t number = 0; at + kChunkHeaderBytes <= length; ++number) {
    const auto [size, type] = words_at<2>(file, at);
    at += kChunkHeaderBytes;
    if (size > length - at)
      refuse(fmt::format("the chunk at byte {} of the GLB file has {} bytes, {} are left", at, size, length - at));
    remark_on_chunk(number, type, size, at);
    if (type == kChunkJson && !text) {
      if (size > GltfLimits::kMaxJsonBytes)
        refuse(fmt::format("the JSON has {} bytes; at most {} are read", size, GltfLimits::kMaxJsonBytes));
      text.emplace(size, '\0');
      file.read(at, std::as_writable_bytes(std::span(*text)));
    } else if (type == kChunkBinary && binary_chunk_ == nullptr) {
      binary_chunk_ = part_of(shared, at, size);
    }
    at += size + (4 - size % 4) % 4;
  }
  if (!text) refuse("the GLB file has no JSON");
  if (at < length)
    remarks_.push_back(
        fmt::format("after the last chunk of the GLB file, at byte {}, {} bytes are left over", at, length - at));
  parse(std::move(*text));
}

/// The JSON is the first chunk and the binary one the second, both padded to multiples of four bytes.
void GltfDocument::remark_on_chunk(std::size_t number, std::uint32_t type, std::uint64_t size, std::uint64_t at) {
  constexpr std::size_t kMost = 20;
  if (remarks_.size() >= kMost) return;
  const auto say = [&](const std::string& what) {
    remarks_.push_back(fmt::format("chunk {} of the GLB file, at byte {}, {}", number, at, what));
  };
  if (size % 4 != 0) say(fmt::format("has {} bytes, which is no multiple of 4", size));
  if (type == kChunkJson) {
    if (number != 0) say("is JSON, which must be the first chunk; the first such chunk is used");
  } else if (type == kChunkBinary) {
    if (number != 1) say("is binary, which must be the second chunk; the first such chunk is used");
  } else {
    say(fmt::format("has the unknown type {:#x}; it is ignored", type));
  }
}

void GltfDocument::parse(std::string text) {
  if (const char* pointer = text::pointer_sentence(text)) refuse(pointer);
  lines_.emplace(text);
  try {
    root_ = parse_json(text);
  } catch (const JsonError& error) {
    const auto [line, column] = lines_->place(error.offset);
    throw Error(ErrorKind::scene, fmt::format("{}:{}:{}: {}", path_, line, column, error.message));
  }
}

void GltfDocument::check_version() const {
  try {
    if (root_.object() == nullptr)
      throw GltfError{&root_, fmt::format("the document is {}; it must be an object", root_.kind())};
    const JsonValue* asset = find_object(root_, "asset");
    if (asset == nullptr) throw GltfError{&root_, "the document has no \"asset\"; this is not glTF 2"};
    const std::string version = string_or(*asset, "version", "");
    const std::string least = string_or(*asset, "minVersion", version);
    if (!version.starts_with("2."))
      throw GltfError{asset, fmt::format("this is glTF {}; version 2.0 is read", text::quoted(version))};
    if (least != "2.0" && least != version)
      throw GltfError{asset, fmt::format("the asset needs glTF {}; version 2.0 is read", text::quoted(least))};
  } catch (const GltfError& error) {
    const SourcePosition at = position(*error.where);
    throw Error(ErrorKind::scene, fmt::format("{}:{}:{}: {}", at.file, at.line, at.column, error.message));
  }
}

SourcePosition GltfDocument::position(const JsonValue& value) const {
  const auto [line, column] = lines_->place(value.offset());
  return {path_, line, column};
}

const JsonValue& GltfDocument::element(std::string_view array, std::uint32_t index, const JsonValue& where) const {
  const JsonValue::Array& elements = array_of(root_, array);
  if (index >= elements.size())
    throw GltfError{&where, fmt::format("this refers to number {} of \"{}\", of which there are {}", index, array,
                                        elements.size())};
  if (elements[index].object() == nullptr)
    throw GltfError{&elements[index],
                    fmt::format("\"{}\" holds {}; it must hold objects", array, elements[index].kind())};
  return elements[index];
}

std::shared_ptr<const ByteStore> GltfDocument::buffer(std::uint32_t index, const JsonValue& where) {
  const JsonValue& buffer = element("buffers", index, where);
  std::shared_ptr<const ByteStore>& store = buffers_[index];
  if (store != nullptr) return store;
  std::shared_ptr<const ByteStore> bytes;
  if (const JsonValue* uri = buffer.find("uri"); uri != nullptr) {
    bytes = resource(string_or(buffer, "uri", ""), *uri);
  } else if (index == 0 && binary_chunk_ != nullptr) {
    bytes = binary_chunk_;
  } else {
    throw GltfError{&buffer, "the buffer has neither a \"uri\" nor a binary chunk of a GLB file"};
  }
  const std::uint64_t length = count_or(buffer, "byteLength", bytes->size());
  if (length > bytes->size())
    throw GltfError{&buffer,
                    fmt::format("the buffer should have {} bytes but has {}: it is truncated", length, bytes->size())};
  store = std::move(bytes);
  return store;
}

std::shared_ptr<const ByteStore> GltfDocument::resource(const std::string& uri, const JsonValue& where) {
  try {
    if (std::optional<DataUri> data = parse_data_uri(uri)) return memory_store(std::move(data->bytes));
    return open_(uri);
  } catch (const UriError& error) {
    constexpr std::size_t kMostShown = 200;
    throw GltfError{&where, fmt::format("\"{}\": {}", text::printable(uri, kMostShown), error.message)};
  } catch (const Error& error) {
    throw GltfError{&where, error.what(), error.kind()};
  }
}

std::shared_ptr<const ByteStore> GltfDocument::part_of_buffer(const JsonValue& view) {
  const auto index = find_index(view, "buffer");
  if (!index) throw GltfError{&view, "a view has no \"buffer\""};
  const std::shared_ptr<const ByteStore> bytes = buffer(*index, view);
  const std::uint64_t offset = count_or(view, "byteOffset", 0);
  const auto length = find_count(view, "byteLength");
  if (!length) throw GltfError{&view, "a view of a buffer has no \"byteLength\""};
  if (offset > bytes->size() || *length > bytes->size() - offset)
    throw GltfError{&view, fmt::format("the view of {} bytes from {} on exceeds its buffer, which has {}", *length,
                                       offset, bytes->size())};
  return part_of(bytes, offset, *length);
}

bool is_gltf(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return text::equal_ignoring_case(extension, ".gltf") || text::equal_ignoring_case(extension, ".glb");
}

}  // namespace etendue
