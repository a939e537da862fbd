/// Camera rays and reconstruction filters, against docs/conventions.md in double precision.

#include <algorithm>
#include <cmath>
#include <numbers>

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
    const bool box = scene.camera.filter.type == Filter::Type::box;
    KernelRun kernel{kernels::camera_rays, "camera_rays", &compiled};
    kernel.constants = {{gpu::kConstantFilterKind, box ? gpu::kFilterBox : gpu::kFilterTable},
                        {gpu::kConstantCamera, view.camera}};
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
    gpu::CameraCase c{random.below(camera.width), random.below(camera.height), {random.unit(), 0.0f}};
    c.u.y = random.unit();
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
  if (f.type == Filter::Type::tent) return std::max(0.0, 1.0 - x);
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
        Filter{.type = Filter::Type::mitchell, .radius = 3.5, .b = 0.0, .c = 0.5}}) {
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
