// Lights without extent: points, spots, projectors and directional lights. docs/conventions.md, "Lights without extent".
#include "../features.glsl"
#include "../mutants.h"

FEATURE(uint, kDeltaLights, kConstantDeltaLights, 0u)      // kDelta… of all of them
FEATURE(uint, kDistantLights, kConstantDistantLights, 0u)  // the first ones of the table are infinitely far away

// Instead of a density, since no other strategy can find these lights: the MIS weights are 1 and 0.
const float kDeltaDensity = 1e30;

#define delta_lights_are(flags) ((kDeltaLights & (flags)) != 0u)

// Fraction of a spot's intensity in the unit direction w, at the angle θ from its axis.
float spot_share(DeltaLight light, vec3 w) {
  const float cos_theta = dot(light.forward, w);
  if (cos_theta <= light.cos_cutoff) return 0.0;
  if (cos_theta >= light.cos_beam) return 1.0;
  float t = (cos_theta - light.cos_cutoff) * light.fade;
  if ((light.header & kDeltaSmooth) != 0u) return t * t * (3.0 - 2.0 * t);
  if ((light.header & kDeltaQuartic) != 0u) return t * t * t * t;
  t = (light.cutoff_turns - turn_of(cos_theta, length(cross(light.forward, w)))) * light.fade;
  MUTATE(kMutantSpotFadesByCosine, t = (cos_theta - light.cos_cutoff) / (light.cos_beam - light.cos_cutoff));
  return clamp(t, 0.0, 1.0);
}

// The value of the light's picture in direction w; a projector is black outside it.
vec3 picture_of_light(DeltaLight light, vec3 w) {
  const float z = dot(light.forward, w);
  const vec2 slope = vec2(dot(light.across, w), dot(cross(light.forward, light.across), w)) / z;
  const vec2 uv = 0.5 + slope * light.picture_scale;
  const bool projects = delta_lights_are(kDeltaProjector) && (light.header & kDeltaProjector) != 0u;
  vec3 shown = vec3(1.0);
  if (delta_lights_are(kDeltaTextured) && light.texture_index != kNone) shown = texture_at(fetch_texture(light.texture_index), vec3(uv, 1.0)).xyz;
  if (!projects) return shown;
  const bool beside = z <= 0.0 || any(lessThan(uv, vec2(0.0))) || any(greaterThan(uv, vec2(1.0)));
  MUTATE(kMutantProjectorByIntensity, return beside ? vec3(0.0) : shown);
  // The irradiance of the plane z = 1 is the intensity times cos³θ.
  return beside ? vec3(0.0) : shown / (z * z * z);
}

// The intensity toward the unit direction w.
vec3 delta_intensity(DeltaLight light, vec3 w) {
  vec3 intensity = light.intensity;
  if (delta_lights_are(kDeltaSpot) && (light.header & kDeltaSpot) != 0u) intensity *= spot_share(light, w);
  if (delta_lights_are(kDeltaProjector | kDeltaTextured) && (light.header & (kDeltaProjector | kDeltaTextured)) != 0u) {
    intensity *= max_component(intensity) > 0.0 ? picture_of_light(light, w) : vec3(0.0);
  }
  return intensity;
}

// A light with a position, chosen with probability `prob`.
LightSample sample_delta_light(vec3 p, DeltaLight light, float prob) {
  const vec3 v = light.p - p;
  const float d2 = dot(v, v);
  LightSample ls;
  ls.p = light.p;
  ls.error = 0.0;
  ls.ng = vec3(0.0);
  ls.wi = v * inversesqrt(d2);
  ls.pdf_w = d2 > 0.0 ? prob : 0.0;
  ls.mis_pdf = kDeltaDensity;
  ls.radiance = delta_intensity(light, -ls.wi) / d2;
  MUTATE(kMutantPointDistanceNotSquared, ls.radiance *= sqrt(d2));
  MUTATE(kMutantPointWeighed, ls.mis_pdf = 0.3);
  ls.instance = kDeltaLightSampled;
  ls.primitive = light.number;
  return ls;
}

// A light infinitely far away: the last one whose threshold is <= word.
LightSample sample_distant_light(uint word) {
  uint first = 0u;
  for (uint count = kDistantLights; count > 1u; count -= count >> 1u) {
    const uint half_count = count >> 1u;
    // Beyond the last one, nothing is looked up.
    first += first + half_count < kDistantLights && fetch_delta_light_threshold(first + half_count) <= word ? half_count : 0u;
  }
  const DeltaLight light = fetch_delta_light(first);
  LightSample ls;
  ls.error = -1.0;  // the light has no position
  ls.wi = light.p;
  ls.pdf_w = light.prob;
  MUTATE(kMutantDistantChoiceForgotten, ls.pdf_w = 1.0);
  ls.mis_pdf = kDeltaDensity;
  ls.radiance = light.intensity;
  ls.instance = kDeltaLightSampled;
  ls.primitive = light.number;
  return ls;
}
