/// EXR files as pictures of scenes: one layer in grey or colour, with or without alpha.

#include <algorithm>
#include <array>
#include <set>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "image/exr_io.h"

namespace etendue {
namespace {

/// The channels of a picture in its order, with `prefix` before their names; none if it has neither R, G and B nor Y.
std::vector<std::string> picture_channels(const Imf::ChannelList& channels, const std::string& prefix) {
  const auto has = [&](const char* name) { return channels.findChannel(prefix + name) != nullptr; };
  std::vector<std::string> names;
  if (has("R") && has("G") && has("B")) {
    names = {prefix + "R", prefix + "G", prefix + "B"};
  } else if (has("Y")) {
    names = {prefix + "Y"};
  } else {
    return {};
  }
  if (has("A")) names.push_back(prefix + "A");
  return names;
}

/// Layers with a picture in them.
std::vector<std::string> picture_layers(const Imf::ChannelList& channels) {
  std::set<std::string> all;
  channels.layers(all);
  std::vector<std::string> layers;
  std::copy_if(all.begin(), all.end(), std::back_inserter(layers),
               [&](const std::string& layer) { return !picture_channels(channels, layer + ".").empty(); });
  return layers;
}

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) list += (i > 0 ? ", " : "") + text::quoted(names[i]);
  return names.size() > kMost ? list + fmt::format(" and {} more", names.size() - kMost) : list;
}

std::vector<std::string> choose_channels(const Imf::ChannelList& channels, const std::string& layer,
                                         const std::string& path, std::vector<std::string>& notes) {
  std::vector<std::string> names = picture_channels(channels, layer.empty() ? "" : layer + ".");
  if (!names.empty()) return names;
  const std::vector<std::string> layers = picture_layers(channels);
  if (layer.empty() && layers.size() == 1) {
    notes.push_back(fmt::format("{}: the picture is that of its only layer, {}", path, text::quoted(layers[0])));
    return picture_channels(channels, layers[0] + ".");
  }
  if (layers.empty()) fail_on_file(path, "has neither the channels R, G and B nor the channel Y, in no layer");
  if (layer.empty())
    fail_on_file(path, fmt::format("has its pictures in the layers {}; name one of them", list_of(layers)));
  fail_on_file(path, fmt::format("has no picture in a layer {}; those that have one are {}", text::quoted(layer),
                                 list_of(layers)));
}

/// The format that holds all channels. Throws if one lacks a number for some pixel.
BitmapFormat common_format(const Imf::ChannelList& channels, const std::vector<std::string>& names,
                           const std::string& path) {
  const bool halves = std::all_of(names.begin(), names.end(),
                                  [&](const std::string& name) { return channels[name].type == Imf::HALF; });
  for (const std::string& name : names) {
    const Imf::Channel& channel = channels[name];
    if (channel.xSampling != 1 || channel.ySampling != 1) {
      fail_on_file(path, fmt::format("channel {} is stored at {}x{} times lower resolution; save it at full resolution",
                                     text::quoted(name), channel.xSampling, channel.ySampling));
    }
  }
  return halves ? BitmapFormat::f16 : BitmapFormat::f32;
}

void add_notes(const Imf::Header& header, const std::vector<std::string>& names, const std::string& path,
               std::vector<std::string>& notes) {
  const Imf::ChannelList& channels = header.channels();
  if (header.dataWindow() != header.displayWindow())
    notes.push_back(
        fmt::format("{}: its data window is the picture; the display window, which differs, is ignored", path));
  if (names.size() <= 2 && channels.findChannel("RY") != nullptr)
    notes.push_back(fmt::format("{}: its colour differences RY and BY are ignored; the picture is grey", path));
  if (std::any_of(names.begin(), names.end(),
                  [&](const std::string& name) { return channels[name].type == Imf::UINT; }))
    notes.push_back(fmt::format("{}: its integers are taken as they are, not as parts of a largest one", path));
}

}  // namespace

Bitmap decode_exr_bitmap(std::span<const std::byte> bytes, const std::string& path, const std::string& layer) {
  const Imf::Header header = read_exr_header(bytes, path);
  check_exr_size(header, bytes.size(), path);
  std::vector<std::string> notes;
  const std::vector<std::string> names = choose_channels(header.channels(), layer, path, notes);
  const BitmapFormat format = common_format(header.channels(), names, path);
  add_notes(header, names, path, notes);

  const Imath::Box2i& window = header.dataWindow();
  Bitmap bitmap = make_bitmap(static_cast<std::uint64_t>(window.max.x - window.min.x) + 1,
                              static_cast<std::uint64_t>(window.max.y - window.min.y) + 1,
                              static_cast<std::uint32_t>(names.size()), format);
  bitmap.notes = std::move(notes);
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < names.size(); ++c) {
    add_slice(buffer, names[c], format == BitmapFormat::f16 ? Imf::HALF : Imf::FLOAT,
              bitmap.texels.data() + c * bytes_of(format), names.size() * bytes_of(format), window);
  }
  decode_exr(bytes, buffer, path);
  return bitmap;
}

}  // namespace etendue
