#include "formats/mitsuba/mitsuba_textures.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "core/text.h"

namespace etendue {
namespace {

constexpr double kGrey = 0.5;
/// Limit on textures within textures, because references may be circular.
constexpr int kMaxDepth = 8;

/// Sets all channels of a texel to 0 or 1.
void fill_texel(Bitmap& bitmap, std::uint32_t x, std::uint32_t y, double value) {
  const std::size_t bytes = bitmap.row_bytes() / bitmap.width;
  std::byte* texel = &bitmap.texels[y * bitmap.row_bytes() + x * bytes];
  const auto whole = static_cast<float>(value);
  const std::uint8_t code = value > 0.0 ? 255 : 0;
  const std::uint16_t half = value > 0.0 ? 0x3c00 : 0;
  for (std::uint32_t channel = 0; channel < bitmap.channels; ++channel) {
    const std::size_t size = bytes / bitmap.channels;
    const void* from = bitmap.format == BitmapFormat::u8    ? static_cast<const void*>(&code)
                       : bitmap.format == BitmapFormat::f16 ? static_cast<const void*>(&half)
                                                            : static_cast<const void*>(&whole);
    std::memcpy(texel + channel * size, from, size);
  }
}

/// Adds a column at each side that is filled with `u`, and a row at each end that is filled with `v`.
std::shared_ptr<const Bitmap> framed(const Bitmap& bitmap, std::optional<double> u, std::optional<double> v) {
  auto result = std::make_shared<Bitmap>();
  result->width = bitmap.width + (u ? 2 : 0);
  result->height = bitmap.height + (v ? 2 : 0);
  result->channels = bitmap.channels;
  result->format = bitmap.format;
  result->color_space = bitmap.color_space;
  result->texels.resize(result->row_bytes() * result->height);
  const std::size_t texel_bytes = bitmap.row_bytes() / bitmap.width;
  for (std::uint32_t y = 0; y < bitmap.height; ++y)
    std::memcpy(&result->texels[(y + (v ? 1 : 0)) * result->row_bytes() + (u ? texel_bytes : 0)],
                &bitmap.texels[y * bitmap.row_bytes()], bitmap.row_bytes());
  for (std::uint32_t x = 0; v && x < result->width; ++x) {
    for (const std::uint32_t y : {0u, result->height - 1}) fill_texel(*result, x, y, *v);
  }
  for (std::uint32_t y = 0; u && y < result->height; ++y) {
    for (const std::uint32_t x : {0u, result->width - 1}) fill_texel(*result, x, y, *u);
  }
  return result;
}

/// Maps texture coordinates of a picture to those of the picture with its frame.
glm::dmat3 place_in_frame(std::uint32_t width, std::uint32_t height, bool u, bool v) {
  const double x = u ? 1.0 / (width + 2.0) : 0.0, y = v ? 1.0 / (height + 2.0) : 0.0;
  return {1.0 - 2.0 * x, 0.0, 0.0, 0.0, 1.0 - 2.0 * y, 0.0, x, y, 1.0};
}

}  // namespace

ColorParameter MitsubaTextures::parameter(const MitsubaColor& color) {
  if (color.texture == nullptr) return color.value;
  const Scaled found = scaled(*color.texture, false, 0);
  return found.row ? ColorParameter(found.factor, *found.row) : ColorParameter(found.factor);
}

ScalarParameter MitsubaTextures::scalar(const XmlElement& texture) {
  const Scaled found = scaled(texture, true, 0);
  if (!found.row) return found.factor.x;
  return {found.factor.x, *found.row, found.channel};
}

glm::dvec3 MitsubaTextures::constant(const MitsubaColor& color, const char* of) {
  const ColorParameter found = parameter(color);
  if (!found.texture) return found.value;
  context_.missing.add(fmt::format("a texture of {}", of), context_.document.position(*color.texture), "grey, 0.5");
  return found.value * kGrey;
}

MitsubaTextures::Scaled MitsubaTextures::scaled(const XmlElement& texture, bool number, int depth) {
  if (const auto found = rows_.find({&texture, number}); found != rows_.end()) return found->second;
  return rows_[{&texture, number}] = read(texture, number, depth);
}

MitsubaTextures::Scaled MitsubaTextures::read(const XmlElement& texture, bool number, int depth) {
  const Scaled grey{.factor = glm::dvec3(kGrey), .row = {}};
  const auto object = MitsubaObject::read(texture, context_, "grey, 0.5");
  if (!object) return grey;
  const std::string_view type = object->type();
  const auto row = [&](std::optional<Texture> read) {
    return read ? Scaled{.factor = glm::dvec3(1.0), .row = add(std::move(*read))} : grey;
  };
  if (type == "bitmap") {
    Scaled result = row(read_bitmap(*object));
    result.channel = channel_of(*object, number);
    return result;
  }
  if (type == "checkerboard") return row(read_checkerboard(*object, number, depth));
  if (type == "mesh_attribute" || type == "vertexcolors") {
    Scaled result = row(read_attribute(*object));
    if (type == "mesh_attribute") result.factor *= object->real("scale");
    return result;
  }
  if (type == "rawconstant") return {.factor = object->color("value", SpectrumUse::index).value, .row = {}};
  if (type != "scale") throw std::logic_error(fmt::format("the reader has no texture {}", type));
  if (depth >= kMaxDepth) {
    context_.sink.error(object->position(), fmt::format("textures are nested {} deep", depth));
    return grey;
  }
  const std::vector<const XmlElement*> within = object->children("texture");
  if (within.empty()) return grey;  // reported
  Scaled result = scaled(*within.front(), number, depth + 1);
  result.factor *= object->color("scale", SpectrumUse::index).value;
  return result;
}

std::uint32_t MitsubaTextures::add(Texture texture) {
  scene_.textures.push_back(std::move(texture));
  return static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

std::uint32_t MitsubaTextures::add_constant(const glm::dvec3& color, const SourcePosition& position) {
  return add({.source = CheckerboardTexture{color, color}, .name = "constant", .position = position});
}

std::optional<Texture> MitsubaTextures::read_bitmap(const MitsubaObject& object) {
  BitmapTexture source;
  const Wrap u = wrap(object, object.given("wrap_mode_u") ? "wrap_mode_u" : "wrap_mode");
  const Wrap v = wrap(object, object.given("wrap_mode_v") ? "wrap_mode_v" : "wrap_mode");
  source.wrap_u = u.mode;
  source.wrap_v = v.mode;
  set_filter(object, source);
  set_encoding(object, source);
  const std::shared_ptr<const Bitmap> bitmap = picture(object);
  if (bitmap == nullptr) return std::nullopt;
  source.bitmap = row_of(bitmap, u, v);
  const glm::dmat3 inside = place_in_frame(bitmap->width, bitmap->height, u.border.has_value(), v.border.has_value());
  // v is flipped both in the texture and on surfaces.
  return Texture{
      .source = source,
      .uv_transform = inside * kFlipV * uv_transform(object) * kFlipV + glm::dmat3(0.0),  // no negative zeros
      .name = std::filesystem::path(text::trim(object.text("filename"))).filename().string(),
      .position = object.position()};
}

std::uint32_t MitsubaTextures::row_of(const std::shared_ptr<const Bitmap>& bitmap, const Wrap& u, const Wrap& v) {
  const auto [known, is_new] =
      bitmaps_.try_emplace({bitmap.get(), u.border, v.border}, static_cast<std::uint32_t>(scene_.bitmaps.size()));
  if (is_new) scene_.bitmaps.push_back(u.border || v.border ? framed(*bitmap, u.border, v.border) : bitmap);
  return known->second;
}

TextureChannel MitsubaTextures::channel_of(const MitsubaObject& bitmap, bool number) {
  if (!bitmap.given("channel")) return TextureChannel::luminance;
  const std::string word = bitmap.text("channel");
  if (number && word == "r") return TextureChannel::red;
  if (number && word == "g") return TextureChannel::green;
  if (number && word == "b") return TextureChannel::blue;
  if (number && word == "a") return TextureChannel::alpha;
  if (number && word == "y") return TextureChannel::luminance;
  context_.missing.add(
      number ? fmt::format("channel {} of a bitmap", text::printable(word, 20)) : "one channel of a bitmap as a colour",
      bitmap.position_of("channel"), number ? "its luminance" : "all of them");
  return TextureChannel::luminance;
}

std::shared_ptr<const Bitmap> MitsubaTextures::picture(const MitsubaObject& object) {
  if (!object.given("filename")) return nullptr;  // reported
  const SourcePosition position = object.position_of("filename");
  const std::string path = context_.document.resolve(object.text("filename"));
  const auto [known, is_new] = pictures_.try_emplace(path);
  if (!is_new) return known->second;
  try {
    auto bitmap = std::make_shared<Bitmap>(files_.picture(path));
    for (const std::string& note : std::exchange(bitmap->notes, {})) context_.sink.note(position, note);
    known->second = std::move(bitmap);
  } catch (const Error& error) {
    context_.sink.error(position, fmt::format("picture {}", error.what()), error.kind());
  }
  return known->second;
}

MitsubaTextures::Wrap MitsubaTextures::wrap(const MitsubaObject& object, const char* name) {
  const std::string word = object.text(name);
  if (word == "mirror") return {TextureWrap::mirror};
  if (word == "clamp") return {TextureWrap::clamp};
  if (word == "zero") return {TextureWrap::clamp, 0.0};
  if (word == "one") return {TextureWrap::clamp, 1.0};
  if (word != "repeat")
    context_.sink.error(
        object.position_of(name),
        fmt::format("{} is not a wrap mode{}; known are: repeat, mirror, clamp, zero, one", text::quoted(word),
                    text::did_you_mean(word, {"repeat", "mirror", "clamp", "zero", "one"})));
  return {};
}

void MitsubaTextures::set_filter(const MitsubaObject& object, BitmapTexture& picture) {
  const std::string word = object.text("filter_type");
  if (word == "nearest") {
    picture.filter = TextureFilter::nearest;
  } else if (word == "ewa" || word == "trilinear" || word == "anisotropic") {
    context_.sink.note(object.position_of("filter_type"),
                       fmt::format("the filter {} is read as bilinear: many samples filter pictures", word));
  } else if (word != "bilinear") {
    context_.sink.error(object.position_of("filter_type"),
                        fmt::format("{} is not a texture filter{}; known are: nearest, bilinear, trilinear, "
                                    "anisotropic, ewa",
                                    text::quoted(word), text::did_you_mean(word, {"nearest", "bilinear"})));
  }
}

/// Whether numbers are linear or sRGB codes: the file format decides, unless the scene does.
void MitsubaTextures::set_encoding(const MitsubaObject& object, BitmapTexture& picture) {
  if (object.boolean("raw")) picture.color_space = ColorSpace::linear;
  const double gamma = object.real("gamma");
  if (gamma == 1.0) picture.color_space = ColorSpace::linear;
  if (gamma != 1.0 && gamma != -1.0)
    context_.missing.add("gamma of a bitmap", object.position_of("gamma"), "that of sRGB");
}

/// The transform in Mitsuba's coordinates.
glm::dmat3 MitsubaTextures::uv_transform(const MitsubaObject& object) {
  const auto scale = [&](const char* axis) { return object.real(object.given(axis) ? axis : "uvscale"); };
  const glm::dmat3 old = {scale("uscale"),        0.0, 0.0, 0.0, scale("vscale"), 0.0, object.real("uoffset"),
                          object.real("voffset"), 1.0};
  return old * object.uv_matrix("to_uv");
}

Texture MitsubaTextures::read_checkerboard(const MitsubaObject& object, bool number, int depth) {
  CheckerboardTexture board;
  read_square(object, "color0", number, depth, board.color0, board.texture0);
  read_square(object, "color1", number, depth, board.color1, board.texture1);
  // Mitsuba (3.9) swaps the two colours if the texture is used as a number.
  if (number) {
    std::swap(board.color0, board.color1);
    std::swap(board.texture0, board.texture1);
  }
  return {.source = board,
          .uv_transform = uv_transform(object) * kFlipV + glm::dmat3(0.0),
          .name = "checkerboard",
          .position = object.position()};
}

/// The colour or texture in the squares of a checkerboard.
void MitsubaTextures::read_square(const MitsubaObject& board, const char* name, bool number, int depth,
                                  glm::dvec3& color, std::optional<std::uint32_t>& row) {
  const MitsubaColor given = board.color(name, SpectrumUse::reflectance);
  color = given.value;
  if (given.texture == nullptr) return;
  if (depth >= kMaxDepth) {
    color = glm::dvec3(kGrey);
    return context_.sink.error(board.position(), fmt::format("textures lie {} deep within each other", depth));
  }
  const Scaled within = scaled(*given.texture, number, depth + 1);
  color = within.factor;
  row = within.row;
  const bool colors = row && std::holds_alternative<AttributeTexture>(scene_.textures[*row].source);
  const bool channel = row && within.channel != TextureChannel::luminance;
  if (channel)
    context_.missing.add("one channel of a bitmap in a checkerboard", board.position_of(name), "all of them");
  if (!colors) return;
  context_.missing.add("colours of a mesh in a checkerboard", board.position_of(name), "grey, 0.5");
  color = glm::dvec3(kGrey);
  row.reset();
}

std::optional<Texture> MitsubaTextures::read_attribute(const MitsubaObject& object) {
  using Source = AttributeTexture::Source;
  const std::string name = object.type() == "vertexcolors" ? "vertex_color" : object.text("name");
  const bool faces = name.starts_with("face_");
  if (!faces && !name.starts_with("vertex_")) {
    context_.sink.error(
        object.position_of("name"),
        fmt::format("{} is not a mesh attribute; its name begins with vertex_ or face_", text::quoted(name)));
    return std::nullopt;
  }
  return Texture{.source = AttributeTexture{faces ? Source::face_color : Source::vertex_color},
                 .name = name,
                 .position = object.position()};
}

}  // namespace etendue
