#version 460
#extension GL_GOOGLE_include_directive : require
// Entry i of every table, fetched and written back field by field.
#include "test_io.glsl"
#include "scene.glsl"

TEST_BUFFERS(uvec4, TablesAnswer)

void main() {
  if (!lane_has_work()) return;
  const uint i = inputs[lane()].x;
  outputs[lane()] = TablesAnswer(fetch_record(i * kPrimitiveSlots), fetch_instance(i), fetch_material(i, kMaterialTexels), fetch_material_textures(i), fetch_texture_use(i),
                                 fetch_light_instance(i),
                                 fetch_light_primitive(i), uvec4(fetch_light_primitive_threshold(i), 0u, 0u, 0u), fetch_light_bounds(kLightPairTexels * i), fetch_light_pair(i),
                                 fetch_trail(fetch_first_trail(i) + inputs[lane()].y), fetch_vertex_normals(i),
                                 vec4(fetch_filter_knot(i), 0.0, 0.0, 0.0), fetch_place(i), vec4(fetch_place_origin(i), uintBitsToFloat(fetch_instance_place(i))),
                                 fetch_texture(i), fetch_instance_attributes(i),
                                 fetch_attribute(i), fetch_picture(i), fetch_transmittances(i),
                                 fetch_environment_row(i), fetch_environment_search(i), fetch_environment_texel(i),
                                 fetch_delta_light(i), uvec4(fetch_delta_light_threshold(i), 0u, 0u, 0u));
}
