// The path estimator of docs/conventions.md, "Path estimator", one segment at a time.
#ifndef PATH_GLSL
#define PATH_GLSL

#include "../bsdf/bsdf.glsl"
#include "../camera.glsl"
#include "../emitter/emitter.glsl"
#include "../trace.glsl"

layout(constant_id = 1) const uint kIntegrator = kIntegratorPath;
layout(constant_id = 2) const bool kNee = true;
layout(constant_id = 3) const bool kMis = true;

// A path under construction: the ray that is traced next and what it carries.
struct Path {
  Ray ray;
  vec3 beta;           // throughput; the filter's weight is not part of it
  float bsdf_pdf;      // solid-angle density of the ray's direction; meaningless after a delta lobe
  vec3 radiance;       // gathered so far
  float eta_scale;     // product of (n_i/n_o)² along the path
  uint segment;        // of the ray, the camera ray is 1
  bool full_emission;  // emission at the ray's end counts in full: camera ray, after a delta lobe, or no light sampling
  uint pixel;
  uint sample_index;
  uint steps;          // traversal steps spent
  float filter_weight;
};

// Decisions taken at the end of a segment; kNone where nothing was decided. Folded into signatures or written out by the kernels that
// want them, optimised away in the others.
struct Decisions {
  uint shape, primitive;
  uint light_shape, light_primitive, light_contributed;
  uint lobe, survived;
};

Path begin_path(uint pixel, uint sample_index) {
  const uvec4 words = random_words(frame.seed, pixel, sample_index, kBlockCamera);
  const uvec2 xy = uvec2(pixel % frame.width, pixel / frame.width);
  float weight;
  const Ray ray = sample_camera_ray(xy, to_unit(words.xy), weight);
  return Path(ray, vec3(1.0), 0.0, vec3(0.0), 1.0, 1u, true, pixel, sample_index, 0u, weight);
}

// The value of a finished path's sample.
vec3 path_value(Path path) { return path.filter_weight * path.radiance; }

vec3 sky_radiance(vec3 d) { return mix(frame.sky_horizon, frame.sky_top, clamp(d.y, 0.0, 1.0)); }

// Power heuristic with exponent 2 [Veach1997], as the weight of the strategy with density `own`. A ratio, so that large densities
// do not overflow.
float power_heuristic(float own, float other) {
  const float ratio = other / own;
  return 1.0 / (1.0 + ratio * ratio);
}

// Step 2: emission met by chance.
vec3 gather_emission(Path path, Surface s, Shape shape, uint slot) {
  const vec3 le = area_radiance(shape, s.ng, -path.ray.d);
  if (path.full_emission || shape.light_prob == 0.0) return path.beta * le;
  if (!kMis) return vec3(0.0);
  // ray.o is offset from the vertex by its error bound, which is far below the distance to the light.
  return path.beta * le * power_heuristic(path.bsdf_pdf, light_pdf(path.ray.o, path.ray.d, s, shape, slot));
}

// Step 4: one sampled light, one shadow ray.
vec3 gather_light(inout Path path, Surface s, Shape shape, vec3 wo, uint step_budget, inout Decisions decisions) {
  const LightSample light = sample_light(s.p, random_words(frame.seed, path.pixel, path.sample_index, block_light(path.segment - 1u)));
  decisions.light_shape = light.shape;
  decisions.light_primitive = light.primitive;
  decisions.light_contributed = 0u;
  const vec3 wi = to_local(s.frame, light.wi);
  const vec3 reflected = bsdf_eval(shape, wo, wi) * light.radiance;
  if (light.pdf_w <= 0.0 || max_component(reflected) == 0.0 || !consistent_side(s, light.wi)) return vec3(0.0);
  const Ray shadow = spawn_shadow_ray(s.p, s.ng, s.error, light.p, light.ng, light.error);
  if (trace(shadow, true, step_budget, path.steps).slot != kNone) return vec3(0.0);
  decisions.light_contributed = 1u;
  const float w_light = kMis ? power_heuristic(light.mis_pdf, bsdf_pdf(shape, wo, wi)) : 1.0;
  return path.beta * reflected * (w_light / light.pdf_w);
}

// Step 6: ends the path or makes up for the paths that ended.
bool survive_roulette(inout Path path, float u) {
  const float q = min(max_component(path.beta) * path.eta_scale, 0.99);
  if (u >= q) return false;
  path.beta /= q;
  return true;
}

// Traces path.ray, gathers what its end sends back and prepares the next ray; false when the path has ended. When path.steps exceeds
// the budget the result is void.
bool path_segment(inout Path path, uint step_budget, out Decisions decisions) {
  decisions = Decisions(kNone, kNone, kNone, kNone, kNone, kNone, kNone);
  const Hit hit = trace(path.ray, false, step_budget, path.steps);
  if (hit.slot == kNone) {
    if (kIntegrator == kIntegratorPath) path.radiance += path.beta * sky_radiance(path.ray.d);
    return false;
  }
  Shape shape;
  const Surface s = make_surface(path.ray, hit, shape);
  decisions.shape = s.shape;
  decisions.primitive = s.primitive;
  if (kIntegrator == kIntegratorNormals) {
    path.radiance += path.beta * (0.5 * s.frame.n + 0.5);
    return false;
  }
  path.radiance += gather_emission(path, s, shape, hit.slot);
  if (path.segment >= frame.max_depth) return false;

  const vec3 wo = to_local(s.frame, -path.ray.d);
  if (!consistent_side(s, -path.ray.d) || (bsdf_is_one_sided(shape) && wo.z <= 0.0)) {
    decisions.lobe = kLobeNone;
    return false;
  }
  if (kNee && !bsdf_is_delta(shape) && frame.light_shape_count > 0u) {
    path.radiance += gather_light(path, s, shape, wo, step_budget, decisions);
  }

  const uvec4 words = random_words(frame.seed, path.pixel, path.sample_index, block_bsdf(path.segment - 1u));
  const BsdfSample bs = bsdf_sample(shape, wo, to_unit(words.x), to_unit(words.yz));
  const vec3 wi = to_world(s.frame, bs.wi);
  // A transmitted direction changes sides of both normals together; a mismatch means light would leak through.
  if (bs.pdf == 0.0 || max_component(bs.weight) == 0.0 || !consistent_side(s, wi)) {
    decisions.lobe = kLobeNone;
    return false;
  }
  decisions.lobe = bs.lobe;
  path.beta *= bs.weight;
  path.eta_scale *= bs.eta_scale;
  path.full_emission = is_delta(bs.lobe) || !kNee;
  path.bsdf_pdf = bs.pdf;
  path.ray = spawn_ray(s.p, s.ng, s.error, wi);
  if (frame.rr_depth > 0u && path.segment >= frame.rr_depth) {
    const bool survived = survive_roulette(path, to_unit(words.w));
    decisions.survived = survived ? 1u : 0u;
    if (!survived) return false;
  }
  ++path.segment;
  return true;
}

#endif
