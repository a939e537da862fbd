/// Surfaces that emit the same radiance in all directions on the side of the shading normal.

#include <algorithm>
#include <array>
#include <cmath>

#include "reference/delta_light.h"
#include "reference/frame.h"
#include "reference/intersect.h"
#include "reference/lights.h"
#include "reference/sampling.h"
#include "reference/texture.h"
#include "render/renderer.h"
#include "scene/sharing.h"

namespace etendue::reference {
namespace {

/// Whether an inward sphere illuminates a point: one inside, or on the sphere within rounding.
bool is_inside(const Sphere& sphere, const Vec3& from) {
  const double slack = 1e-12 * (largest_coordinate(sphere.center) + sphere.radius);
  return glm::distance(from, sphere.center) < sphere.radius + slack;
}

/// A point of a sphere that emits inward, uniform in the directions from a point inside.
void sample_sphere_from_inside(const Sphere& sphere, double prob, const Vec3& from, const SampleRandom::Light& random,
                               LightSample& sample) {
  const Vec3 to_center = sphere.center - from;
  const double distance = glm::length(to_center);
  if (!is_inside(sphere, from)) return;  // nothing is emitted outward
  const double z = 1.0 - 2.0 * random.u, r = std::sqrt(std::max(0.0, 1.0 - z * z)), phi = 2.0 * kPi * random.v;
  const Vec3 local(r * std::cos(phi), r * std::sin(phi), z);
  sample.wi = Frame(distance > 0.0 ? to_center / distance : Vec3(0, 0, 1)).to_world(local);
  const double along = glm::dot(to_center, sample.wi);
  const double half_chord =
      std::sqrt(std::max(0.0, sphere.radius * sphere.radius - distance * distance + along * along));
  const Vec3 outward = glm::normalize((along + half_chord) * sample.wi - to_center);
  sample.surface.ng = sample.surface.ns = -outward;
  sample.surface.p = sphere.center + sphere.radius * outward;
  sample.surface.magnitude = largest_coordinate(sphere.center) + sphere.radius;
  sample.pdf_w = sample.pdf_w_mis = prob / (4.0 * kPi);
}

/// A point of the sphere, uniform in the solid angle that the sphere subtends from outside.
void sample_sphere(const Sphere& sphere, double prob, const Vec3& from, const SampleRandom::Light& random,
                   LightSample& sample) {
  const Vec3 to_center = sphere.center - from;
  const double distance = glm::length(to_center);
  if (distance <= sphere.radius) return;  // nothing is emitted inward
  const SphereCone cone(sphere.radius, distance);
  const Vec3 local = cone.sample({random.u, random.v});
  sample.wi = Frame(to_center / distance).to_world(local);
  // Nearer intersection: distance · cos θ minus half the chord; at the limb rounding may leave no chord.
  const double sin2 = local.x * local.x + local.y * local.y;
  const double half_chord = std::sqrt(std::max(0.0, sphere.radius * sphere.radius - distance * distance * sin2));
  const Vec3 point = from + (distance * local.z - half_chord) * sample.wi;
  const Vec3 normal = glm::normalize(point - sphere.center);
  sample.surface.ng = sample.surface.ns = normal;
  sample.surface.p = sphere.center + sphere.radius * normal;
  sample.surface.magnitude = largest_coordinate(sphere.center) + sphere.radius;
  sample.pdf_w = sample.pdf_w_mis = prob * cone.pdf_w();
}

double primitive_area(const Scene& scene, const AreaLight& light, std::uint32_t primitive) {
  const auto* mesh = std::get_if<TriangleMesh>(&scene.shape_of(scene.instances[light.instance]));
  if (mesh == nullptr) return light.area;
  const auto [p0, p1, p2] = light.placement.triangle(*mesh, primitive);
  return triangle_area(p0, p1, p2);
}

/// Of a primitive, or a part of one.
double entry_area(const Scene& scene, const AreaLight& light, std::uint32_t entry) {
  const double side = 1.0 / light.cells_of(entry);
  return primitive_area(scene, light, light.triangle_of(entry)) * side * side;
}

/// The area over which a choice by object-space area spreads the probability of the instance, at one of its triangles:
/// the area of the mesh, scaled in the same ratio as the triangle.
double stretched_area(const Scene& scene, const AreaLight& light, std::uint32_t primitive) {
  const auto& mesh = std::get<TriangleMesh>(scene.shape_of(scene.instances[light.instance]));
  const glm::uvec3 t = mesh.triangles[primitive];
  const double object = triangle_area(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]);
  return light.shared->area() * (primitive_area(scene, light, primitive) / object);
}

}  // namespace

Lights::Chosen Lights::choose_shared(const Scene& scene, const AreaLight& light, double prob, std::uint32_t word) {
  const std::size_t triangle = light.shared->triangles().choose(word);
  Chosen chosen{.light = &light, .primitive = static_cast<std::uint32_t>(triangle), .prob = prob};
  chosen.pdf_a = prob * light.shared->triangles().prob(triangle) / primitive_area(scene, light, chosen.primitive);
  chosen.pdf_a_mis = prob / stretched_area(scene, light, chosen.primitive);
  return chosen;
}

