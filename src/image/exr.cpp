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

void check_complete(const Image& image, const std::string& path) {
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  const bool whole = count > 0 && image.pixels.size() == count &&
                     (image.standard_error.empty() || image.standard_error.size() == count) &&
                     (image.sample_count.empty() || image.sample_count.size() == count);
  if (!whole) {
    throw Error(
        ErrorKind::file,
        fmt::format("{}: cannot write an image of {}x{} pixels whose arrays hold {}, {} and {}", path, image.width,
                    image.height, image.pixels.size(), image.standard_error.size(), image.sample_count.size()));
  }
}

void add_color_slices(Imf::FrameBuffer& buffer, const std::array<const char*, 3>& names,
                      const std::vector<glm::vec3>& values, const Imath::Box2i& window) {
  for (int c = 0; c < 3; ++c) {
    add_slice(buffer, names[static_cast<std::size_t>(c)], Imf::FLOAT, &values[0][c], sizeof(glm::vec3), window);
  }
}

void add_statistics(Imf::FrameBuffer& buffer, const Image& image, const Imath::Box2i& window) {
  if (!image.standard_error.empty()) add_color_slices(buffer, kStandardError, image.standard_error, window);
  if (!image.sample_count.empty()) {
    add_slice(buffer, kSampleCount, Imf::UINT, image.sample_count.data(), sizeof(std::uint32_t), window);
  }
}

/// Throws unless the channel holds one real number for every pixel.
void check_color_channel(const Imf::ChannelList& channels, const char* name, const std::string& path) {
  const Imf::Channel& channel = channels[name];
  if (channel.type == Imf::UINT)
    fail_on_file(path, fmt::format("channel {} holds integers; expected float or half", name));
  if (channel.xSampling != 1 || channel.ySampling != 1) {
    fail_on_file(path, fmt::format("channel {} is stored at {}x{} times lower resolution; only full resolution is read",
                                   name, channel.xSampling, channel.ySampling));
  }
}

bool full_resolution(const Imf::ChannelList& channels, const char* name, Imf::PixelType type) {
  const Imf::Channel* channel = channels.findChannel(name);
  return channel != nullptr && channel->type == type && channel->xSampling == 1 && channel->ySampling == 1;
}

}  // namespace

void write_exr(const std::string& path, const Image& image) {
  check_complete(image, path);
  Imf::Header header = make_exr_header(image.width, image.height, image.metadata, path);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer buffer;
  add_color_slices(buffer, kColor, image.pixels, header.dataWindow());
  add_statistics(buffer, image, header.dataWindow());
  add_channels(buffer, image.channels, header.dataWindow());
  write_file_atomically(path, encode_exr(header, buffer, path));
}

Image decode_exr_image(std::span<const std::byte> bytes, const std::string& path, std::span<const std::string> beside) {
  const Imf::Header header = read_exr_header(bytes, path);
  check_exr_size(header, bytes.size(), path);
  const Imf::ChannelList& channels = header.channels();
  const bool color =
      std::all_of(kColor.begin(), kColor.end(), [&](auto* name) { return channels.findChannel(name) != nullptr; });
  if (!color && channels.findChannel("Y") == nullptr)
    fail_on_file(path, "has neither the channels R, G and B nor the channel Y");
  const auto names = color ? kColor : std::array<const char*, 3>{"Y", "Y", "Y"};
  for (const char* name : names) check_color_channel(channels, name, path);

  Image image;
  const Imath::Box2i& window = header.dataWindow();
  image.width = static_cast<std::uint32_t>(window.max.x - window.min.x) + 1;
  image.height = static_cast<std::uint32_t>(window.max.y - window.min.y) + 1;
  image.metadata = exr_metadata(header);
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  image.pixels.resize(count);
  if (std::all_of(kStandardError.begin(), kStandardError.end(),
                  [&](auto* name) { return full_resolution(channels, name, Imf::FLOAT); })) {
    image.standard_error.resize(count);
  }
  if (full_resolution(channels, kSampleCount, Imf::UINT)) image.sample_count.resize(count);

  Imf::FrameBuffer buffer;
  if (color) {
    add_color_slices(buffer, kColor, image.pixels, window);
  } else {
    add_slice(buffer, "Y", Imf::FLOAT, image.pixels.data(), sizeof(glm::vec3), window);
  }
  add_statistics(buffer, image, window);
  for (const std::string& name : beside) {
    if (!full_resolution(channels, name.c_str(), Imf::FLOAT) && !full_resolution(channels, name.c_str(), Imf::HALF))
      continue;
    image.channels.push_back({name, std::vector<float>(count), {}});
  }
  add_channels(buffer, image.channels, window);
  decode_exr(bytes, buffer, path);
  if (!color)
    std::for_each(image.pixels.begin(), image.pixels.end(), [](glm::vec3& pixel) { pixel = glm::vec3(pixel.x); });
  return image;
}

}  // namespace etendue
