#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

#include <xxhash.h>

namespace etendue {
namespace {

/// XXH3 over a sequence of values. Lengths and variant indices go in as well, so that different scenes cannot run into
/// the same bytes.
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
    static_assert(std::has_unique_object_representations_v<T> || std::is_same_v<T, glm::dvec3>);
    value(values.size());
    bytes(values.data(), values.size() * sizeof(T));
  }
  std::uint64_t digest() const { return XXH3_64bits_digest(state_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_{XXH3_createState()};
};
static_assert(sizeof(glm::dvec3) == 24 && sizeof(glm::uvec3) == 12);

void hash(Hasher& h, const TriangleMesh& mesh) {
  h.list(mesh.positions);
  h.list(mesh.normals);
  h.list(mesh.triangles);
}
void hash(Hasher& h, const Sphere& sphere) {
  h.value(sphere.center);
  h.value(sphere.radius);
}
void hash(Hasher& h, const DiffuseBsdf& bsdf) {
  h.value(bsdf.albedo);
}
void hash(Hasher&, const MirrorBsdf&) {}
void hash(Hasher& h, const DielectricBsdf& bsdf) {
  h.value(bsdf.int_ior);
  h.value(bsdf.ext_ior);
}

template <typename... Ts>
void hash(Hasher& h, const std::variant<Ts...>& variant) {
  h.value(variant.index());
  std::visit([&](const auto& value) { hash(h, value); }, variant);
}

void hash(Hasher& h, const Camera& camera) {
  h.value(camera.fov);
  h.value(camera.near_clip);
  h.value(camera.far_clip);
  for (int column = 0; column < 4; ++column) h.bytes(&camera.world_from_camera[column], 4 * sizeof(double));
  h.value(camera.filter.type);
  h.value(camera.filter.radius);
  h.value(camera.filter.stddev);
  h.value(camera.filter.b);
  h.value(camera.filter.c);
}

double largest_component(const glm::dvec3& v) {
  return std::max({v.x, v.y, v.z});
}

}  // namespace

double triangle_area(const TriangleMesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 &p0 = mesh.positions[t.x], &p1 = mesh.positions[t.y], &p2 = mesh.positions[t.z];
  return 0.5 * glm::length(glm::cross(p1 - p0, p2 - p0));
}

std::uint64_t scene_hash(const Scene& scene) {
  Hasher h;
  hash(h, scene.camera);
  h.value(scene.sampler.type);
  if (scene.sampler.type == Sampler::Type::sobol) h.value(scene.sampler.set_bits);
  h.value(scene.sky.top);
  h.value(scene.sky.horizon);
  h.value(scene.shapes.size());
  for (const Shape& shape : scene.shapes) {
    hash(h, shape.geometry);
    hash(h, shape.bsdf);
    h.value(shape.emitter.has_value());
    if (shape.emitter) h.value(shape.emitter->radiance);
  }
  return h.digest();
}

bool uses_light_tree(const Scene& scene) {
  return scene.integrator.type == Integrator::Type::path && scene.integrator.nee && wants_light_tree(scene);
}

bool wants_light_tree(const Scene& scene) {
  using enum Integrator::LightSampler;
  if (scene.integrator.light_sampler != automatic) return scene.integrator.light_sampler == tree;
  std::size_t primitives = 0;
  for (const Shape& shape : scene.shapes) {
    if (!shape.emitter) continue;
    const auto* mesh = std::get_if<TriangleMesh>(&shape.geometry);
    primitives += mesh != nullptr ? mesh->triangles.size() : 1;
  }
  return primitives >= kManyLights;
}

int film_exponent(const Scene& scene) {
  return film_exponent(scene, scene.integrator.type);
}

int film_exponent(const Scene& scene, Integrator::Type integrator) {
  if (integrator == Integrator::Type::normals) return 0;
  double largest = std::max(largest_component(scene.sky.top), largest_component(scene.sky.horizon));
  for (const Shape& shape : scene.shapes) {
    if (shape.emitter) largest = std::max(largest, largest_component(shape.emitter->radiance));
  }
  if (!(largest > 0.0)) return 0;
  int exponent = 0;
  const double mantissa = std::frexp(largest, &exponent);  // largest = mantissa · 2^exponent, mantissa in [1/2, 1)
  return mantissa == 0.5 ? exponent - 1 : exponent;
}

}  // namespace etendue
