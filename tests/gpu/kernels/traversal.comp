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
  const Hit hit = walk_hit(walk(ray, false));
  const bool any = walk_found(walk(ray, true));
  const Hit brute = trace_brute_force(ray);
  TraceAnswer a = TraceAnswer(hit.t, hit.instance, kNone, any ? 1u : 0u, brute.t, brute.instance, kNone, 0u);
  if (hit.instance != kNone) a.primitive = hit.primitive;
  if (brute.instance != kNone) {
    a.brute_primitive = brute.primitive;
    a.ties = count_ties(ray, brute.t);
  }
  outputs[lane()] = a;
}
