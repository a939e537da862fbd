// The material of the first instance, which is the patch of etendue::add_test_patch(): samples, or values at given directions, as the path estimator has
// them there. Directions are those of the world.
#ifndef BSDF_PROBE_GLSL
#define BSDF_PROBE_GLSL

#include "../sampler.glsl"
#include "../scatterer.glsl"
#include "../scene.glsl"

layout(push_constant) uniform ProbeBlock { BsdfProbePass probe; };
// A direction as floats, and the number of the sample whose choices hold.
layout(set = kSetKernel, binding = kBindingRequests, std430) readonly buffer QueryBuffer { uvec4 queries[]; };
layout(set = kSetKernel, binding = kBindingResults, std430) writeonly buffer ResultBuffer { BsdfProbeResult results[]; };

void probe_bsdf(uint i) {
  if (i >= probe.count) return;
  const bool samples = probe.mode == kProbeSamples;
  const uvec4 query = samples ? uvec4(0u) : queries[i];
  const vec3 asked = uintBitsToFloat(query.xyz);
  const uint number = samples ? probe.first + i : query.w;
  const vec3 n = vec3(0.0, 0.0, 1.0);
  const float unit = frame.distance_scale;
  const Primitive triangle = Primitive(vec3(0.0), 0u, vec3(unit, 0.0, 0.0), 0u, vec3(0.0, unit, 0.0), 0u);
  const Surface s = Surface(vec3(0.0), 0.0, n, 0u, make_frame(n), 0u, n, true);
  const SurfacePoint at = SurfacePoint(0u, 0u, vec3(1.0, 0.0, 0.0), n);
  Choice choice = Choice(fetch_instance(0u).material, s.frame, n, 1.0, true);
  OtherChoice other_choice = OtherChoice(choice, -1.0);
  const uvec4 words = choice_words(probe.seed, 0u, number, 0u, 0u, 0u, probe.wo.z < 0.0 ? 1u : 0u);
  if (kAdapters != 0u) {
    choice = choose_material(choice.material, s.frame, at, triangle, probe.wo, words, other_choice);
    if (kPassable && choice.material == kNone) {
      results[i] = samples ? BsdfProbeResult(-probe.wo, 1.0, vec3(1.0), kLobePassed) : BsdfProbeResult(asked, 0.0, vec3(0.0), kLobeNone);
      return;
    }
  }
  const Scatterer chosen = scatterer_of(choice, s, at, triangle, probe.wo);
  // Without adapters the functions of the material alone have to say what is black.
  if (kAdapters != 0u && is_black(chosen, probe.wo)) {
    results[i] = BsdfProbeResult(samples ? vec3(0.0) : asked, 0.0, vec3(0.0), kLobeNone);
    return;
  }
  OtherHalf other = OtherHalf(chosen, -1.0);
  if (kBlended && probe.mode != kProbeChosen && other_choice.share >= 0.0) other = other_half(chosen, other_choice, at, triangle, probe.wo, words);
  if (samples) {
    const uvec4 u = random_words(probe.seed, 0u, number, block_bsdf(0u));
    vec3 wi;
    const BsdfSample b = sample_scattering(chosen, other, to_unit(u.x), to_unit(u.yz), wi);
    results[i] = BsdfProbeResult(wi, b.pdf, b.weight, b.lobe);
    return;
  }
  const vec3 wi = asked;
  const Scattering first = scattering(chosen, wi);
  vec3 value = first.value;
  float pdf = first.pdf;
  if (is_mixed(other)) {
    const Scattering second = scattering(other.scatterer, wi);
    value = mixed(other, value, second.value);
    pdf = mixed(other, pdf, second.pdf);
  }
  results[i] = BsdfProbeResult(wi, pdf, value, kLobeNone);
}

#endif
