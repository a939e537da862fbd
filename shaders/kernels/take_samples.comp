#version 460
#extension GL_GOOGLE_include_directive : require
// Adds the samples of a pass to the film: each lane adds those of one slot, in order.
#include "../film.glsl"
#include "../math.glsl"
layout(set = kSetKernel, binding = kBindingFrame, std140) uniform FrameBlock { Frame frame; };
#include "../slots.glsl"

layout(local_size_x = kWorkgroupSize) in;

layout(constant_id = kConstantLuminance) const bool kLuminance = false;
layout(set = kSetKernel, binding = kBindingFilm, std430) buffer FilmBuffer { FilmSlot film[]; };
// For each slot, the sum over the paths of an unfinished set; not bound if random numbers are independent.
layout(set = kSetKernel, binding = kBindingSetSums, std430) buffer SetSumBuffer { vec4 set_sums[]; };
layout(set = kSetKernel, binding = kBindingSamples, std430) readonly buffer SampleBuffer { vec4 samples[]; };

// The first of a slot's paths that the film rejected.
struct Rejected {
  uint path;  // kNone: none so far
  uint segments;
};

// A sample of the film is the mean over a set: sets are independent of each other, the paths within one are not.
void take_sample(uint path, vec4 traced, inout vec3 set_sum, inout FilmSlot sums, inout Rejected first_rejected) {
  vec3 value = kLuminance ? vec3(luminance(traced.xyz)) : traced.xyz;
  bool bad = false;
  bool complete = true;
  if (kSetBits > 0u) {
    bad = !is_finite(value);  // detected here, because the mean does not reveal which path it was
    set_sum += value;
    complete = (path & kSetMask) == kSetMask;
    value = set_sum / float(kSetMask + 1u);
    set_sum = complete ? vec3(0.0) : set_sum;
  }
  if (complete) bad = (!film_add(sums, value, frame.film_exponent) && (kSetBits == 0u || is_finite(value))) || bad;
  if (bad && first_rejected.path == kNone) first_rejected = Rejected(path, floatBitsToUint(traced.w));
}

void main() {
  const uint group = gl_WorkGroupID.x, lane = gl_LocalInvocationIndex;
  const SlotPlace place = slot_place(group, lane);
  if (place.pixel == kNone) return;
  const uint slot = pass.first_slot + group * kWorkgroupSize + lane;
  FilmSlot sums = film[slot];
  vec3 set_sum = kSetBits > 0u ? set_sums[slot].xyz : vec3(0.0);
  Rejected first_rejected = Rejected(kNone, 0u);
  for (uint k = 0u; k < pass.paths && has_path(place.layer, k); ++k)
    take_sample(path_number(place.layer, k), samples[sample_at(group, k, lane)], set_sum, sums, first_rejected);
  if (first_rejected.path != kNone) {
    const uint i = atomicAdd(report.rejected_count, 1u);
    if (i < kRejectedListed) rejected[i] = RejectedEntry(place.pixel, first_rejected.path, first_rejected.segments, 0u);
  }
  film[slot] = sums;
  if (kSetBits > 0u) set_sums[slot] = vec4(set_sum, 0.0);
}
