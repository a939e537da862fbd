// The path estimator of docs/conventions.md, "Path estimator", as steps between rays: arrive() shades the end of a path segment and determines the
// next rays; settle_light() handles the result of a shadow ray. The caller decides who traces the rays, and when, so that one traversal site can
// serve both kinds.
#ifndef PATH_GLSL
#define PATH_GLSL

#include "../adapters.glsl"
#include "../features.glsl"
#include "../bsdf/bsdf.glsl"
#include "../camera.glsl"
#include "../emitter/emitter.glsl"
#include "../mutants.h"
#include "../scatterer.glsl"
#include "../trace.glsl"

FEATURE(uint, kIntegrator, kConstantIntegrator, kIntegratorPath)
layout(constant_id = kConstantNee) const bool kNee = true;  // and there are lights
layout(constant_id = kConstantMis) const bool kMis = true;
FEATURE(bool, kHideEmitters, kConstantHideEmitters, false)
FEATURE(bool, kHideBackground, kConstantHideBackground, false)
FEATURE(uint, kLightPart, kConstantLightPart, kLightPartAll)
const bool kGathersLight = kIntegrator == kIntegratorPath || kIntegrator == kIntegratorDirect || kIntegrator == kIntegratorWhitted;

// A path under construction: the ray that is traced next and what it carries.
struct Path {
  Ray ray;
  vec3 beta;           // throughput; the filter's weight is not part of it
  vec3 absorption;     // of the medium that the ray is in, per scene unit
  float bsdf_pdf;      // solid-angle density of the ray's direction; meaningless after a delta lobe
  vec3 n;              // shading normal at the ray's origin, for the density of light sampling there
  vec3 radiance;       // gathered so far
  float eta_scale;     // product of (n_i/n_o)² along the path
  uint segment;        // of the ray, the camera ray is 1
  bool full_emission;  // emission at the ray's end counts in full: camera ray, after a delta lobe, or no light sampling
  uint pixel;
  uint sample_index;
  float filter_weight;
  bool alive;          // `ray` is still to be traced
  // The light sample of the last vertex: counts if `shadow_ray` hits nothing.
  bool shadow_pending;
  Ray shadow_ray;
  vec3 shadow_value;
  // For scenes with surfaces that light may pass: what the rays have passed, and how many more segments the shadow ray may have.
  Passed passed;
  Passed shadow_passed;
  uint shadow_segments;
  uint shadow_vertex;  // vertex where the shadow ray began
  uint bounces;        // how often the path was scattered
  uint channel;        // after the first dispersing material: 1 red, 2 green, 3 blue
};

// Decisions taken at the end of a segment; kNone where nothing was decided. Kernels that need them fold them into signatures or write them out; in
// the others they are optimised away.
struct Decisions {
  uint instance, primitive;
  uint light_instance, light_primitive, light_contributed;
  uint lobe, survived;
};

Ray camera_ray(uint pixel, uvec2 xy, uint sample_index, out float weight) {
  const uvec4 words = random_words(frame.seed, pixel, sample_index, kBlockCamera);
  vec3 lens = vec3(0.0);
  if (kCamera == kCameraLens || kCamera == kCameraIrradiance) {
    const uvec4 more = reserved_words(frame.seed, pixel, sample_index, kBlockLens);
    lens = vec3(to_unit(more.x), to_unit(more.yz));
  }
  return sample_camera_ray(xy, to_unit(words.xy), lens, weight);
}

// Splits a position in the film into column and row.
uvec2 film_place(uint pixel) { return divide(pixel, frame.width).yx; }

Path begin_path(uint pixel, uvec2 xy, uint sample_index) {
  float weight;
  const Ray ray = camera_ray(pixel, xy, sample_index, weight);
  return Path(ray, vec3(1.0), vec3(0.0), 0.0, vec3(0.0), vec3(0.0), 1.0, 1u, true, pixel, sample_index, weight, true, false, ray, vec3(0.0),
              kNothingPassed, kNothingPassed, 0u, 0u, 0u, 0u);
}

