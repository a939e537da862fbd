#version 460
#extension GL_GOOGLE_include_directive : require
#include "surface.glsl"
#include "test_io.glsl"
#include "walk.glsl"

TEST_BUFFERS(SpawnCase, SpawnAnswer)

void main() {
  if (!lane_has_work()) return;
  const SpawnCase c = inputs[lane()];
  const Ray ray = Ray(c.o, 0.0, c.d, kInfinity);
  const Hit hit = walk_hit(walk(ray, false));
  SpawnAnswer a = SpawnAnswer(vec3(0.0), kNone, vec3(0.0), kNone, 0.0, kInfinity, kNone, kNone);
  if (hit.instance != kNone) {
    const Surface s = make_surface(ray, hit, fetch_instance(hit.instance));
    const Hit next = walk_hit(walk(spawn_ray(s.p, s.ng, s.error, c.wi), false));
    a = SpawnAnswer(s.p, s.instance, s.ng, s.primitive, s.error, next.t, kNone, kNone);
    a.next_instance = next.instance;
    if (next.instance != kNone) a.next_primitive = next.primitive;
  }
  outputs[lane()] = a;
}
