// Microfacets: the distribution of their normals, how much of them is visible from a direction, and which visible one is hit. docs/conventions.md,
// "Microfacets", defines all of it. Directions are local, w on the side z > 0.
#ifndef MICROFACETS_GLSL
#define MICROFACETS_GLSL

#include "math.glsl"
#include "mutants.h"

// Of a material's surface. GGX and Beckmann's distribution share all but a few lines, and a scene that has only one of them computes only that.
struct Facets {
  vec2 alpha;
  bool beckmann;
};

// The square of the tangent of a direction's angle in the frame in which the roughness is 1, times w.z².
float stretched_sin2(Facets f, vec3 w) {
  const vec2 s = f.alpha * w.xy;
  return dot(s, s);
}

// Area of microfacets by the solid angle of their normals h: the integral of D(h) h.z is 1 [Walter2007]. From h.xy, so that nothing cancels where
// the lobe is narrow.
float facet_density(Facets f, vec3 h) {
  const vec2 s = h.xy / f.alpha;
  const float sin2 = dot(s, s);
  const float cos2 = h.z * h.z;
  const float scale = 1.0 / (kPi * f.alpha.x * f.alpha.y);
  // Cut off at 2e-22 of its peak, before it underflows: whether light arrives at all must not depend on the precision.
  if (f.beckmann) return h.z > 0.0 && sin2 <= 50.0 * cos2 ? scale * exp(-sin2 / cos2) / (cos2 * cos2) : 0.0;
  const float sum = cos2 + sin2;
  return h.z > 0.0 ? scale / (sum * sum) : 0.0;
}

// Smith's masking: the fraction of microfacets of normal h visible from w, 0 if it sees their back (w_h = w·h). For
// Beckmann a rational function [Walter2007, eq. 27], as in other renderers.
float facet_masking(Facets f, vec3 w, float w_h) {
  if (w_h * w.z <= 0.0) return 0.0;
  const float sin2 = stretched_sin2(f, w);
  const float z = abs(w.z);
  if (!f.beckmann) return 2.0 * z / (z + sqrt(z * z + sin2));
  const float a = z * inversesqrt(max(sin2, 1e-30));
  return a < 1.6 ? (a * (3.535 + 2.181 * a)) / (1.0 + a * (2.276 + 2.577 * a)) : 1.0;
}

// exp(z²) erfc(z) for z >= 0, relative error 2e-7: a polynomial in 1/(1 + 0.4 z), fitted for this purpose.
float scaled_erfc(float z) {
  const float t = 1.0 / (1.0 + 0.4 * z);
  return t * (0.225675861 + t * (0.22566977 + t * (0.207838645 + t * (0.168577742 + t * (0.141278916 + t * (-0.00525863236 + t * (0.168647569 +
         t * (-0.182617593 + t * 0.0501878442))))))));
}

// The visible area of all microfacets from w: the integral of D(h) max(0, w·h), exactly. w.z divided by it is the exact masking.
float visible_area(Facets f, vec3 w) {
  const float sin2 = stretched_sin2(f, w);
  if (!f.beckmann) return 0.5 * (w.z + sqrt(w.z * w.z + sin2));
  const float s = sqrt(sin2);
  const float a = min(w.z / max(s, 1e-20), 9.0);  // beyond 9, exp(−a²) is negligible
  const float e = exp(-a * a);
  return w.z * (1.0 - 0.5 * e * scaled_erfc(a)) + s * e * 0.282094792;  // 1/(2 √π)
}

// Density of sample_facet at h w.r.t. solid angle, over w·h.
float visible_density_by_cos(Facets f, vec3 w, vec3 h) { return facet_density(f, h) / visible_area(f, w); }

// Inverse error function by its single-precision polynomials [Giles2012]; `below` and `above` are 1 + x and 1 − x,
// which cannot be computed exactly from x.
float inverse_erf(float x, float above, float below) {
  const float w = -log(above * below);
  if (w < 5.0) {
    const float t = w - 2.5;
    return x * (1.50140941 + t * (0.246640727 + t * (-0.00417768164 + t * (-0.00125372503 + t * (0.00021858087 + t * (-4.39150654e-06 +
           t * (-3.5233877e-06 + t * (3.43273939e-07 + t * 2.81022636e-08))))))));
  }
  const float t = sqrt(w) - 3.0;
  return x * (2.83297682 + t * (1.00167406 + t * (0.00943887047 + t * (-0.0076224613 + t * (0.00573950773 + t * (-0.00367342844 +
         t * (0.00134934322 + t * (0.000100950558 + t * -0.000200214257))))))));
}

