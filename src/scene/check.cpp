#include "scene/check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>

#include "core/text.h"
#include "scene/bounds.h"
#include "scene/placed.h"
#include "scene/precision.h"

namespace etendue {
namespace {

bool is_dark(const glm::dvec3& radiance) {
  return radiance == glm::dvec3(0.0);
}

void check_light(const Scene& scene, Diagnostics& diagnostics) {
  const bool sky = !is_dark(scene.sky);
  const bool emitter = std::any_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& instance) {
    return instance.emitter && !is_dark(scene.emitter_of(instance)->radiance.value);
  });
  const bool delta =
      std::ranges::any_of(scene.delta_lights, [](const DeltaLight& light) { return !is_dark(light.intensity.value); });
  if (delta && !samples_lights(scene.integrator)) {
    diagnostics.warning(scene.delta_lights.front().position,
                        fmt::format("{} of the scene's lights have no extent: only light sampling reaches them, which "
                                    "this integrator does not do, so they are dark; use path with nee, or path_mis",
                                    scene.delta_lights.size()));
  }
  if (sky || emitter || delta) return;
  diagnostics.warning(scene.position,
                      "the scene has no emitter and a black sky: the image will be black; add a lamp or a sky");
}

/// True if some part of the box lies more than rounding in front of the triangle's plane.
bool box_in_front(const Bounds& box, const glm::dvec3& p, const glm::dvec3& n, double tolerance) {
  const glm::dvec3 farthest(n.x > 0 ? box.max.x : box.min.x, n.y > 0 ? box.max.y : box.min.y,
                            n.z > 0 ? box.max.z : box.min.z);
  return glm::dot(farthest - p, n) > tolerance;
}

/// An emitter mesh none of whose triangles has anything, or the camera, in front of it. Boxes make it a cautious test:
/// it warns only when nothing can be lit.
void check_facing(const Scene& scene, const Instance& instance, const Bounds& all, Diagnostics& diagnostics) {
  const auto* object = std::get_if<TriangleMesh>(&scene.shape_of(instance));
  if (object == nullptr || !instance.emitter) return;
  const PlacedMesh mesh(*object, instance);
  const glm::dvec3 extent = all.max - all.min;
  const double tolerance = 1e-6 * std::max({extent.x, extent.y, extent.z});
  for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
    const auto [p, p1, p2] = mesh.triangle(i);
    const glm::dvec3 n = glm::cross(p1 - p, p2 - p);
    const double length = glm::length(n);
    if (length > 0.0 && box_in_front(all, p, n / length, tolerance)) return;
  }
  diagnostics.warning(
      instance.position,
      fmt::format("the emitter {} faces away from everything in scene {}: it lights nothing; turn its triangles around",
                  text::quoted(instance.name), scene.name));
}

/// Generalised winding number of a mesh around a point: the solid angle it fills over 4π [VanOosterom1983]; ±1 inside a
/// closed mesh, 0 outside, in between for open ones.
double winding_number(const PlacedMesh& mesh, const glm::dvec3& p) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
    const auto [p0, p1, p2] = mesh.triangle(i);
    const glm::dvec3 a = p0 - p, b = p1 - p, c = p2 - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double numerator = glm::dot(a, glm::cross(b, c));
    const double denominator = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
    sum += 2.0 * std::atan2(numerator, denominator);
  }
  return sum / (4.0 * glm::pi<double>());
}

double volume_size(const Bounds& box) {
  return glm::length(box.max - box.min);
}

bool contains(const Shape& shape, const Instance& instance, const glm::dvec3& p) {
  if (const auto* object = std::get_if<Sphere>(&shape)) {
    const Sphere sphere = placed_sphere(*object, instance);
    return glm::distance(p, sphere.center) < sphere.radius;
  }
  const auto* mesh = std::get_if<TriangleMesh>(&shape);
  return mesh != nullptr && std::abs(winding_number(PlacedMesh(*mesh, instance), p)) > 0.5;
}

