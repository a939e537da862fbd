#include "compile/textures.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>

#include <fmt/core.h>

#include "core/errors.h"
#include "scene/materials.h"
#include "scene/parameters.h"
#include "scene/placed.h"
#include "scene/sharing.h"

namespace etendue {
namespace {

gpu::uint format_bits(const Bitmap& bitmap) {
  const auto log2_bytes = static_cast<gpu::uint>(std::countr_zero(bytes_of(bitmap.format)));
  return log2_bytes << gpu::kTextureFormatShift | bitmap.channels << gpu::kTextureChannelsShift;
}

/// Floats encoded by the sRGB curve are decoded here, because kernels decode 8-bit codes only.
std::shared_ptr<const Bitmap> linear_floats(const Bitmap& coded) {
  auto linear = std::make_shared<Bitmap>();
  linear->width = coded.width;
  linear->height = coded.height;
  linear->channels = coded.channels;
  linear->format = BitmapFormat::f32;
  const std::size_t numbers = std::size_t{coded.width} * coded.height * coded.channels;
  linear->texels.resize(numbers * sizeof(float));
  std::size_t at = 0;
  for (std::uint32_t y = 0; y < coded.height; ++y) {
    for (std::uint32_t x = 0; x < coded.width; ++x) {
      for (std::uint32_t c = 0; c < coded.channels; ++c, at += sizeof(float)) {
        const bool alpha = coded.has_alpha() && c + 1 == coded.channels;
        const float stored = coded.stored(x, y, c);
        const auto light = alpha ? stored : static_cast<float>(linear_from_srgb(static_cast<double>(stored)));
        std::memcpy(&linear->texels[at], &light, sizeof light);
      }
    }
  }
  return linear;
}

/// The attributes of an instance's shape that its textures read.
struct Needs {
  std::uint32_t sets = 0;
  bool vertex_colors = false, face_colors = false, tangents = false;
  bool any = false;
};

class TextureCompiler {
 public:
  explicit TextureCompiler(const Scene& scene) : scene_(scene), sharing_(scene) {}

  CompiledTextures compile() {
    for (const Instance& instance : scene_.instances) find_needs(instance);
    for (const DeltaLight& light : scene_.delta_lights) textured_ |= is_textured(light);
    if (!textured_) return {};
    for (const Texture& texture : scene_.textures) out_.textures.push_back(flatten(texture));
    for (const Instance& instance : scene_.instances) out_.instances.push_back(flatten(instance));
    return std::move(out_);
  }

 private:
  /// Instances of one shape with the same winding have the same attributes. The weights of a shared mesh are those of
  /// its vertices in their original order.
  std::pair<std::uint32_t, bool> key(const Instance& instance) const {
    const auto index = static_cast<std::size_t>(&instance - scene_.instances.data());
    return {instance.shape, turns_winding(instance) && !sharing_.has_instance(index)};
  }

  void find_needs(const Instance& instance) {
    Needs& needs = needs_[key(instance)];
    const auto add = [&](const char*, const auto& parameter) {
      if (parameter.texture) add_need(scene_.textures[*parameter.texture], instance, needs);
    };
    each_material(scene_, instance.material, [&](const Material& material) {
      each_parameter(material, add);
      if (is_aligned(material)) add_tangents(instance, needs);
      const auto* normals = material.adapter ? std::get_if<NormalMapAdapter>(&*material.adapter) : nullptr;
      const auto* gltf = material.adapter ? nullptr : std::get_if<GltfBsdf>(&material.bsdf);
      const bool of_coat = gltf != nullptr && gltf->coat_vertex_tangents && gltf->coat_normals.texture;
      if (of_coat || (normals != nullptr && normals->vertex_tangents)) {
        needs.tangents = true;
        out_.features |= gpu::kTexturesVertexTangents;
      }
      const bool plain = material.adapter || std::holds_alternative<DiffuseBsdf>(material.bsdf);
      if (!plain && is_textured(material)) out_.features |= gpu::kTexturesRich;
      if (gltf != nullptr && gltf->anisotropy_directions.texture) out_.features |= gpu::kTexturesTurn;
      const auto* coated = std::get_if<RoughPlasticBsdf>(&material.bsdf);
      if (coated != nullptr && coated->alpha.texture && !material.adapter) out_.features |= gpu::kTexturesCoat;
    });
    if (std::ranges::find(scene_.aovs, Aov::uv) != scene_.aovs.end()) add_coordinates(instance, needs);
    const AreaEmitter* emitter = scene_.emitter_of(instance);
    if (emitter == nullptr) return;
    each_parameter(*emitter, add);
    if (is_textured(*emitter)) out_.features |= gpu::kTexturesRadiance;
  }

