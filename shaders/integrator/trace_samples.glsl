// Single samples with the signature of their decisions, for comparing renderers sample by sample.
#ifndef TRACE_SAMPLES_GLSL
#define TRACE_SAMPLES_GLSL

#include "path.glsl"
#include "signature.glsl"

layout(push_constant) uniform PassBlock { Pass pass; };
layout(set = kSetKernel, binding = kBindingRequests, std430) readonly buffer RequestBuffer { SampleRequest requests[]; };
layout(set = kSetKernel, binding = kBindingResults, std430) writeonly buffer ResultBuffer { SampleResult results[]; };

void trace_sample(uint i) {
  if (i >= pass.request_count) return;
  const SampleRequest request = requests[i];
  Path path = begin_path(request.pixel, request.sample_index);
  uint signature = kSignatureStart;
  uint steps = 0u;
  while (path.alive) {
    if (steps > pass.step_budget) break;
    Decisions decisions;
    path_segment(path, pass.step_budget, steps, decisions);
    signature = fold_decisions(signature, decisions);
  }
  results[i] = SampleResult(path_value(path), signature, path.segment, steps > pass.step_budget ? 1u : 0u, 0u, 0u);
}

#endif