/// The medium around the camera is that of the smallest dielectric it is inside of; a hollow (inside index near 1) is
/// air.
void check_camera_medium(const Scene& scene, const std::vector<Bounds>& boxes, Diagnostics& diagnostics) {
  const glm::dvec3 eye(scene.camera.world_from_camera[3]);
  const Instance* innermost = nullptr;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (!std::holds_alternative<DielectricBsdf>(scene.bsdf_of(instance)) || volume_size(boxes[i]) >= smallest) continue;
    const bool in_box = glm::all(glm::greaterThan(eye, boxes[i].min)) && glm::all(glm::lessThan(eye, boxes[i].max));
    if (!in_box) continue;
    if (!contains(scene.shape_of(instance), instance, eye)) continue;
    innermost = &instance;
    smallest = volume_size(boxes[i]);
  }
  constexpr double kAir = 1.01;
  if (innermost == nullptr || std::get<DielectricBsdf>(scene.bsdf_of(*innermost)).int_ior < kAir) return;
  diagnostics.warning(
      scene.camera.position,
      fmt::format("the camera is inside the dielectric {} of line {}; move it out unless that is intended",
                  text::quoted(innermost->name), innermost->position.line));
}

/// Devices compute in single precision, relative to the size of the whole scene.
void check_scale(const Instance& instance, const Bounds& box, const Bounds& all, Diagnostics& diagnostics) {
  constexpr double kTooSmall = 1e-6;
  const double size = volume_size(box), whole = volume_size(all);
  if (!(size < kTooSmall * whole)) return;
  diagnostics.warning(
      instance.position,
      fmt::format("{} is {:.0e} of the scene's size: single precision, in which devices compute, cannot resolve it; "
                  "shrink what is largest, or use --device reference",
                  text::quoted(instance.name), size / whole));
}

/// Warns about settings without effect.
void check_effect(const Scene& scene, const Instance& instance, Diagnostics& diagnostics) {
  const auto* glass = std::get_if<DielectricBsdf>(&scene.bsdf_of(instance));
  if (glass == nullptr || glass->int_ior != glass->ext_ior) return;
  diagnostics.warning(instance.position, fmt::format("the dielectric {} has no effect: intIOR and extIOR are both {}",
                                                     text::quoted(instance.name), glass->int_ior));
}

void check_normals(const Scene& scene, const Instance& instance, Diagnostics& diagnostics) {
  const auto* mesh = std::get_if<TriangleMesh>(&scene.shape_of(instance));
  if (mesh == nullptr || mesh->normals.empty()) return;
  const auto against = std::count_if(mesh->triangles.begin(), mesh->triangles.end(), [&](const glm::uvec3& t) {
    const glm::dvec3& p = mesh->positions[t.x];
    const glm::dvec3 ng = glm::cross(mesh->positions[t.y] - p, mesh->positions[t.z] - p);
    return glm::dot(ng, mesh->normals[t.x] + mesh->normals[t.y] + mesh->normals[t.z]) < 0.0;
  });
  // Simplified and sculpted meshes have a few such slivers; one in a thousand is an error of export.
  if (against * 1000 < static_cast<std::ptrdiff_t>(mesh->triangles.size()) || against == 0) return;
  diagnostics.warning(instance.position, fmt::format("{} of {} triangles of {} have vertex normals against their "
                                                     "winding; the normals decide which side emits and reflects",
                                                     against, mesh->triangles.size(), text::quoted(instance.name)));
}

/// Numbers positions so that equal ones get the same number: vertices are split where normals differ.
std::vector<std::uint32_t> weld(const TriangleMesh& mesh) {
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const glm::dvec3 &p = mesh.positions[a], &q = mesh.positions[b];
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
  };
  std::vector<std::uint32_t> order(mesh.positions.size()), number(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), less);
  for (std::size_t i = 0; i < order.size(); ++i)
    number[order[i]] = i > 0 && !less(order[i - 1], order[i]) ? number[order[i - 1]] : order[i];
  return number;
}

