// One path, vertex by vertex, to find where two renderers diverge.
#ifndef TRACE_PATH_GLSL
#define TRACE_PATH_GLSL

#include "path.glsl"

layout(push_constant) uniform PassBlock { Pass pass; };
layout(set = kSetKernel, binding = kBindingRequests, std430) readonly buffer RequestBuffer { SampleRequest requests[]; };
layout(set = kSetKernel, binding = kBindingResults, std430) writeonly buffer VertexBuffer {
  uint vertex_count;
  uint pad0, pad1, pad2;
  TracedVertex vertices[];
};

void trace_requested_path() {
  Path path = begin_path(requests[0].pixel, requests[0].sample_index);
  uint count = 0u;
  uint steps = 0u;
  while (path.alive) {
    if (steps > pass.step_budget || count >= kMaxTracedVertices) break;
    const Ray ray = path.ray;
    Decisions d;
    const Hit hit = walk_hit(trace(ray, false, path.passed, pass.step_budget, steps));
    end_segment(path, hit, pass.step_budget, steps, d);
    vertices[count++] = TracedVertex(path_value(path), d.instance, d.primitive, d.light_instance, d.light_primitive, d.light_contributed, d.lobe,
                                     d.survived, 0u, 0u, ray.o, 0u, hit.instance == kNone ? ray.d : ray.o + hit.t * ray.d, 0u);
  }
  vertex_count = count;
}

#endif