Path begin_path(uint pixel, uint sample_index) { return begin_path(pixel, film_place(pixel), sample_index); }

#include "aov.glsl"
#include "direct.glsl"
#include "first_hit.glsl"

// The value of a finished path's sample.
vec3 path_value(Path path) { return (kIntegrator == kIntegratorAov ? aov_weight(path) : path.filter_weight) * path.radiance; }

// Whether light that was scattered this many times is gathered.
bool part_counts(uint bounces) {
  MUTATE(kMutantLightPartLate, return kLightPart == kLightPartAll || (kLightPart == kLightPartIndirect) == (bounces > 2u));
  if (kLightPart == kLightPartDirect) return bounces <= 1u;
  return kLightPart == kLightPartAll || bounces > 1u;
}

// Power heuristic with exponent 2 [Veach1997]: the weight of the strategy with density `own`. Written with a ratio, so that large densities do not
// overflow.
float power_heuristic(float own, float other) {
  const float ratio = other / own;
  return 1.0 / (1.0 + ratio * ratio);
}

// Samples that share a vertex: `direct` takes several, every other integrator one.
float light_sample_count() {
  MUTATE(kMutantSampleCountsForgotten, return 1.0);
  return kIntegrator == kIntegratorDirect ? float(frame.emitter_samples) : 1.0;
}
float bsdf_sample_count() { return kIntegrator == kIntegratorDirect ? float(frame.bsdf_samples) : 1.0; }

vec3 surface_emission(Path path, Surface s, Instance instance, SurfacePoint at) {
  vec3 le = area_radiance(instance, s.frame.n, -path.ray.d);
  if (textures_have(kTexturesRadiance) && max_component(le) > 0.0) le *= radiance_factor(at);
  return le;
}

// Step 2: emission hit by chance.
vec3 gather_emission(Path path, vec3 le, Surface s, vec3 weights, Instance instance, Primitive prim) {
  if (!part_counts(path.bounces)) return vec3(0.0);
  MUTATE(kMutantEmissionTwice, return path.beta * le);
  if (path.full_emission || instance.light_prob == 0.0) return path.beta * le;
  if (!kMis) return vec3(0.0);
  // ray.o is offset from the vertex by its error bound, which is far below the distance to the light.
  MUTATE(kMutantMisHeuristicsMixed, return path.beta * le / (1.0 + light_pdf(path.ray.o, path.n, path.ray.d, s, weights, instance, prim) / path.bsdf_pdf));
  float pdf_light = light_pdf(path.ray.o, path.n, path.ray.d, s, weights, instance, prim);
  if (kHasOutside) pdf_light *= lights_prob();
  return path.beta * le * power_heuristic(bsdf_sample_count() * path.bsdf_pdf, light_sample_count() * pdf_light);
}

// A position in the sky's picture whose radiance some light is still to be multiplied by: light that a ray leaving the scene gathers, or the light that
// was sampled. The end of a segment has at most one of them, and lavapipe would look up both for all lanes. Without a picture the light is complete.
struct LookUp {
  bool wanted;
  EnvironmentPlace at;
  vec3 gathered;  // by a ray that left the scene
};

void look_up(inout Path path, LookUp sky) {
  if (!sky.wanted) return;
  const vec3 le = kEnvironmentPictured ? picture_radiance(sky.at) : vec3(1.0);
  path.radiance += sky.gathered * le;
  path.shadow_value *= le;
  path.shadow_pending = path.shadow_pending && max_component(le) != 0.0;
}

// Step 1: light from the environment.
vec3 gather_environment(Path path, vec3 le, float pdf_light) {
  if (!part_counts(path.bounces)) return vec3(0.0);
  MUTATE(kMutantEnvironmentTwice, return path.beta * le);
  if (path.full_emission) return path.beta * le;
  if (!kMis) return vec3(0.0);
  return path.beta * le * power_heuristic(bsdf_sample_count() * path.bsdf_pdf, light_sample_count() * pdf_light);
}