/// Edges that are not run through equally often in both directions: a closed, consistently oriented surface has none.
std::size_t open_edges(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> number = weld(mesh);
  std::vector<std::uint64_t> edges;  // both ends sorted, then the direction in the lowest bit
  edges.reserve(mesh.triangles.size() * 3);
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t a = number[t[i]], b = number[t[(i + 1) % 3]];
      if (a != b) edges.push_back(std::min(a, b) << 33 | std::max(a, b) << 1 | (a < b ? 1 : 0));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::size_t open = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::int64_t balance = 0;
    const std::uint64_t edge = edges[i] >> 1;
    for (; i < edges.size() && edges[i] >> 1 == edge; ++i) balance += (edges[i] & 1) != 0 ? 1 : -1;
    open += static_cast<std::size_t>(std::abs(balance));
  }
  return open;
}

void check_closed(const Scene& scene, const Instance& instance, Diagnostics& diagnostics) {
  const Shape& shape = scene.shape_of(instance);
  const auto* mesh = std::get_if<TriangleMesh>(&shape);
  if (!std::holds_alternative<DielectricBsdf>(scene.bsdf_of(instance))) return;
  if (std::holds_alternative<Disk>(shape) || std::holds_alternative<Cylinder>(shape)) {
    diagnostics.warning(instance.position,
                        fmt::format("the dielectric {} is not closed: light that enters may never leave; use a mesh",
                                    text::quoted(instance.name)));
  }
  if (mesh == nullptr) return;
  const std::size_t open = open_edges(*mesh);
  if (open == 0) return;
  diagnostics.warning(
      instance.position,
      fmt::format(
          "the dielectric mesh {} is not closed ({} open edges): light that enters may never leave; close the mesh",
          text::quoted(instance.name), open));
}

}  // namespace

void check_scene(const Scene& scene, Diagnostics& diagnostics) {
  const Sharing sharing(scene);
  const std::vector<Bounds> boxes = instance_bounds(scene, sharing);
  Bounds all;
  for (const Bounds& box : boxes) {
    all.add(box.min);
    all.add(box.max);
  }
  Bounds seen = all;  // what light can shine on, or into
  seen.add(glm::dvec3(scene.camera.world_from_camera[3]));
  if (gathers_light(scene.integrator)) check_light(scene, diagnostics);
  check_camera_medium(scene, boxes, diagnostics);
  // For a shared mesh only the first instance is checked, because a forest has thousands.
  std::vector<bool> told(scene.shapes.size(), false), told_as_glass(scene.shapes.size(), false);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const bool shared = sharing.has_instance(i);
    const bool glass = std::holds_alternative<DielectricBsdf>(scene.bsdf_of(instance));
    check_scale(instance, boxes[i], all, diagnostics);
    if (!shared) check_facing(scene, instance, seen, diagnostics);
    check_effect(scene, instance, diagnostics);
    if (!shared || !told[instance.shape]) check_normals(scene, instance, diagnostics);
    if (glass && (!shared || !told_as_glass[instance.shape])) check_closed(scene, instance, diagnostics);
    told[instance.shape] = true;
    told_as_glass[instance.shape] = told_as_glass[instance.shape] || glass;
  }
  if (const std::string sentence = precision_complaint(scene); !sentence.empty())
    diagnostics.warning(scene.camera.position, sentence);
}

void check_scene_file(const SceneFile& file, Diagnostics& diagnostics) {
  if (const auto* scene = std::get_if<Scene>(&file)) check_scene(*scene, diagnostics);
  if (const auto* test = std::get_if<TTest>(&file)) {
    for (const Scene& scene : test->scenes) check_scene(scene, diagnostics);
  }
}

}  // namespace etendue
