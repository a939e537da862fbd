// Choosing among many lights by their possible contribution to a point: docs/conventions.md, "Light tree" [Conty2018].
#include "../material_flags.glsl"
#include "../mutants.h"

// Levels of the tree; 0: lights are chosen by power alone. A constant, because lavapipe would compute both choices behind an `if`.
layout(constant_id = kConstantLightTreeDepth) const uint kLightTreeDepth = 0u;
const bool kLightTree = kLightTreeDepth > 0u;

// Height of a group above a plane, as used for the choice: its middle is at `middle`, and it reaches `reach` above and
// below. 0 only if all of it is below. The highest point is rarely the one that counts: 0.7 and 0.1 are from
// docs/conventions.md.
float usual_height(float middle, float reach) { return middle + reach > 0.0 ? max(middle + 0.7 * reach, 0.1 * reach) : 0.0; }

// Likely contribution of a group of lights to a surface at p with normal n, up to a common factor: power · cos · cos / d². 0 only if nothing arrives.
float light_importance(LightBounds bounds, float power, vec3 p, vec3 n) {
  const vec3 v = bounds.center - p;
  const float d2 = dot(v, v);
  const float d = sqrt(d2);
  const float along = -dot(bounds.axis, v);
  const float across = sqrt(max(0.0, d2 - along * along));
  const float sin_cone = sqrt(max(0.0, 1.0 - bounds.cos_cone * bounds.cos_cone));
  const float above_light = along >= bounds.cos_cone * d ? d : bounds.cos_cone * along + sin_cone * across;  // over the cone of normals
  float above_surface = dot(n, v);
  // Light from either side reaches a transmissive surface: n is 0 there, and the angle to the surface does not count.
  if ((kMaterialFlagsSome & kMaterialTransmissive) != 0u && dot(n, n) == 0.0) above_surface = d;
  MUTATE(kMutantTreeCullsTooMuch, above_surface -= 0.3 * d + bounds.radius);
  const float reach = bounds.radius + 1e-5 * d;  // rounding must not lose a light at the horizon
  const float inv = 1.0 / (d2 + 0.35 * bounds.radius * bounds.radius + 1e-30);
  return power * (usual_height(above_light, reach) * inv) * (usual_height(above_surface, reach) * inv);
}

// Probability of the left one, or −1 if neither can contribute.
float left_share(LightPair pair, vec3 p, vec3 n) {
  const float left = light_importance(pair.left_bounds, pair.left_power, p, n);
  const float right = light_importance(pair.right_bounds, pair.right_power, p, n);
  return left + right > 0.0 ? left / (left + right) : -1.0;
}

// The number that decides at a level: a new one after every sixth level, because stretching the rest of a number
// magnifies its rounding error, and devices would then choose different lights.
const uint kLevelsPerWord = 6u;
uint light_word(uint level, uint word) {
  uint x = word + level * 0x9e3779b9u;
  x = (x ^ (x >> 16u)) * 0x7feb352du;
  x = (x ^ (x >> 15u)) * 0x846ca68bu;
  return x ^ (x >> 16u);
}
float fresh_number(uint level, uvec2 words) {
  return to_unit(level == 0u ? words.x : level == kLevelsPerWord ? words.y : light_word(level, words.y));
}

// Chooses a primitive and returns its index among the light primitives; `prob` is 0 when nothing can contribute.
uint choose_light(vec3 p, vec3 n, uvec2 words, out float prob) {
  uint at = 0u;
  float u = 0.0;
  prob = 1.0;
  for (uint level = 0u; level < kLightTreeDepth; ++level) {
    if ((at & kLightLeaf) != 0u) break;
    const LightPair pair = fetch_light_pair(at);
    u = level % kLevelsPerWord == 0u ? fresh_number(level, words) : u;
    const float share = left_share(pair, p, n);
    const bool left = u < share;
    const float chance = left ? share : 1.0 - share;
    u = min((left ? u : u - share) / chance, 1.0 - 1.0 / 16777216.0);
    prob = share < 0.0 ? 0.0 : prob * chance;
    at = left ? pair.left : pair.right;
    MUTATE(kMutantTreeShareForgotten, prob = (at & kLightLeaf) != 0u && share > 0.0 ? prob / chance : prob);
  }
  return at & ~kLightLeaf;
}

// The probability that the primitive at the end of the trail is chosen; 0 for one that never is.
float light_choice_prob(vec3 p, vec3 n, uint trail) {
  uint at = 0u;
  float prob = trail != 0u ? 1.0 : 0.0;
  for (uint level = 0u; level < kLightTreeDepth; ++level) {
    if (trail <= 1u) break;
    const LightPair pair = fetch_light_pair(at);
    const float share = left_share(pair, p, n);
    const bool left = (trail & 1u) == 0u;
    prob = share < 0.0 ? 0.0 : prob * (left ? share : 1.0 - share);
    at = left ? pair.left : pair.right;
    MUTATE(kMutantTreeMisForgotten, prob = level == 0u ? 1.0 : prob);
    trail >>= 1u;
  }
  return prob;
}