// `n` is the normal by which lights are chosen.
LightSample sample_environment_or_light(Path path, Surface s, vec3 n) {
  const uint vertex = path.segment - 1u;
  uvec4 words = uvec4(0u);
  if (kHasOutside) {
    words = reserved_words(frame.seed, path.pixel, path.sample_index, block_environment(vertex));
    if (chooses_environment(words)) return sample_environment(words);
    if (chooses_distant_light(words)) return sample_distant_light(words.x);
  }
  LightSample light = sample_light(s.p, n, random_words(frame.seed, path.pixel, path.sample_index, block_light(vertex)));
  if (kHasOutside) {
    light.pdf_w *= lights_prob();
    light.mis_pdf *= lights_prob();
  }
  return light;
}

// The normal by which lights are chosen: 0 where light from both sides counts.
vec3 light_normal(Surface s, Material material) { return material_has(material, kMaterialTransmissive) ? vec3(0.0) : s.frame.n; }
// For a mixture it does not depend on which half was chosen.
vec3 light_normal(Scatterer chosen, OtherHalf other) {
  const vec3 n = light_normal(chosen.s, chosen.material);
  if (!is_mixed(other)) return n;
  return n == light_normal(other.scatterer.s, other.scatterer.material) ? n : vec3(0.0);
}

// A dispersing material refracts each colour differently: from there on a path carries one of the three, chosen by `u`.
void disperse(inout Path path, inout Material m, float u) {
  if (!material_has(m, kMaterialDispersive)) return;
  if (path.channel == 0u) {
    path.channel = 1u + min(uint(3.0 * u), 2u);
    path.beta *= 3.0 * vec3(equal(uvec3(1u, 2u, 3u), uvec3(path.channel)));
  }
  float part = float(path.channel) - 2.0;
  MUTATE(kMutantDispersionReversed, part = -part);
  m.eta.x = max(m.eta.x + part * (m.volume.w - 1.0) * (m.eta.x - 1.0), 1.001);
}

// Step 4: one sampled light, left pending until its shadow ray has been traced.
void sample_direct_light(inout Path path, Scatterer chosen, OtherHalf other, inout LookUp sky, inout Decisions decisions) {
  const Surface s = chosen.s;
  const LightSample light = sample_environment_or_light(path, s, light_normal(chosen, other));
  sky.wanted = kHasEnvironment && light.instance == kEnvironmentLight;
  sky.at = light.sky;
  decisions.light_instance = light.instance;
  decisions.light_primitive = light.instance != kNone ? light.primitive : kNone;
  decisions.light_contributed = light.instance != kNone ? 0u : kNone;
  const Scattering first = scattering(chosen, light.wi);
  vec3 reflected = first.value;
  float pdf = first.pdf;
  if (is_mixed(other)) {
    const Scattering second = scattering(other.scatterer, light.wi);
    reflected = mixed(other, reflected, second.value);
    MUTATE(kMutantMixtureHalfWhole, reflected += (1.0 - other.share) * first.value);
    pdf = mixed(other, pdf, second.pdf);
  }
  reflected *= light.radiance;
  path.shadow_pending = light.pdf_w > 0.0 && max_component(reflected) != 0.0;
  const bool from_outside = sky.wanted ||
                            (kDistantLights > 0u && light.instance == kDeltaLightSampled && light.error < 0.0);
  if (from_outside) {
    path.shadow_ray = spawn_ray(s.p, s.ng, s.error, light.wi);
  } else {
    path.shadow_ray = spawn_shadow_ray(s.p, s.ng, s.error, light.p, light.ng, light.error);
  }
  const float w_light = kMis ? power_heuristic(light_sample_count() * light.mis_pdf, bsdf_sample_count() * pdf) : 1.0;
  path.shadow_value = path.beta * reflected * (w_light / (light_sample_count() * light.pdf_w));
  if (kVolumes)
    path.shadow_value *= transmittance(absorption_toward(chosen.material, to_local(s.frame, light.wi), path.absorption), path.shadow_ray.t_max);
  // The contribution is unbounded near a point light. The cap takes effect only at distances that single precision
  // cannot resolve.
  if (kDeltaLights != 0u && light.instance == kDeltaLightSampled) path.shadow_value = min(path.shadow_value, vec3(frame.delta_light_limit));
  if (!part_counts(path.bounces + 1u)) path.shadow_value = vec3(0.0);
  path.shadow_passed = kNothingPassed;
  path.shadow_segments = frame.max_depth - path.segment - 1u;
  path.shadow_vertex = path.segment - 1u;
}

