// A pass over film slots: which paths it gives to each of them, and where their samples are stored until they are added to the film.
#ifndef SLOTS_GLSL
#define SLOTS_GLSL

#include "gpu_types.h"
#include "math.glsl"
#include "sampler.glsl"

layout(push_constant) uniform PassBlock { Pass pass; };
layout(set = kSetKernel, binding = kBindingReport, std430) buffer ReportBuffer {
  ReportHead report;
  RejectedEntry rejected[kRejectedListed];
  uint lanes_done[];  // items that a lane has finished
};

const uint kSetMask = (1u << kSetBits) - 1u;

// Position of a slot. `pixel` is kNone for padding; `layer` is its index among the pixel's slots.
struct SlotPlace {
  uint pixel, layer;
  uvec2 xy;
};

// The slot of a lane in a group of the pass; src/gpu/device_film.h describes the two layouts.
SlotPlace slot_place(uint group, uint lane) {
  const uint g = pass.first_group + group;
  if (pass.packed_pixels > 0u) {
    const uint i = g * kWorkgroupSize + lane;
    const uvec2 place = divide(i, pass.packed_pixels);
    return SlotPlace(place.x < pass.slots_per_pixel ? place.y : kNone, place.x, divide(place.y, frame.width).yx);
  }
  const uvec2 xy = divide(g, frame.tiles_x).yx * kTileSize + uvec2(lane % kTileSize, lane / kTileSize);
  return SlotPlace(xy.x < frame.width && xy.y < frame.height ? xy.y * frame.width + xy.x : kNone, 0u, xy);
}

// The k-th path of a slot in this pass: the slots of a pixel take whole sets in turn. A set is one path if random
// numbers are independent.
uint path_set(uint layer, uint k) { return layer + ((pass.paths_before + k) >> kSetBits) * pass.slots_per_pixel; }
bool has_path(uint layer, uint k) { return path_set(layer, k) < pass.sets; }
uint path_number(uint layer, uint k) { return ((pass.first_set + path_set(layer, k)) << kSetBits) | ((pass.paths_before + k) & kSetMask); }

// Neighbouring lanes have neighbouring samples.
uint sample_at(uint group, uint path, uint lane) { return (group * pass.paths + path) * kWorkgroupSize + lane; }

#endif
