#include "scene/test_patch.h"

namespace etendue {

void add_test_patch(Scene& scene, const glm::dvec2& uv) {
  const glm::vec2 corner(uv);
  TriangleMesh mesh{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .normals = {}, .triangles = {{0, 1, 2}}};
  mesh.uv_sets = {{corner, corner + glm::vec2(1, 0), corner + glm::vec2(0, 1)}};
  mesh.tangents.assign(3, glm::vec4(1, 0, 0, 1));
  scene.shapes.emplace_back(std::move(mesh));
  scene.instances.push_back({.shape = static_cast<std::uint32_t>(scene.shapes.size() - 1),
                             .material = static_cast<std::uint32_t>(scene.materials.size() - 1)});
  scene.instances.back().name = "patch";
}

Scene test_patch(const Bsdf& bsdf) {
  Scene scene;
  scene.materials.push_back({.bsdf = bsdf});
  add_test_patch(scene);
  return scene;
}

}  // namespace etendue
