// Reflectance of a smooth dielectric interface.
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

#endif
