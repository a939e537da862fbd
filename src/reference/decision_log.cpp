#include "reference/integrator.h"

namespace etendue::reference {

PathVertex* DecisionLog::vertex() const {
  return vertices_ != nullptr && segments_ <= kMaxVertices ? &vertices_->back() : nullptr;
}

void DecisionLog::segment(const Ray& ray, const std::optional<Surface>& hit) {
  ++segments_;
  if (vertices_ != nullptr && segments_ <= kMaxVertices) vertices_->emplace_back();
  if (PathVertex* v = vertex()) {
    v->from = glm::vec3(ray.origin);
    v->to = glm::vec3(hit ? hit->p : ray.direction);
  }
  fold(hit ? hit->instance + 1 : 0);
  if (!hit) return;
  fold(hit->primitive + 1);
  if (PathVertex* v = vertex()) {
    v->instance = hit->instance;
    v->primitive = hit->primitive;
  }
}

void DecisionLog::light(const LightSample& sample, bool contributed) {
  light(sample.instance, sample.primitive, contributed);
}

void DecisionLog::environment(const EnvironmentSample& sample, bool contributed) {
  light(sample.delta ? PathVertex::kDeltaLight : PathVertex::kEnvironment, sample.cell, contributed);
}

void DecisionLog::light(std::uint32_t instance, std::uint32_t primitive, bool contributed) {
  fold(instance + 1);
  fold(primitive + 1);
  fold(contributed ? 1 : 0);
  if (PathVertex* v = vertex()) {
    v->light_instance = instance;
    v->light_primitive = primitive;
    v->light_contributed = contributed ? 1 : 0;
  }
}

void DecisionLog::lobe(Lobe lobe) {
  fold(static_cast<std::uint32_t>(lobe));
  if (PathVertex* v = vertex()) v->lobe = static_cast<std::uint32_t>(lobe);
}

void DecisionLog::roulette(bool survived) {
  fold(survived ? 1 : 0);
  if (PathVertex* v = vertex()) v->survived = survived ? 1 : 0;
}

void DecisionLog::radiance(const Vec3& rgb) {
  if (PathVertex* v = vertex()) v->radiance = glm::vec3(rgb);
}

}  // namespace etendue::reference
