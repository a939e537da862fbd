#include "image/exr_io.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <mutex>

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfCompression.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfVersion.h>
#include <fmt/format.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "core/printable.h"
#include "image/files.h"

namespace etendue {
namespace {

/// Names to which the EXR format gives a meaning and a type; as metadata they get a prefix.
constexpr std::array<const char*, 12> kReservedNames = {
    "channels",           "compression",       "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio",
    "screenWindowCenter", "screenWindowWidth", "name",       "type",          "version",   "view"};
constexpr const char* kReservedPrefix = "etendue.";

std::string attribute_name(const std::string& key) {
  const bool reserved = std::find(kReservedNames.begin(), kReservedNames.end(), key) != kReservedNames.end();
  return reserved ? kReservedPrefix + key : key;
}

std::string metadata_key(const std::string& attribute) {
  const std::string prefix = kReservedPrefix;
  if (attribute.starts_with(prefix)) {
    std::string key = attribute.substr(prefix.size());
    if (attribute_name(key) == attribute) return key;
  }
  return attribute;
}

void use_threads() {
  static std::once_flag once;
  std::call_once(once, [] { Imf::setGlobalThreadCount(static_cast<int>(thread_count())); });
}

std::uint64_t pixel_bytes(const Imf::ChannelList& channels) {
  std::uint64_t bytes = 0;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    bytes += channel.channel().type == Imf::HALF ? 2 : 4;
  }
  return bytes;
}

void check_dimensions(std::int64_t width, std::int64_t height, const std::string& path) {
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide ||
      static_cast<std::uint64_t>(width * height) > kMaxImagePixels) {
    fail_on_file(path, fmt::format("has {}x{} pixels; files hold 1 to {} a side and at most {} in all", width, height,
                                   kMaxImageSide, kMaxImagePixels));
  }
}

/// Walks the attributes of a header: name, type (both end in a zero byte), 32-bit size, value; an empty name ends it.
class AttributeWalker {
 public:
  AttributeWalker(std::span<const std::byte> bytes, std::size_t start, const std::string& path)
      : bytes_(bytes), position_(start), path_(path) {}

  bool next(ExrAttribute& attribute) {
    attribute.name = word();
    if (attribute.name.empty()) return false;
    attribute.type = word();
    if (bytes_.size() - position_ < 4) truncated();
    std::uint32_t size = 0;
    for (int i = 0; i < 4; ++i) size |= std::to_integer<std::uint32_t>(bytes_[position_ + i]) << (8 * i);
    position_ += 4;
    if (size > bytes_.size() - position_) truncated();
    attribute.offset = position_;
    attribute.size = size;
    position_ += size;
    return true;
  }

 private:
  [[noreturn]] void truncated() const {
    fail_on_file(path_, "is a damaged EXR file: its header runs past the end of the file");
  }

  std::string word() {
    std::string result;
    while (position_ < bytes_.size() && bytes_[position_] != std::byte{0}) {
      result += static_cast<char>(bytes_[position_++]);
      if (result.size() > 255)
        fail_on_file(path_, "is a damaged EXR file: a name in its header has more than 255 bytes");
    }
    if (position_ == bytes_.size()) truncated();
    ++position_;
    return result;
  }

  std::span<const std::byte> bytes_;
  std::size_t position_;
  const std::string& path_;
};

/// The largest compression ratio of a method, rounded up.
std::uint64_t largest_ratio(Imf::Compression method) {
  switch (method) {
    case Imf::NO_COMPRESSION:
      return 1;
    case Imf::RLE_COMPRESSION:
      return 64;  // two bytes for a run of at most 128
    case Imf::DWAA_COMPRESSION:
    case Imf::DWAB_COMPRESSION:
      return 65536;  // run lengths, then deflate
    default:
      return 1040;  // deflate reaches 1032; PIZ, PXR24 and B44 less
  }
}

}  // namespace

void fail_on_file(const std::string& path, const std::string& reason) {
  throw Error(ErrorKind::file, fmt::format("{}: {}", path, reason));
}

void MemoryOStream::write(const char bytes[], int count) {
  const auto size = static_cast<std::size_t>(count);
  if (position_ + size > bytes_.size()) bytes_.resize(position_ + size);
  std::memcpy(bytes_.data() + position_, bytes, size);
  position_ += size;
}

bool MemoryIStream::read(char target[], int count) {
  const auto size = static_cast<std::uint64_t>(std::max(count, 0));
  if (position_ > bytes_.size() || size > bytes_.size() - position_) throw Iex::InputExc("the file ends too early");
  if (size > 0) std::memcpy(target, bytes_.data() + position_, size);
  position_ += size;
  return position_ < bytes_.size();
}

