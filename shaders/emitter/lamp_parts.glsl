// Lamps that are divided into parts, because some of them are much brighter than others: docs/conventions.md, "Lamps of varying brightness".
#include "../mutants.h"

// Where the numbers that choose a point of the part point to in its triangle.
vec2 part_point(LightPrimitive light, vec2 u) {
  if (!kLampParts || light.cells == 0u) return u;
  return (vec2(light.cell / light.cells, light.cell % light.cells) + u) * (1.0 / float(light.cells));
}

// The density of points by area in a part, as a multiple of that in the triangle.
float part_density(LightPrimitive light) {
  if (!kLampParts || light.cells == 0u) return 1.0;
  MUTATE(kMutantPartAreaWhole, return 1.0);
  return float(light.cells * light.cells);
}

// The cell that a point of the triangle is in: the inverse of square_to_triangle.
uint cell_at(vec3 weights, uint cells) {
  const float root = weights.y + weights.z;
  const vec2 u = vec2(root * root, weights.y / max(root, 1e-30));
  const uvec2 cell = uvec2(clamp(u * float(cells), vec2(0.0), vec2(float(cells - 1u))));
  return cell.x * cells + cell.y;
}

// Of a point with these weights; `first` is the trail of the instance's first primitive.
LightTrail light_trail(uint first, uint primitive, vec3 weights) {
  LightTrail trail = fetch_trail(first + primitive);
  if (kLampParts && trail.cells > 0u) {
    uint cell = cell_at(weights, trail.cells);
    MUTATE(kMutantPartMisplaced, cell = 0u);
    trail = fetch_trail(trail.first + cell);
  }
  return trail;
}
