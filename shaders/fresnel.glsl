// Reflectance of smooth interfaces.
#ifndef FRESNEL_GLSL
#define FRESNEL_GLSL

// Exact unpolarised reflectance [Born1999, §1.5]. cos_o in [0,1] on the incident side, eta = n_t / n_o. Returns 1 at total
// internal reflection; cos_t (>= 0) is the cosine on the transmitted side, 0 then.
float fresnel_dielectric(float cos_o, float eta, out float cos_t) {
  const float sin2_t = max(0.0, 1.0 - cos_o * cos_o) / (eta * eta);
  if (sin2_t >= 1.0) {
    cos_t = 0.0;
    return 1.0;
  }
  cos_t = sqrt(1.0 - sin2_t);
  const float parallel = (eta * cos_o - cos_t) / (eta * cos_o + cos_t);
  const float perpendicular = (cos_o - eta * cos_t) / (cos_o + eta * cos_t);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

// Exact unpolarised reflectance of a metal of complex index eta + ik per component, seen from a medium of index 1
// [Born1999, §14.2]. a² + b² is the squared modulus of the refracted wave's normal component. Its difference from the
// real part would suffer from cancellation, so that is computed from the product of the roots.
vec3 fresnel_conductor(float cos_o, vec3 eta, vec3 k) {
  const float cos2 = cos_o * cos_o;
  const float sin2 = max(0.0, 1.0 - cos2);
  const vec3 real = eta * eta - k * k - sin2;
  const vec3 imaginary = 2.0 * eta * k;
  const vec3 modulus = sqrt(real * real + imaginary * imaginary);  // a² + b²
  const vec3 a2 = 0.5 * mix(imaginary * imaginary / max(modulus - real, vec3(1e-30)), modulus + real, greaterThan(real, vec3(0.0)));
  const vec3 a_cos = 2.0 * cos_o * sqrt(max(a2, vec3(0.0)));
  const vec3 perpendicular = (modulus + cos2 - a_cos) / (modulus + cos2 + a_cos);
  const vec3 parallel = (cos2 * modulus + sin2 * sin2 - a_cos * sin2) / (cos2 * modulus + sin2 * sin2 + a_cos * sin2);
  return 0.5 * perpendicular * (1.0 + parallel);
}

#endif
