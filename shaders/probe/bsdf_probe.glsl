// One material on its own, that of the first instance: samples, or values at given directions.
#ifndef BSDF_PROBE_GLSL
#define BSDF_PROBE_GLSL

#include "../bsdf/bsdf.glsl"
#include "../sampler.glsl"
#include "../scene.glsl"

layout(push_constant) uniform ProbeBlock { BsdfProbePass probe; };
layout(set = kSetKernel, binding = kBindingRequests, std430) readonly buffer QueryBuffer { vec4 queries[]; };
layout(set = kSetKernel, binding = kBindingResults, std430) writeonly buffer ResultBuffer { BsdfProbeResult results[]; };

void probe_bsdf(uint i) {
  if (i >= probe.count) return;
  const Material material = evaluate_material(fetch_instance(0u).material, SurfacePoint(0u, 0u, vec3(1.0 / 3.0), vec3(0.0, 0.0, 1.0)));
  if (probe.evaluate != 0u) {
    const vec3 wi = queries[i].xyz;
    results[i] = BsdfProbeResult(wi, bsdf_pdf(material, probe.wo, wi), bsdf_eval(material, probe.wo, wi), kLobeNone);
    return;
  }
  const uvec4 words = random_words(probe.seed, 0u, probe.first + i, block_bsdf(0u));
  const BsdfSample s = bsdf_sample(material, probe.wo, to_unit(words.x), to_unit(words.yz));
  results[i] = BsdfProbeResult(s.wi, s.pdf, s.weight, s.lobe);
}

#endif
