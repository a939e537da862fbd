#version 460
#extension GL_GOOGLE_include_directive : require
#include "test_io.glsl"
#include "vertex_normals.glsl"

TEST_BUFFERS(uvec4, NormalsAnswer)

void main() {
  if (!lane_has_work()) return;
  const VertexNormals n = unfold_normals(inputs[lane()]);
  outputs[lane()] = NormalsAnswer(vec4(n.n0, 0.0), vec4(n.n1, 0.0), vec4(n.n2, 0.0));
}
