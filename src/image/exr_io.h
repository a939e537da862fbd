#pragma once
/// Common code for the EXR files of pictures and films: memory streams, header checks, metadata. Internal to src/image.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>

#include "image/decode.h"
#include "image/image.h"

namespace etendue {

/// Text attribute that only film files have; never part of the metadata.
inline constexpr const char* kChecksumAttribute = "filmChecksum";
/// "depth:7 normal:0": text attribute of film files with AOVs, their films' exponents; never part of the metadata.
inline constexpr const char* kAovsAttribute = "filmAovs";
/// Integer attribute that only film files have: the version of their layout.
inline constexpr const char* kFormatAttribute = "filmFormat";
/// Channel of pictures and films.
inline constexpr const char* kSampleCount = "SampleCount";

/// Throws Error(file): "PATH: REASON".
[[noreturn]] void fail_on_file(const std::string& path, const std::string& reason);

class MemoryOStream : public Imf::OStream {
 public:
  MemoryOStream() : Imf::OStream("memory") {}
  void write(const char bytes[], int count) override;
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  std::uint64_t position_ = 0;
};

/// Reads from bytes that must outlive it; throws Iex::InputExc past their end.
class MemoryIStream : public Imf::IStream {
 public:
  explicit MemoryIStream(std::span<const std::byte> bytes) : Imf::IStream("memory"), bytes_(bytes) {}
  bool read(char target[], int count) override;
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

 private:
  std::span<const std::byte> bytes_;
  std::uint64_t position_ = 0;
};

/// The position of an attribute's value in the file.
struct ExrAttribute {
  std::string name;
  std::string type;
  std::size_t offset = 0;
  std::size_t size = 0;
};

/// The attributes of a single-part scan-line or tiled file, from its first bytes. This is done before the library sees
/// the file, because it would allocate whatever size an attribute claims. Throws Error(file).
std::vector<ExrAttribute> exr_attributes(std::span<const std::byte> bytes, const std::string& path);

/// The header, checked: attributes lie inside the bytes, the sizes are within the limits above. Throws
/// Error(file).
Imf::Header read_exr_header(std::span<const std::byte> bytes, const std::string& path);

/// The same of a file, of which only the first bytes are read; checked against the size of the file.
Imf::Header load_exr_header(const std::string& path);

/// Whether the header is that of a film file, valid or not.
bool is_film(const Imf::Header& header);

/// Throws Error(file) unless a file of `file_size` bytes can hold the pixels its header announces.
void check_exr_size(const Imf::Header& header, std::uint64_t file_size, const std::string& path);

/// A header with everything both kinds of file have in common.
Imf::Header make_exr_header(std::uint32_t width, std::uint32_t height, const Metadata& metadata,
                            const std::string& path);

/// Text attributes by their metadata names.
Metadata exr_metadata(const Imf::Header& header);

/// Channel `name` of the whole data window, from or to `base`: rows without gaps, `stride` bytes from pixel to pixel.
void add_slice(Imf::FrameBuffer& buffer, const std::string& name, Imf::PixelType type, const void* base,
               std::size_t stride, const Imath::Box2i& window);

/// Channels other than colour. `channels` must outlive the buffer.
void add_channels(Imf::FrameBuffer& buffer, const std::vector<ImageChannel>& channels, const Imath::Box2i& window);

/// Encodes the channels of `buffer`; throws Error(file) naming the path.
std::vector<std::byte> encode_exr(Imf::Header header, const Imf::FrameBuffer& buffer, const std::string& path);
/// Decodes the channels of `buffer`, all of them or none; throws Error(file) naming the path.
void decode_exr(std::span<const std::byte> bytes, const Imf::FrameBuffer& buffer, const std::string& path);

}  // namespace etendue
