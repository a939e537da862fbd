#include "reference/lights.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "reference/delta_light.h"
#include "reference/intersect.h"
#include "reference/sampling.h"
#include "scene/sharing.h"
#include "scene/texture_facts.h"

namespace etendue::reference {

namespace {

/// Meshes as lights, by shape; created when the first instance needs it.
using SharedLights = std::map<std::uint32_t, std::shared_ptr<const MeshLight>>;

/// Luminance times area of each part.
std::vector<double> part_powers(const TriangleMesh& mesh, const AreaLight& light) {
  std::vector<double> powers;
  for (std::uint32_t entry = 0; entry < light.parts.brightness.size(); ++entry) {
    const auto [p0, p1, p2] = light.placement.triangle(mesh, light.triangle_of(entry));
    const std::uint32_t n = light.cells_of(entry);
    powers.push_back(light.parts.brightness[entry] * (triangle_area(p0, p1, p2) / (n * n)));
  }
  return powers;
}

AreaLight make_light(const Scene& scene, std::uint32_t index, bool shared, SharedLights& shared_lights,
                     const std::map<std::uint32_t, LampParts>& parts) {
  const Instance& instance = scene.instances[index];
  AreaLight light{.instance = index, .placement = Placement(instance), .area = 0.0, .triangles = {}, .shared = {}};
  if (const auto* object = std::get_if<Sphere>(&scene.shape_of(instance))) {
    const Sphere sphere = light.placement.sphere(*object);
    light.area = 4.0 * kPi * sphere.radius * sphere.radius;
    return light;
  }
  if (std::holds_alternative<Disk>(scene.shape_of(instance))) {
    light.area = light.placement.disk().area();
    return light;
  }
  if (const auto* object = std::get_if<Cylinder>(&scene.shape_of(instance))) {
    light.area = light.placement.cylinder(*object).area();
    return light;
  }
  const auto& mesh = std::get<TriangleMesh>(scene.shape_of(instance));
  if (shared) {
    std::shared_ptr<const MeshLight>& of_shape = shared_lights[instance.shape];
    if (!of_shape) of_shape = std::make_shared<const MeshLight>(mesh);
    light.shared = of_shape;
    light.area = of_shape->placed_area(light.placement);
    return light;
  }
  std::vector<double> areas;
  areas.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [p0, p1, p2] = light.placement.triangle(mesh, i);
    areas.push_back(triangle_area(p0, p1, p2));
    light.area += areas.back();
  }
  if (const auto divided = parts.find(index); divided != parts.end()) {
    light.parts = divided->second;
    areas = part_powers(mesh, light);
  }
  light.triangles = DiscreteChoice(areas);
  return light;
}

/// The corners of a part: those of its cell, on the triangle.
std::array<Vec3, 4> part_corners(const std::array<Vec3, 3>& p, std::uint32_t n, std::uint32_t cell) {
  std::array<Vec3, 4> corners;
  for (std::uint32_t k = 0; k < 4; ++k) {
    const Vec3 b = square_to_triangle(Vec2(cell / n + k / 2, cell % n + k % 2) / static_cast<double>(n));
    corners[k] = b.x * p[0] + b.y * p[1] + b.z * p[2];
  }
  return corners;
}

/// A triangle emits on the side of its vertex normals: the leaf's normal is their mean, or none if one of them points
/// away from it.
void shine_by_vertex_normals(const TriangleMesh& mesh, std::uint32_t i, const Placement& placement, LightLeaf& leaf) {
  const glm::uvec3 t = mesh.triangles[i];
  Vec3 sum(0.0);
  for (int k = 0; k < 3; ++k) {
    leaf.corner_normals.push_back(placement.normal(mesh.normals[t[k]]));
    sum += leaf.corner_normals.back();
  }
  leaf.normal = sum == Vec3(0.0) ? sum : glm::normalize(sum);
  const bool apart = std::any_of(leaf.corner_normals.begin(), leaf.corner_normals.end(),
                                 [&](const Vec3& n) { return !(glm::dot(n, leaf.normal) > 0.0); });
  if (apart) leaf.normal = Vec3(0.0);
}

/// A disk or cylinder of radiance 1.
LightLeaf round_leaf(const Shape& shape, const Placement& placement) {
  LightLeaf leaf;
  if (const auto* object = std::get_if<Cylinder>(&shape)) {
    const Tube tube = placement.cylinder(*object);
    leaf.power = 2.0 * tube.radius * tube.height;  // its area as seen from the side
    const Vec3 top = tube.base + tube.height * tube.axis;
    const Vec3 reach = tube.radius * glm::sqrt(glm::max(Vec3(0.0), 1.0 - tube.axis * tube.axis));
    leaf.lower = glm::min(tube.base, top) - reach;
    leaf.upper = glm::max(tube.base, top) + reach;
    return leaf;
  }
  const Ellipse disk = placement.disk();
  const Vec3 reach = glm::sqrt(disk.a * disk.a + disk.b * disk.b);
  leaf.power = disk.area();
  leaf.lower = disk.center - reach;
  leaf.upper = disk.center + reach;
  leaf.normal = disk.normal();
  return leaf;
}

/// Luminance times area of the whole instance.
double instance_power(KnownTextureFacts& facts, const AreaLight& light) {
  const Scene& scene = facts.scene();
  const EmitterRadiance radiance(facts, scene.instances[light.instance]);
  if ((radiance.uniform() && light.parts.empty()) || light.shared)
    return luminance(radiance.mean_of_all()) * light.area;
  const auto& mesh = std::get<TriangleMesh>(scene.shape_of(scene.instances[light.instance]));
  double sum = 0.0;
  if (!light.parts.empty()) {
    for (const double power : part_powers(mesh, light)) sum += power;
    return sum;
  }
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [p0, p1, p2] = light.placement.triangle(mesh, i);
    sum += luminance(radiance.mean(i)) * triangle_area(p0, p1, p2);
  }
  return sum;
}

