// Diffuse area light on a triangle, disk, cylinder or sphere, emitting on the side of the shading normal.
#include "../features.glsl"
#include "../mutants.h"

FEATURE(bool, kTwoSidedLights, kConstantTwoSidedLights, false)
bool shines_on_both_sides(Instance instance) {
  MUTATE(kMutantLampBackDark, return false);
  return kTwoSidedLights && instance.light_area < 0.0;
}
float light_area_of(Instance instance) { return kTwoSidedLights ? abs(instance.light_area) : instance.light_area; }

// Radiance toward w (pointing away from the surface).
vec3 area_radiance(Instance instance, vec3 ns, vec3 w) {
  MUTATE(kMutantEmitterTwoSided, return instance.radiance);
  return shines_on_both_sides(instance) || dot(w, ns) > 0.0 ? instance.radiance : vec3(0.0);
}

// The factor of a lamp's radiance at a point of it.
vec3 radiance_factor(SurfacePoint at) { return color_factor(fetch_instance_attributes(at.instance).radiance_texture, at); }

// 1 − cos of the half angle of the cone subtended by the emitting side of a sphere: 0 if p is not outside. Inward ones subtend all directions from
// inside.
float sphere_one_minus_cos(vec3 p, Primitive sphere) {
  const vec3 v = sphere.p0 - p;
  const float radius = sphere.p1.x;
  const float d2 = dot(v, v);
  if (is_inward(sphere)) {
    const float reach = radius + surface_error(sphere);  // its own points see it, too
    return d2 < reach * reach ? 2.0 : 0.0;
  }
  const float sin2 = radius * radius / d2;
  return d2 > radius * radius ? sin2 / (1.0 + sqrt(max(0.0, 1.0 - sin2))) : 0.0;
}

// How a primitive was chosen: the probability of its instance, its own within it, and the area over which the MIS weights spread the former.
struct LightChoice {
  float instance_prob;
  float primitive_prob;
  float mis_area;
};

// Or on a disk: the two differ in the position and number of their points in the plane of p0, p1 and p2.
LightSample area_sample_flat(vec3 p, Primitive tri, Instance instance, LightChoice choice, vec2 u) {
  vec3 b = square_to_triangle(u);
  float share = 0.5;  // of the area of the parallelogram of p1 − p0 and p2 − p0
  if (is_disk(tri)) {
    float r;
    const vec2 d = square_to_disk(u, r);
    b = vec3(1.0 - d.x - d.y, d);
    share = kPi;
    MUTATE(kMutantDiskAreaOfASquare, share = 4.0);
  }
  LightSample ls;
  ls.p = b.x * tri.p0 + b.y * tri.p1 + b.z * tri.p2;
  const vec3 n = cross(tri.p1 - tri.p0, tri.p2 - tri.p0);
  const float largest = max_component(abs(n));
  const vec3 scaled = n / largest;  // the square of a tiny area would vanish
  const float scaled_length = length(scaled);
  const float twice_area = largest * scaled_length;
  ls.ng = scaled * (1.0 / scaled_length);
  if (kInstanced && instance.place != kNone) ls.ng *= fetch_place(instance.place).side;
  const vec3 v = ls.p - p;
  const float d2 = dot(v, v);
  ls.wi = v * inversesqrt(d2);
  // The shading normal decides on which side the light emits, the geometric normal how large it appears.
  bool facing = dot(ls.wi, kLightNormals ? shading_normal(instance, tri.primitive, b, ls.ng) : ls.ng) < 0.0;
  facing = facing || shines_on_both_sides(instance);
  MUTATE(kMutantEmitterTwoSided, facing = true);
  const float cos_light = abs(dot(ls.wi, ls.ng));
  facing = facing && cos_light > 0.0 && d2 > 0.0;
  // prob/area turned into solid angle: dω = cos θ dA / d².
  ls.pdf_w = facing ? choice.instance_prob * choice.primitive_prob * d2 / (share * twice_area * cos_light) : 0.0;
  ls.mis_pdf = facing ? choice.instance_prob * d2 / (choice.mis_area * cos_light) : 0.0;
  MUTATE(kMutantTriangleChoiceForgotten, ls.pdf_w /= choice.primitive_prob);
  MUTATE(kMutantDistanceNotSquared, ls.pdf_w /= sqrt(d2));
  return ls;
}

