/// Camera rays and reconstruction filters, against docs/conventions.md in double precision.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include <fmt/format.h>

#include "device_test.h"
#include "reference_scenes.h"
#include "validate/statistics.h"

namespace etendue::test {
namespace {

using Filter = ReconstructionFilter;

class DeviceCamera : public DeviceTest {
 protected:
  std::vector<gpu::CameraAnswer> rays(const Scene& scene, const std::vector<gpu::CameraCase>& cases) {
    const CompiledScene compiled = compile_scene(scene);
    const CompiledView view = compile_view(SceneFacts(compiled), view_of(scene), 0);
    KernelRun kernel{kernels::camera_rays, "camera_rays", &compiled};
    kernel.constants = {{gpu::kConstantFilterKind, view.filter},
                        {gpu::kConstantCamera, view.camera},
                        {gpu::kConstantCameraWindow, view.window ? 1u : 0u}};
    kernel.view = view_of(scene);
    return run<gpu::CameraAnswer>(kernel, cases);
  }
};

Scene scene_with(const Camera& camera) {
  Scene scene;
  scene.camera = camera;  // no shapes: scene units are normalised units
  return scene;
}

std::vector<gpu::CameraCase> random_cases(const Camera& camera, std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<gpu::CameraCase> cases;
  for (std::size_t i = 0; i < n; ++i) {
    gpu::CameraCase c{random.below(camera.width), random.below(camera.height), {random.unit(), 0.0f}, {}, 0};
    c.u.y = random.unit();
    c.lens = {random.unit(), random.unit(), random.unit()};
    cases.push_back(c);
  }
  return cases;
}

TEST_F(DeviceCamera, RaysPointWhereTheFormatSays) {
  struct Setup {
    std::uint32_t width, height;
    double fov;
    bool mirrored;
  };
  for (const Setup& s :
       {Setup{800, 600, 27.7856, true}, {1, 1, 1e-6, false}, {7, 301, 90.0, false}, {1000, 3, 170.0, true}}) {
    Camera camera;
    camera.width = s.width;
    camera.height = s.height;
    camera.fov = s.fov;
    camera.near_clip = 0.25;
    camera.far_clip = 80.0;
    camera.world_from_camera = reference::test::look_at({1, 2, 3}, {-4, 1, 0.5}, {0.1, 1, 0});
    if (s.mirrored)
      camera.world_from_camera = camera.world_from_camera * glm::dmat4(glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, 1));
    const auto cases = random_cases(camera, 2000, 1);
    const auto answers = rays(scene_with(camera), cases);
    const double tx = std::tan(s.fov * std::numbers::pi / 360.0), ty = tx * s.height / s.width;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const double x = double{cases[i].u.x} + cases[i].x, y = double{cases[i].u.y} + cases[i].y;
      const glm::dvec3 v(tx * (1.0 - 2.0 * x / s.width), ty * (1.0 - 2.0 * y / s.height), 1.0);
      const glm::dvec3 d = glm::normalize(glm::dmat3(camera.world_from_camera) * v);
      EXPECT_LT(glm::length(glm::dvec3(answers[i].d) - d), 5e-7 * std::max({1.0, tx, ty}))
          << s.width << ' ' << x << ' ' << y;
      EXPECT_EQ(answers[i].o, glm::vec3(1, 2, 3));
      EXPECT_NEAR(answers[i].t_min, 0.25 * glm::length(v), 1e-6 * glm::length(v));  // clip distances are depths
      EXPECT_NEAR(answers[i].t_max, 80.0 * glm::length(v), 4e-4 * glm::length(v));
      EXPECT_EQ(answers[i].weight, 1.0f);
    }
  }
}

// A camera with a shifted axis that renders a part of its film.
Camera cropped_camera(Camera::Type type) {
  Camera camera;
  camera.type = type;
  camera.width = 40;
  camera.height = 30;
  camera.window = {.origin = {0.25, 0.1}, .size = {0.5, 0.75}, .principal_offset = {0.03, -0.02}};
  camera.fov = 50.0;
  camera.near_clip = 0.25;
  camera.far_clip = 80.0;
  camera.world_from_camera = reference::test::look_at({1, 2, 3}, {-4, 1, 0.5}, {0.1, 1, 0});
  for (int a = 0; a < 3; ++a) camera.world_from_camera[a] *= 1.5;
  return camera;
}