// Words for the choice at vertex k, or at a surface hit by a shadow ray from there; d is the direction of the ray, `flags` as in choice_words().
uvec4 choice_words_at(Path path, uint k, Surface s, vec3 d, uint flags) {
  uint side = dot(d, s.ng) > 0.0 ? 1u : 0u;
  MUTATE(kMutantMaskSidesTogether, side = 0u);
  return choice_words(frame.seed, path.pixel, path.sample_index, k, s.instance, s.primitive, side | flags);
}

// Whether the shadow ray, which has hit a surface, continues behind it.
bool shadow_passes(inout Path path, Ray ray, Hit hit) {
  MUTATE(kMutantMaskShadowsAll, return false);
  bool limited = kCountPasses;
  MUTATE(kMutantPassesFree, limited = false);
  if (limited && path.shadow_segments == 0u) return false;
  const Instance instance = fetch_instance(hit.instance);
  const Surface s = make_surface(ray, hit, instance);
  OtherChoice other;
  const SurfacePoint at = SurfacePoint(s.instance, s.primitive, hit.weights, s.ng);
  const uvec4 words = choice_words_at(path, path.shadow_vertex, s, ray.d, 2u);
  if (choose_material(instance.material, s.frame, at, hit.geometry, -ray.d, words, other).material != kNone) return false;
  --path.shadow_segments;
  path.shadow_ray.t_min = hit.t;
  path.shadow_passed = pass_behind(s, hit.t, ray.d);
  return true;
}

// Whether a shadow ray that has arrived may continue, because light may pass what it hit. What no light passes ends its walk, wherever it is; of the
// other surfaces it finds the nearest, and shadow_passes() decides.
const bool kShadowRaysEnd = !kPassable || !kGathersLight;
bool may_go_on(Walk walk) { return !kShadowRaysEnd && walk_found(walk) && !is_opaque(walk.nearest.order); }

// The shadow ray has been traced.
void settle_light(inout Path path, bool occluded) {
  if (!occluded) path.radiance += path.shadow_value;
  path.shadow_pending = false;
}

// Step 6: ends the path, or compensates for the paths that ended.
bool survive_roulette(inout Path path, float u) {
  float q = min(max_component(path.beta) * path.eta_scale, 0.99);
  if (kIntegrator == kIntegratorWhitted) q = kWhittedSurvival;
  if (u >= q) return false;
  MUTATE(kMutantRouletteUncompensated, return true);
  path.beta *= 1.0 / q;
  return true;
}

// Step 5 and 6: the next direction. Leaves path.alive false when the path ends here.
void scatter(inout Path path, Scatterer chosen, OtherHalf other, inout Decisions decisions) {
  const Surface s = chosen.s;
  const uvec4 words = random_words(frame.seed, path.pixel, path.sample_index, block_bsdf(path.segment - 1u));
  vec3 wi;
  const BsdfSample bs = sample_scattering(chosen, other, to_unit(words.x), to_unit(words.yz), wi);
  if (bs.pdf == 0.0 || max_component(bs.weight) == 0.0) {
    decisions.lobe = kLobeNone;
    return;
  }
  decisions.lobe = bs.lobe;
  ++path.bounces;
  path.beta *= bs.weight * (1.0 / bsdf_sample_count());
  path.eta_scale *= bs.eta_scale;
  path.full_emission = is_delta(bs.lobe) || !kNee;
  MUTATE(kMutantEmissionAfterDeltaLost, path.full_emission = !kNee);
  path.bsdf_pdf = bs.pdf;
  if (kVolumes) path.absorption = absorption_toward(chosen.material, bs.wi, path.absorption);
  path.n = light_normal(chosen, other);
  path.ray = spawn_ray(s.p, s.ng, s.error, wi);
  path.passed = kNothingPassed;
  path.alive = true;
  if (path.segment >= frame.rr_depth) {
    path.alive = survive_roulette(path, to_unit(words.w));
    decisions.survived = path.alive ? 1u : 0u;
  }
  if (path.alive) ++path.segment;
}