LightSample area_sample_sphere(vec3 p, Primitive sphere, LightChoice choice, vec2 u) {
  const vec3 center = sphere.p0;
  const float radius = sphere.p1.x;
  const float one_minus_cos = sphere_one_minus_cos(p, sphere);
  LightSample ls;
  const vec3 v = center - p;
  const float distance = length(v);
  const vec3 local = square_to_cone(u, one_minus_cos);
  const bool inward = is_inward(sphere);
  ls.wi = to_world(make_frame(inward && distance == 0.0 ? vec3(0.0, 0.0, 1.0) : v / distance), local);
  // Nearer intersection of that direction, by the law of cosines; local.xy carries sin θ without cancellation. From inside there is one ahead.
  const float sin2 = dot(local.xy, local.xy);
  const float half_chord = sqrt(max(0.0, radius * radius - distance * distance * sin2));
  const float t = distance * local.z + (inward ? half_chord : -half_chord);
  ls.ng = normalize(p + t * ls.wi - center);
  ls.p = center + radius * ls.ng;
  if (inward) ls.ng = -ls.ng;
  ls.pdf_w = one_minus_cos > 0.0 ? choice.instance_prob / (2.0 * kPi * one_minus_cos) : 0.0;
  ls.mis_pdf = ls.pdf_w;
  return ls;
}

// Uniform by area: u.x along the axis, u.y around it.
LightSample area_sample_cylinder(vec3 p, Primitive prim, LightChoice choice, vec2 u) {
  const vec3 axis = prim.p1 - prim.p0;
  const float height = length(axis);
  const float radius = prim.p2.x;
  const ShadingFrame around = make_frame(axis * (1.0 / height));
  const float phi = 2.0 * kPi * u.y;
  const vec3 outward = cos(phi) * around.s + sin(phi) * around.t;
  LightSample ls;
  ls.p = prim.p0 + u.x * axis + radius * outward;
  ls.ng = prim.p2.y * outward;
  const vec3 v = ls.p - p;
  const float d2 = dot(v, v);
  ls.wi = v * inversesqrt(d2);
  const float cos_light = -dot(ls.wi, ls.ng);
  const bool facing = cos_light > 0.0 && d2 > 0.0;
  float area = 2.0 * kPi * radius * height;
  MUTATE(kMutantCylinderHalfArea, area *= 0.5);
  ls.pdf_w = facing ? choice.instance_prob * choice.primitive_prob * d2 / (area * cos_light) : 0.0;
  ls.mis_pdf = facing ? choice.instance_prob * d2 / (choice.mis_area * cos_light) : 0.0;
  return ls;
}

// Weights of the point that area_sample chooses, as needed by textures.
vec3 sampled_weights(Primitive prim, vec2 u) {
  if (is_cylinder(prim)) return vec3(1.0 - u.x, u.x, 0.0);
  if (!is_disk(prim)) return square_to_triangle(u);
  float r;
  const vec2 d = square_to_disk(u, r);
  return vec3(1.0 - d.x - d.y, d);
}

LightSample area_sample(vec3 p, Primitive prim, Instance instance, LightChoice choice, vec2 u) {
  LightSample ls;
  if (kSphereLights && is_sphere(prim)) {
    ls = area_sample_sphere(p, prim, choice, u);
  } else if (kCylinderLights && is_cylinder(prim)) {
    ls = area_sample_cylinder(p, prim, choice, u);
  } else {
    ls = area_sample_flat(p, prim, instance, choice, u);
  }
  ls.error = surface_error(prim);
  MUTATE(kMutantLightChoiceForgotten, ls.pdf_w /= choice.instance_prob);
  MUTATE(kMutantLightPdfScaled, ls.pdf_w *= 1.02);
  ls.radiance = instance.radiance;
  bool textured = textures_have(kTexturesRadiance);
  MUTATE(kMutantLightTextureIgnored, textured = false);
  if (textured) ls.radiance *= radiance_factor(SurfacePoint(prim.instance, prim.primitive, sampled_weights(prim, u), ls.ng));
  ls.instance = prim.instance;
  ls.primitive = prim.primitive;
  return ls;
}

// `prob` is that of the choice, `area` what it is spread over.
float area_pdf(vec3 p, vec3 wi, Surface s, Primitive prim, float prob, float area) {
  if (kSphereLights) {
    const float one_minus_cos = sphere_one_minus_cos(p, prim);
    if (is_sphere(prim)) return one_minus_cos > 0.0 ? prob / (2.0 * kPi * one_minus_cos) : 0.0;
  }
  const vec3 v = s.p - p;
  const float cos_light = abs(dot(wi, s.ng));
  return cos_light > 0.0 ? prob * dot(v, v) / (area * cos_light) : 0.0;
}
