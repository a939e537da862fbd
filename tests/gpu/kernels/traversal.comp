#version 460
#extension GL_GOOGLE_include_directive : require
#include "test_io.glsl"
#include "brute_force.glsl"
#include "walk.glsl"

TEST_BUFFERS(RayCase, TraceAnswer)

void main() {
  if (!lane_has_work()) return;
  const RayCase c = inputs[lane()];
  const Ray ray = Ray(c.o, c.t_min, c.d, c.t_max);
  const Hit hit = walk(ray, false);
  const Hit any = walk(ray, true);
  const Hit brute = trace_brute_force(ray);
  TraceAnswer a = TraceAnswer(hit.t, kNone, kNone, any.slot != kNone ? 1u : 0u, brute.t, kNone, kNone, 0u);
  if (hit.slot != kNone) {
    const Primitive p = fetch_primitive(hit.slot);
    a.shape = p.shape;
    a.primitive = p.primitive;
  }
  if (brute.slot != kNone) {
    const Primitive p = fetch_primitive(brute.slot);
    a.brute_shape = p.shape;
    a.brute_primitive = p.primitive;
    a.ties = count_ties(ray, brute.t);
  }
  outputs[lane()] = a;
}
