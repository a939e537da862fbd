#include "compile/shared_mesh.h"

#include <algorithm>
#include <cmath>

#include "compile/reinsertion.h"
#include "compile/twins.h"
#include "scene/bounds.h"
#include "scene/placed.h"

namespace etendue {
namespace {

// Half of a float's unit in the last place at 1.
constexpr double kUnit = 0x1p-24;

Normalization object_normalization(const glm::dvec3& lower, const glm::dvec3& upper) {
  Normalization n;
  n.center = 0.5 * lower + 0.5 * upper;
  const glm::dvec3 half = glm::max(upper - n.center, n.center - lower);
  const double farthest = std::max({half.x, half.y, half.z});
  constexpr double kLargestExponent = 1000.0;
  if (farthest > 0.0) n.scale = std::exp2(std::min(-std::ceil(std::log2(farthest)), kLargestExponent));
  return n;
}

Box triangle_box(const gpu::Primitive& p) {
  Box box;
  for (const glm::vec3& v : {glm::vec3(p.p0), glm::vec3(p.p1), glm::vec3(p.p2)}) box.extend(v);
  return box;
}

// The boxes of about `count` nodes that together contain a tree; the largest nodes are opened first.
std::vector<Box> cover(const Bvh& bvh, std::size_t count) {
  std::vector<std::uint32_t> nodes{0};
  const auto smaller = [&](std::uint32_t a, std::uint32_t b) {
    const float area_a = bvh.nodes[a].leaf != 0 ? -1.0f : bvh.nodes[a].box.half_area();
    const float area_b = bvh.nodes[b].leaf != 0 ? -1.0f : bvh.nodes[b].box.half_area();
    return area_a != area_b ? area_a < area_b : a > b;
  };
  while (nodes.size() < count) {
    const auto largest = std::max_element(nodes.begin(), nodes.end(), smaller);
    if (bvh.nodes[*largest].leaf != 0) break;
    const std::uint32_t first = bvh.nodes[*largest].first;
    *largest = first;
    nodes.push_back(first + 1);
  }
  std::vector<Box> boxes;
  for (const std::uint32_t node : nodes) boxes.push_back(bvh.nodes[node].box);
  return boxes;
}

// The cofactor matrix, by which cross products of edges are transformed.
glm::dmat3 cofactors(const glm::dmat3& m) {
  return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

bool is_conformal(const glm::dmat3& c) {
  constexpr double kTolerance = 1e-9;
  const double xx = glm::dot(c[0], c[0]), yy = glm::dot(c[1], c[1]), zz = glm::dot(c[2], c[2]);
  const double largest = std::max({xx, yy, zz});
  return std::abs(xx - yy) <= kTolerance * largest && std::abs(xx - zz) <= kTolerance * largest &&
         std::max({std::abs(glm::dot(c[0], c[1])), std::abs(glm::dot(c[1], c[2])), std::abs(glm::dot(c[2], c[0]))}) <=
             kTolerance * largest;
}

}  // namespace

SharedMesh prepare_shared_primitives(const Shape& shape) {
  const auto& mesh = std::get<TriangleMesh>(shape);
  SharedMesh shared;
  shared.bounds = bounds_of(shape);
  shared.normalization = object_normalization(shared.bounds.min, shared.bounds.max);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3 t = mesh.triangles[i];
    gpu::Primitive p{};
    p.p0 = shared.normalization.point(mesh.positions[t.x]);
    p.p1 = shared.normalization.point(mesh.positions[t.y]);
    p.p2 = shared.normalization.point(mesh.positions[t.z]);
    p.primitive = i;
    p.kind = gpu::kPrimitiveTriangle | i << gpu::kPrimitiveOrderShift;
    shared.primitives.push_back(p);
  }
  return shared;
}

SharedMesh prepare_shared_mesh(const Shape& shape) {
  SharedMesh shared = prepare_shared_primitives(shape);
  std::vector<Box> boxes;
  for (const gpu::Primitive& p : shared.primitives) boxes.push_back(triangle_box(p));
  std::vector<std::uint32_t> outside;
  for (const Twin& twin : find_twins(shared.primitives)) outside.push_back(twin.primitive);
  if (outside.size() == boxes.size()) return shared;
  shared.bvh = build_bvh(std::move(boxes), outside);
  reinsert_subtrees(shared.bvh);
  constexpr std::size_t kParts = 48;
  shared.parts = cover(shared.bvh, kParts);
  return shared;
}

MeshLight measure_mesh_light(const TriangleMesh& mesh) {
  constexpr double kLeastShare = 1e-14;  // of the longest edge squared, for twice the area
  MeshLight light;
  std::vector<glm::dvec3> normals;  // of the triangles that emit, and of their corners
  glm::dvec3 sum(0.0);
  bool all_sides = false;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    const glm::dvec3 cross = glm::cross(b - a, c - a);
    const double length = glm::length(cross);
    const double longest = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
    const double area = length > kLeastShare * longest ? 0.5 * length : 0.0;
    light.areas.push_back(area);
    if (area == 0.0) continue;
    light.area += area;
    glm::dvec3 n = cross / length;
    light.spread += area * glm::outerProduct(n, n);
    if (!mesh.normals.empty()) {
      const glm::dvec3 corners = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
      n = glm::length(corners) > 0.0 ? glm::normalize(corners) : glm::dvec3(0.0);
      for (int k = 0; k < 3; ++k) {
        all_sides = all_sides || !(glm::dot(n, mesh.normals[t[k]]) > 0.0);
        normals.push_back(glm::normalize(mesh.normals[t[k]]));
      }
    }
    normals.push_back(n);
    sum += area * n;
  }
  if (all_sides || !(glm::length(sum) > 1e-3 * light.area)) return light;
  const glm::dvec3 axis = glm::normalize(sum);
  double cosine = 1.0;
  for (const glm::dvec3& n : normals) cosine = std::min(cosine, glm::dot(axis, n));
  if (!(cosine > 0.0)) return light;  // a cone wider than a half-space is not convex and may miss normals in between
  light.axis = axis;
  light.cos_cone = cosine;
  return light;
}