  /// The feature for a shape that has texture coordinates of its own.
  static gpu::uint feature_of(const Shape& shape) {
    if (std::holds_alternative<Sphere>(shape)) return gpu::kTexturesSphere;
    if (std::holds_alternative<Disk>(shape)) return gpu::kTexturesDisk;
    return std::holds_alternative<Cylinder>(shape) ? gpu::kTexturesCylinder : 0;
  }

  void add_need(const Texture& texture, const Instance& instance, Needs& needs) {
    textured_ = needs.any = true;
    needs.vertex_colors |= texture.vertex_tint;
    if (const auto* attribute = std::get_if<AttributeTexture>(&texture.source)) {
      const bool faces = attribute->source == AttributeTexture::Source::face_color;
      (faces ? needs.face_colors : needs.vertex_colors) = true;
    } else if (const gpu::uint feature = feature_of(scene_.shape_of(instance)); feature != 0) {
      out_.features |= feature;
    } else {
      needs.sets = std::max(needs.sets, texture.uv_set + 1);
    }
  }

  /// Adds what a material needs whose frame follows texture coordinates, if the shape has any.
  void add_tangents(const Instance& instance, Needs& needs) {
    textured_ = needs.any = true;
    out_.features |= gpu::kTexturesTangents | feature_of(scene_.shape_of(instance));
    const auto* mesh = std::get_if<TriangleMesh>(&scene_.shape_of(instance));
    if (mesh != nullptr && !mesh->uv_sets.empty()) needs.sets = std::max(needs.sets, 1u);
  }

  /// The AOV of texture coordinates needs them even without textures.
  void add_coordinates(const Instance& instance, Needs& needs) {
    const Shape& shape = scene_.shape_of(instance);
    const auto* mesh = std::get_if<TriangleMesh>(&shape);
    if (mesh != nullptr && mesh->uv_sets.empty()) return;
    textured_ = needs.any = true;
    out_.features |= mesh != nullptr ? gpu::kTexturesMesh : feature_of(shape);
    if (mesh != nullptr) needs.sets = std::max(needs.sets, 1u);
  }

  gpu::TextureRecord flatten(const Texture& texture) {
    gpu::TextureRecord record{};
    const glm::dmat3 rows = glm::transpose(texture.uv_transform);
    record.u_row = glm::vec3(rows[0]);
    record.v_row = glm::vec3(rows[1]);
    record.uv_set = texture.uv_set;
    std::visit([&](const auto& source) { flatten_source(source, texture, record); }, texture.source);
    if (texture.vertex_tint) record.header |= gpu::kTextureTinted;
    if (texture.alpha_cutoff) record.header |= gpu::kTextureCut;
    if (texture.premultiplied) record.header |= gpu::kTexturePremultiplied;
    record.cutoff = static_cast<float>(texture.alpha_cutoff.value_or(0.0));
    if (texture.vertex_tint) out_.features |= gpu::kTexturesTinted;
    if (texture.alpha_cutoff || texture.premultiplied) out_.features |= gpu::kTexturesAlpha;
    return record;
  }

