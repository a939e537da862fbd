#include "reference/mesh_light.h"

#include <algorithm>
#include <cmath>

#include "reference/intersect.h"

namespace etendue::reference {
namespace {

/// Rows of the matrix that takes the cross product of two edges to that of the transformed edges.
std::array<Vec3, 3> cofactor_rows(const glm::dmat4& m) {
  const Vec3 x(m[0]), y(m[1]), z(m[2]);
  const glm::dmat3 rows = glm::transpose(glm::dmat3(glm::cross(y, z), glm::cross(z, x), glm::cross(x, y)));
  return {rows[0], rows[1], rows[2]};
}

/// Rotation, reflection and one scale: angles between normals stay what they are.
bool keeps_angles(const std::array<Vec3, 3>& rows) {
  double largest = 0.0, skew = 0.0;
  for (const Vec3& row : rows) largest = std::max(largest, glm::dot(row, row));
  for (std::size_t i = 0; i < 3; ++i) {
    skew = std::max(skew, std::abs(glm::dot(rows[i], rows[(i + 1) % 3])));
    skew = std::max(skew, largest - glm::dot(rows[i], rows[i]));
  }
  return skew <= 1e-9 * largest;
}

}  // namespace

MeshLight::MeshLight(const TriangleMesh& mesh) {
  std::vector<double> areas;
  for (const glm::uvec3& t : mesh.triangles) {
    const Vec3 &p0 = mesh.positions[t.x], &p1 = mesh.positions[t.y], &p2 = mesh.positions[t.z];
    areas.push_back(triangle_area(p0, p1, p2));
    area_ += areas.back();
    if (areas.back() == 0.0) continue;
    const Vec3 n = glm::normalize(glm::cross(p1 - p0, p2 - p0));
    for (int column = 0; column < 3; ++column) spread_[column] += areas.back() * n[column] * n;
  }
  triangles_ = DiscreteChoice(areas);
  for (const Vec3& p : mesh.positions) {
    lower_ = glm::min(lower_, p);
    upper_ = glm::max(upper_, p);
  }
  find_cone(mesh);
}

void MeshLight::find_cone(const TriangleMesh& mesh) {
  struct Normal {
    Vec3 n;
    double area;  // 0 for that of a corner
  };
  std::vector<Normal> normals;
  for (const glm::uvec3& t : mesh.triangles) {
    const Vec3 &p0 = mesh.positions[t.x], &p1 = mesh.positions[t.y], &p2 = mesh.positions[t.z];
    const double area = triangle_area(p0, p1, p2);
    if (area == 0.0) continue;
    Vec3 n = glm::cross(p1 - p0, p2 - p0);
    if (!mesh.normals.empty()) {
      n = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
      if (n == Vec3(0.0)) return;
      for (int k = 0; k < 3; ++k) normals.push_back({glm::normalize(mesh.normals[t[k]]), 0.0});
      // Shading normals between corners that have no half space in common may point anywhere.
      if (std::any_of(normals.end() - 3, normals.end(), [&](const Normal& c) { return !(glm::dot(c.n, n) > 0.0); }))
        return;
    }
    normals.push_back({glm::normalize(n), area});
  }
  Vec3 sum(0.0);
  for (const Normal& normal : normals) sum += normal.area * normal.n;
  if (!(glm::length(sum) > 1e-3 * area_)) return;
  const Vec3 axis = glm::normalize(sum);
  double cosine = 1.0;
  for (const Normal& normal : normals) cosine = std::min(cosine, glm::dot(axis, normal.n));
  if (cosine <= 0.0) return;
  axis_ = axis;
  cos_cone_ = cosine;
}

double MeshLight::placed_area(const Placement& placement) const {
  double sum = 0.0;
  for (const Vec3& row : cofactor_rows(placement.matrix())) sum += glm::dot(row, spread_ * row);
  return std::sqrt(area_ * std::max(sum, 0.0));
}

LightLeaf MeshLight::leaf(const Placement& placement) const {
  LightLeaf leaf;
  leaf.power = placed_area(placement);
  leaf.lower = Vec3(INFINITY);
  leaf.upper = Vec3(-INFINITY);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p = placement.point({(corner & 1) != 0 ? upper_.x : lower_.x, (corner & 2) != 0 ? upper_.y : lower_.y,
                                    (corner & 4) != 0 ? upper_.z : lower_.z});
    leaf.lower = glm::min(leaf.lower, p);
    leaf.upper = glm::max(leaf.upper, p);
  }
  if (cos_cone_ <= 0.0) return leaf;
  const std::array<Vec3, 3> rows = cofactor_rows(placement.matrix());
  double cosine = cos_cone_;
  if (!keeps_angles(rows)) {
    double norm2 = 0.0;
    for (const Vec3& row : rows) norm2 += glm::dot(row, row);
    const double length =
        glm::length(Vec3(glm::dot(rows[0], axis_), glm::dot(rows[1], axis_), glm::dot(rows[2], axis_)));
    const double beside = std::sqrt((1.0 - std::min(1.0, cos_cone_ * cos_cone_)) * norm2);
    const double along = cos_cone_ * length - beside;
    if (along <= 0.0) return leaf;
    cosine = along / std::sqrt(along * along + beside * beside);
  }
  leaf.normal = placement.normal(axis_);
  leaf.cos_cone = cosine;
  return leaf;
}

}  // namespace etendue::reference
