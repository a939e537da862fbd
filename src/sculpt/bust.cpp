#include <array>
#include <vector>

#include "sculpt/field.h"

namespace etendue::sculpt {
namespace {

// Lengths are in half heads: the head reaches from the chin at y = -1 to the crown at y = 1; +x is the sitter's left,
// +z is forward. Features that come in pairs are described once, for x >= 0, and mirrored through |x|.

constexpr double kFloor = -3.62;           // underside of the pedestal
constexpr double kHeight = 1.16 - kFloor;  // including the curls; scaled to 1 in the file

struct Curl {
  Vec3 center, normal, t, b;
  double radius, turn;  // turn: +1 or -1, the direction of winding
};

// Spiral curls all over the scalp, placed by the golden angle like the seeds of a sunflower, so that no rows are
// visible.
std::vector<Curl> make_curls() {
  constexpr int kCount = 200;
  constexpr double kCos = -0.7373688780783197, kSin = 0.6754902942615238;  // golden angle, 137.508°
  const Vec3 center{0.0, 0.25, -0.12}, radii{0.74, 0.76, 0.88};
  std::vector<Curl> curls;
  double c = 1.0, s = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double y = 1.0 - (2.0 * i + 1.0) / kCount, r = std::sqrt(1.0 - y * y);
    const Vec3 d{r * c, y, r * s};
    const Vec3 p = center + radii * d;
    const Vec3 n = normalize(d / radii);
    const Vec3 t = normalize(cross(n, Vec3{0.31, 0.95, 0.02}));
    const auto word = hash(static_cast<std::uint32_t>(i), 3u, 5u);
    // The hairline is a slanted plane from the forehead past the ears to the nape, higher at the temples.
    const double above = 0.78 * (p.y - 0.60) - 0.625 * (p.z - 0.66);
    if (above > 0.03)
      curls.push_back({p, n, t, cross(n, t), 0.165 + 0.025 * signed_unit(word), word & 1u ? 1.0 : -1.0});
    const double next = c * kCos - s * kSin;
    s = c * kSin + s * kCos;
    c = next;
  }
  return curls;
}

// One curl is a dome with a spiral groove. cos(k r − θ) is computed without θ, since cos θ and sin θ are x/r and y/r.
double curl(const Curl& curl, Vec3 p) {
  const Vec3 q = p - curl.center;
  const double x = dot(q, curl.t), y = curl.turn * dot(q, curl.b), z = dot(q, curl.normal);
  const double r = std::sqrt(x * x + y * y) + 1e-9;
  const double rho = r / curl.radius;
  const double phase = 2.1 * rho;  // turns of the spiral
  const double wave = (cos_turns(phase) * x + sin_turns(phase) * y) / r;
  const double groove = 0.022 * wave * smoothstep(0.05, 0.3, rho) * (1.0 - smoothstep(0.85, 1.2, rho));
  const double dome = length({x, y, 1.55 * z}) - curl.radius;  // flattened
  return 0.72 * dome - groove;
}

double hair(const std::vector<Curl>& curls, Vec3 p) {
  const double scalp = ellipsoid(p, {0.0, 0.25, -0.12}, {0.735, 0.755, 0.875});
  const double above = 0.78 * (p.y - 0.60) - 0.625 * (p.z - 0.66);
  double d = intersect(scalp, -above, 0.10);
  if (std::abs(scalp) > 0.35) return d - 0.1;
  for (const Curl& c : curls) {
    const Vec3 q = p - c.center;
    if (dot(q, q) < 0.16) d = join(d, curl(c, p), 0.02);
  }
  return d;
}

double eyes(Vec3 p, double d) {
  const Vec3 eye{0.262, 0.03, 0.515};
  d = carve(d, ellipsoid(p, {0.27, 0.03, 0.745}, {0.19, 0.115, 0.19}), 0.10);
  double ball = sphere(p, eye, 0.135);
  ball = carve(ball, ellipsoid(p, eye + Vec3{0.0, 0.008, 0.135}, {0.030, 0.034, 0.030}), 0.012);  // the drilled pupil
  // The lids are a shell around the eyeball, which is open between two slanted planes that bend toward the corners.
  const Vec3 q = p - eye;
  const double lids = length(q) - 0.155, bend = q.x * q.x;
  const double upper = intersect(lids, -(q.y - 0.44 * q.z + 2.0 * bend), 0.012);
  const double lower = intersect(lids + 0.006, q.y + 0.34 * q.z - 1.6 * bend, 0.012);
  d = join(d, upper, 0.022);
  d = join(d, lower, 0.035);
  return join(d, ball, 0.006);
}

double nose(Vec3 p, double d) {
  d = join(d, capsule(p, {0.0, 0.15, 0.645}, {0.0, -0.20, 0.855}, 0.060, 0.068), 0.10);
  d = join(d, sphere(p, {0.0, -0.235, 0.862}, 0.085), 0.06);
  d = join(d, ellipsoid(p, {0.088, -0.258, 0.765}, {0.060, 0.058, 0.085}), 0.07);
  return carve(d, ellipsoid(p, {0.050, -0.325, 0.80}, {0.026, 0.035, 0.042}), 0.025);
}

double mouth(Vec3 p, double d) {
  d = join(d, ellipsoid(p, {0.0, -0.53, 0.50}, {0.27, 0.21, 0.21}), 0.14);
  d = carve(d, capsule(p, {0.0, -0.36, 0.765}, {0.0, -0.43, 0.755}, 0.016, 0.020), 0.05);  // philtrum
  const double upper = join(capsule(p, {0.045, -0.484, 0.700}, {0.215, -0.532, 0.612}, 0.040, 0.020),
                            sphere(p, {0.0, -0.500, 0.704}, 0.034), 0.03);
  const double lower = capsule(p, {0.0, -0.592, 0.680}, {0.185, -0.556, 0.618}, 0.054, 0.022);
  d = join(d, upper, 0.030);
  d = join(d, lower, 0.035);
  d = carve(d, capsule(p, {0.0, -0.538, 0.760}, {0.225, -0.545, 0.648}, 0.014, 0.008), 0.038);
  return carve(d, ellipsoid(p, {0.0, -0.690, 0.70}, {0.15, 0.035, 0.06}), 0.09);  // below the lower lip
}

double ear(Vec3 p) {
  const Vec3 center{0.71, -0.03, -0.10};
  // The ear is tilted back and stands out from the head a little.
  const Vec3 q0 = p - center;
  const Vec3 q{0.94 * q0.x + 0.34 * q0.z, 0.97 * q0.y - 0.24 * q0.z, -0.34 * q0.x + 0.24 * q0.y + 0.91 * q0.z};
  double d = ellipsoid(q, {0, 0, 0}, {0.055, 0.215, 0.135});
  d = carve(d, ellipsoid(q, {0.05, 0.02, 0.005}, {0.040, 0.150, 0.085}), 0.03);
  d = join(d, ellipsoid(q, {0.015, -0.01, -0.035}, {0.022, 0.09, 0.025}), 0.03);  // the inner ridge
  return join(d, sphere(q, {0.0, -0.03, 0.095}, 0.035), 0.03);
}

double head(const std::vector<Curl>& curls, Vec3 world) {
  const Vec3 p{std::abs(world.x), world.y, world.z};
  double d = ellipsoid(p, {0.0, 0.25, -0.12}, {0.70, 0.73, 0.84});
  d = join(d, ellipsoid(p, {0.0, -0.32, 0.14}, {0.50, 0.62, 0.53}), 0.25);
  d = join(d, capsule(p, {0.44, -0.36, -0.06}, {0.13, -0.80, 0.42}, 0.14, 0.12), 0.22);    // jaw
  d = join(d, ellipsoid(p, {0.0, -0.84, 0.51}, {0.16, 0.13, 0.14}), 0.12);                 // chin
  d = join(d, ellipsoid(p, {0.36, -0.16, 0.40}, {0.14, 0.10, 0.15}), 0.24);                // cheekbone
  d = join(d, ellipsoid(p, {0.25, -0.42, 0.36}, {0.20, 0.26, 0.20}), 0.20);                // cheek
  d = join(d, capsule(p, {0.07, 0.155, 0.665}, {0.40, 0.185, 0.49}, 0.055, 0.045), 0.14);  // brow
  d = eyes(p, d);
  d = nose(p, d);
  d = mouth(p, d);
  d = join(d, ear(p), 0.04);
  return join(d, hair(curls, world), 0.02);
}

double body(Vec3 world) {
  const Vec3 p{std::abs(world.x), world.y, world.z};
  double d = capsule(p, {0.0, -0.45, -0.18}, {0.0, -1.75, -0.28}, 0.40, 0.44);
  d = join(d, capsule(p, {0.46, -0.42, -0.16}, {0.10, -1.70, 0.16}, 0.10, 0.085),
           0.14);  // the diagonal muscle of the neck
  d = join(d, capsule(p, {0.22, -1.05, -0.38}, {1.05, -1.78, -0.36}, 0.22, 0.24), 0.30);  // trapezius
  d = join(d, ellipsoid(p, {0.0, -2.30, -0.22}, {1.05, 0.85, 0.58}), 0.25);               // rib cage
  d = join(d, ellipsoid(p, {1.22, -2.08, -0.30}, {0.38, 0.46, 0.42}), 0.25);              // shoulder
  d = join(d, ellipsoid(p, {0.45, -2.32, 0.13}, {0.46, 0.34, 0.24}), 0.18);               // breast
  d = join(d, capsule(p, {0.13, -1.78, 0.155}, {0.95, -1.72, -0.10}, 0.05, 0.05), 0.22);  // collar bone
  d = carve(d, sphere(p, {0.0, -1.72, 0.37}, 0.07), 0.14);                                // pit of the throat
  // Arms and chest are cut off by one ellipsoid, as sculptors do.
  return intersect(d, ellipsoid(p, {0.0, -1.55, -0.2}, {1.40, 1.30, 1.25}), 0.06);
}

double socle(Vec3 p) {
  const Vec3 axis{0.0, 0.0, -0.22};
  const auto at = [&](double y) { return Vec3{axis.x, y, axis.z}; };
  double d = capsule(p, at(-2.5), at(-3.3), 0.30, 0.27);
  d = join(d, torus(p, at(-2.86), 0.30, 0.06), 0.05);
  d = join(d, capsule(p, at(-3.28), at(-3.38), 0.34, 0.44), 0.12);
  d = intersect(d, -(p.y + 3.50), 0.02);
  d = join(d, torus(p, at(-3.385), 0.47, 0.075), 0.015);
  return join(d, disc(p, at(kFloor + 0.09), 0.66, 0.09, 0.025), 0.01);
}

// The head is turned to its left, and the neck follows: a rotation about the y axis that increases along the neck. To
// avoid library functions, cosine and sine are interpolated and normalised instead of the angle.
Vec3 turned(Vec3 p) {
  constexpr double kCos = 0.951, kSin = -0.309;  // 18°
  const double t = smoothstep(-1.75, -0.75, p.y);
  const double c = mix(1.0, kCos, t), s = mix(0.0, kSin, t);
  const double norm = 1.0 / std::sqrt(c * c + s * s);
  const double z = p.z + 0.2;  // the axis runs through the neck
  return {norm * (c * p.x + s * z), p.y, norm * (c * z - s * p.x) - 0.2};
}

}  // namespace

Solid bust() {
  const auto value = [curls = make_curls()](Vec3 model) {
    const Vec3 p = kHeight * model + Vec3{0.0, kFloor, 0.0};
    const Vec3 q = turned(p);
    double d = body(q);
    if (p.y > -1.6) d = join(d, head(curls, q), 0.10);
    if (p.y < -2.0) d = join(d, socle(p), 0.05);
    return d / kHeight;
  };
  return {value, {-0.36, -0.02, -0.32}, {0.36, 1.03, 0.30}, 1.6};
}

}  // namespace etendue::sculpt
