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
  const Hit hit = walk(ray, false);
  SpawnAnswer a = SpawnAnswer(vec3(0.0), kNone, vec3(0.0), kNone, 0.0, kInfinity, kNone, kNone);
  if (hit.slot != kNone) {
    Shape shape;
    const Surface s = make_surface(ray, hit, shape);
    const Hit next = walk(spawn_ray(s.p, s.ng, s.error, c.wi), false);
    a = SpawnAnswer(s.p, s.shape, s.ng, s.primitive, s.error, next.t, kNone, kNone);
    if (next.slot != kNone) {
      const Primitive p = fetch_primitive(next.slot);
      a.next_shape = p.shape;
      a.next_primitive = p.primitive;
    }
  }
  outputs[lane()] = a;
}