// The same ray continues behind a surface that it passes.
void pass_surface(inout Path path, Surface s, float t, inout Decisions decisions) {
  decisions.lobe = kLobePassed;
  path.ray.t_min = t;
  path.passed = pass_behind(s, t, path.ray.d);
  path.alive = true;
  if (kCountPasses) ++path.segment;
}

// All of arrive() except looking up the sky's picture.
void arrive_unlit(inout Path path, Hit hit, inout LookUp sky, out Decisions decisions) {
  decisions = Decisions(kNone, kNone, kNone, kNone, kNone, kNone, kNone);
  path.alive = false;
  path.shadow_pending = false;
  // A ray that has passed a surface starts there.
  if (kVolumes) path.beta *= transmittance(path.absorption, (hit.instance == kNone ? kInfinity : hit.t) - path.ray.t_min);
  if (hit.instance == kNone) {
    bool hidden = no_light_to_camera(path) || (kHideBackground && path.bounces == 0u);
    MUTATE(kMutantBackgroundSeen, hidden = no_light_to_camera(path));
    if (kHasEnvironment && (kGathersLight || kIntegrator == kIntegratorAov) && !hidden) {
      float pdf_light;
      const vec3 le = environment_radiance(path.ray.d, sky.at, pdf_light);
      if (kIntegrator == kIntegratorAov) {
        see_emission(path, kEnvironmentPictured ? picture_radiance(sky.at) : le);
      } else {
        sky.wanted = true;
        sky.gathered = gather_environment(path, le, pdf_light);
      }
    }
    if (kIntegrator == kIntegratorVisibility) path.radiance += vec3(1.0);
    if (kIntegrator == kIntegratorDirect && !is_camera_segment(path)) next_direct_round(path);
    if (!is_finite(path.ray.o + path.ray.d)) path.radiance = vec3(kInfinity);  // the film rejects the sample and counts it
    return;
  }
  const Instance instance = fetch_instance(hit.instance);
  Surface s = make_surface(path.ray, hit, instance);
  decisions.instance = s.instance;
  decisions.primitive = s.primitive;
  if (!kGathersLight && kIntegrator != kIntegratorAov) {
    shade_first_hit(path, s, hit);
    return;
  }
  const SurfacePoint at = SurfacePoint(s.instance, s.primitive, attribute_weights(hit, s), s.ng);
  if (kHideEmitters && hidden_from_camera(path, instance)) {
    pass_through(path, s, hit);
    return;
  }
  if (!no_light_to_camera(path)) {
    const vec3 le = surface_emission(path, s, instance, at);
    if (kIntegrator == kIntegratorAov) see_emission(path, le);
    else path.radiance += gather_emission(path, le, s, hit.weights, instance, hit.geometry);
  }
  uint max_depth = frame.max_depth;
  MUTATE(kMutantDepthOffByOne, ++max_depth);
  Choice choice = Choice(instance.material, s.frame, s.base, 1.0, true);
  OtherChoice other_choice = OtherChoice(choice, -1.0);
  const uvec4 words = choice_words_at(path, path.segment - 1u, s, path.ray.d, 0u);
  if (kAdapters != 0u && (path.segment < max_depth || !kCountPasses)) {
    choice = choose_material(instance.material, s.frame, at, hit.geometry, -path.ray.d, words, other_choice);
    if (kPassable && choice.material == kNone) {
      pass_surface(path, s, hit.t, decisions);
      return;
    }
  }
  if (kIntegrator == kIntegratorDirect && !is_camera_segment(path)) {
    next_direct_round(path);
    return;
  }
  s.frame = choice.frame;
  s.base = choice.base;
  s.shadowed = choice.shadowed;
  if (kIntegrator == kIntegratorAov && frame.aov <= kAovLastAtHit) {
    path.radiance = value_at_hit(path, s, instance, at);
    return;
  }
  if (kLightPart == kLightPartDirect && path.bounces > 0u) return;
  if (path.segment >= max_depth) return;
  Scatterer chosen = scatterer_of(choice, s, at, hit.geometry, -path.ray.d);
  if (kDispersive && kIntegrator != kIntegratorAov) disperse(path, chosen.material, choice_number(words, kNone));
  const Material material = chosen.material;
  s = chosen.s;
  if (kIntegrator == kIntegratorAov && frame.aov == kAovNormal && !material_has(material, kMaterialDelta)) {
    path.radiance = s.frame.n;
    return;
  }
  if (is_black(chosen, -path.ray.d)) {
    decisions.lobe = kLobeNone;
    return;
  }
  OtherHalf other = OtherHalf(chosen, -1.0);
  if (kBlended && (kGathersLight || kIntegrator == kIntegratorAov) && other_choice.share >= 0.0)
    other = other_half(chosen, other_choice, at, hit.geometry, -path.ray.d, words);
  if (kDispersive && kIntegrator != kIntegratorAov && is_mixed(other)) disperse(path, other.scatterer.material, choice_number(words, kNone));
  const bool delta = material_has(material, kMaterialDelta);
  const bool all_delta = delta && (!is_mixed(other) || material_has(other.scatterer.material, kMaterialDelta));
  const uint round = direct_round(path);
  if (kNee && !all_delta && (kIntegrator != kIntegratorDirect || round < frame.emitter_samples)) sample_direct_light(path, chosen, other, sky, decisions);
  if (kIntegrator == kIntegratorWhitted && !delta) return;
  if (kIntegrator != kIntegratorDirect || round < frame.bsdf_samples) scatter(path, chosen, other, decisions);
  if (kIntegrator == kIntegratorDirect && !path.alive) next_direct_round(path);
  bool seen = !delta;
  MUTATE(kMutantAovEndsAtMirror, seen = true);
  if (kIntegrator == kIntegratorAov && seen) end_at_albedo(path, decisions);
}

