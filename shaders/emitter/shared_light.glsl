// Lights that are instances of shared meshes: one leaf of the light tree each, then a triangle by its area in the mesh. docs/conventions.md, "Shared meshes".

// The word that chooses the triangle if the tree has used up those of the light.
const uint kTriangleLevel = 36u;

// `prob` is that of the instance, `word` chooses the triangle.
LightSample sample_shared_light(vec3 p, LightInstance light, float prob, uint word, vec2 u) {
  const LightPrimitive choice = fetch_light_primitive(choose_light_primitive(light, word));
  const Instance instance = fetch_instance(light.instance);
  const Place place = fetch_place(instance.place);
  const Primitive tri = place_triangle(place, choice.primitive, light.instance);
  const float area = light_area_of(instance) * place_area_factor(place, triangle_normal(tri));
  LightSample ls = area_sample(p, tri, instance, LightChoice(prob, choice.prob, area), u);
  MUTATE(kMutantInstanceAreaNotScaled, ls.pdf_w *= place_area_factor(place, triangle_normal(tri)));
  ls.error += place.error + place.relative_error * length(ls.p - p);
  return ls;
}