// Every kind of camera against the definitions of docs/conventions.md; the whole film is 80 by 40 pixels.
TEST_F(DeviceCamera, RaysOfOtherCameras) {
  using Type = Camera::Type;
  using Axis = Camera::FovAxis;
  const double half = std::tan(25.0 * std::numbers::pi / 180.0);
  for (const auto& [type, axis, tan_x] : {std::tuple(Type::perspective, Axis::x, half),
                                          {Type::perspective, Axis::y, 2.0 * half},
                                          {Type::perspective, Axis::diagonal, half / std::sqrt(1.25)},
                                          {Type::perspective, Axis::smaller, 2.0 * half},
                                          {Type::perspective, Axis::larger, half},
                                          {Type::thin_lens, Axis::x, half},
                                          {Type::orthographic, Axis::x, 0.0},
                                          {Type::spherical, Axis::x, 0.0},
                                          {Type::radiance_meter, Axis::x, 0.0}}) {
    Camera camera = cropped_camera(type);
    camera.fov_axis = axis;
    camera.aperture = {.radius = 0.3, .focus_distance = 2.5, .blades = 5, .rotation = 20.0};
    const auto cases = random_cases(camera, 1000, 7);
    const auto answers = rays(scene_with(camera), cases);
    const glm::dmat4& m = camera.world_from_camera;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const double x = 0.28 + 0.5 * (double{cases[i].u.x} + cases[i].x) / 40.0;
      const double y = 0.08 + 0.75 * (double{cases[i].u.y} + cases[i].y) / 30.0;
      const glm::dvec2 ndc(1.0 - 2.0 * x, 1.0 - 2.0 * y);
      glm::dvec3 start(0.0), v(0.0, 0.0, 1.0);
      if (tan_x > 0.0) v = {tan_x * ndc.x, tan_x * ndc.y / 2.0, 1.0};
      if (type == Type::orthographic) start = {ndc.x, ndc.y / 2.0, 0.0};
      if (type == Type::spherical) {
        const double longitude = std::numbers::pi * ndc.x, polar = std::numbers::pi * y;
        v = {std::sin(longitude) * std::sin(polar), std::cos(polar), std::cos(longitude) * std::sin(polar)};
      }
      if (type == Type::thin_lens) {
        const double blade = std::floor(5.0 * double{cases[i].lens.x}), root = std::sqrt(double{cases[i].lens.y});
        const auto corner = [](double k) {
          const double angle = (20.0 + 72.0 * k) * std::numbers::pi / 180.0;
          return 0.3 * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
        };
        const double b = cases[i].lens.z * root;
        start = b * corner(blade) + (root - b) * corner(blade + 1.0);
        v = (2.5 * v - start) / 2.5;
      }
      const glm::dvec3 world = glm::dmat3(m) * v;
      const auto at = fmt::format("{} {} {}", static_cast<int>(type), static_cast<int>(axis), i);
      EXPECT_LT(glm::length(glm::dvec3(answers[i].d) - glm::normalize(world)), 2e-6) << at;
      EXPECT_LT(glm::length(glm::dvec3(answers[i].o) - glm::dvec3(m * glm::dvec4(start, 1.0))), 2e-6) << at;
      EXPECT_NEAR(answers[i].t_min, 0.25 * glm::length(world), 1e-5) << at;
      EXPECT_NEAR(answers[i].t_max, 80.0 * glm::length(world), 1e-3) << at;
    }
  }
}

