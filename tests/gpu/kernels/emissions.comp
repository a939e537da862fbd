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
  if (hit.slot == kNone) {
    outputs[lane()] = EmissionAnswer(vec3(0.0), 0.0, kNone, kNone, hit.t, 0u);
    return;
  }
  Shape shape;
  const Surface s = make_surface(ray, hit, shape);
  const float pdf = shape.light_prob > 0.0 ? light_pdf(c.o, vec3(0.0), c.d, s, shape, hit.slot) : 0.0;
  outputs[lane()] = EmissionAnswer(area_radiance(shape, s.ng, -c.d), pdf, s.shape, s.primitive, hit.t, 0u);
}
