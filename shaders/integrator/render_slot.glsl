// One lane's share of a pass: all paths of its film slot up to pass.path_end.
#ifndef RENDER_SLOT_GLSL
#define RENDER_SLOT_GLSL

#include "../film.glsl"
#include "path.glsl"

layout(constant_id = kConstantLuminance) const bool kLuminance = false;
layout(constant_id = kConstantStepsPerTurn) const uint kStepsPerTurn = 6u;
layout(constant_id = kConstantTurnsPerRound) const uint kTurnsPerRound = 2u;
layout(constant_id = kConstantIterationsPerRound) const uint kIterationsPerRound = 8u;  // upper bound of all loops' iterations in a round

layout(push_constant) uniform PassBlock { Pass pass; };
layout(set = kSetKernel, binding = kBindingProgress, std430) buffer ProgressBuffer { uint next_path[]; };
// Per slot the sum over a set of paths that a dispatch left unfinished, xyz; not bound where numbers are independent.
layout(set = kSetKernel, binding = kBindingSetSums, std430) buffer SetSumBuffer { vec4 set_sums[]; };
layout(set = kSetKernel, binding = kBindingReport, std430) buffer ReportBuffer {
  ReportHead report;
  RejectedEntry rejected[];
};

// The first of a lane's samples that the film refused, kept until the lane ends: a store in the loop costs every round.
struct Rejected {
  uint sample_index;  // kNone: none so far
  uint segment;
};

void report_rejected(uint pixel, Rejected first) {
  const uint i = atomicAdd(report.rejected_count, 1u);
  if (i < kRejectedListed) rejected[i] = RejectedEntry(pixel, first.sample_index, first.segment, 0u);
}

// Pixel of a slot, kNone for padding; src/gpu/device_film.h describes the two layouts. Both are computed and one is selected.
uint slot_pixel(uint group, uint lane) {
  const uint i = group * kWorkgroupSize + lane;
  const uint packed_pixel = i < pass.packed_pixels * pass.lanes_per_pixel ? i % max(pass.packed_pixels, 1u) : kNone;
  const uvec2 xy = uvec2(group % frame.tiles_x, group / frame.tiles_x) * kTileSize + uvec2(lane % kTileSize, lane / kTileSize);
  const uint tiled_pixel = xy.x < frame.width && xy.y < frame.height ? xy.y * frame.width + xy.x : kNone;
  return mix(tiled_pixel, packed_pixel, pass.packed_pixels > 0u);
}

// The path after this one in the same slot: the lanes of a pixel take whole sets in turn. A set is one path where numbers are independent.
const uint kSetMask = (1u << kSetBits) - 1u;
uint path_after(uint path) {
  return (path & kSetMask) != kSetMask ? path + 1u : path + 1u + ((pass.lanes_per_pixel - 1u) << kSetBits);
}

// What the film takes as a sample is the mean over a set: sets are independent of each other, the paths within one are not.
void finish_path(Path path, inout vec3 set_sum, inout FilmSlot sums, inout Rejected first_rejected) {
  vec3 value = kLuminance ? vec3(luminance(path_value(path))) : path_value(path);
  bool bad = false;
  bool complete = true;
  if (kSetBits > 0u) {
    bad = !is_finite(value);  // found here, because the mean does not tell which path it was
    set_sum += value;
    complete = (path.sample_index & kSetMask) == kSetMask;
    value = set_sum / float(kSetMask + 1u);
    set_sum = complete ? vec3(0.0) : set_sum;
  }
  if (complete) bad = (!film_add(sums, value, frame.film_exponent) && (kSetBits == 0u || is_finite(value))) || bad;
  if (bad && first_rejected.sample_index == kNone) first_rejected = Rejected(path.sample_index, path.segment);
}

// The lane's samples one after the other, with a single traversal site: every round of the loop takes some traversal steps, then shades
// the lanes whose ray has arrived. A lane never waits for another lane's path or ray to end. A shadow ray that has arrived needs little, so a round
// has two turns of steps: usually the shadow ray of the last vertex in the first and the next segment in the second.
//
// Loops are bounded: the iterations of a round are counted alike by all lanes of a group. A sample that does not fit into the
// budget is handed back untouched: next_path remembers where to go on, and the host dispatches again. So the budget changes when a
// sample is computed, never its value.
void render_slot(uint group, uint lane) {
  const uint pixel = slot_pixel(group, lane);
  if (pixel == kNone) return;
  const uint slot = group * kWorkgroupSize + lane - pass.slot_base;
  FilmSlot sums = film[slot];
  const uint first_path = next_path[slot];
  if (first_path >= pass.path_end) return;
  vec3 set_sum = vec3(0.0);
  if (kSetBits > 0u) set_sum = set_sums[slot].xyz;
  Path path = begin_path(pixel, first_path);
  Walk walk = begin_walk(path.ray, false, kNothingPassed);
  Rejected first_rejected = Rejected(kNone, 0u);
  uint iterations = 0u;
  while (path.sample_index < pass.path_end) {
    if (iterations > pass.step_budget) break;
    iterations += kIterationsPerRound;
    for (uint turn = 0u; turn < kTurnsPerRound; ++turn) {
      advance_walk(walk, kStepsPerTurn);
      if (walk_done(walk) && path.shadow_pending) {
        PROFILE(profile_arrival(true, false));
        if (shadow_ray_goes_on(path, walk)) {
          walk = begin_walk(path.shadow_ray, false, path.shadow_passed);
        } else {
          settle_light(path, walk_found(walk));
          if (path.alive) walk = begin_walk(path.ray, false, path.passed);
        }
      }
    }
    if (!walk_done(walk) || (!kShadowRaysEnd && path.shadow_pending)) continue;
    if (path.alive) {
      PROFILE(profile_arrival(false, path.segment == 1u));
      Decisions decisions;
      arrive(path, walk_hit(walk), decisions);
    }
    if (!path.alive && !path.shadow_pending) {
      finish_path(path, set_sum, sums, first_rejected);
      PROFILE(profile_finish());
      path = begin_path(pixel, path_after(path.sample_index));
    }
    Ray next_ray = path.ray;
    if (path.shadow_pending) next_ray = path.shadow_ray;
    walk = begin_walk(next_ray, path.shadow_pending && kShadowRaysEnd, path.shadow_pending ? path.shadow_passed : path.passed);
  }
  if (path.sample_index < pass.path_end) {
    atomicAdd(report.unfinished, 1u);
    if (path.sample_index == first_path) atomicAdd(report.stuck, 1u);
  }
  if (first_rejected.sample_index != kNone) report_rejected(pixel, first_rejected);
  PROFILE(profile_store(slot));
  film[slot] = sums;
  next_path[slot] = path.sample_index;
  if (kSetBits > 0u) set_sums[slot] = vec4(set_sum, 0.0);
}

#endif