/// The parts of a triangle, which has the leaf `whole`.
void add_parts(const AreaLight& light, std::uint32_t triangle, const std::array<Vec3, 3>& p, const LightLeaf& whole,
               std::vector<LightLeaf>& leaves) {
  const std::uint32_t n = light.parts.cells[triangle];
  for (std::uint32_t cell = 0; cell < n * n; ++cell) {
    LightLeaf& leaf = leaves.emplace_back(whole);
    leaf.primitive = light.parts.first[triangle] + cell;
    leaf.power = light.parts.brightness[leaf.primitive] * (triangle_area(p[0], p[1], p[2]) / (n * n));
    const std::array<Vec3, 4> corners = part_corners(p, n, cell);
    leaf.lower = glm::min(glm::min(corners[0], corners[1]), glm::min(corners[2], corners[3]));
    leaf.upper = glm::max(glm::max(corners[0], corners[1]), glm::max(corners[2], corners[3]));
  }
}

/// Of light number `l`.
void add_triangles(const TriangleMesh& mesh, const EmitterRadiance& radiance, std::uint32_t l, const AreaLight& light,
                   std::vector<LightLeaf>& leaves) {
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::array<Vec3, 3> p = light.placement.triangle(mesh, i);
    if (is_degenerate(p[0], p[1], p[2])) continue;
    LightLeaf leaf{.light = l,
                   .primitive = i,
                   .power = luminance(radiance.mean(i)) * triangle_area(p[0], p[1], p[2]),
                   .lower = glm::min(p[0], glm::min(p[1], p[2])),
                   .upper = glm::max(p[0], glm::max(p[1], p[2])),
                   .normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]))};
    if (!mesh.normals.empty()) shine_by_vertex_normals(mesh, i, light.placement, leaf);
    if (light.parts.empty())
      leaves.push_back(leaf);
    else
      add_parts(light, i, p, leaf, leaves);
  }
}

