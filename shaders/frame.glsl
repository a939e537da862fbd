// Local shading frames: +Z is the normal.
#ifndef FRAME_GLSL
#define FRAME_GLSL

struct ShadingFrame {
  vec3 s, t, n;  // orthonormal, world space
};

// Orthonormal basis around the unit vector n without branches on its direction [Duff2017].
ShadingFrame make_frame(vec3 n) {
  const float sign_z = n.z >= 0.0 ? 1.0 : -1.0;
  const float a = -1.0 / (sign_z + n.z);
  const float b = n.x * n.y * a;
  return ShadingFrame(vec3(1.0 + sign_z * n.x * n.x * a, sign_z * b, -sign_z * n.x), vec3(b, sign_z + n.y * n.y * a, -n.y), n);
}

vec3 to_local(ShadingFrame f, vec3 w) { return vec3(dot(w, f.s), dot(w, f.t), dot(w, f.n)); }
vec3 to_world(ShadingFrame f, vec3 w) { return f.s * w.x + f.t * w.y + f.n * w.z; }

#endif
