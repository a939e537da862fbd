// From pixel and random numbers to a camera ray.
#ifndef CAMERA_GLSL
#define CAMERA_GLSL

#include "features.glsl"
#include "frame.glsl"
#include "mutants.h"
#include "ray.glsl"
#include "sampler.glsl"
#include "scene.glsl"
#include "warp.glsl"

layout(constant_id = kConstantFilterKind) const uint kFilterKind = kFilterBox;
FEATURE(uint, kCamera, kConstantCamera, kCameraPinhole)
FEATURE(bool, kCameraWindow, kConstantCameraWindow, false)  // a part of the film, or its axis off centre

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
  const bool negative = kFilterKind == kFilterAlternating ? (uint(abs(x)) & 1u) != 0u : abs(x) > frame.filter_zero;
  weight = negative ? -frame.filter_weight : frame.filter_weight;
  MUTATE(kMutantFilterSignDropped, weight = frame.filter_weight);
  return x;
}

// Start of rays that do not begin at the camera's position: on a plane with its centre at camera_origin. For a distant camera this plane is in front
// of the scene: seen from the camera itself, the scene would be as large as the rounding errors of a position; here these are the rounding errors of
// a point of the scene and, as fractions of a pixel, those of `ndc`.
vec3 plane_point(vec2 ndc, vec2 lens) {
  MUTATE(kMutantPlaneTooWide, ndc.x *= 1.1);
  MUTATE(kMutantLensTooWide, lens *= 1.02);
  const vec2 start = vec2(frame.plane_x * ndc.x, frame.plane_y * ndc.y) + frame.lens_offset * lens;
  return frame.camera_origin + (frame.camera_x * start.x + frame.camera_y * start.y);
}

// The distance behind its start at which a camera ray with direction `d` leaves the camera.
float camera_ray_start(vec3 d) {
  if (kCamera != kCameraPlane && kCamera != kCameraLens) return 0.0;
  // Along d depth grows by the inverse of the length of the vector that reaches depth 1.
  const vec3 depth_axis = cross(frame.camera_x, frame.camera_y);
  return frame.plane_depth * (dot(frame.camera_z, depth_axis) / dot(d, depth_axis));
}

// Film position in pixels to [−1, 1]², 1 being the left and the upper edge of the whole film.
vec2 film_to_ndc(vec2 film) {
  if (kCameraWindow) return frame.window_offset - frame.window_scale * film;
  return 1.0 - 2.0 * film / vec2(frame.width, frame.height);
}

// A point of the aperture, in units of its radius. A polygon's corners are on the circle; u.x chooses one of the triangles around its centre.
vec2 lens_point(vec3 u) {
  MUTATE(kMutantBladesIgnored, u.x = u.y; float radius; return square_to_disk(u.yz, radius));
  if (frame.lens_blades == 0u) {
    float r;
    return square_to_disk(u.yz, r);
  }
  const float blades = float(frame.lens_blades);
  const float blade = min(floor(u.x * blades), blades - 1.0);
  const vec3 weights = square_to_triangle(u.yz);
  const vec2 from = cos_sin_turn(fract(frame.lens_rotation + blade / blades));
  const vec2 to = cos_sin_turn(fract(frame.lens_rotation + (blade + 1.0) / blades));
  return weights.y * from + weights.z * to;
}

// A panorama: longitude runs from +180° at the left edge to −180°, measured from +Z toward +X; polar angle runs from +Y down.
Ray spherical_ray(vec2 ndc) {
  MUTATE(kMutantPanoramaEven, ndc.y = 1.0 - 2.0 * (0.5 - 0.5 * ndc.y) * (0.5 - 0.5 * ndc.y));
  const vec2 longitude = cos_sin_turn(fract(0.5 * ndc.x));
  const vec2 polar = cos_sin_turn(fract(0.25 - 0.25 * ndc.y));
  const vec3 v = frame.camera_x * (longitude.y * polar.y) + frame.camera_y * polar.x + frame.camera_z * (longitude.x * polar.y);
  const float unit = length(v);
  return Ray(frame.camera_origin, frame.near_clip * unit, v * (1.0 / unit), frame.far_clip * unit);
}

// Into the hemisphere that contains camera +Z, distributed by the cosine with the plane's normal.
Ray irradiance_ray(vec3 o, vec2 u) {
  const vec3 across = normalize(cross(frame.camera_x, frame.camera_y));
  const vec3 n = dot(across, frame.camera_z) < 0.0 ? -across : across;
  const float unit = length(frame.camera_z);
  return Ray(o, frame.near_clip * unit, to_world(make_frame(n), square_to_cosine_hemisphere(u)), frame.far_clip * unit);
}

// The ray of one sample of one pixel. `u` is for the filter, `lens_u` for the aperture; `weight` is that of the reconstruction filter, times π if the
// sample is one of irradiance.
Ray sample_camera_ray(uvec2 pixel, vec2 u, vec3 lens_u, out float weight) {
  float weight_x, weight_y;
  const vec2 offset = vec2(sample_filter(u.x, weight_x), sample_filter(u.y, weight_y));
  weight = weight_x * weight_y;
  const vec2 ndc = film_to_ndc(vec2(pixel) + 0.5 + offset);
  if (kCamera == kCameraSpherical) return spherical_ray(ndc);
  vec2 slope = vec2(frame.tan_x * ndc.x, frame.tan_y * ndc.y);
  vec2 lens = vec2(0.0);
  if (kCamera == kCameraLens) lens = lens_point(lens_u);
  if (kCamera == kCameraLens) slope += frame.lens_slope * lens;
  const vec3 o = kCamera == kCameraPinhole ? frame.camera_origin : plane_point(ndc, lens);
  if (kCamera == kCameraIrradiance) {
    weight *= kPi;
    return irradiance_ray(o, lens_u.yz);
  }
  const vec3 v = frame.camera_x * slope.x + frame.camera_y * slope.y + frame.camera_z;
  // v reaches the plane at camera depth 1, so its length turns depths into distances.
  const float depth_scale = length(v);
  return Ray(o, frame.near_clip * depth_scale, v * (1.0 / depth_scale), frame.far_clip * depth_scale);
}

#endif
