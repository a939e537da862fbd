// Interference in a thin film [Belcour2017], with the fits used by Khronos; docs/conventions.md, "glTF".
#ifndef THIN_FILM_GLSL
#define THIN_FILM_GLSL

#include "math.glsl"
#include "mutants.h"

vec3 squared(vec3 v) { return v * v; }

// Fourier transforms of the eye's sensitivities, converted to Rec. 709, for a path difference of `path` nanometres and
// a phase shift per component.
vec3 film_sensitivity(float path, vec3 shift) {
  const float phase = 2.0 * kPi * path * 1e-9;
  const vec3 peak = vec3(5.4856e-13, 4.4201e-13, 5.2481e-13), place = vec3(1.6810e6, 1.7953e6, 2.2084e6), width = vec3(4.3278e9, 9.3046e9, 6.6121e9);
  vec3 xyz = peak * sqrt(2.0 * kPi * width) * cos(place * phase + shift) * exp(-width * (phase * phase));
  xyz.x += 9.7470e-14 * sqrt(2.0 * kPi * 4.5282e9) * cos(2.2399e6 * phase + shift.x) * exp(-4.5282e9 * phase * phase);
  xyz *= 1.0 / 1.0685e-7;
  return vec3(dot(vec3(3.2404542, -1.5371385, -0.4985314), xyz), dot(vec3(-0.9692660, 1.8760108, 0.0415560), xyz),
              dot(vec3(0.0556434, -0.2040259, 1.0572252), xyz));
}

// A film of given index and thickness (nanometres) on a base of reflectance r0 at normal incidence.
struct Film {
  float index;
  float thickness;
  vec3 r0;
};

// Upper bound of the reflectance at normal incidence, for any thickness.
vec3 film_bound(Film film) {
  const vec3 base = (1.0 + sqrt(min(film.r0, vec3(0.9999)))) / (1.0 - sqrt(min(film.r0, vec3(0.9999))));
  const vec3 below = abs(base - film.index) / (base + film.index);
  const float above = abs(film.index - 1.0) / (film.index + 1.0);
  return squared((above + below) / (1.0 + above * below));
}

// Reflectance for light at a given cosine outside.
vec3 film_reflectance(Film film, float cosine) {
  const float index = mix(1.0, film.index, smoothstep(0.0, 0.03, film.thickness));
  const float sin2 = (1.0 - cosine * cosine) / (index * index);
  const float inner = sqrt(max(0.0, 1.0 - sin2));
  const float root = (index - 1.0) / (index + 1.0), x = 1.0 - cosine, y = 1.0 - inner;
  const float r12 = root * root + (1.0 - root * root) * (x * x * (x * x) * x), t = 1.0 - r12;
  const vec3 roots = sqrt(min(film.r0, vec3(0.9999))), base = (1.0 + roots) / (1.0 - roots);
  const vec3 normal = squared((base - index) / (base + index));
  const vec3 r23 = normal + (1.0 - normal) * (y * y * (y * y) * y);
  vec3 shift = kPi * (vec3(1.0) + vec3(lessThan(base, vec3(index))));
  MUTATE(kMutantFilmShiftForgotten, shift = vec3(0.0));
  const float path = 2.0 * index * film.thickness * inner;
  const vec3 both = clamp(r12 * r23, vec3(1e-5), vec3(0.9999)), sum = t * t * r23 / (1.0 - both), once = sqrt(both);
  vec3 reflected = r12 + sum + (sum - t) * once * 2.0 * film_sensitivity(path, shift);
  reflected += (sum - t) * both * 2.0 * film_sensitivity(2.0 * path, 2.0 * shift);
  const vec3 most = film_bound(film);
  return clamp(reflected, vec3(0.0), most + (1.0 - most) * (x * x * (x * x) * x));
}

#endif
