// Choosing among many lights by what each can contribute to a point: docs/conventions.md, "Light tree" [Conty2018].
#include "../mutants.h"

// Levels of the tree; 0: lights are chosen by power alone. A constant, because lavapipe would compute both choices behind an `if`.
layout(constant_id = 18) const uint kLightTreeDepth = 0u;
const bool kLightTree = kLightTreeDepth > 0u;

// Cosine and sine.
vec2 angle_of_cosine(float c) { return vec2(c, sqrt(max(0.0, 1.0 - c * c))); }
// a − b, or 0 where b is the larger one.
vec2 angle_minus(vec2 a, vec2 b) { return a.x >= b.x ? vec2(1.0, 0.0) : vec2(a.x * b.x + a.y * b.y, a.y * b.x - a.x * b.y); }

// Bounds what the node's lights send to a surface at p with normal n, up to a factor that all nodes share: power · cos · cos / d² with the
// least angles that any of its points and normals can have. 0 only where nothing arrives.
float light_importance(LightNode node, vec3 p, vec3 n) {
  const vec3 v = node.center - p;
  const float d2 = dot(v, v);
  const vec3 w = v * inversesqrt(d2);
  const float sin2 = node.radius_squared / d2;
  const vec2 extent = vec2(sqrt(max(0.0, 1.0 - sin2)), sqrt(sin2));
  const vec2 emitted = angle_minus(angle_minus(angle_of_cosine(-dot(node.axis, w)), vec2(node.cos_cone, node.sin_cone)), extent);
  vec2 received = angle_minus(angle_of_cosine(dot(n, w)), extent);
  MUTATE(kMutantTreeCullsTooMuch, received.x = dot(n, w) - 0.3);
  const float margin = 1e-5;  // rounding must not lose a light at the horizon
  const float outside = node.power / d2 * max(0.0, emitted.x + margin) * max(0.0, received.x + margin);
  return d2 <= node.radius_squared ? node.power / node.radius_squared : outside;
}

// Probability of the left child, or −1 where neither can contribute.
float left_share(uint child, vec3 p, vec3 n) {
  const float left = light_importance(fetch_light_node(child), p, n);
  const float right = light_importance(fetch_light_node(child + 1u), p, n);
  return left + right > 0.0 ? left / (left + right) : -1.0;
}

// The number that decides at a level: a fresh one after every sixth, because stretching what is left of a number magnifies its rounding, and
// other devices would then choose other lights.
const uint kLevelsPerWord = 6u;
float fresh_number(uint level, uvec2 words) {
  uint x = words.y + level * 0x9e3779b9u;
  x = (x ^ (x >> 16u)) * 0x7feb352du;
  x = (x ^ (x >> 15u)) * 0x846ca68bu;
  x ^= x >> 16u;
  return to_unit(level == 0u ? words.x : level == kLevelsPerWord ? words.y : x);
}

// Chooses a leaf; `prob` is 0 when nothing can contribute.
LightNode choose_light(vec3 p, vec3 n, uvec2 words, out float prob) {
  uint at = 0u;
  uint child = fetch_light_node(0u).child;
  float u = 0.0;
  prob = 1.0;
  for (uint level = 0u; level < kLightTreeDepth; ++level) {
    if ((child & kLightLeaf) != 0u) break;
    u = level % kLevelsPerWord == 0u ? fresh_number(level, words) : u;
    const float share = left_share(child, p, n);
    const bool left = u < share;
    u = min(left ? u / share : (u - share) / (1.0 - share), 1.0 - 1.0 / 16777216.0);
    prob = share < 0.0 ? 0.0 : prob * (left ? share : 1.0 - share);
    at = left ? child : child + 1u;
    child = fetch_light_node(at).child;
    MUTATE(kMutantTreeShareForgotten, prob = (child & kLightLeaf) != 0u && share > 0.0 ? prob / (left ? share : 1.0 - share) : prob);
  }
  return fetch_light_node(at);
}

// The leaf of a primitive and the probability of its choice; `prob` is 0 for a primitive that is never chosen.
LightNode find_light(vec3 p, vec3 n, uint trail, out float prob) {
  uint at = 0u;
  prob = trail != 0u ? 1.0 : 0.0;
  for (uint level = 0u; level < kLightTreeDepth; ++level) {
    if (trail <= 1u) break;
    const uint child = fetch_light_node(at).child;
    const float share = left_share(child, p, n);
    const bool left = (trail & 1u) == 0u;
    prob = share < 0.0 ? 0.0 : prob * (left ? share : 1.0 - share);
    at = left ? child : child + 1u;
    MUTATE(kMutantTreeMisForgotten, prob = level == 0u ? 1.0 : prob);
    trail >>= 1u;
  }
  return fetch_light_node(at);
}