  void flatten_source(const BitmapTexture& picture, const Texture& texture, gpu::TextureRecord& record) {
    // Texels count rows from the top, texture coordinates from the bottom.
    record.v_row = glm::vec3(glm::dvec3(0.0, 0.0, 1.0) - glm::transpose(texture.uv_transform)[1]);
    const Bitmap& bitmap = *scene_.bitmaps[picture.bitmap];
    const ColorSpace color_space = picture.color_space.value_or(bitmap.color_space);
    const bool codes = color_space == ColorSpace::srgb && bitmap.format == BitmapFormat::u8;
    const bool decode = color_space == ColorSpace::srgb && !codes;
    const auto [place, added] = places_.try_emplace({picture.bitmap, decode}, next_place_);
    if (added) add_bitmap(decode ? linear_floats(bitmap) : scene_.bitmaps[picture.bitmap], texture);
    const Bitmap& stored = *placed_[{picture.bitmap, decode}];
    record.first = static_cast<gpu::uint>(place->second);
    record.width = stored.width;
    record.height = stored.height;
    record.header = gpu::kTextureBitmap | static_cast<gpu::uint>(picture.wrap_u) << gpu::kTextureWrapUShift |
                    static_cast<gpu::uint>(picture.wrap_v) << gpu::kTextureWrapVShift | format_bits(stored);
    out_.features |= gpu::kTexturesBitmap;
    const auto feature = [&](bool has, gpu::uint flag, gpu::uint of_all) {
      if (!has) return;
      record.header |= flag;
      out_.features |= of_all;
    };
    feature(picture.filter == TextureFilter::bilinear, gpu::kTextureBilinear, gpu::kTexturesBilinear);
    feature(codes, gpu::kTextureSrgb, gpu::kTexturesSrgb);
    feature(stored.channels == 3, 0u, gpu::kTexturesThreeChannels);
  }
  void flatten_source(const CheckerboardTexture& board, const Texture&, gpu::TextureRecord& record) {
    record.header = gpu::kTextureCheckerboard;
    record.color0 = glm::vec3(board.color0);
    record.color1 = glm::vec3(board.color1);
    record.first = board.texture0.value_or(gpu::kNone);
    record.width = board.texture1.value_or(gpu::kNone);
    out_.features |= gpu::kTexturesCheckerboard;
    if (board.is_nested()) out_.features |= gpu::kTexturesNested;
  }
  void flatten_source(const AttributeTexture& attribute, const Texture&, gpu::TextureRecord& record) {
    const bool faces = attribute.source == AttributeTexture::Source::face_color;
    record.header = faces ? gpu::kTextureFaceColor : gpu::kTextureVertexColor;
    out_.features |= gpu::kTexturesAttribute;
  }

  void add_bitmap(std::shared_ptr<const Bitmap> bitmap, const Texture& texture) {
    constexpr std::uint64_t kAddressable = std::uint64_t{1} << 32;  // bytes of a picture: kernels count them in 32 bits
    const std::uint64_t bytes = bitmap->texels.size();
    next_place_ += (bytes + sizeof(gpu::uvec4) - 1) / sizeof(gpu::uvec4);
    if (bytes >= kAddressable || next_place_ >= kAddressable)
      throw Error(ErrorKind::scene,
                  fmt::format("The picture {} has {} bytes; kernels address fewer than {} in one, and "
                              "16 times as many in all. Use a smaller one or --device reference.",
                              texture.name, bytes, kAddressable));
    const auto* picture = std::get_if<BitmapTexture>(&texture.source);
    placed_[{picture->bitmap, bitmap != scene_.bitmaps[picture->bitmap]}] = bitmap;
    out_.bitmaps.push_back(std::move(bitmap));
  }

  gpu::InstanceAttributes flatten(const Instance& instance) {
    gpu::InstanceAttributes flat{.first = 0, .layout_bits = 0, .radiance_texture = gpu::kNone, .pad0 = 0};
    const AreaEmitter* emitter = scene_.emitter_of(instance);
    if (emitter != nullptr && emitter->radiance.texture) flat.radiance_texture = *emitter->radiance.texture;
    const Needs& needs = needs_[key(instance)];
    if (!needs.any) return flat;
    if (std::holds_alternative<Sphere>(scene_.shape_of(instance))) {
      flat.first = static_cast<gpu::uint>(out_.attributes.size());
      flat.layout_bits = gpu::kAttributesSphere;
      add_rotation(instance);
      return flat;
    }
    if (std::holds_alternative<Disk>(scene_.shape_of(instance))) {
      flat.layout_bits = gpu::kAttributesDisk | (turns_winding(instance) ? gpu::kAttributesTurned : 0u);
      return flat;
    }
    if (const auto* cylinder = std::get_if<Cylinder>(&scene_.shape_of(instance))) {
      flat.first = static_cast<gpu::uint>(out_.attributes.size());
      flat.layout_bits = gpu::kAttributesCylinder;
      add_turn(*cylinder, instance);
      return flat;
    }
    flat.layout_bits = needs.sets | (needs.vertex_colors ? gpu::kAttributesVertexColors : 0u) |
                       (needs.face_colors ? gpu::kAttributesFaceColors : 0u) |
                       (needs.tangents ? gpu::kAttributesTangents : 0u);
    // Tangents are in world space, unless the mesh is shared.
    const auto index = static_cast<std::size_t>(&instance - scene_.instances.data());
    const std::size_t own = needs.tangents && !sharing_.has_instance(index) ? index : scene_.instances.size();
    const auto [place, added] =
        meshes_.try_emplace({key(instance), own}, static_cast<gpu::uint>(out_.attributes.size()));
    flat.first = place->second;
    if (added) add_mesh(instance, needs);
    return flat;
  }

