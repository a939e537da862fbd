// The integrators direct and whitted, where they differ from path; docs/conventions.md, "Integrators".
//
// direct takes several samples of each strategy at the first surface, one of each per round. A round begins by tracing
// the camera ray again, because nothing about a vertex is kept while other rays are traced. Segment 2r + 1 is the
// camera ray of round r, 2r + 2 the ray of its material sample.
#ifndef DIRECT_GLSL
#define DIRECT_GLSL

const float kWhittedSurvival = 0.95;  // probability of continuing behind a mirror or glass, after [Whitted1980]

bool is_camera_segment(Path path) { return kIntegrator == kIntegratorDirect ? (path.segment & 1u) == 1u : path.segment == 1u; }

uint direct_round(Path path) { return (path.segment - 1u) >> 1u; }

// Emission seen directly by the camera counts once, in the first round, or not at all.
bool no_light_to_camera(Path path) {
  if (kHideEmitters && is_camera_segment(path)) return true;
  return kIntegrator == kIntegratorDirect && is_camera_segment(path) && path.segment > 1u;
}

void next_direct_round(inout Path path) {
  const uint round = direct_round(path) + 1u;
  path.alive = round < max(frame.emitter_samples, frame.bsdf_samples);
  if (!path.alive) return;
  float weight;
  path.ray = camera_ray(path.pixel, film_place(path.pixel), path.sample_index, weight);
  path.passed = kNothingPassed;
  path.beta = vec3(1.0);
  path.channel = 0u;
  path.absorption = vec3(0.0);
  path.full_emission = true;
  path.bounces = 0u;
  path.segment = 2u * round + 1u;
}

bool hidden_from_camera(Path path, Instance instance) {
  MUTATE(kMutantHiddenEmittersOpaque, return false);
  return kHideEmitters && is_camera_segment(path) && instance.radiance != vec3(0.0);
}

// The camera ray continues behind an emitter that is hidden from it.
void pass_through(inout Path path, Surface s, Hit hit) {
  Ray ray = spawn_ray(s.p, s.ng, s.error, path.ray.d);
  ray.t_max = path.ray.t_max - hit.t;
  path.ray = ray;
  path.passed = kNothingPassed;
  path.alive = true;
}

#endif
