#include "formats/mesh/builtin_meshes.h"

#include <iterator>

namespace etendue {
namespace {

/// A parallelogram: the corner with texture coordinates 0, 0, and the edges along which u and v grow. It is seen from
/// the side from which u × v points to the eye, or away from it where `turned`.
void add_face(TriangleMesh& mesh, const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v, bool turned) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::dvec3& p : {corner, corner + u, corner + u + v, corner + v}) mesh.positions.push_back(p);
  std::vector<glm::vec2>& uvs = mesh.uv_sets[0];
  uvs.insert(uvs.end(), {{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}});
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh.triangles.push_back(first + (turned ? glm::uvec3(a, c, b) : glm::uvec3(a, b, c)));
  };
  add(0, 1, 2);
  add(0, 2, 3);
}

}  // namespace

TriangleMesh make_parallelogram(const glm::dvec3& origin, const glm::dvec3& u, const glm::dvec3& v) {
  TriangleMesh mesh;
  mesh.uv_sets.emplace_back();
  add_face(mesh, origin, u, v, false);
  return mesh;
}

TriangleMesh make_rectangle() {
  return make_parallelogram({-1.0, -1.0, 0.0}, {2.0, 0.0, 0.0}, {0.0, 2.0, 0.0});
}

TriangleMesh make_cube() {
  TriangleMesh mesh;
  mesh.uv_sets.emplace_back();
  struct Face {
    glm::dvec3 corner, u, v;
  };
  const glm::dvec3 x(2.0, 0.0, 0.0), y(0.0, 2.0, 0.0), z(0.0, 0.0, 2.0);
  const Face faces[] = {{{-1.0, -1.0, -1.0}, z, x}, {{1.0, 1.0, 1.0}, -x, -z},  {{1.0, -1.0, 1.0}, y, -z},
                        {{-1.0, -1.0, 1.0}, y, x},  {{-1.0, -1.0, -1.0}, y, z}, {{-1.0, 1.0, -1.0}, -y, x}};
  for (const Face& face : faces) add_face(mesh, face.corner, face.u, face.v, true);
  return mesh;
}

}  // namespace etendue
