#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

#include <xxhash.h>

#include "scene/bounds.h"
#include "scene/materials.h"
#include "scene/parameters.h"
#include "scene/sharing.h"

namespace etendue {
namespace {

/// XXH3 over a sequence of values. Lengths and variant indices go in as well, so that different scenes cannot run
/// into the same bytes.
class Hasher {
 public:
  Hasher() { XXH3_64bits_reset(state_.get()); }

  void bytes(const void* data, std::size_t size) { XXH3_64bits_update(state_.get(), data, size); }
  template <typename T>
  void value(const T& v) {
    // Structs could have padding, whose bytes mean nothing.
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    bytes(&v, sizeof v);
  }
  void value(const glm::dvec3& v) { bytes(&v, sizeof v); }
  template <typename T>
  void list(const std::vector<T>& values) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_same_v<T, glm::dvec3> ||
                  std::is_same_v<T, glm::vec3> || std::is_same_v<T, glm::vec2> || std::is_same_v<T, glm::vec4> ||
                  std::is_same_v<T, float>);
    value(values.size());
    bytes(values.data(), values.size() * sizeof(T));
  }
  void list(const VectorList& vectors) {
    value(vectors.size());
    for (const glm::dvec3& v : vectors) bytes(&v, sizeof v);
  }
  std::uint64_t digest() const { return XXH3_64bits_digest(state_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_{XXH3_createState()};
};
static_assert(sizeof(glm::vec4) == 16 && sizeof(glm::dvec3) == 24 && sizeof(glm::vec3) == 12 &&
              sizeof(glm::vec2) == 8 && sizeof(glm::uvec3) == 12);

void hash(Hasher& h, const TriangleMesh& mesh) {
  h.list(mesh.positions);
  h.list(mesh.normals);
  h.value(mesh.uv_sets.size());
  for (const std::vector<glm::vec2>& uvs : mesh.uv_sets) h.list(uvs);
  h.list(mesh.vertex_colors);
  if (!mesh.vertex_alphas.empty()) h.list(mesh.vertex_alphas);
  if (!mesh.tangents.empty()) h.list(mesh.tangents);
  h.list(mesh.face_colors);
  h.list(mesh.triangles);
}
void hash(Hasher& h, const Sphere& sphere) {
  h.value(sphere.center);
  h.value(sphere.radius);
}
void hash(Hasher&, const Disk&) {}
void hash(Hasher& h, const Cylinder& cylinder) {
  h.value(cylinder.p0);
  h.value(cylinder.p1);
  h.value(cylinder.radius);
}
void hash(Hasher& h, const ColorParameter& parameter) {
  h.value(parameter.value);
  if (parameter.texture) h.value(*parameter.texture);
}
void hash(Hasher& h, const ScalarParameter& parameter) {
  h.value(parameter.value);
  if (!parameter.texture) return;
  h.value(*parameter.texture);
  h.value(parameter.channel);
}
void hash(Hasher& h, const PrincipledBsdf& bsdf) {
  each_parameter(bsdf, [&](const char*, const auto& parameter) { hash(h, parameter); });
}
void hash(Hasher& h, const PrincipledThinBsdf& bsdf) {
  each_parameter(bsdf, [&](const char*, const auto& parameter) { hash(h, parameter); });
}
void hash(Hasher& h, const GltfBsdf& bsdf) {
  if (bsdf.dispersion != 0.0) h.value(bsdf.dispersion);
  if (bsdf.coat_keeps_normal) h.value(bsdf.coat_vertex_tangents);
  each_parameter(bsdf, [&](const char*, const auto& parameter) { hash(h, parameter); });
  h.value(bsdf.anisotropy_rotation);
  h.value(bsdf.thin);
  h.value(bsdf.attenuation_color);
  h.value(bsdf.attenuation_distance);
}
void hash(Hasher& h, const DiffuseBsdf& bsdf) {
  hash(h, bsdf.albedo);
}
void hash(Hasher&, const MirrorBsdf&) {}
void hash(Hasher&, const NullBsdf&) {}
void hash(Hasher& h, const DielectricBsdf& bsdf) {
  h.value(bsdf.int_ior);
  h.value(bsdf.ext_ior);
  if (!is_tinted(bsdf)) return;  // scenes of before keep their hashes
  hash(h, bsdf.specular_reflectance);
  hash(h, bsdf.specular_transmittance);
}

void hash(Hasher& h, const Roughness& roughness) {
  h.value(roughness.distribution);
  hash(h, roughness.alpha_u);
  hash(h, roughness.alpha_v);
}
void hash(Hasher& h, const ConductorIndex& index) {
  hash(h, index.eta);
  hash(h, index.k);
}
void hash(Hasher& h, const MicrofacetBsdf& bsdf) {
  hash(h, bsdf.kd);
  hash(h, bsdf.alpha);
  h.value(bsdf.int_ior);
  h.value(bsdf.ext_ior);
}
void hash(Hasher& h, const ConductorBsdf& bsdf) {
  hash(h, bsdf.index);
  hash(h, bsdf.specular_reflectance);
}
void hash(Hasher& h, const RoughConductorBsdf& bsdf) {
  hash(h, bsdf.index);
  hash(h, bsdf.roughness);
  hash(h, bsdf.specular_reflectance);
}

void hash(Hasher& h, const RoughDielectricBsdf& bsdf) {
  h.value(bsdf.int_ior);
  h.value(bsdf.ext_ior);
  hash(h, bsdf.roughness);
  hash(h, bsdf.specular_reflectance);
  hash(h, bsdf.specular_transmittance);
}
void hash(Hasher& h, const ThinDielectricBsdf& bsdf) {
  h.value(bsdf.int_ior);
  h.value(bsdf.ext_ior);
  hash(h, bsdf.specular_reflectance);
  hash(h, bsdf.specular_transmittance);
}
void hash(Hasher& h, const PlasticBsdf& bsdf) {
  hash(h, bsdf.diffuse_reflectance);
  hash(h, bsdf.specular_reflectance);
  h.value(bsdf.int_ior);
  h.value(bsdf.ext_ior);
  h.value(bsdf.nonlinear);
}
void hash(Hasher& h, const RoughPlasticBsdf& bsdf) {
  hash(h, bsdf.diffuse_reflectance);
  hash(h, bsdf.specular_reflectance);
  h.value(bsdf.int_ior);
  h.value(bsdf.ext_ior);
  h.value(bsdf.nonlinear);
  h.value(bsdf.distribution);
  hash(h, bsdf.alpha);
}

template <typename... Ts>
void hash(Hasher& h, const std::variant<Ts...>& variant) {
  h.value(variant.index());
  std::visit([&](const auto& value) { hash(h, value); }, variant);
}

void hash(Hasher&, const TwoSidedAdapter&) {}
void hash(Hasher& h, const MaskAdapter& mask) {
  hash(h, mask.opacity);
}
void hash(Hasher& h, const BlendAdapter& blend) {
  hash(h, blend.weight);
}
void hash(Hasher& h, const TurnedNormals& turned) {
  if (turned == TurnedNormals{}) return;
  h.value(turned.mirrored);
  h.value(turned.shadowed);
}
void hash(Hasher& h, const NormalMapAdapter& map) {
  hash(h, map.normals);
  if (map.vertex_tangents) h.value(map.vertex_tangents);
  hash(h, map.turned);
}
void hash(Hasher& h, const BumpMapAdapter& map) {
  hash(h, map.height);
  hash(h, map.turned);
}

/// The hash of each row: for an adapter, a digest that includes those of its candidates.
std::vector<std::uint64_t> adapter_digests(const Scene& scene) {
  std::vector<std::uint64_t> digests;
  for (const Material& material : scene.materials) {
    Hasher h;
    if (material.adapter) {
      hash(h, *material.adapter);
      each_choice(*material.adapter, [&](std::uint32_t row) { h.value(digests[row]); });
    } else {
      hash(h, material.bsdf);
    }
    digests.push_back(h.digest());
  }
  return digests;
}

void hash(Hasher& h, const glm::dmat4& matrix) {
  for (int column = 0; column < 4; ++column) h.bytes(&matrix[column], 4 * sizeof(double));
}

/// Settings that plain cameras lack are hashed only if present, so that plain cameras keep their hash.
void hash_rest(Hasher& h, const Camera& camera) {
  const FilmWindow& window = camera.window;
  if (camera.type == Camera::Type::perspective && camera.fov_axis == Camera::FovAxis::x && window.whole()) return;
  h.value(camera.type);
  h.value(camera.fov_axis);
  for (const glm::dvec2& v : {window.origin, window.size, window.principal_offset}) {
    h.value(v.x);
    h.value(v.y);
  }
  if (camera.type != Camera::Type::thin_lens) return;
  h.value(camera.aperture.radius);
  h.value(camera.aperture.focus_distance);
  h.value(camera.aperture.blades);
  h.value(camera.aperture.rotation);
}

void hash(Hasher& h, const BitmapTexture& texture) {
  h.value(texture.bitmap);
  h.value(texture.wrap_u);
  h.value(texture.wrap_v);
  h.value(texture.filter);
  h.value(texture.color_space.has_value());
  if (texture.color_space) h.value(*texture.color_space);
}
void hash(Hasher& h, const CheckerboardTexture& texture) {
  h.value(texture.color0);
  h.value(texture.color1);
  if (!texture.is_nested()) return;
  constexpr std::uint32_t kNothing = 0xffffffff;
  h.value(texture.texture0.value_or(kNothing));
  h.value(texture.texture1.value_or(kNothing));
}
void hash(Hasher& h, const AttributeTexture& texture) {
  h.value(texture.source);
}

void hash(Hasher& h, const Texture& texture) {
  hash(h, texture.source);
  for (int column = 0; column < 3; ++column) h.value(texture.uv_transform[column]);
  h.value(texture.uv_set);
  if (!texture.is_derived()) return;
  h.value(texture.vertex_tint);
  h.value(texture.alpha_cutoff.has_value());
  if (texture.alpha_cutoff) h.value(*texture.alpha_cutoff);
  h.value(texture.premultiplied);
}

void hash(Hasher& h, const Bitmap& bitmap) {
  h.value(bitmap.width);
  h.value(bitmap.height);
  h.value(bitmap.channels);
  h.value(bitmap.format);
  h.value(bitmap.color_space);
  h.bytes(bitmap.texels.data(), bitmap.texels.size());
}

/// A gradient that is not turned goes in as it always did.
void hash(Hasher& h, const Sky& sky) {
  h.value(sky.top);
  h.value(sky.horizon);
  const bool turned = sky.world_from_sky != glm::dmat3(1.0);
  if (turned) {
    h.value('T');
    for (int column = 0; column < 3; ++column) h.value(glm::dvec3(sky.world_from_sky[column]));
  }
  if (!sky.picture) return;
  h.value('P');
  hash(h, *sky.picture->bitmap);
  h.value(sky.picture->scale);
  h.value(sky.picture->rows);
}

void hash(Hasher& h, const DeltaLight& light) {
  h.value(light.type);
  hash(h, light.intensity);
  hash(h, light.world_from_light);
  h.value(light.cutoff);
  h.value(light.beam_width);
  h.value(light.falloff);
  h.value(light.slope.x);
  h.value(light.slope.y);
}

void hash(Hasher& h, const Camera& camera) {
  h.value(camera.fov);
  h.value(camera.near_clip);
  h.value(camera.far_clip);
  hash(h, camera.world_from_camera);
  h.value(camera.filter.type);
  h.value(camera.filter.radius);
  h.value(camera.filter.stddev);
  h.value(camera.filter.b);
  h.value(camera.filter.c);
  // Later settings of filters are hashed only if used, so that older scenes keep their hashes.
  if (camera.filter.stretch != 1.0) h.value(camera.filter.stretch);
  if (camera.filter.type == ReconstructionFilter::Type::lanczos) h.value(camera.filter.lobes);
  hash_rest(h, camera);
}

}  // namespace

Instance& Scene::add(Shape shape, Bsdf bsdf, std::optional<AreaEmitter> emitter) {
  Instance instance{.shape = static_cast<std::uint32_t>(shapes.size()),
                    .material = static_cast<std::uint32_t>(materials.size())};
  shapes.push_back(std::move(shape));
  materials.push_back({.bsdf = bsdf});
  if (emitter) {
    instance.emitter = static_cast<std::uint32_t>(emitters.size());
    emitters.push_back(std::move(*emitter));
  }
  return instances.emplace_back(std::move(instance));
}

std::size_t primitive_count(const Shape& shape) {
  const auto* mesh = std::get_if<TriangleMesh>(&shape);
  return mesh != nullptr ? mesh->triangles.size() : 1;
}

bool may_pass(const Scene& scene, std::uint32_t row) {
  bool passes = false;
  each_material(scene, row, [&](const Material& material) {
    passes |= material.adapter ? std::holds_alternative<MaskAdapter>(*material.adapter)
                               : std::holds_alternative<NullBsdf>(material.bsdf);
  });
  return passes;
}

bool may_pass(const Scene& scene) {
  return std::ranges::any_of(scene.instances, [&](const Instance& i) { return may_pass(scene, i.material); });
}

std::uint64_t scene_hash(const Scene& scene) {
  Hasher h;
  hash(h, scene.camera);
  h.value(scene.sampler.type);
  if (scene.sampler.type == Sampler::Type::sobol) h.value(scene.sampler.set_bits);
  hash(h, scene.sky);
  h.value(scene.shapes.size());
  for (const Shape& shape : scene.shapes) hash(h, shape);
  // Lights of shared meshes are chosen otherwise: other samples.
  if (Sharing(scene).any()) h.value(scene.instancing);
  const std::vector<std::uint64_t> adapters = adapter_digests(scene);
  h.value(scene.instances.size());
  for (const Instance& instance : scene.instances) {
    h.value(instance.shape);
    hash(h, instance.world_from_object);
    h.value(instance.flip_normals);
    if (scene.materials[instance.material].adapter) {
      h.value('A');
      h.value(adapters[instance.material]);
    } else {
      hash(h, scene.bsdf_of(instance));
    }
    h.value(instance.emitter.has_value());
    if (const AreaEmitter* emitter = scene.emitter_of(instance)) {
      hash(h, emitter->radiance);
      if (emitter->two_sided) h.value(emitter->two_sided);
    }
  }
  for (const DeltaLight& light : scene.delta_lights) hash(h, light);
  // Nothing where there is none: scenes without textures have the numbers they had before there were any.
  for (const Texture& texture : scene.textures) hash(h, texture);
  for (const auto& bitmap : scene.bitmaps) hash(h, *bitmap);
  return h.digest();
}

bool gathers_light(const Integrator& integrator) {
  using enum Integrator::Type;
  return integrator.type == path || integrator.type == direct || integrator.type == whitted;
}

bool samples_lights(const Integrator& integrator) {
  using enum Integrator::Type;
  if (integrator.type == direct) return integrator.emitter_samples > 0;
  return integrator.type == whitted || (integrator.type == path && integrator.nee);
}

bool weighs_strategies(const Integrator& integrator) {
  using enum Integrator::Type;
  if (integrator.type == direct) return integrator.emitter_samples > 0 && integrator.bsdf_samples > 0;
  return integrator.type == path && integrator.nee && integrator.mis;
}

bool counts_passes(const Integrator& integrator) {
  using enum Integrator::Type;
  return integrator.type == whitted || ((integrator.type == path || integrator.type == aov) && integrator.count_passes);
}

bool uses_light_tree(const Scene& scene) {
  return samples_lights(scene.integrator) && wants_light_tree(scene);
}

bool wants_light_tree(const Scene& scene) {
  using enum Integrator::LightSampler;
  if (scene.integrator.light_sampler != automatic) return scene.integrator.light_sampler == tree;
  std::size_t primitives = 0;
  for (const Instance& instance : scene.instances) {
    if (instance.emitter) primitives += primitive_count(scene.shape_of(instance));
  }
  for (const DeltaLight& light : scene.delta_lights) primitives += light.type != DeltaLight::Type::directional ? 1 : 0;
  return primitives >= kManyLights;
}

}  // namespace etendue
