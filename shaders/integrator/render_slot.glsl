// One lane's share of a pass: all samples of its film slot up to pass.sample_end.
#ifndef RENDER_SLOT_GLSL
#define RENDER_SLOT_GLSL

#include "../film.glsl"
#include "path.glsl"

layout(constant_id = 4) const bool kLuminance = false;

layout(push_constant) uniform PassBlock { Pass pass; };
layout(set = 0, binding = kBindingProgress, std430) buffer ProgressBuffer { uint next_sample[]; };
layout(set = 0, binding = kBindingReport, std430) buffer ReportBuffer {
  ReportHead report;
  RejectedEntry rejected[];
};

void report_rejected(Path path) {
  const uint i = atomicAdd(report.rejected_count, 1u);
  if (i < kRejectedListed) rejected[i] = RejectedEntry(path.pixel, path.sample_index, path.segment, 0u);
}

// Slot -> pixel: 8 × 8 tiles, row by row; kNone for the padding at the right and lower border.
uint slot_pixel(uint group, uint lane) {
  const uint tile = group % (pass.slots_per_layer / kWorkgroupSize);
  const uvec2 xy = uvec2(tile % frame.tiles_x, tile / frame.tiles_x) * kTileSize + uvec2(lane % kTileSize, lane / kTileSize);
  return xy.x < frame.width && xy.y < frame.height ? xy.y * frame.width + xy.x : kNone;
}

// A sample that does not fit into the step budget is handed back untouched: next_sample remembers where to go on, and the host
// dispatches again. So the budget changes when a sample is computed, never its value.
void render_slot(uint group, uint lane) {
  const uint pixel = slot_pixel(group, lane);
  if (pixel == kNone) return;
  const uint slot = group * kWorkgroupSize + lane - pass.slot_base;
  FilmSlot sums = film[slot];
  uint sample_index = next_sample[slot];
  uint steps = 0u;
  while (sample_index < pass.sample_end) {
    Path path = begin_path(pixel, sample_index);
    path.steps = steps;
    bool alive = true;
    while (alive) {
      if (path.steps > pass.step_budget) break;
      Decisions decisions;
      alive = path_segment(path, pass.step_budget, decisions);
    }
    if (path.steps > pass.step_budget) {
      atomicAdd(report.unfinished, 1u);
      if (steps == 0u) atomicAdd(report.stuck, 1u);
      break;
    }
    steps = path.steps;
    const vec3 value = kLuminance ? vec3(luminance(path_value(path))) : path_value(path);
    if (!film_add(sums, value, frame.film_exponent)) report_rejected(path);
    sample_index += pass.lanes_per_pixel;
  }
  film[slot] = sums;
  next_sample[slot] = sample_index;
}

#endif