/// Every primitive that emits, in the order of the scene.
std::vector<LightLeaf> light_leaves(KnownTextureFacts& facts, const std::vector<AreaLight>& lights,
                                    const std::vector<std::uint32_t>& deltas) {
  const Scene& scene = facts.scene();
  std::vector<LightLeaf> leaves;
  for (std::uint32_t l = 0; l < lights.size(); ++l) {
    const EmitterRadiance radiance(facts, scene.instances[lights[l].instance]);
    const Shape& shape = scene.shape_of(scene.instances[lights[l].instance]);
    if (const auto* object = std::get_if<Sphere>(&shape)) {
      const Sphere sphere = lights[l].placement.sphere(*object);
      leaves.push_back({.light = l,
                        .primitive = 0,
                        .power = luminance(radiance.mean()) * kPi * sphere.radius * sphere.radius,
                        .lower = sphere.center - sphere.radius,
                        .upper = sphere.center + sphere.radius});
      continue;
    }
    if (std::holds_alternative<Disk>(shape) || std::holds_alternative<Cylinder>(shape)) {
      leaves.push_back(round_leaf(shape, lights[l].placement));
      leaves.back().light = l;
      leaves.back().power *= luminance(radiance.mean());
      continue;
    }
    if (lights[l].shared) {
      LightLeaf leaf = lights[l].shared->leaf(lights[l].placement);
      leaf.light = l;
      leaf.power *= luminance(radiance.mean_of_all());
      if (leaf.power > 0.0) leaves.push_back(leaf);
      continue;
    }
    add_triangles(std::get<TriangleMesh>(shape), radiance, l, lights[l], leaves);
  }
  // A light that emits on both sides has no normal, like a sphere.
  for (LightLeaf& leaf : leaves) {
    if (!lights[leaf.light].two_sided) continue;
    leaf.normal = Vec3(0.0);
    leaf.corner_normals.clear();
  }
  for (std::uint32_t d = 0; d < deltas.size(); ++d) {
    const DeltaLight& light = scene.delta_lights[deltas[d]];
    LightLeaf& leaf = leaves.emplace_back();
    leaf.light = static_cast<std::uint32_t>(lights.size()) + d;
    leaf.power = luminance(mean_intensity(scene, light));
    leaf.lower = leaf.upper = light.origin();
    if (light.type == DeltaLight::Type::point) continue;
    leaf.normal = light.axis(2);
    leaf.cos_cone = cone_cosine(light);
  }
  std::erase_if(leaves, [](const LightLeaf& leaf) { return !(leaf.power > 0.0); });
  return leaves;
}

}  // namespace

std::uint32_t AreaLight::entry_at(std::uint32_t primitive, const Vec3& weights) const {
  if (parts.empty()) return primitive;
  const std::uint32_t n = parts.cells[primitive];
  const Vec2 square = triangle_to_square(weights);
  const auto cell = [n](double x) { return std::min(static_cast<std::uint32_t>(std::max(x, 0.0) * n), n - 1); };
  return parts.first[primitive] + cell(square.x) * n + cell(square.y);
}

std::uint32_t AreaLight::triangle_of(std::uint32_t entry) const {
  if (parts.empty()) return entry;
  return static_cast<std::uint32_t>(std::ranges::upper_bound(parts.first, entry) - parts.first.begin()) - 1;
}

std::uint32_t AreaLight::cells_of(std::uint32_t entry) const {
  return parts.empty() ? 1 : parts.cells[triangle_of(entry)];
}

double Lights::prob(const Vec3& from, const Vec3& ns, std::uint32_t instance, std::uint32_t primitive,
                    const Vec3& weights) const {
  const std::optional<std::size_t> index = of_instance_[instance];
  if (!index) return 0.0;
  const AreaLight& of = lights_[*index];
  const std::uint32_t entry = of.entry_at(primitive, weights);
  if (!tree_.empty()) {
    const auto light = static_cast<std::uint32_t>(*index);
    if (of.shared) return tree_.prob(from, ns, light, 0) * of.choice().prob(primitive);
    return tree_.prob(from, ns, light, entry);
  }
  return choice_.prob(*index) * (of.choice().empty() ? 1.0 : of.choice().prob(entry));
}

Lights::Lights(const Scene& scene) : of_instance_(scene.instances.size()) {
  const Sharing sharing(scene);
  const std::map<std::uint32_t, LampParts> parts = lamp_parts(scene);
  KnownTextureFacts facts(scene);
  SharedLights shared;
  std::vector<double> weights;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    if (!scene.instances[i].emitter) continue;
    of_instance_[i] = lights_.size();
    lights_.push_back(make_light(scene, i, sharing.has_instance(i), shared, parts));
    lights_.back().two_sided = scene.emitter_of(scene.instances[i])->two_sided;
    weights.push_back(instance_power(facts, lights_.back()));
    power_ += weights.back();
  }
  for (std::uint32_t i = 0; i < scene.delta_lights.size(); ++i) {
    const DeltaLight& light = scene.delta_lights[i];
    const double power = choice_power(scene, light);
    if (light.type == DeltaLight::Type::directional || !(power > 0.0)) continue;
    deltas_.push_back(i);
    weights.push_back(power);
    power_ += power;
  }
  choice_ = DiscreteChoice(weights);
  if (wants_light_tree(scene)) tree_ = LightTree(light_leaves(facts, lights_, deltas_));
}

}  // namespace etendue::reference
