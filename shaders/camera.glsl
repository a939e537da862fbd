// Pixel and random numbers to a camera ray.
#ifndef CAMERA_GLSL
#define CAMERA_GLSL

#include "mutants.h"
#include "ray.glsl"
#include "sampler.glsl"
#include "scene.glsl"

layout(constant_id = kConstantFilterKind) const uint kFilterKind = kFilterBox;
layout(constant_id = kConstantCamera) const uint kCamera = kCameraPinhole;

// Offset from the pixel centre, in pixels, distributed like |filter|; `weight` is ±∫|f|/∫f.
float sample_filter(float u, out float weight) {
  MUTATE(kMutantJitterMissing, u = 0.5);
  if (kFilterKind == kFilterBox) {
    weight = 1.0;
    return u - 0.5;
  }
  const float position = u * float(kFilterSteps);
  const uint i = min(uint(position), kFilterSteps - 1u);
  const float x = mix(fetch_filter_knot(i), fetch_filter_knot(i + 1u), position - float(i));
  weight = abs(x) > frame.filter_zero ? -frame.filter_weight : frame.filter_weight;
  MUTATE(kMutantFilterSignDropped, weight = frame.filter_weight);
  return x;
}

// Where a camera far from the scene lets its rays begin: on a plane before the scene, which camera_origin is the middle of. Seen from the camera
// itself the scene would be as large as the rounding errors of a position; here they are those of a point of the scene, and, as fractions of a pixel,
// those of `ndc`.
vec3 plane_point(vec2 ndc) {
  MUTATE(kMutantPlaneTooWide, ndc.x *= 1.02);
  return frame.camera_origin + (frame.camera_x * (frame.plane_x * ndc.x) + frame.camera_y * (frame.plane_y * ndc.y));
}

// How far behind its start a camera ray with direction `d` leaves the camera.
float camera_ray_start(vec3 d) {
  if (kCamera == kCameraPinhole) return 0.0;
  // Along d depth grows by the inverse of the length of the vector that reaches depth 1.
  const vec3 depth_axis = cross(frame.camera_x, frame.camera_y);
  return frame.plane_depth * (dot(frame.camera_z, depth_axis) / dot(d, depth_axis));
}

// The ray of one sample of one pixel; `weight` is that of the reconstruction filter.
Ray sample_camera_ray(uvec2 pixel, vec2 u, out float weight) {
  float weight_x, weight_y;
  const vec2 offset = vec2(sample_filter(u.x, weight_x), sample_filter(u.y, weight_y));
  weight = weight_x * weight_y;
  const vec2 film = vec2(pixel) + 0.5 + offset;
  const vec2 ndc = 1.0 - 2.0 * film / vec2(frame.width, frame.height);
  const vec3 v = frame.camera_x * (frame.tan_x * ndc.x) + frame.camera_y * (frame.tan_y * ndc.y) + frame.camera_z;
  // v reaches the plane at camera depth 1, so its length turns depths into distances.
  const float depth_scale = length(v);
  const vec3 o = kCamera == kCameraPlane ? plane_point(ndc) : frame.camera_origin;
  return Ray(o, frame.near_clip * depth_scale, v * (1.0 / depth_scale), frame.far_clip * depth_scale);
}

#endif
