#include "formats/model/studio.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/bounds.h"

namespace etendue {

void frame_camera(Scene& scene) {
  const Bounds bounds = bounds_of(scene);
  const glm::dvec3 center = 0.5 * (bounds.min + bounds.max);
  const double radius = std::max(0.5 * glm::distance(bounds.min, bounds.max), 1e-6);
  Camera& camera = scene.camera;
  camera.position = scene.position;
  camera.fov = 35.0;
  camera.fov_axis = Camera::FovAxis::smaller;
  const double distance = 1.02 * radius / std::sin(0.5 * camera.fov * std::numbers::pi / 180.0);
  const glm::dvec3 back = glm::normalize(glm::dvec3(0.5, 0.35, 1.0));
  const glm::dvec3 z = -back, x = glm::normalize(glm::cross(glm::dvec3(0.0, 1.0, 0.0), z));
  camera.world_from_camera = {glm::dvec4(x, 0.0), glm::dvec4(glm::cross(z, x), 0.0), glm::dvec4(z, 0.0),
                              glm::dvec4(center + distance * back, 1.0)};
  camera.near_clip = 1e-3 * radius;
  camera.far_clip = 1e3 * radius;
}

void add_studio_sky(Scene& scene) {
  scene.sky.top = glm::dvec3(1.5, 1.5, 1.55);
  scene.sky.horizon = glm::dvec3(0.3);
}

void set_viewer_sampling(Scene& scene) {
  constexpr std::uint32_t kSamples = 64;
  scene.camera.filter = {.type = ReconstructionFilter::Type::gaussian, .radius = 2.0, .stddev = 0.5};
  scene.sampler = {Sampler::Type::sobol, kSamples, 4};
}

}  // namespace etendue
