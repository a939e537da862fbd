/// EXR pictures.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <fmt/format.h>

#include "core/errors.h"
#include "image/exr_io.h"
#include "image/files.h"

namespace etendue {
namespace {

constexpr std::array<const char*, 3> kColor = {"R", "G", "B"};
constexpr std::array<const char*, 3> kStandardError = {"StdErr.R", "StdErr.G", "StdErr.B"};
constexpr const char* kSampleCount = "SampleCount";

bool has_channels(const Imf::ChannelList& channels, const std::array<const char*, 3>& names) {
  return std::all_of(names.begin(), names.end(),
                     [&](const char* name) { return channels.findChannel(name) != nullptr; });
}

void check_complete(const Image& image, const std::string& path) {
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  const bool whole = count > 0 && image.pixels.size() == count &&
                     (image.standard_error.empty() || image.standard_error.size() == count) &&
                     (image.sample_count.empty() || image.sample_count.size() == count);
  if (!whole) {
    throw Error(
        ExitCode::file_error,
        fmt::format("{}: cannot write an image of {}x{} pixels whose arrays hold {}, {} and {}", path, image.width,
                    image.height, image.pixels.size(), image.standard_error.size(), image.sample_count.size()));
  }
}

void add_color_slices(Imf::FrameBuffer& buffer, const std::array<const char*, 3>& names,
                      const std::vector<glm::vec3>& values, std::uint32_t width) {
  for (int c = 0; c < 3; ++c) add_slice(buffer, names[c], Imf::FLOAT, &values[0][c], sizeof(glm::vec3), width);
}

}  // namespace

void write_exr(const std::string& path, const Image& image) {
  check_complete(image, path);
  Imf::Header header = make_exr_header(image.width, image.height, image.metadata, path);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer buffer;
  add_color_slices(buffer, kColor, image.pixels, image.width);
  if (!image.standard_error.empty()) add_color_slices(buffer, kStandardError, image.standard_error, image.width);
  if (!image.sample_count.empty()) {
    add_slice(buffer, kSampleCount, Imf::UINT, image.sample_count.data(), sizeof(std::uint32_t), image.width);
  }
  for (auto slice = buffer.begin(); slice != buffer.end(); ++slice) {
    header.channels().insert(slice.name(), Imf::Channel(slice.slice().type));
  }
  write_file_atomically(path, encode_exr(header, buffer, image.height, path));
}

}  // namespace etendue
