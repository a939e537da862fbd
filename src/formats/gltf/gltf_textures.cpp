#include "formats/gltf/gltf_textures.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/text.h"
#include "image/bitmap_bytes.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

TextureWrap wrap_of(const JsonValue& sampler, std::string_view name) {
  const std::uint64_t mode = count_or(sampler, name, 10497);
  switch (mode) {
    case 10497:
      return TextureWrap::repeat;
    case 33648:
      return TextureWrap::mirror;
    case 33071:
      return TextureWrap::clamp;
    default:
      throw GltfError{&sampler, fmt::format("\"{}\" is {}; it must be 10497, 33648 or 33071", name, mode)};
  }
}

/// The same transform for coordinates with v upward, as in scene.h.
glm::dmat3 with_v_upward(const glm::dmat3& m) {
  const glm::dmat3 flip(glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.0, -1.0, 0.0), glm::dvec3(0.0, 1.0, 1.0));
  glm::dmat3 turned = flip * m * flip;
  turned[0][2] = turned[1][2] = 0.0;
  turned[2][2] = 1.0;
  return turned;
}

/// The name of an image format that is not supported.
const char* foreign_kind(std::span<const std::byte> bytes) {
  const auto begins = [&](std::size_t at, std::string_view magic) {
    return bytes.size() >= at + magic.size() && std::memcmp(bytes.data() + at, magic.data(), magic.size()) == 0;
  };
  if (begins(0, "\xabKTX 20\xbb")) return "KTX2 (Basis Universal, KHR_texture_basisu)";
  if (begins(0, "\xabKTX 11\xbb")) return "KTX";
  if (begins(0, "DDS ")) return "DDS (MSFT_texture_dds)";
  if (begins(4, "ftypavif")) return "AVIF (EXT_texture_avif)";
  return nullptr;
}

Bitmap empty_like(const Bitmap& from, std::uint32_t channels, BitmapFormat format) {
  Bitmap bitmap{.width = from.width, .height = from.height, .channels = channels, .format = format};
  bitmap.texels.resize(bitmap.row_bytes() * bitmap.height);
  return bitmap;
}

std::byte code_of(double value) {
  return static_cast<std::byte>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
}

double alpha_at(const Bitmap& bitmap, std::uint32_t x, std::uint32_t y) {
  return bitmap.has_alpha() ? static_cast<double>(bitmap.stored(x, y, bitmap.channels - 1)) : 1.0;
}

/// A grey picture with 8 bits per pixel.
template <typename F>
Bitmap grey(const Bitmap& from, const F& value) {
  Bitmap bitmap = empty_like(from, 1, BitmapFormat::u8);
  std::size_t at = 0;
  for (std::uint32_t y = 0; y < from.height; ++y) {
    for (std::uint32_t x = 0; x < from.width; ++x) bitmap.texels[at++] = code_of(value(x, y));
  }
  return bitmap;
}

double srgb_from_linear(double c) {
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
}

}  // namespace

std::optional<std::uint32_t> GltfTextures::row(const GltfTextureInfo& info, ColorSpace color_space,
                                               const TextureRecipe* recipe) {
  const glm::dmat3& m = info.transform;
  const std::string key =
      fmt::format("{} {} {} {} {} {} {} {} {} {}", info.index, info.uv_set, static_cast<int>(color_space), m[0][0],
                  m[0][1], m[1][0], m[1][1], m[2][0], m[2][1], recipe == nullptr ? "" : recipe->key);
  const auto [known, is_new] = rows_.try_emplace(key);
  if (!is_new) return known->second;
  try {
    known->second = make_row(info, color_space, recipe);
  } catch (const GltfError& error) {
    const SourcePosition position = document_.position(*error.where);
    // Several textures may use the same picture: one message is enough.
    if (!said_.insert(to_string(position) + error.message).second) return std::nullopt;
    if (approximate_) {
      const std::string sentence = fmt::format("{}; the material is shown without it", error.message);
      sink_.warning(position, sentence);
      scene_.approximations.push_back(sentence);
    } else {
      sink_.error(position, error.message, error.kind);
    }
  }
  return known->second;
}