const float kSmallestHalf = 1.0 / 33554432.0;  // 2^-25, half of the step of random numbers

// The slope x (in units of the roughness) up to which a fraction u of the area of Beckmann's microfacets lies that is
// visible from a direction of cosine c and sine s: the integral of (c − s x) exp(−x²) up to x is u times that up to
// c/s. Newton's method on a nearly linear function of x: √−log(fraction) if c/s is small, otherwise log(fraction) from
// the nearer end.
float visible_slope(float c, float s, float u) {
  const float kHalfRootPi = 0.886226925;
  const float below = u + kSmallestHalf;
  const float above = 1.0 - u - kSmallestHalf;
  const float end = min(c / max(s, 1e-20), 1e4);
  const float e_end = exp(-min(end * end, 80.0));
  const float c_end = scaled_erfc(end);
  const float whole = c * kHalfRootPi * (2.0 - e_end * c_end) + 0.5 * s * e_end;
  const float beyond = c * kHalfRootPi * e_end * c_end - 0.5 * s * e_end;
  const bool straight = end < 2.5;
  const bool upper = !straight && u > 0.5;
  const float v = sqrt(above < 0.01 ? above * (1.0 + 0.5 * above) : -log(below));
  float x = straight ? 1.7 * c / (1.5 * s + c) - (1.0 + 0.35 * c / (s + c)) * v : inverse_erf(below - above, 2.0 * below, 2.0 * above) - 0.5 * s / c;
  const float wanted = (upper ? above : below) * whole;
  for (int i = 0; i < 3; ++i) {
    x = min(x, end - 1e-4 * v);
    const float e = exp(-x * x);
    const float tail = e * scaled_erfc(abs(x));  // erfc(|x|)
    const float side = (x < 0.0) == upper ? 2.0 - tail : tail;
    const float value = max(upper ? c * kHalfRootPi * side - 0.5 * s * e - beyond : c * kHalfRootPi * side + 0.5 * s * e, 1e-30);
    const float g = sqrt(max(log(whole / value), 1e-14));
    const float share_error = straight ? 2.0 * g * (g - v) : (upper ? log(value / wanted) : log(wanted / value));
    x += clamp(share_error * value / ((c - s * x) * e), -0.5, 0.5);
  }
  return x;
}

// Normals of roughness 1 visible from w. Beckmann's: slopes along and across w's azimuth are independent [Heitz2014].
vec3 sample_beckmann(vec3 w, vec2 u) {
  const float s = length(w.xy);
  const vec2 azimuth = s > 0.0 ? w.xy / s : vec2(1.0, 0.0);
  const float along = visible_slope(w.z, s, u.x);
  const float below = u.y + kSmallestHalf;
  const float above = 1.0 - u.y - kSmallestHalf;
  const float across = inverse_erf(below - above, 2.0 * below, 2.0 * above);
  return vec3(-along * azimuth.x + across * azimuth.y, -along * azimuth.y - across * azimuth.x, 1.0);
}

// GGX: the hemisphere seen from w reflects parallel rays uniformly into the cap z > −w.z of the sphere [Dupuy2023]. The
// heights of the cap's point and of the normal are computed without cancellation.
vec3 sample_ggx(vec3 w, vec2 u) {
  const float drop = u.x * (1.0 + w.z);  // 1 − z of the point
  return vec3(sqrt(max(0.0, drop * (2.0 - drop))) * cos_sin_turn(u.y) + w.xy, (1.0 - u.x) * (1.0 + w.z));
}

// The normal of a microfacet visible from w (w.z > 0), chosen by its visible area [Heitz2014, Heitz2018].
vec3 sample_facet(Facets f, vec3 w, vec2 u) {
  const vec3 flat_w = normalize(vec3(f.alpha * w.xy, w.z));
  vec3 h;
  if (f.beckmann) {
    h = sample_beckmann(flat_w, u);
  } else {
    h = sample_ggx(flat_w, u);
  }
  MUTATE(kMutantStretchForgotten, return normalize(h));
  return normalize(vec3(f.alpha * h.xy, h.z));
}

#endif
