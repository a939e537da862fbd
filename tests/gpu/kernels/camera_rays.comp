#version 460
#extension GL_GOOGLE_include_directive : require
#include "camera.glsl"
#include "test_io.glsl"

TEST_BUFFERS(CameraCase, CameraAnswer)

void main() {
  if (!lane_has_work()) return;
  const CameraCase c = inputs[lane()];
  float weight;
  const Ray ray = sample_camera_ray(uvec2(c.x, c.y), c.u, c.lens, weight);
  outputs[lane()] = CameraAnswer(ray.o, ray.t_min, ray.d, ray.t_max, weight, 0u, 0u, 0u);
}