std::uint32_t GltfTextures::tinted(std::optional<std::uint32_t> row, const SourcePosition& position) {
  if (!row)
    return once(
        "white",
        {.source = AttributeTexture{AttributeTexture::Source::vertex_color}, .name = "COLOR_0", .position = position});
  Texture texture = scene_.textures[*row];
  texture.vertex_tint = true;
  return once(fmt::format("tinted {}", *row), std::move(texture));
}

std::uint32_t GltfTextures::derived(std::uint32_t row, std::optional<double> alpha_cutoff, bool premultiplied) {
  Texture texture = scene_.textures[row];
  texture.alpha_cutoff = alpha_cutoff;
  texture.premultiplied = premultiplied;
  return once(fmt::format("derived {} {} {}", row, alpha_cutoff.has_value() ? fmt::format("{}", *alpha_cutoff) : "-",
                          premultiplied),
              std::move(texture));
}

std::uint32_t GltfTextures::once(const std::string& key, Texture texture) {
  const auto [known, is_new] = derived_.try_emplace(key);
  if (!is_new) return known->second;
  scene_.textures.push_back(std::move(texture));
  return known->second = static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

std::uint32_t GltfTextures::make_row(const GltfTextureInfo& info, ColorSpace color_space, const TextureRecipe* recipe) {
  const JsonValue& texture = document_.element("textures", info.index, *info.where);
  const std::uint32_t image = image_of(texture);
  BitmapTexture picture{.bitmap = bitmap_of(image, recipe, texture), .color_space = color_space};
  if (const auto index = find_index(texture, "sampler")) {
    constexpr std::uint64_t kNearest = 9728;
    const JsonValue& sampler = document_.element("samplers", *index, texture);
    picture.wrap_u = wrap_of(sampler, "wrapS");
    picture.wrap_v = wrap_of(sampler, "wrapT");
    if (count_or(sampler, "magFilter", 0) == kNearest) picture.filter = TextureFilter::nearest;
  }
  const JsonValue& source = document_.element("images", image, texture);
  const std::string uri = string_or(source, "uri", "");
  const std::string name = uri.starts_with("data:") ? "" : uri;
  scene_.textures.push_back({.source = picture,
                             .uv_transform = with_v_upward(info.transform),
                             .uv_set = info.uv_set,
                             .name = string_or(source, "name", name.empty() ? fmt::format("image {}", image) : name),
                             .position = document_.position(*info.where)});
  return static_cast<std::uint32_t>(scene_.textures.size() - 1);
}

std::uint32_t GltfTextures::image_of(const JsonValue& texture) const {
  if (const JsonValue* webp = find_extension(texture, "EXT_texture_webp")) {
    if (const auto image = find_index(*webp, "source")) return *image;
  }
  if (const auto image = find_index(texture, "source")) return *image;
  for (const char* foreign : {"KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"}) {
    const JsonValue* extension = find_extension(texture, foreign);
    if (extension == nullptr) continue;
    // If the image cannot be decoded, the message names its format; a PNG under this extension works, too.
    if (const auto image = find_index(*extension, "source")) return *image;
  }
  throw GltfError{&texture, "the texture has no \"source\""};
}

std::uint32_t GltfTextures::bitmap_of(std::uint32_t image, const TextureRecipe* recipe, const JsonValue& where) {
  const std::string key = fmt::format("{} {}", image, recipe == nullptr ? "" : recipe->key);
  if (const auto known = bitmaps_.find(key); known != bitmaps_.end()) return known->second;
  const std::shared_ptr<const Bitmap> source = decoded(image, where);
  scene_.bitmaps.push_back(recipe == nullptr ? source : std::make_shared<const Bitmap>(recipe->make(*source)));
  return bitmaps_[key] = static_cast<std::uint32_t>(scene_.bitmaps.size() - 1);
}

std::shared_ptr<const Bitmap> GltfTextures::decoded(std::uint32_t index, const JsonValue& where) {
  if (std::shared_ptr<const Bitmap> known = decoded_[index].lock()) return known;
  const JsonValue& image = document_.element("images", index, where);
  const std::string uri = string_or(image, "uri", "");
  std::shared_ptr<const ByteStore> store;
  std::string name = fmt::format("image {}", index);
  if (const auto view = find_index(image, "bufferView")) {
    store = accessors_.view(*view, image);
  } else {
    if (image.find("uri") == nullptr) throw GltfError{&image, "the image has neither a \"uri\" nor a \"bufferView\""};
    store = document_.resource(uri, image);
    if (!uri.starts_with("data:")) name = text::printable(uri, 200);
  }
  const std::vector<std::byte> bytes = store->read(0, store->size());
  if (const char* kind = foreign_kind(bytes))
    throw GltfError{&image,
                    fmt::format("{} is a picture in the format {}, which is not read; convert it to PNG, JPEG "
                                "or WebP",
                                name, kind),
                    ErrorKind::file};
  try {
    auto bitmap = std::make_shared<const Bitmap>(decode_picture(bytes, name));
    decoded_[index] = bitmap;
    return bitmap;
  } catch (const Error& error) {
    throw GltfError{&image, error.what(), error.kind()};
  }
}

TextureRecipe alpha_as_grey() {
  return {"alpha", [](const Bitmap& from) {
            return grey(from, [&](std::uint32_t x, std::uint32_t y) { return alpha_at(from, x, y); });
          }};
}

TextureRecipe white_with_alpha() {
  return {"white", [](const Bitmap& from) {
            Bitmap bitmap = empty_like(from, 4, BitmapFormat::u8);
            std::ranges::fill(bitmap.texels, std::byte{0xff});
            std::size_t at = 3;
            for (std::uint32_t y = 0; y < from.height; ++y) {
              for (std::uint32_t x = 0; x < from.width; ++x, at += 4) bitmap.texels[at] = code_of(alpha_at(from, x, y));
            }
            return bitmap;
          }};
}

TextureRecipe roughness_of_glossiness(double factor) {
  return {fmt::format("rough {}", factor), [=](const Bitmap& from) {
            return grey(from, [&](std::uint32_t x, std::uint32_t y) { return 1.0 - factor * alpha_at(from, x, y); });
          }};
}

TextureRecipe film_thickness(double least, double most) {
  return {fmt::format("film {} {}", least, most), [=](const Bitmap& from) {
            return grey(from, [&](std::uint32_t x, std::uint32_t y) {
              const double green = static_cast<double>(from.stored(x, y, from.channels < 3 ? 0 : 1));
              return least + (most - least) * green;
            });
          }};
}

TextureRecipe scaled_normals(double scale, bool flip) {
  return {fmt::format("normals {} {}", scale, flip), [=](const Bitmap& from) {
            // Floats, because 8 bits after scaling would show as steps in reflections.
            Bitmap bitmap = empty_like(from, 3, BitmapFormat::f32);
            std::size_t at = 0;
            for (std::uint32_t y = 0; y < from.height; ++y) {
              for (std::uint32_t x = 0; x < from.width; ++x) {
                for (std::uint32_t c = 0; c < 3; ++c) {
                  const double code = static_cast<double>(from.stored(x, y, from.channels < 3 ? 0 : c));
                  const double factor = c == 0 ? scale : c == 1 ? (flip ? -scale : scale) : 1.0;
                  const auto value = static_cast<float>(0.5 + factor * (code - 0.5));
                  std::memcpy(&bitmap.texels[at], &value, sizeof value);
                  at += sizeof value;
                }
              }
            }
            return bitmap;
          }};
}

TextureRecipe premultiplied() {
  return {"premultiplied", [](const Bitmap& from) {
            Bitmap bitmap = empty_like(from, 3, BitmapFormat::u8);
            std::size_t at = 0;
            for (std::uint32_t y = 0; y < from.height; ++y) {
              for (std::uint32_t x = 0; x < from.width; ++x) {
                const glm::dvec4 color = texel_color(from, ColorSpace::srgb, x, y);
                for (int c = 0; c < 3; ++c) bitmap.texels[at++] = code_of(srgb_from_linear(color[c] * color.a));
              }
            }
            return bitmap;
          }};
}

}  // namespace etendue
