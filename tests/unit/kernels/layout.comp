#version 460
#extension GL_GOOGLE_include_directive : require
// Every struct of gpu_types.h in a buffer, so that the SPIR-V states its offsets; never run. compile_layout.cpp reads it.
#include "gpu_types.h"

layout(local_size_x = 1) in;
layout(push_constant) uniform PassBlock { Pass pass; };
layout(set = 0, binding = 0, std140) uniform FrameBlock { Frame frame; };
layout(set = 0, binding = 1, std430) buffer RecordBuffer { Record records[]; };
layout(set = 0, binding = 2, std430) buffer PrimitiveBuffer { Primitive primitives[]; };
layout(set = 0, binding = 3, std430) buffer InstanceBuffer { Instance instances[]; };
layout(set = 0, binding = 4, std430) buffer LightInstanceBuffer { LightInstance light_instances[]; };
layout(set = 0, binding = 5, std430) buffer LightPrimitiveBuffer { LightPrimitive light_primitives[]; };
layout(set = 0, binding = 6, std430) buffer FilmBuffer { FilmSlot film[]; };
layout(set = 0, binding = 7, std430) buffer ReportBuffer { ReportHead head; RejectedEntry rejected[]; };
layout(set = 0, binding = 8, std430) buffer RequestBuffer { SampleRequest requests[]; };
layout(set = 0, binding = 9, std430) buffer ResultBuffer { SampleResult results[]; };
layout(set = 0, binding = 10, std430) buffer RayRequestBuffer { RayRequest ray_requests[]; };
layout(set = 0, binding = 11, std430) buffer RayResultBuffer { RayResult ray_results[]; };
layout(set = 0, binding = 12, std430) buffer VertexBuffer { TracedVertex vertices[]; };
layout(set = 0, binding = 13, std430) buffer ProbePassBuffer { BsdfProbePass probe_passes[]; };
layout(set = 0, binding = 14, std430) buffer ProbeResultBuffer { BsdfProbeResult probe_results[]; };
layout(set = 0, binding = 15, std430) buffer LightPairBuffer { LightPair light_pairs[]; };
layout(set = 0, binding = 16, std430) buffer LightBoundsBuffer { LightBounds light_bounds[]; };
layout(set = 0, binding = 17, std430) buffer LightTrailBuffer { LightTrail light_trails[]; };
layout(set = 0, binding = 19, std430) buffer MaterialBuffer { MaterialRecord materials[]; };
layout(set = 0, binding = 21, std430) buffer TextureBuffer { TextureRecord texture_records[]; };
layout(set = 0, binding = 22, std430) buffer InstanceAttributesBuffer { InstanceAttributes instance_attributes[]; };
layout(set = 0, binding = 20, std430) buffer MaterialTexturesBuffer { MaterialTextures material_textures[]; };

layout(set = 0, binding = 24, std430) buffer TextureUseBuffer { TextureUse texture_uses[]; };
layout(set = 0, binding = 20, std430) buffer PlaceBuffer { Place places[]; };
layout(set = 0, binding = 22, std430) buffer EnvironmentRowBuffer { EnvironmentRow environment_rows[]; };
layout(set = 0, binding = 21, std430) buffer EnvironmentTexelBuffer { EnvironmentTexel environment_texels[]; };
layout(set = 0, binding = 23, std430) buffer DeltaLightBuffer { DeltaLight delta_lights[]; };
layout(set = 0, binding = 18, std430) buffer PathProfileBuffer { PathProfile path_profiles[]; };

void main() {
  path_profiles[0].camera.x = 0u;
  records[0].a.x = pass.paths + frame.seed + requests[0].pixel + floatBitsToUint(ray_requests[0].t_min);
  primitives[0].kind = 0u;
  instances[0].material = 0u;
  places[0].side = 0.0;
  materials[0].header = 0u;
  material_textures[0].first = 0u;
  texture_uses[0].floats = 0u;
  texture_records[0].header = 0u;
  instance_attributes[0].first = 0u;
  light_instances[0].threshold = 0u;
  light_primitives[0].threshold = 0u;
  film[0].tail.x = 0u;
  head.stuck = 0u;
  rejected[0].pixel = 0u;
  results[0].stuck = 0u;
  ray_results[0].steps = 0u;
  vertices[0].instance = 0u;
  probe_passes[0].seed = 0u;
  probe_results[0].lobe = 0u;
  light_pairs[0].left = 0u;
  light_bounds[0].radius = 0.0;
  light_trails[0].turns = 0u;
  delta_lights[0].threshold = 0u;
  environment_rows[0].density = 0.0;
  environment_texels[0].words = 0u;
}