void Lights::choose_part(const AreaLight& light, std::uint32_t entry, Chosen& chosen) {
  chosen.primitive = light.triangle_of(entry);
  if (light.parts.empty()) return;
  const std::uint32_t n = light.cells_of(entry), cell = entry - light.parts.first[chosen.primitive];
  chosen.side = 1.0 / n;
  chosen.corner = Vec2(cell / n, cell % n) * chosen.side;
}

std::optional<Lights::Chosen> Lights::choose(const Scene& scene, const Vec3& from, const Vec3& ns,
                                             const SampleRandom::Light& random) const {
  if (!tree_.empty()) {
    const LightTree::Choice choice = tree_.choose(from, ns, random.emitter, random.primitive);
    if (choice.leaf == nullptr) return std::nullopt;
    if (choice.leaf->light >= lights_.size())
      return Chosen{.delta = deltas_[choice.leaf->light - lights_.size()], .prob = choice.prob};
    const AreaLight& light = lights_[choice.leaf->light];
    constexpr std::uint32_t kTriangleLevel = 36;
    if (light.shared) return choose_shared(scene, light, choice.prob, hashed_word(kTriangleLevel, random.primitive));
    Chosen chosen{.light = &light, .prob = choice.prob};
    choose_part(light, choice.leaf->primitive, chosen);
    chosen.pdf_a = choice.prob / entry_area(scene, light, choice.leaf->primitive);
    chosen.pdf_a_mis = chosen.pdf_a;
    return chosen;
  }
  const std::size_t index = choice_.choose(random.emitter);
  if (index >= lights_.size()) return Chosen{.delta = deltas_[index - lights_.size()], .prob = choice_.prob(index)};
  const AreaLight& light = lights_[index];
  if (light.shared) return choose_shared(scene, light, choice_.prob(index), random.primitive);
  Chosen chosen{.light = &light, .prob = choice_.prob(index)};
  if (light.triangles.empty()) return chosen;
  const auto entry = static_cast<std::uint32_t>(light.triangles.choose(random.primitive));
  choose_part(light, entry, chosen);
  chosen.pdf_a = chosen.prob * light.triangles.prob(entry) / entry_area(scene, light, entry);
  chosen.pdf_a_mis = light.parts.empty() ? chosen.prob / light.area : chosen.pdf_a;
  return chosen;
}

void Lights::sample_triangle(const TriangleMesh& mesh, const Chosen& chosen, const Vec3& from,
                             const SampleRandom::Light& random, LightSample& sample) const {
  const std::array<Vec3, 3> p = chosen.light->placement.triangle(mesh, chosen.primitive);
  Vec3 b = square_to_triangle(chosen.corner + chosen.side * Vec2(random.u, random.v));
  // For a shared mesh, the weights are those of the vertices in their original order.
  const bool shared = chosen.light->shared != nullptr;
  if (shared && chosen.light->placement.turned()) std::swap(b.y, b.z);
  sample.surface.p = b.x * p[0] + b.y * p[1] + b.z * p[2];
  sample.surface.ng = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
  sample.surface.weights = b;
  sample.surface.ns = chosen.light->placement.shading_normal(mesh, chosen.primitive, b, sample.surface.ng);
  for (const Vec3& vertex : p)
    sample.surface.magnitude = std::max(sample.surface.magnitude, largest_coordinate(vertex));

  see_from(from, chosen, shared, sample);
}

/// A point of a disk or cylinder, uniform by area.
void Lights::sample_round(const Shape& shape, Chosen chosen, const Vec3& from, const SampleRandom::Light& random,
                          LightSample& sample) const {
  const AreaLight& light = *chosen.light;
  chosen.pdf_a = chosen.pdf_a_mis = chosen.prob / light.area;
  Surface& surface = sample.surface;
  if (const auto* object = std::get_if<Cylinder>(&shape)) {
    const Tube tube = light.placement.cylinder(*object);
    const double phi = 2.0 * kPi * random.v;
    const Vec3 outward = Frame(tube.axis).to_world(Vec3(std::cos(phi), std::sin(phi), 0.0));
    surface.p = tube.base + random.u * tube.height * tube.axis + tube.radius * outward;
    surface.ng = surface.ns = tube.side * outward;
    surface.magnitude = largest_coordinate(tube.base) + tube.height + tube.radius;
  } else {
    const Ellipse disk = light.placement.disk();
    const Vec2 xy = square_to_disk({random.u, random.v});
    surface.p = disk.center + xy.x * disk.a + xy.y * disk.b;
    surface.ng = surface.ns = disk.normal();
    surface.magnitude = largest_coordinate(disk.center) + largest_coordinate(disk.a) + largest_coordinate(disk.b);
  }
  see_from(from, chosen, false, sample);
}

