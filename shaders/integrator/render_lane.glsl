// One lane's share of a dispatch: paths of many pixels, one after the other, whose values become samples for take_samples.comp.
#ifndef RENDER_LANE_GLSL
#define RENDER_LANE_GLSL

#include "path.glsl"
#include "../slots.glsl"

layout(constant_id = kConstantStepsPerTurn) const uint kStepsPerTurn = 6u;
layout(constant_id = kConstantTurnsPerRound) const uint kTurnsPerRound = 2u;
layout(constant_id = kConstantIterationsPerRound) const uint kIterationsPerRound = 8u;  // upper bound of all loops' iterations in a round

#ifdef ETENDUE_PROFILE
layout(set = kSetKernel, binding = kBindingSamples, std430) writeonly buffer SampleBuffer { PathProfile samples[]; };
#else
layout(set = kSetKernel, binding = kBindingSamples, std430) writeonly buffer SampleBuffer { vec4 samples[]; };
#endif

// The work of a lane: the paths of one slot, then those of the same slot in a later group. Lanes of a workgroup are those of a group of slots.
struct Item {
  uint group;  // of slots, within the pass
  uint path;   // of those that the pass gives each slot
};

Item first_item(uint lane_group, uint lane) {
  const uint done = pass.resume != 0u ? lanes_done[lane_group * kWorkgroupSize + lane] : 0u;
  return Item(lane_group + done / pass.paths * gl_NumWorkGroups.x, done % pass.paths);
}
Item item_after(Item item) {
  const bool last = item.path + 1u >= pass.paths;
  return Item(last ? item.group + gl_NumWorkGroups.x : item.group, last ? 0u : item.path + 1u);
}
uint items_before(Item item, uint lane_group) { return (item.group - lane_group) / gl_NumWorkGroups.x * pass.paths + item.path; }

// If there is none, because the slot has no pixel or no path left, the path is over before it begins, and so are those that would follow.
Path begin_item(inout Item item, uint lane) {
  const SlotPlace place = slot_place(item.group, lane);
  Path path = begin_path(place.pixel, place.xy, path_number(place.layer, item.path));
  path.alive = place.pixel != kNone && has_path(place.layer, item.path) && item.group < pass.group_count;
  path.ray.d = path.alive ? path.ray.d : vec3(kInfinity);  // not a ray
  item.path = path.alive ? item.path : pass.paths - 1u;
  return path;
}

// The lane's paths with a single traversal site: every round of the loop takes some traversal steps, then shades the lanes whose ray has arrived. A
// lane never waits for another lane's path or ray to end. A shadow ray that has arrived needs little work, so a round has two turns of steps: usually
// the shadow ray of the last vertex in the first and the next segment in the second.
//
// Loops are bounded: all lanes of a group count the iterations of a round alike. A path that does not fit into the budget is given up: lanes_done
// records where to continue, and the host dispatches again. So the budget changes when a sample is computed, never its value.
void render_lane(uint lane_group, uint lane) {
  Item item = first_item(lane_group, lane);
  const uint done_before = items_before(item, lane_group);
  Path path = begin_item(item, lane);
  Walk walk = begin_walk(path.ray, false, kNothingPassed);
  uint iterations = 0u;
  while (item.group < pass.group_count) {
    if (iterations > pass.step_budget) break;
    iterations += kIterationsPerRound;
    for (uint turn = 0u; turn < kTurnsPerRound; ++turn) {
      advance_walk(walk, kStepsPerTurn);
      if (walk_done(walk) && path.shadow_pending && !may_go_on(walk)) {
        PROFILE(profile_arrival(true, false));
        settle_light(path, walk_found(walk));
        if (path.alive) walk = begin_walk(path.ray, false, path.passed);
      }
    }
    // Once a round, because it takes longer than all steps of a turn.
    if (!kShadowRaysEnd && walk_done(walk) && path.shadow_pending) {
      PROFILE(profile_arrival(true, false));
      if (shadow_passes(path, path.shadow_ray, walk_hit(walk))) {
        walk = begin_walk(path.shadow_ray, true, path.shadow_passed);
      } else {
        settle_light(path, true);
        if (path.alive) walk = begin_walk(path.ray, false, path.passed);
      }
    }
    const bool arrived = walk_done(walk) && (kShadowRaysEnd || !path.shadow_pending);
    if (arrived && path.alive) {
      PROFILE(profile_arrival(false, path.segment == 1u));
      Decisions decisions;
      arrive(path, walk_hit(walk), decisions);
    }
    const bool over = arrived && !path.alive && !path.shadow_pending;
    const uint at = sample_at(item.group, item.path, lane);
#ifdef ETENDUE_PROFILE
    if (over) samples[at] = path_profile();
#else
    // For every path, ended or not: lavapipe checks for each lane and word whether it stores, and guesses wrong if only some do.
    samples[at] = vec4(path_value(path), uintBitsToFloat(path.segment));
#endif
    if (over) {
      item = item_after(item);
      path = begin_item(item, lane);
    }
    if (arrived) {
      Ray next_ray = path.ray;
      if (path.shadow_pending) next_ray = path.shadow_ray;
      walk = begin_walk(next_ray, path.shadow_pending, path.shadow_pending ? path.shadow_passed : path.passed);
    }
  }
  const uint done = items_before(item, lane_group);
  if (item.group < pass.group_count) {
    atomicAdd(report.unfinished, 1u);
    if (done == done_before) atomicAdd(report.stuck, 1u);
  }
  lanes_done[lane_group * kWorkgroupSize + lane] = done;
}

#endif
