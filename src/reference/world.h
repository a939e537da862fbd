#pragma once
/// The scene as the reference renders it: description, hierarchy, lights, filter.

#include <optional>
#include <vector>

#include "reference/bvh.h"
#include "reference/environment.h"
#include "reference/filter.h"
#include "reference/intersect.h"
#include "reference/lights.h"
#include "reference/placement.h"
#include "reference/ray.h"
#include "scene/sharing.h"
#include "scene/view.h"

namespace etendue::reference {

class World {
 public:
  /// Of rays and the points that they meet: double precision, or shaken at random by what single precision does to
  /// them.
  enum class Rounding { full, single };

  explicit World(const Scene& scene, Rounding rounding = Rounding::full);

  /// Looks at the same shapes and lights in another way.
  void set_view(const View& view);
  /// The same surfaces, of the same kinds of materials with other numbers.
  void set_materials(const std::vector<Material>& materials) { scene_.materials = materials; }

  const Scene& scene() const { return scene_; }
  const Lights& lights() const { return lights_; }
  const Environment& environment() const { return environment_; }
  double delta_light_limit() const { return delta_light_limit_; }
  const FilterSampler& filter() const { return filter_; }

  /// The nearest surface along the ray.
  std::optional<Surface> closest_hit(const Ray& ray) const;
  /// Whether some surface may be passed as if it were not there.
  bool may_pass() const { return may_pass_; }
  /// Whether anything lies between two points that have already been offset off their surfaces.
  bool occluded(const Vec3& from, const Vec3& to) const;
  /// Whether a ray from a point that has already been offset off its surface meets nothing.
  bool escapes(const Vec3& from, const Vec3& direction) const;

 private:
  /// A triangle; or a sphere when `radius` > 0 (its centre is p0); or a disk or tube; or an instance of a shared mesh,
  /// all of it.
  struct Primitive {
    Vec3 p0{0.0}, p1{0.0}, p2{0.0};
    double radius = 0.0;
    std::uint32_t instance = 0;
    std::uint32_t index = 0;  ///< triangle in its mesh, 0 for a sphere
    bool whole_mesh = false;  ///< then p0 and p1 are the corners of a box around it
    std::optional<Ellipse> disk = {};
    std::optional<Tube> tube = {};
  };
  /// A shared mesh in its own space; `instance` of its primitives means nothing.
  struct Mesh {
    Bvh bvh;
    std::vector<Primitive> primitives;  ///< in the order of the hierarchy's leaves
  };
  /// What a ray has met so far.
  struct Found {
    bool any = false;
    std::uint32_t instance = 0, index = 0;
    double radius = 0.0;  ///< of a sphere, around `center`
    Vec3 center{0.0};
    std::optional<Ellipse> disk = {};
    std::optional<Tube> tube = {};
    TriangleHit hit;
  };
  static Bvh build(std::vector<Primitive>& primitives);
  void add_meshes(const Sharing& sharing);
  std::vector<Primitive> collect(const Sharing& sharing) const;
  /// Tests one primitive, that of `instance`, against a ray in its space; takes it when it is the nearest.
  static void meet(const Primitive& primitive, std::uint32_t instance, const Ray& ray, const TriangleTest& test,
                   double& t_max, Found& found);
  std::vector<Primitive> without_twins(std::vector<Primitive> primitives) const;
  Surface surface(const Found& found, const Vec3& near_point) const;
  void shake(Surface& surface) const;
  Surface triangle_surface(const Found& found) const;
  static Surface sphere_surface(const Found& found, const Vec3& near_point, bool inward);
  static Surface disk_surface(const Found& found, const Vec3& near_point);
  static Surface tube_surface(const Found& found, const Vec3& near_point);

  Scene scene_;
  Rounding rounding_;
  Lights lights_;
  Environment environment_;
  FilterSampler filter_;
  double delta_light_limit_ = 0.0;
  Bvh bvh_;
  std::vector<Primitive> primitives_;  ///< in the order of the hierarchy's leaves
  std::vector<Placement> placements_;  ///< of the instances
  std::vector<bool> passing_;          ///< of the instances: whether rays may pass them
  bool may_pass_ = false;
  std::optional<Sharing> sharing_;
  std::vector<Mesh> meshes_;  ///< by shape; empty where it is not shared
};

}  // namespace etendue::reference