  /// Rows of the rotation or reflection from the world into the sphere's space. Normals that point inward are reversed.
  void add_rotation(const Instance& instance) {
    const glm::dmat3 axes(instance.world_from_object);
    for (int row = 0; row < 3; ++row) {
      const glm::dvec3 axis = glm::normalize(axes[row]);
      out_.attributes.emplace_back(glm::vec3(instance.flip_normals ? -axis : axis), 0.0f);
    }
  }

  /// The direction where angles around a cylinder begin, and the one a quarter turn further; normals that point inward
  /// are reversed.
  void add_turn(const Cylinder& cylinder, const Instance& instance) {
    const glm::dvec3 axis = glm::normalize(cylinder.p1 - cylinder.p0);
    // Source: [Duff2017], listing 3.
    const double sign = axis.z >= 0.0 ? 1.0 : -1.0;
    const double a = -1.0 / (sign + axis.z), b = axis.x * axis.y * a;
    const glm::dvec3 s(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    const glm::dvec3 t(b, sign + axis.y * axis.y * a, -axis.y);
    const glm::dmat3 axes(instance.world_from_object);
    const double side = instance.flip_normals ? -1.0 : 1.0;
    for (const glm::dvec3& v : {s, t}) out_.attributes.emplace_back(glm::vec3(side * glm::normalize(axes * v)), 0.0f);
  }

  void add_mesh(const Instance& instance, const Needs& needs) {
    const auto& mesh = std::get<TriangleMesh>(scene_.shape_of(instance));
    const bool turned = key(instance).second;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      glm::uvec3 t = mesh.triangles[i];
      if (turned) std::swap(t.y, t.z);
      for (std::uint32_t set = 0; set < needs.sets; ++set) {
        const std::vector<glm::vec2>& uvs = mesh.uv_sets[set];
        out_.attributes.emplace_back(uvs[t.x], uvs[t.y]);
        out_.attributes.emplace_back(uvs[t.z], 0.0f, 0.0f);
      }
      for (int k = 0; k < 3 && needs.vertex_colors; ++k)
        out_.attributes.emplace_back(mesh.vertex_colors[t[k]],
                                     mesh.vertex_alphas.empty() ? 1.0f : mesh.vertex_alphas[t[k]]);
      if (needs.face_colors) out_.attributes.emplace_back(mesh.face_colors[i], 0.0f);
      for (int k = 0; k < 3 && needs.tangents; ++k)
        out_.attributes.push_back(placed_tangent(instance, mesh.tangents[t[k]]));
    }
  }

  gpu::vec4 placed_tangent(const Instance& instance, const glm::vec4& tangent) const {
    const auto index = static_cast<std::size_t>(&instance - scene_.instances.data());
    if (sharing_.has_instance(index)) return tangent;
    // Only directions matter: the lengths are scaled to suit single precision, by the same factor for the whole
    // instance.
    const glm::dmat3 linear(instance.world_from_object);
    const double size = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
    return {glm::vec3(linear * (glm::dvec3(tangent) / size)), turns_winding(instance) ? -tangent.w : tangent.w};
  }

  using BitmapUse = std::pair<std::uint32_t, bool>;  // index, and whether its floats were decoded
  const Scene& scene_;
  Sharing sharing_;
  CompiledTextures out_;
  bool textured_ = false;
  std::map<std::pair<std::uint32_t, bool>, Needs> needs_;
  // First texel of the attributes, for each shape, or for one instance if it must be.
  std::map<std::pair<std::pair<std::uint32_t, bool>, std::size_t>, gpu::uint> meshes_;
  std::map<BitmapUse, std::uint64_t> places_;  // in multiples of 16 bytes
  std::map<BitmapUse, std::shared_ptr<const Bitmap>> placed_;
  std::uint64_t next_place_ = 0;
};

}  // namespace

CompiledTextures compile_textures(const Scene& scene) {
  return TextureCompiler(scene).compile();
}

}  // namespace etendue