/// Converts a density by area to one by solid angle.
void Lights::see_from(const Vec3& from, const Chosen& chosen, bool shared, LightSample& sample) {
  const Vec3 to_light = sample.surface.p - from;
  const double distance = glm::length(to_light);
  if (shared) sample.surface.magnitude = kMostCondition * (sample.surface.magnitude + distance);
  if (distance == 0.0) return;
  sample.wi = to_light / distance;
  if (!chosen.light->two_sided && glm::dot(sample.wi, sample.surface.ns) >= 0.0) return;  // seen from behind
  const double cos_light = std::abs(glm::dot(sample.wi, sample.surface.ng));
  if (cos_light == 0.0) return;  // seen edge-on
  const double area_to_solid_angle = distance * distance / cos_light;
  sample.pdf_w = chosen.pdf_a * area_to_solid_angle;
  sample.pdf_w_mis = chosen.pdf_a_mis * area_to_solid_angle;
}

/// The sampled point itself, whose surface must not occlude it.
LightSample Lights::sample_delta(const Scene& scene, std::uint32_t number, double prob, const Vec3& from) {
  const DeltaLight& light = scene.delta_lights[number];
  LightSample sample;
  sample.instance = PathVertex::kDeltaLight;
  sample.primitive = number;
  sample.delta = true;
  sample.surface.p = light.origin();
  const Vec3 to_light = sample.surface.p - from;
  const double distance = glm::length(to_light);
  if (!(distance > 0.0)) return sample;
  sample.wi = to_light / distance;
  sample.pdf_w = prob;
  sample.radiance = intensity(scene, light, -sample.wi) / (distance * distance);
  return sample;
}

std::optional<LightSample> Lights::sample(const Scene& scene, const Vec3& from, const Vec3& ns,
                                          const SampleRandom::Light& random) const {
  const std::optional<Chosen> chosen = choose(scene, from, ns, random);
  if (!chosen) return std::nullopt;
  if (chosen->delta) return sample_delta(scene, *chosen->delta, chosen->prob, from);
  LightSample sample;
  sample.instance = sample.surface.instance = chosen->light->instance;
  sample.primitive = sample.surface.primitive = chosen->primitive;
  const Shape& shape = scene.shape_of(scene.instances[sample.instance]);
  if (const auto* sphere = std::get_if<Sphere>(&shape))
    (scene.instances[sample.instance].flip_normals ? sample_sphere_from_inside : sample_sphere)(
        chosen->light->placement.sphere(*sphere), chosen->prob, from, random, sample);
  else if (const auto* mesh = std::get_if<TriangleMesh>(&shape))
    sample_triangle(*mesh, *chosen, from, random, sample);
  else
    sample_round(shape, *chosen, from, random, sample);
  if (sample.pdf_w > 0.0)
    sample.radiance = at_point(scene, scene.emitter_of(scene.instances[sample.instance])->radiance, sample.surface);
  return sample;
}

double Lights::pdf_w_mis(const Scene& scene, const Vec3& from, const Vec3& ns, const Surface& at) const {
  const std::optional<std::size_t> index = of_instance_[at.instance];
  if (!index) return 0.0;
  const AreaLight& light = lights_[*index];
  // With the choice by power, the MIS weights treat all triangles of an instance as one, using its probability and its
  // area, unless it is divided into parts.
  const bool by_tree = !tree_.empty();
  const bool by_entry = by_tree || !light.parts.empty();
  const double prob_light = by_tree && light.shared ? tree_.prob(from, ns, static_cast<std::uint32_t>(*index), 0)
                            : by_entry              ? prob(from, ns, at.instance, at.primitive, at.weights)
                                                    : choice_.prob(*index);
  const double area = light.shared ? stretched_area(scene, light, at.primitive)
                      : by_entry   ? entry_area(scene, light, light.entry_at(at.primitive, at.weights))
                                   : light.area;
  if (const auto* object = std::get_if<Sphere>(&scene.shape_of(scene.instances[at.instance]))) {
    const Sphere sphere = light.placement.sphere(*object);
    const double distance = glm::length(sphere.center - from);
    if (scene.instances[at.instance].flip_normals) return is_inside(sphere, from) ? prob_light / (4.0 * kPi) : 0.0;
    return distance <= sphere.radius ? 0.0 : prob_light * SphereCone(sphere.radius, distance).pdf_w();
  }
  const Vec3 to_light = at.p - from;
  const double distance2 = glm::dot(to_light, to_light);
  const double cos_light = std::abs(glm::dot(to_light, at.ng)) / std::sqrt(distance2);
  return cos_light == 0.0 ? 0.0 : prob_light / area * distance2 / cos_light;
}

Vec3 emitted_radiance(const Scene& scene, const Surface& surface, const Vec3& wo) {
  const AreaEmitter* emitter = scene.emitter_of(scene.instances[surface.instance]);
  const bool shines = emitter != nullptr && (emitter->two_sided || glm::dot(surface.ns, wo) > 0.0);
  return shines ? at_point(scene, emitter->radiance, surface) : Vec3(0.0);
}

}  // namespace etendue::reference
