#version 460
#extension GL_GOOGLE_include_directive : require
#include "sampler.glsl"
#include "emitter/emitter.glsl"
#include "test_io.glsl"
#include "brute_force.glsl"

TEST_BUFFERS(RayCase, EmissionAnswer)

void main() {
  if (!lane_has_work()) return;
  const RayCase c = inputs[lane()];
  const Ray ray = Ray(c.o, c.t_min, c.d, c.t_max);
  const Hit hit = trace_brute_force(ray);
  if (hit.instance == kNone) {
    outputs[lane()] = EmissionAnswer(vec3(0.0), 0.0, kNone, kNone, hit.t, 0u);
    return;
  }
  const Instance instance = fetch_instance(hit.instance);
  const Surface s = make_surface(ray, hit, instance);
  const float pdf = instance.light_prob > 0.0 ? light_pdf(c.o, vec3(0.0), c.d, s, hit.weights, instance, hit.geometry) : 0.0;
  outputs[lane()] = EmissionAnswer(area_radiance(instance, s.frame.n, -c.d), pdf, s.instance, s.primitive, hit.t, 0u);
}