// Rays of a meter of irradiance: from all of its square, into the hemisphere before it, most along the normal.
TEST_F(DeviceCamera, MetersOfIrradianceLookAround) {
  Camera camera;
  camera.type = Camera::Type::irradiance_meter;
  camera.width = camera.height = 2;
  const auto cases = random_cases(camera, 20000, 8);
  const auto answers = rays(scene_with(camera), cases);
  RunningMoments cosine, x;
  for (const gpu::CameraAnswer& a : answers) {
    EXPECT_FLOAT_EQ(a.weight, std::numbers::pi_v<float>);
    EXPECT_GT(a.d.z, 0.0f);
    EXPECT_LE(std::max(std::abs(a.o.x), std::abs(a.o.y)), 1.0f);
    cosine.add(a.d.z);
    x.add(a.o.x * a.o.x);
  }
  EXPECT_NEAR(cosine.mean(), 2.0 / 3.0, 5.0 * cosine.standard_error());
  EXPECT_NEAR(x.mean(), 1.0 / 3.0, 5.0 * x.standard_error());
}

// Where rays of cameras up to a billion units away pass the scene, and how long they are: as exact as a point of the
// scene, or a thousandth of a pixel.
TEST_F(DeviceCamera, FarCamerasKeepTheirPrecision) {
  for (const double distance : {10.0, 40.0, 1e3, 1e6, 1e9}) {
    for (const double axis : {1.0, 1e-3}) {  // length of the camera's axes, which is its unit of depth
      Camera camera;
      camera.width = camera.height = 256;
      camera.fov = std::atan(1.5 / distance) * 360.0 / std::numbers::pi;
      const glm::dvec3 eye = distance * glm::normalize(glm::dvec3(2, 1, -3));
      camera.world_from_camera = reference::test::look_at(eye, {0.1, 0.05, 0}, {0.1, 1, 0});
      for (int a = 0; a < 3; ++a) camera.world_from_camera[a] *= axis;
      camera.near_clip = (distance - 0.5) / axis;
      camera.far_clip = (distance + 0.75) / axis;
      Scene scene = scene_with(camera);
      scene.add(Sphere{{0, 0, 0}, 1.0});  // scene units are normalised units
      const auto cases = random_cases(camera, 500, 3);
      const auto answers = rays(scene, cases);
      const double t = std::tan(camera.fov * std::numbers::pi / 360.0);
      for (std::size_t i = 0; i < cases.size(); ++i) {
        const double x = double{cases[i].u.x} + cases[i].x, y = double{cases[i].u.y} + cases[i].y;
        const glm::dvec3 v(t * (1.0 - x / 128.0), t * (1.0 - y / 128.0), 1.0);
        const glm::dvec3 world = glm::dmat3(camera.world_from_camera) * v;
        const glm::dvec3 o(answers[i].o), d(answers[i].d);
        const double tolerance = 4e-6;  // a pixel is 0.012 wide
        ASSERT_LT(glm::length(o), 16.0 * 1.125);
        for (const auto& [depth, at] :
             {std::pair(camera.near_clip, answers[i].t_min), {camera.far_clip, answers[i].t_max}}) {
          // In double precision relative to the scene: eye + depth · world would be rounded to the distance.
          const glm::dvec3 p =
              (eye + distance * glm::normalize(world)) + (depth - distance / glm::length(world)) * world;
          const double bound = tolerance + 1e-15 * distance;
          EXPECT_LT(glm::length(o + double{at} * d - p), bound) << distance << ' ' << axis << ' ' << i;
        }
      }
    }
  }
}

// Values of the filters, by their definitions.
double filter_value(const Filter& f, double x) {
  x = std::abs(x);
  if (f.type == Filter::Type::tent) return std::max(0.0, 1.0 - x / f.stretch);
  if (f.type == Filter::Type::box) return x < 0.5 * f.stretch ? 1.0 : 0.0;
  if (f.type == Filter::Type::lanczos) {
    const double t = std::numbers::pi * x;
    return x == 0.0 ? 1.0 : x < f.lobes ? f.lobes * std::sin(t) * std::sin(t / f.lobes) / (t * t) : 0.0;
  }
  if (f.type == Filter::Type::gaussian) {
    return x < f.radius ? std::exp(-x * x / (2 * f.stddev * f.stddev)) -
                              std::exp(-f.radius * f.radius / (2 * f.stddev * f.stddev))
                        : 0.0;
  }
  const double q = 2.0 * x / f.radius, b = f.b, c = f.c;
  if (q < 1) return (12 - 9 * b - 6 * c) * q * q * q + (-18 + 12 * b + 6 * c) * q * q + 6 - 2 * b;
  if (q < 2) return (-b - 6 * c) * q * q * q + (6 * b + 30 * c) * q * q + (-12 * b - 48 * c) * q + 8 * b + 24 * c;
  return 0.0;
}