bool is_exr(std::span<const std::byte> bytes) {
  constexpr std::array<unsigned char, 4> kMagic = {0x76, 0x2f, 0x31, 0x01};
  return bytes.size() >= kMagic.size() && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

std::vector<ExrAttribute> exr_attributes(std::span<const std::byte> bytes, const std::string& path) {
  if (!is_exr(bytes)) fail_on_file(path, "is not an EXR file");
  if (bytes.size() < 8) fail_on_file(path, "is a damaged EXR file: it ends inside its header");
  const auto flags = std::to_integer<unsigned>(bytes[5]);
  // Bits 11 and 12 of the version field: deep data, several parts.
  if ((flags & 0x18u) != 0)
    fail_on_file(path, "is an EXR file with deep data or several parts; only flat single-part files are read");
  AttributeWalker walker(bytes, 8, path);
  std::vector<ExrAttribute> attributes;
  for (ExrAttribute attribute; walker.next(attribute);) attributes.push_back(attribute);
  return attributes;
}

Imf::Header read_exr_header(std::span<const std::byte> bytes, const std::string& path) {
  exr_attributes(bytes, path);
  Imf::Header header;
  try {
    MemoryIStream stream(bytes);
    stream.seekg(4);
    int version = static_cast<int>(std::to_integer<unsigned>(bytes[4]) | std::to_integer<unsigned>(bytes[5]) << 8);
    if (Imf::getVersion(version) != Imf::EXR_VERSION)
      fail_on_file(path, fmt::format("has EXR version {}, not 2", Imf::getVersion(version)));
    stream.seekg(8);
    header.readFrom(stream, version);
    header.sanityCheck(Imf::isTiled(version), false);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail_on_file(path, fmt::format("is a damaged EXR file: {}", error.what()));
  }
  const Imath::Box2i& window = header.dataWindow();
  check_dimensions(std::int64_t{window.max.x} - window.min.x + 1, std::int64_t{window.max.y} - window.min.y + 1, path);
  return header;
}

Imf::Header load_exr_header(const std::string& path) {
  // Headers are short; one that fills the first piece is tried again with a longer one.
  constexpr std::uint64_t kLongest = 1 << 24;
  for (std::uint64_t limit = 1 << 16;; limit *= 16) {
    const std::vector<std::byte> bytes = read_file(path, limit);
    try {
      Imf::Header header = read_exr_header(bytes, path);
      check_exr_size(header, std::filesystem::file_size(path), path);
      return header;
    } catch (const Error&) {
      if (bytes.size() < limit || limit == kLongest) throw;
    }
  }
}

bool is_film(const Imf::Header& header) {
  return header.find(kFormatAttribute) != header.end() || header.find(kChecksumAttribute) != header.end();
}

void check_exr_size(const Imf::Header& header, std::uint64_t file_size, const std::string& path) {
  const Imath::Box2i& window = header.dataWindow();
  const std::uint64_t width = static_cast<std::uint64_t>(window.max.x - window.min.x) + 1;
  const std::uint64_t height = static_cast<std::uint64_t>(window.max.y - window.min.y) + 1;
  const std::uint64_t raw = width * height * pixel_bytes(header.channels());
  if (raw / largest_ratio(header.compression()) > file_size) {
    fail_on_file(path, fmt::format("announces {} bytes of pixels but has only {} bytes: it is damaged or truncated",
                                   raw, file_size));
  }
}

Imf::Header make_exr_header(std::uint32_t width, std::uint32_t height, const Metadata& metadata,
                            const std::string& path) {
  check_dimensions(width, height, path);
  Imf::Header header(static_cast<int>(width), static_cast<int>(height));
  Imf::addChromaticities(header, Imf::Chromaticities());  // Rec. 709 primaries and white point
  for (const auto& [key, value] : metadata) {
    const std::string name = attribute_name(key);
    if (key.empty() || name.size() > 255 || name.find('\0') != std::string::npos ||
        header.find(name.c_str()) != header.end()) {
      fail_on_file(path, fmt::format("{} cannot be the name of a header attribute", text::quoted(key)));
    }
    header.insert(name, Imf::StringAttribute(value));
  }
  return header;
}

Metadata exr_metadata(const Imf::Header& header) {
  Metadata metadata;
  for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute())) {
      const std::string_view name = attribute.name();
      if (name != kChecksumAttribute && name != kAovsAttribute)
        metadata[metadata_key(attribute.name())] = text->value();
    }
  }
  return metadata;
}

void add_slice(Imf::FrameBuffer& buffer, const std::string& name, Imf::PixelType type, const void* base,
               std::size_t stride, const Imath::Box2i& window) {
  const std::size_t width = static_cast<std::size_t>(window.max.x - window.min.x) + 1;
  buffer.insert(name, Imf::Slice::Make(type, base, window, stride, stride * width));
}

void add_channels(Imf::FrameBuffer& buffer, const std::vector<ImageChannel>& channels, const Imath::Box2i& window) {
  for (const ImageChannel& channel : channels) {
    if (channel.numbers.empty()) {
      add_slice(buffer, channel.name, Imf::FLOAT, channel.values.data(), sizeof(float), window);
    } else {
      add_slice(buffer, channel.name, Imf::UINT, channel.numbers.data(), sizeof(std::uint32_t), window);
    }
  }
}

std::vector<std::byte> encode_exr(Imf::Header header, const Imf::FrameBuffer& buffer, const std::string& path) {
  use_threads();
  try {
    for (auto slice = buffer.begin(); slice != buffer.end(); ++slice) {
      header.channels().insert(slice.name(), Imf::Channel(slice.slice().type));
    }
    MemoryOStream stream;
    {
      Imf::OutputFile file(stream, header);
      file.setFrameBuffer(buffer);
      file.writePixels(header.dataWindow().max.y + 1);
    }
    return std::move(stream.bytes());
  } catch (const std::exception& error) {
    fail_on_file(path, fmt::format("cannot be encoded as EXR: {}", error.what()));
  }
}

void decode_exr(std::span<const std::byte> bytes, const Imf::FrameBuffer& buffer, const std::string& path) {
  use_threads();
  bool complete = false;
  try {
    MemoryIStream stream(bytes);
    Imf::InputFile file(stream);
    complete = file.isComplete();
    if (complete) {
      const Imath::Box2i window = file.header().dataWindow();
      file.setFrameBuffer(buffer);
      file.readPixels(window.min.y, window.max.y);
    }
  } catch (const std::exception& error) {
    fail_on_file(path, fmt::format("is a damaged EXR file: {}", error.what()));
  }
  if (!complete) fail_on_file(path, "is an unfinished or truncated EXR file: parts of the picture are missing");
}

}  // namespace etendue
