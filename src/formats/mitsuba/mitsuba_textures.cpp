#include "formats/mitsuba/mitsuba_textures.h"

#include <filesystem>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "core/text.h"

namespace etendue {
namespace {

constexpr double kGrey = 0.5;
/// Textures within textures: a reference may lead back to where it stands.
constexpr int kMaxDepth = 8;

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
  if (type == "checkerboard") return row(read_checkerboard(*object, number));
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
  source.wrap_u = wrap(object, object.given("wrap_mode_u") ? "wrap_mode_u" : "wrap_mode");
  source.wrap_v = wrap(object, object.given("wrap_mode_v") ? "wrap_mode_v" : "wrap_mode");
  set_filter(object, source);
  set_encoding(object, source);
  const std::shared_ptr<const Bitmap> bitmap = picture(object);
  if (bitmap == nullptr) return std::nullopt;
  const auto [known, is_new] = bitmaps_.try_emplace(bitmap.get(), static_cast<std::uint32_t>(scene_.bitmaps.size()));
  if (is_new) scene_.bitmaps.push_back(bitmap);
  source.bitmap = known->second;
  // Both its coordinates and those of surfaces are turned over.
  return Texture{.source = source,
                 .uv_transform = kFlipV * uv_transform(object) * kFlipV + glm::dmat3(0.0),  // no negative zeros
                 .name = std::filesystem::path(text::trim(object.text("filename"))).filename().string(),
                 .position = object.position()};
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

TextureWrap MitsubaTextures::wrap(const MitsubaObject& object, const char* name) {
  const std::string word = object.text(name);
  if (word == "mirror") return TextureWrap::mirror;
  if (word == "clamp") return TextureWrap::clamp;
  if (word == "zero" || word == "one") {
    context_.missing.add(fmt::format("wrap mode {}", word), object.position_of(name), "clamp");
    return TextureWrap::clamp;
  }
  if (word != "repeat")
    context_.sink.error(object.position_of(name),
                        fmt::format("{} is not a wrap mode{}; known are: repeat, mirror, clamp", text::quoted(word),
                                    text::did_you_mean(word, {"repeat", "mirror", "clamp"})));
  return TextureWrap::repeat;
}

void MitsubaTextures::set_filter(const MitsubaObject& object, BitmapTexture& picture) {
  const std::string word = object.text("filter_type");
  if (word == "nearest") {
    picture.filter = TextureFilter::nearest;
  } else if (word == "ewa" || word == "trilinear") {
    context_.sink.note(object.position_of("filter_type"),
                       fmt::format("the filter {} is read as bilinear: many samples filter pictures", word));
  } else if (word != "bilinear") {
    context_.sink.error(object.position_of("filter_type"),
                        fmt::format("{} is not a texture filter{}; known are: nearest, bilinear, trilinear, ewa",
                                    text::quoted(word), text::did_you_mean(word, {"nearest", "bilinear"})));
  }
}

/// Whether numbers are light or codes of sRGB: the kind of file decides, unless the scene does.
void MitsubaTextures::set_encoding(const MitsubaObject& object, BitmapTexture& picture) {
  if (object.boolean("raw")) picture.color_space = ColorSpace::linear;
  const double gamma = object.real("gamma");
  if (gamma == 1.0) picture.color_space = ColorSpace::linear;
  if (gamma != 1.0 && gamma != -1.0)
    context_.missing.add("gamma of a bitmap", object.position_of("gamma"), "that of sRGB");
}

/// In Mitsuba's coordinates.
glm::dmat3 MitsubaTextures::uv_transform(const MitsubaObject& object) {
  const glm::dmat3 old = {object.real("uscale"),  0.0, 0.0, 0.0, object.real("vscale"), 0.0, object.real("uoffset"),
                          object.real("voffset"), 1.0};
  return old * object.uv_matrix("to_uv");
}

Texture MitsubaTextures::read_checkerboard(const MitsubaObject& object, bool number) {
  CheckerboardTexture board{constant(object.color("color0", SpectrumUse::reflectance), "a checkerboard"),
                            constant(object.color("color1", SpectrumUse::reflectance), "a checkerboard")};
  // As a number Mitsuba's (3.9) has its colours the other way round.
  if (number) std::swap(board.color0, board.color1);
  return {.source = board,
          .uv_transform = uv_transform(object) * kFlipV + glm::dmat3(0.0),
          .name = "checkerboard",
          .position = object.position()};
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