double placed_area(const MeshLight& light, const Instance& instance) {
  const glm::dmat3 c = cofactors(glm::dmat3(instance.world_from_object));
  const glm::dmat3 spread = c * light.spread * glm::transpose(c);
  return std::sqrt(light.area * std::max(0.0, spread[0][0] + spread[1][1] + spread[2][2]));
}

LightLeaf placed_light_leaf(const SharedMesh& mesh, const Instance& instance) {
  LightLeaf leaf;
  leaf.power = placed_area(mesh.light, instance);
  const Bounds box = transformed(mesh.bounds, instance.world_from_object);
  leaf.lower = box.min;
  leaf.upper = box.max;
  if (mesh.light.cos_cone <= 0.0) return leaf;
  // Normals are transformed by the cofactors, and reversed if the instance reverses the winding.
  const glm::dmat3 c = cofactors(glm::dmat3(instance.world_from_object));
  const glm::dvec3 axis = c * mesh.light.axis;
  const double length = glm::length(axis);
  double cosine = mesh.light.cos_cone;
  if (!is_conformal(c)) {
    // A normal at angle a from the axis is transformed to a vector with a component of at least cos a |C axis| − sin a
    // ‖C‖ along C axis and at most sin a ‖C‖ perpendicular to it.
    const double norm = std::sqrt(glm::dot(c[0], c[0]) + glm::dot(c[1], c[1]) + glm::dot(c[2], c[2]));
    const double beside = std::sqrt(1.0 - std::min(1.0, cosine * cosine)) * norm;
    const double along = cosine * length - beside;
    cosine = along > 0.0 ? along / std::hypot(along, beside) : -1.0;
  }
  if (cosine <= 0.0) return leaf;
  leaf.normal = axis / length * (turns_winding(instance) ? -1.0 : 1.0);
  leaf.cos_cone = cosine;
  return leaf;
}

gpu::Place make_place(const SharedMesh& mesh, const Instance& instance, const Normalization& world) {
  const glm::dmat3 linear(instance.world_from_object);
  const glm::dmat3 m = linear * (world.scale / mesh.normalization.scale);
  const glm::dmat3 w = glm::inverse(linear) * (mesh.normalization.scale / world.scale);
  gpu::Place place{};
  place.origin = world.point(glm::dvec3(instance.world_from_object * glm::dvec4(mesh.normalization.center, 1.0)));
  place.x = glm::vec3(m[0]);
  place.y = glm::vec3(m[1]);
  place.z = glm::vec3(m[2]);
  const glm::dmat3 rows = glm::transpose(w);
  place.object_x = glm::vec3(rows[0]);
  place.object_y = glm::vec3(rows[1]);
  place.object_z = glm::vec3(rows[2]);
  place.side = turns_winding(instance) ? -1.0f : 1.0f;
  place.root_determinant = static_cast<float>(std::sqrt(std::abs(glm::determinant(m))));
  // The extent of the mesh around its origin, per world axis.
  glm::dvec3 reach(0.0);
  for (int i = 0; i < 3; ++i) reach += glm::abs(m[i]);
  // A ray's origin o becomes W (o − origin): five roundings of terms of |W| |o − origin|, and as many again for its
  // direction; the test in mesh space takes 16 units of coordinates up to 1, as it does in the world (surface_error).
  double error = 0.0, condition = 0.0;
  for (int k = 0; k < 3; ++k) {
    double near = 0.0, far = 0.0;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 row = glm::abs(rows[i]);
      near += std::abs(m[i][k]) * (glm::dot(row, reach) + 1.0);
      far += std::abs(m[i][k]) * (row.x + row.y + row.z);
    }
    error = std::max(error, near);
    condition = std::max(condition, far);
  }
  place.error = static_cast<float>(16.0 * kUnit * error);
  place.relative_error = static_cast<float>(10.0 * kUnit * condition);
  return place;
}

Box placed_box(const SharedMesh& mesh, const gpu::Place& place) {
  const glm::dvec3 origin(place.origin);
  const glm::dmat3 m(glm::dvec3(place.x), glm::dvec3(place.y), glm::dvec3(place.z));
  glm::dvec3 lower(INFINITY), upper(-INFINITY);
  for (const Box& part : mesh.parts) {
    const Bounds box = transformed({glm::dvec3(part.lower), glm::dvec3(part.upper)}, glm::dmat4(m));
    lower = glm::min(lower, box.min);
    upper = glm::max(upper, box.max);
  }
  const double slack = double{place.error} + double{place.relative_error};  // a ray as long as half the scene
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.lower[k] = std::nextafter(static_cast<float>(lower[k] + origin[k] - slack), -INFINITY);
    box.upper[k] = std::nextafter(static_cast<float>(upper[k] + origin[k] + slack), INFINITY);
  }
  return box;
}

}  // namespace etendue
