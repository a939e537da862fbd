#include "cli/tev_packets.h"

#include <algorithm>
#include <bit>
#include <span>
#include <string_view>
#include <utility>

namespace etendue::cli {
namespace {

enum class Operation : std::uint8_t { create_image = 4, update_image_v3 = 6 };

constexpr std::size_t kPacketBytes = std::size_t{4} << 20;
constexpr std::size_t kColors = 3;  // interleaved

class PacketWriter {
 public:
  explicit PacketWriter(Operation operation, bool grab_focus) {
    integer<std::uint32_t>(0);  // the length, known at the end
    integer(static_cast<std::uint8_t>(operation));
    integer<std::uint8_t>(grab_focus ? 1 : 0);
  }

  template <typename T>
  void integer(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes_.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff));
  }
  void text(std::string_view characters) {
    for (const char c : characters) bytes_.push_back(static_cast<std::byte>(c));
    bytes_.push_back(std::byte{0});
  }
  void number(float value) { integer(std::bit_cast<std::uint32_t>(value)); }
  void reserve(std::size_t more) { bytes_.reserve(bytes_.size() + more); }

  Packet finish() {
    const std::size_t size = bytes_.size();
    for (std::size_t i = 0; i < sizeof(std::uint32_t); ++i) bytes_[i] = static_cast<std::byte>(size >> (8 * i) & 0xff);
    return std::move(bytes_);
  }

 private:
  Packet bytes_;
};

std::size_t channel_count(const Image& image) {
  return kColors + (image.standard_error.empty() ? 0 : kColors) + (image.sample_count.empty() ? 0 : 1) +
         image.channels.size();
}

/// The colours of a picture and of its error lie together, which is what strides are for.
void write_places(PacketWriter& packet, const Image& image, std::int64_t pixels) {
  const std::size_t triples = image.standard_error.empty() ? 1 : 2;
  std::vector<std::int64_t> offsets, strides;
  for (std::size_t triple = 0; triple < triples; ++triple) {
    for (std::size_t i = 0; i < kColors; ++i) {
      offsets.push_back(static_cast<std::int64_t>(triple * kColors) * pixels + static_cast<std::int64_t>(i));
      strides.push_back(kColors);
    }
  }
  while (offsets.size() < channel_count(image)) {
    offsets.push_back(static_cast<std::int64_t>(offsets.size()) * pixels);
    strides.push_back(1);
  }
  for (const std::int64_t offset : offsets) packet.integer(offset);
  for (const std::int64_t stride : strides) packet.integer(stride);
}

void write_values(PacketWriter& packet, const Image& image, std::size_t begin, std::size_t count) {
  const auto colors = [&](const std::vector<glm::vec3>& values) {
    for (const glm::vec3& value : std::span(values).subspan(begin, count)) {
      for (int i = 0; i < 3; ++i) packet.number(value[i]);
    }
  };
  const auto numbers = [&](const std::vector<std::uint32_t>& values) {
    for (const std::uint32_t value : std::span(values).subspan(begin, count)) packet.number(static_cast<float>(value));
  };
  colors(image.pixels);
  if (!image.standard_error.empty()) colors(image.standard_error);
  if (!image.sample_count.empty()) numbers(image.sample_count);
  for (const ImageChannel& channel : image.channels) {
    if (channel.values.empty()) {
      numbers(channel.numbers);
    } else {
      for (const float value : std::span(channel.values).subspan(begin, count)) packet.number(value);
    }
  }
}

}  // namespace

std::vector<std::string> tev_channels(const Image& image) {
  std::vector<std::string> names = {"R", "G", "B"};
  if (!image.standard_error.empty()) names.insert(names.end(), {"StdErr.R", "StdErr.G", "StdErr.B"});
  if (!image.sample_count.empty()) names.emplace_back("SampleCount");
  for (const ImageChannel& channel : image.channels) names.push_back(channel.name);
  return names;
}

Packet tev_create(const std::string& name, const Image& image) {
  const std::vector<std::string> channels = tev_channels(image);
  PacketWriter packet(Operation::create_image, true);
  packet.text(name);
  packet.integer(static_cast<std::int32_t>(image.width));
  packet.integer(static_cast<std::int32_t>(image.height));
  packet.integer(static_cast<std::int32_t>(channels.size()));
  for (const std::string& channel : channels) packet.text(channel);
  return packet.finish();
}

Packet tev_update(const std::string& name, const Image& image, std::uint32_t first_row, std::uint32_t rows) {
  const std::vector<std::string> channels = tev_channels(image);
  const std::size_t pixels = std::size_t{image.width} * rows;
  PacketWriter packet(Operation::update_image_v3, false);
  packet.text(name);
  packet.integer(static_cast<std::int32_t>(channels.size()));
  for (const std::string& channel : channels) packet.text(channel);
  for (const std::uint32_t place : {std::uint32_t{0}, first_row, image.width, rows})
    packet.integer(static_cast<std::int32_t>(place));
  write_places(packet, image, static_cast<std::int64_t>(pixels));
  packet.reserve(pixels * channels.size() * sizeof(float));
  write_values(packet, image, std::size_t{image.width} * first_row, pixels);
  return packet.finish();
}

std::uint32_t tev_rows(const Image& image) {
  const std::size_t row = std::size_t{image.width} * channel_count(image) * sizeof(float);
  const std::size_t rows = std::max<std::size_t>(kPacketBytes / row, 1);
  return static_cast<std::uint32_t>(std::min<std::size_t>(rows, image.height));
}

}  // namespace etendue::cli
