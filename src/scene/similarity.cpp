#include "scene/similarity.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace etendue {
namespace {

/// Relative to the squared length of the longest axis.
constexpr double kExact = 1e-9, kMisprint = 1e-3;

bool is_similarity_within(const glm::dmat3& m, double tolerance) {
  const double xx = glm::dot(m[0], m[0]), yy = glm::dot(m[1], m[1]), zz = glm::dot(m[2], m[2]);
  const double largest = std::max({xx, yy, zz});
  return std::abs(xx - yy) <= tolerance * largest && std::abs(xx - zz) <= tolerance * largest &&
         std::max({std::abs(glm::dot(m[0], m[1])), std::abs(glm::dot(m[1], m[2])), std::abs(glm::dot(m[2], m[0]))}) <=
             tolerance * largest;
}

/// By Newton's iteration for the orthogonal factor of the polar decomposition [Higham1986], which is the orthogonal
/// matrix nearest to `m`; the error is squared in each step.
glm::dmat3 nearest_similarity(const glm::dmat3& m) {
  constexpr int kSteps = 4;
  const double scale = std::cbrt(std::abs(glm::determinant(m)));
  glm::dmat3 turn = m / scale;
  for (int step = 0; step < kSteps; ++step) turn = 0.5 * (turn + glm::transpose(glm::inverse(turn)));
  return scale * turn;
}

glm::dmat3 rounded(const glm::dmat3& m) {
  const bool usable = std::isfinite(glm::determinant(m)) && std::abs(glm::determinant(m)) > 0.0;
  if (!usable || is_similarity_within(m, kExact) || !is_similarity_within(m, kMisprint)) return m;
  return nearest_similarity(m);
}

void round_axes(glm::dmat4& m) {
  const glm::dmat3 axes = rounded(glm::dmat3(m));
  for (int a = 0; a < 3; ++a) m[a] = glm::dvec4(axes[a], m[a].w);
}

}  // namespace

bool is_similarity(const glm::dmat4& m) {
  return is_similarity_within(glm::dmat3(m), kExact);
}

void round_to_similarities(Scene& scene) {
  scene.sky.world_from_sky = rounded(scene.sky.world_from_sky);
  for (DeltaLight& light : scene.delta_lights) round_axes(light.world_from_light);
  for (Instance& instance : scene.instances) {
    if (instance.shape >= scene.shapes.size()) continue;
    const Shape& shape = scene.shapes[instance.shape];
    if (std::holds_alternative<Sphere>(shape) || std::holds_alternative<Cylinder>(shape))
      round_axes(instance.world_from_object);
  }
}

}  // namespace etendue
