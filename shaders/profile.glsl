// Counters in the render kernel, for `etendue render --stats` and heat maps.
//
// The kernels that render pictures are built without ETENDUE_PROFILE: PROFILE is empty there, and their SPIR-V is the same as if those
// lines did not exist. A second build of the render kernel counts; a third, with ETENDUE_PROFILE_SUBGROUPS, also counts the lanes that
// work together, where a device has subgroup ballots.
#ifndef PROFILE_GLSL
#define PROFILE_GLSL

#ifdef ETENDUE_PROFILE

#ifdef ETENDUE_PROFILE_SUBGROUPS
#extension GL_KHR_shader_subgroup_ballot : require
// This lane's share of a step that its subgroup takes together: over the active lanes, the shares add up to 1.
float subgroup_share() { return 1.0 / float(subgroupBallotBitCount(subgroupBallot(true))); }
#else
float subgroup_share() { return 0.0; }
#endif

#include "gpu_types.h"

PathProfile lane_profile = PathProfile(uvec4(0u), uvec4(0u), uvec4(0u), vec4(0.0));
uvec2 walk_visits = uvec2(0u);  // nodes and primitives visited by the current ray

void profile_step(uint nodes, uint primitives) {
  walk_visits += uvec2(nodes, primitives);
  lane_profile.shares.x += subgroup_share();
  lane_profile.shares.y += 1.0;
}

// To be called when the current ray has arrived.
void profile_arrival(bool shadow, bool camera) {
  const uvec4 counts = uvec4(1u, walk_visits, 0u);
  walk_visits = uvec2(0u);
  lane_profile.shadow += shadow ? counts : uvec4(0u);
  lane_profile.camera += camera && !shadow ? counts : uvec4(0u);
  lane_profile.scattered += camera || shadow ? uvec4(0u) : counts;
  lane_profile.shares.z += subgroup_share();
  lane_profile.shares.w += 1.0;
}

// The counts of the path that has ended; those of the next one start at zero.
PathProfile path_profile() {
  const PathProfile ended = lane_profile;
  lane_profile = PathProfile(uvec4(0u), uvec4(0u), uvec4(0u), vec4(0.0));
  return ended;
}

#define PROFILE(statement) { statement; }
#else
#define PROFILE(statement)
#endif

#endif
