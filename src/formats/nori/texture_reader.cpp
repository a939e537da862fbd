#include "formats/nori/texture_reader.h"

#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/text.h"
#include "scene/limits.h"

namespace etendue {
namespace {

/// The part of a transform that affects texture coordinates.
glm::dmat3 plane_transform(const glm::dmat4& m) {
  return {m[0][0], m[0][1], 0.0, m[1][0], m[1][1], 0.0, m[3][0], m[3][1], 1.0};
}

/// Of a texture with both properties: `uvscale` applies first.
glm::dmat3 uv_matrix(const Object& object) {
  const auto scale = object.get<double>("uvscale");
  return plane_transform(object.matrix("to_uv")) * glm::dmat3(scale, 0.0, 0.0, 0.0, scale, 0.0, 0.0, 0.0, 1.0);
}

/// A word in small letters: exporters of Blender write REPEAT, EXTEND, Linear and Closest.
std::string small_word(const Object& object, const char* property) {
  std::string word(text::trim(object.get<std::string>(property)));
  for (char& c : word) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return word;
}

/// Nori's words for a checkerboard: squares of side 1 in uv / scale − delta. Ours have side 1/2.
glm::dmat3 square_transform(const glm::dvec3& scale, const glm::dvec3& delta) {
  return {0.5 / scale.x, 0.0, 0.0, 0.0, 0.5 / scale.y, 0.0, -0.5 * delta.x, -0.5 * delta.y, 1.0};
}

}  // namespace

std::optional<std::uint32_t> TextureReader::read(const Object& owner, const char* property, Scene& scene) {
  const XmlElement* element = owner.child_of(property);
  if (element == nullptr) return std::nullopt;
  const auto [entry, is_new] = textures_.try_emplace(element);
  if (!is_new) {
    if (open_.contains(element)) context_.diagnostics.error(owner.position(), "this texture stands in itself");
    return entry->second;
  }
  if (open_.size() > kMaxNestedTextures) {
    context_.diagnostics.error(owner.position(),
                               fmt::format("textures lie more than {} deep within each other", kMaxNestedTextures));
    return std::nullopt;
  }
  const std::optional<Object> object = Object::read(*element, context_);
  open_.insert(element);
  std::optional<Texture> texture = object ? read_texture(*object, scene) : std::nullopt;
  open_.erase(element);
  if (!texture) return std::nullopt;
  const auto is_given = [&](const char* name) { return object->plugin().find(name) != nullptr && object->given(name); };
  if (is_given("vertex_tint")) texture->vertex_tint = object->get<bool>("vertex_tint");
  if (is_given("alpha_cutoff")) texture->alpha_cutoff = object->get<double>("alpha_cutoff");
  if (is_given("premultiplied")) texture->premultiplied = object->get<bool>("premultiplied");
  channels_[element] = read_channel(*object);
  if (std::string_view(object->plugin().type) == "constant_color" && !texture->is_derived()) {
    constants_[element] = object->get<glm::dvec3>("value");
    return std::nullopt;
  }
  entry->second = static_cast<std::uint32_t>(scene.textures.size());
  scene.textures.push_back(std::move(*texture));
  if (object->given("scale") && object->plugin().find("scale")->type == ParameterType::color)
    factors_[element] = object->get<glm::dvec3>("scale");
  return entry->second;
}

std::optional<glm::dvec3> TextureReader::constant(const Object& owner, const char* property) const {
  const auto found = constants_.find(owner.child_of(property));
  return found == constants_.end() ? std::nullopt : std::optional(found->second);
}

glm::dvec3 TextureReader::factor(const Object& owner, const char* property) const {
  const auto found = factors_.find(owner.child_of(property));
  return found == factors_.end() ? glm::dvec3(1.0) : found->second;
}

std::optional<Texture> TextureReader::read_texture(const Object& object, Scene& scene) {
  const std::string_view type = object.plugin().type;
  if (type == "bitmap") return read_bitmap_texture(object, scene);
  Texture texture{.source = CheckerboardTexture{}, .name = object.plugin().type, .position = object.position()};
  if (type == "checkerboard") {
    CheckerboardTexture board;
    read_square(object, "color0", scene, board.color0, board.texture0);
    read_square(object, "color1", scene, board.color1, board.texture1);
    texture.source = board;
    texture.uv_transform = uv_matrix(object);
    return texture;
  }
  if (type == "checker") {
    const glm::dvec3 squares(object.get<double>("scalex"), object.get<double>("scaley"), 1.0);
    if (squares.x == 0.0 || squares.y == 0.0) {
      context_.diagnostics.error(object.position_of(squares.x == 0.0 ? "scalex" : "scaley"),
                                 "0 squares are no checkerboard; use another number");
      return std::nullopt;
    }
    texture.source = CheckerboardTexture{object.get<glm::dvec3>("color0"), object.get<glm::dvec3>("color1")};
    texture.uv_transform = square_transform(1.0 / squares, glm::dvec3(0.0));
    return texture;
  }
  if (type == "checkerboard_color") {
    const auto scale = object.get<glm::dvec3>("scale");
    if (scale.x == 0.0 || scale.y == 0.0) {
      context_.diagnostics.error(object.position_of("scale"), "a scale of 0 leaves no squares; use another number");
      return std::nullopt;
    }
    texture.source = CheckerboardTexture{object.get<glm::dvec3>("value1"), object.get<glm::dvec3>("value2")};
    texture.uv_transform = square_transform(scale, object.get<glm::dvec3>("delta"));
    return texture;
  }
  if (type == "constant_color") {
    const auto value = object.get<glm::dvec3>("value");
    texture.source = CheckerboardTexture{value, value};
    return texture;
  }
  if (type != "mesh_attribute") throw std::logic_error(fmt::format("the reader has no texture {}", type));
  const auto attribute = object.get<std::string>("attribute");
  if (attribute != "vertex_color" && attribute != "face_color") {
    context_.diagnostics.error(
        object.position_of("attribute"),
        fmt::format("{} is not a mesh attribute{}; known are vertex_color and face_color", text::quoted(attribute),
                    text::did_you_mean(attribute, {"vertex_color", "face_color"})));
    return std::nullopt;
  }
  texture.source = AttributeTexture{attribute == "face_color" ? AttributeTexture::Source::face_color
                                                              : AttributeTexture::Source::vertex_color};
  return texture;
}

void TextureReader::read_square(const Object& board, const char* property, Scene& scene, glm::dvec3& color,
                                std::optional<std::uint32_t>& row) {
  const XmlElement* within = board.child_of(property);
  if (within == nullptr) return void(color = board.get<glm::dvec3>(property));
  row = read(board, property, scene);
  color = constant(board, property).value_or(factor(board, property));
}

std::optional<Texture> TextureReader::read_bitmap_texture(const Object& object, Scene& scene) {
  Texture texture{.source = BitmapTexture{}, .name = "bitmap", .position = object.position()};
  auto& picture = std::get<BitmapTexture>(texture.source);
  set_wrap(object, picture);
  set_filter(object, picture);
  if (object.get<bool>("raw")) picture.color_space = ColorSpace::linear;
  const auto tile = object.get<glm::dvec3>("tile"), delta = object.get<glm::dvec3>("delta");
  if (tile.x == 0.0 || tile.y == 0.0) {
    context_.diagnostics.error(object.position_of("tile"), "a size of 0 leaves no picture; use another number");
    return std::nullopt;
  }
  const glm::dmat3 tiles(1.0 / tile.x, 0.0, 0.0, 0.0, 1.0 / tile.y, 0.0, -delta.x, -delta.y, 1.0);
  texture.uv_transform = uv_matrix(object) * tiles;
  const std::optional<std::uint32_t> bitmap = read_picture(object, texture, scene);
  if (!bitmap) return std::nullopt;
  picture.bitmap = *bitmap;
  return texture;
}

TextureChannel TextureReader::read_channel(const Object& object) {
  constexpr std::pair<const char*, TextureChannel> kChannels[] = {{"red", TextureChannel::red},
                                                                  {"green", TextureChannel::green},
                                                                  {"blue", TextureChannel::blue},
                                                                  {"alpha", TextureChannel::alpha},
                                                                  {"luminance", TextureChannel::luminance}};
  const std::string word(text::trim(object.get<std::string>("channel")));
  for (const auto& [name, channel] : kChannels) {
    if (word == name) return channel;
  }
  context_.diagnostics.error(
      object.position_of("channel"),
      fmt::format("{} is not a texture channel{}; known are red, green, blue, alpha and luminance", text::quoted(word),
                  text::did_you_mean(word, {"red", "green", "blue", "alpha", "luminance"})));
  return TextureChannel::luminance;
}

void TextureReader::set_wrap(const Object& object, BitmapTexture& picture) {
  const std::string word = small_word(object, "wrap_mode");
  TextureWrap wrap = TextureWrap::repeat;
  if (word == "mirror") {
    wrap = TextureWrap::mirror;
  } else if (word == "clamp" || word == "extend") {
    wrap = TextureWrap::clamp;
  } else if (word != "repeat") {
    context_.diagnostics.error(
        object.position_of("wrap_mode"),
        fmt::format("{} is not a wrap mode{}; known are repeat, mirror and clamp", text::quoted(word),
                    text::did_you_mean(word, {"repeat", "mirror", "clamp"})));
  }
  picture.wrap_u = picture.wrap_v = wrap;
}

void TextureReader::set_filter(const Object& object, BitmapTexture& picture) {
  const std::string word = small_word(object, "filter_type");
  if (word == "nearest" || word == "closest") {
    picture.filter = TextureFilter::nearest;
  } else if (word != "bilinear" && word != "linear") {
    context_.diagnostics.error(object.position_of("filter_type"),
                               fmt::format("{} is not a texture filter{}; known are bilinear and nearest",
                                           text::quoted(word), text::did_you_mean(word, {"bilinear", "nearest"})));
  }
}

std::optional<std::uint32_t> TextureReader::read_picture(const Object& object, Texture& texture, Scene& scene) {
  if (!object.given("filename")) return std::nullopt;
  const auto given = object.get<std::string>("filename");
  const std::string filename(text::trim(given));
  const SourcePosition position = object.position_of("filename");
  if (filename.empty()) {
    context_.diagnostics.error(position, "\"filename\" is empty; give the path of a picture");
    return std::nullopt;
  }
  const std::filesystem::path path = files_.find(filename, "picture", position);
  if (path.empty()) return std::nullopt;
  texture.name = path.filename().string();
  const auto [entry, is_new] = bitmaps_.try_emplace(path.string());
  if (!is_new) return entry->second;
  try {
    auto bitmap = std::make_shared<Bitmap>(read_bitmap(path.string()));
    for (const std::string& note : std::exchange(bitmap->notes, {})) context_.diagnostics.note(position, note);
    entry->second = static_cast<std::uint32_t>(scene.bitmaps.size());
    scene.bitmaps.push_back(std::move(bitmap));
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::file) throw;
    context_.diagnostics.error(position, error.what() + files_.remedy(filename, path));
  }
  return entry->second;
}

}  // namespace etendue