// Shades the end of path.ray: gathers emission, prepares the shadow ray (path.shadow_pending) and the next segment (path.alive).
void arrive(inout Path path, Hit hit, out Decisions decisions) {
  LookUp sky = LookUp(false, EnvironmentPlace(0u, 0u, 0.0, 0.0), vec3(0.0));
  arrive_unlit(path, hit, sky, decisions);
  look_up(path, sky);
}

// Shades the end of a segment whose ray has hit `hit`, for the kernels that trace single paths. `steps` counts
// traversal rounds; beyond the budget the result is void.
void end_segment(inout Path path, Hit hit, uint step_budget, inout uint steps, out Decisions decisions) {
  arrive(path, hit, decisions);
  steps += (2u * kLightTreeDepth + 7u) / 8u;  // this lane's share of the loops that all lanes of a SIMD group go through together
  if (!path.shadow_pending) return;
  bool occluded;
  for (;;) {
    const Walk walk = trace(path.shadow_ray, true, path.shadow_passed, step_budget, steps);
    occluded = walk_found(walk);
    if (!may_go_on(walk) || !shadow_passes(path, path.shadow_ray, walk_hit(walk))) break;
  }
  if (kGathersLight) decisions.light_contributed = occluded ? 0u : 1u;
  else decisions.survived = occluded ? 0u : 1u;
  settle_light(path, occluded);
}

// One whole segment.
void path_segment(inout Path path, uint step_budget, inout uint steps, out Decisions decisions) {
  const Hit hit = walk_hit(trace(path.ray, false, path.passed, step_budget, steps));
  end_segment(path, hit, step_budget, steps, decisions);
}

#endif