// Filter and cumulative sum of |filter| on a fine grid.
struct Cumulative {
  static constexpr int kSteps = 200000;
  explicit Cumulative(const Filter& filter) : radius(filter.radius), absolute{0.0} {
    for (int i = 0; i < kSteps; ++i) {
      const double f = filter_value(filter, -radius + (i + 0.5) * 2.0 * radius / kSteps);
      absolute.push_back(absolute.back() + std::abs(f));
      total += f;
    }
  }
  // Where the cumulative share reaches u.
  double inverse(double u) const {
    const double target = u * absolute.back();
    const auto above = std::lower_bound(absolute.begin() + 1, absolute.end(), target);
    const double step = (target - *(above - 1)) / std::max(*above - *(above - 1), 1e-300);
    return -radius + (static_cast<double>(above - absolute.begin()) - 1.0 + step) * 2.0 * radius / kSteps;
  }
  double weight() const { return absolute.back() / total; }
  double radius, total = 0.0;
  std::vector<double> absolute;
};

TEST_F(DeviceCamera, FilterSamplesFollowTheTabulatedInverse) {
  for (const Filter& filter :
       {Filter{.type = Filter::Type::tent, .radius = 1.0}, Filter{.type = Filter::Type::gaussian},
        Filter{.type = Filter::Type::gaussian, .radius = 3.0, .stddev = 1.1}, Filter{.type = Filter::Type::mitchell},
        Filter{.type = Filter::Type::mitchell, .radius = 3.5, .b = 0.0, .c = 0.5},
        Filter{.type = Filter::Type::tent, .radius = 2.5, .stretch = 2.5},
        Filter{.type = Filter::Type::box, .radius = 1.5, .stretch = 3.0},
        Filter{.type = Filter::Type::lanczos, .radius = 3.0},
        Filter{.type = Filter::Type::lanczos, .radius = 4.0, .lobes = 4}}) {
    Camera camera;
    camera.width = camera.height = 64;
    camera.fov = 90.0;
    camera.filter = filter;
    std::vector<gpu::CameraCase> cases = random_cases(camera, 1 << 15, 2);
    for (gpu::CameraCase& c : cases) c.x = c.y = 32, c.u.y = 0.5f;
    const auto answers = rays(scene_with(camera), cases);
    const Cumulative cumulative(filter);
    std::vector<double> knots;
    for (int i = 0; i <= 1024; ++i)
      knots.push_back(i == 0 ? -filter.radius : i == 1024 ? filter.radius : cumulative.inverse(i / 1024.0));
    const double weight = cumulative.weight();
    RunningMoments mean;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const double position = 1024.0 * cases[i].u.x, below = std::floor(position);
      const auto k = static_cast<std::size_t>(below);
      const double expected = knots[k] + (position - below) * (knots[k + 1] - knots[k]);
      const double x = 32.0 * (1.0 - answers[i].d.x / answers[i].d.z) - 32.5;  // fov 90°: tan = 1
      // Where the filter is nearly zero its inverse is steep; the knots are compared to the accuracy of the grid there.
      ASSERT_NEAR(x, expected, 3e-5) << static_cast<int>(filter.type) << " u = " << cases[i].u.x;
      mean.add(answers[i].weight / weight);
      const double f = filter_value(filter, x),
                   change = std::abs(filter_value(filter, x + 2e-3) - filter_value(filter, x - 2e-3));
      if (std::abs(f) > change) {  // away from the change of sign; the weight of y = 0 is positive
        EXPECT_NEAR(answers[i].weight, (f < 0 ? -weight : weight) * weight, 1e-4 * weight * weight) << x;
      }
    }
    // E[weight of x] = 1, so the filter keeps the image's brightness.
    EXPECT_LT(std::abs(mean.mean() - 1.0), 4.5 * mean.standard_error() + 1e-3);
  }
}

}  // namespace
}  // namespace etendue::test
