#include "compile/compiled_scene.h"

#include <cmath>
#include <numbers>

#include "compile/bvh.h"
#include "compile/discrete.h"
#include "compile/few_primitives.h"
#include "compile/filter_table.h"
#include "compile/normalization.h"
#include "compile/reinsertion.h"
#include "compile/wide_bvh.h"

namespace etendue {
namespace {

constexpr double kPi = std::numbers::pi;

double luminance(const glm::dvec3& rgb) {
  return glm::dot(rgb, glm::dvec3(0.212671, 0.715160, 0.072169));
}

gpu::Shape flatten_material(const Shape& shape) {
  gpu::Shape out{};
  out.first_triangle = gpu::kNone;
  if (const auto* diffuse = std::get_if<DiffuseBsdf>(&shape.bsdf)) {
    out.bsdf = gpu::kBsdfDiffuse;
    out.albedo = glm::vec3(diffuse->albedo);
  } else if (std::holds_alternative<MirrorBsdf>(shape.bsdf)) {
    out.bsdf = gpu::kBsdfMirror;
  } else {
    const auto& dielectric = std::get<DielectricBsdf>(shape.bsdf);
    out.bsdf = gpu::kBsdfDielectric;
    out.int_ior = static_cast<float>(dielectric.int_ior);
    out.ext_ior = static_cast<float>(dielectric.ext_ior);
  }
  if (shape.emitter) out.radiance = glm::vec3(shape.emitter->radiance);
  return out;
}

// Area of primitive i of the shape, in world units.
double primitive_area(const Shape& shape, std::size_t i) {
  if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) return 4.0 * kPi * sphere->radius * sphere->radius;
  const auto& mesh = std::get<TriangleMesh>(shape.geometry);
  const glm::uvec3 t = mesh.triangles[i];
  const glm::dvec3& p0 = mesh.positions[t.x];
  return 0.5 * glm::length(glm::cross(mesh.positions[t.y] - p0, mesh.positions[t.z] - p0));
}

std::size_t primitive_count(const Shape& shape) {
  const auto* mesh = std::get_if<TriangleMesh>(&shape.geometry);
  return mesh != nullptr ? mesh->triangles.size() : 1;
}

Box primitive_box(const gpu::Primitive& p) {
  Box box;
  if (p.kind == gpu::kPrimitiveSphere) {
    for (int a = 0; a < 3; ++a) {  // rounded outward
      box.lower[a] = std::nextafter(p.p0[a] - p.p1.x, -INFINITY);
      box.upper[a] = std::nextafter(p.p0[a] + p.p1.x, INFINITY);
    }
  } else {
    box.extend(p.p0);
    box.extend(p.p1);
    box.extend(p.p2);
  }
  return box;
}

class Compiler {
 public:
  explicit Compiler(const Scene& scene) : scene_(scene), normalization_(find_normalization(scene)) {}

  CompiledScene compile() {
    flatten_shapes();
    build_tree();
    make_lights();
    make_frame();
    return std::move(out_);
  }

 private:
  void flatten_shapes() {
    for (const Shape& shape : scene_.shapes) {
      gpu::Shape flat = flatten_material(shape);
      first_primitive_.push_back(flat_primitives_.size());
      const auto index = static_cast<gpu::uint>(out_.shapes.size());
      if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
        gpu::Primitive p{};
        p.p0 = normalization_.point(sphere->center);
        p.p1.x = static_cast<float>(sphere->radius * normalization_.scale);
        p.shape = index;
        p.kind = gpu::kPrimitiveSphere;
        out_.has_spheres = true;
        flat_primitives_.push_back(p);
      } else {
        flatten_mesh(std::get<TriangleMesh>(shape.geometry), index, flat);
      }
      out_.shapes.push_back(flat);
    }
    if (flat_primitives_.empty())
      flat_primitives_.push_back({});  // a point-sized triangle: bindings are never empty, nothing is hit
    if (out_.shapes.empty()) out_.shapes.push_back({});
  }

  void flatten_mesh(const TriangleMesh& mesh, gpu::uint shape_index, gpu::Shape& flat) {
    gpu::uint triangle = 0;
    for (const glm::uvec3& t : mesh.triangles) {
      gpu::Primitive p{};
      p.p0 = normalization_.point(mesh.positions[t.x]);
      p.p1 = normalization_.point(mesh.positions[t.y]);
      p.p2 = normalization_.point(mesh.positions[t.z]);
      p.shape = shape_index;
      p.primitive = triangle++;
      flat_primitives_.push_back(p);
    }
    if (mesh.normals.empty()) return;
    flat.first_triangle = static_cast<gpu::uint>(out_.triangles.size());
    const auto first_normal = static_cast<gpu::uint>(out_.normals.size());
    for (const glm::uvec3& t : mesh.triangles) out_.triangles.emplace_back(t + first_normal, 0u);
    for (const glm::dvec3& n : mesh.normals) out_.normals.emplace_back(glm::vec3(n), 0.0f);
  }

  // The primitives outside the tree: triangles, then spheres, each in the order of the scene.
  std::vector<std::uint32_t> take_few_primitives(const std::vector<Box>& boxes) {
    std::vector<std::uint32_t> few = choose_few_primitives(boxes);
    const auto spheres = std::ranges::stable_partition(
        few, [&](std::uint32_t i) { return flat_primitives_[i].kind == gpu::kPrimitiveTriangle; });
    out_.few_spheres = static_cast<std::uint32_t>(spheres.size());
    out_.few_triangles = static_cast<std::uint32_t>(few.size() - spheres.size());
    return few;
  }

  void build_tree() {
    std::vector<Box> boxes;
    boxes.reserve(flat_primitives_.size());
    for (const gpu::Primitive& p : flat_primitives_) boxes.push_back(primitive_box(p));
    const std::vector<std::uint32_t> few = take_few_primitives(boxes);
    Bvh bvh;
    if (few.size() < boxes.size()) {
      bvh = build_bvh(std::move(boxes), few);
      reinsert_subtrees(bvh);
    }
    WideBvh tree = make_wide_bvh(bvh, flat_primitives_, few);
    out_.records = std::move(tree.records);
    out_.tree_root = tree.root;
    out_.tree_depth = tree.depth;
    slot_of_ = std::move(tree.slot_of);
  }

  void make_lights() {
    std::vector<double> weights;
    std::vector<double> areas;
    for (const Shape& shape : scene_.shapes) {
      double area = 0.0;
      for (std::size_t i = 0; shape.emitter && i < primitive_count(shape); ++i) area += primitive_area(shape, i);
      areas.push_back(area);
      weights.push_back(shape.emitter ? luminance(shape.emitter->radiance) * area : 0.0);
    }
    const std::vector<std::uint64_t> thresholds = integer_thresholds(weights);
    for (std::size_t i = 0; i < weights.size() && !thresholds.empty(); ++i) {
      if (!(weights[i] > 0.0)) continue;
      gpu::Shape& flat = out_.shapes[i];
      flat.light_prob = static_cast<float>(static_cast<double>(thresholds[i + 1] - thresholds[i]) * 0x1p-32);
      flat.light_area = static_cast<float>(areas[i] * normalization_.scale * normalization_.scale);
      add_light(scene_.shapes[i], static_cast<gpu::uint>(i), static_cast<gpu::uint>(thresholds[i]));
    }
  }

  void add_light(const Shape& shape, gpu::uint index, gpu::uint threshold) {
    gpu::LightShape light{threshold, index, static_cast<gpu::uint>(out_.light_primitives.size()), 0};
    std::vector<double> areas;
    for (std::size_t i = 0; i < primitive_count(shape); ++i) areas.push_back(primitive_area(shape, i));
    const std::vector<std::uint64_t> thresholds = integer_thresholds(areas);
    for (std::size_t i = 0; i < areas.size(); ++i) {
      if (!(areas[i] > 0.0))
        continue;  // entries of zero weight are left out, so the last one with T <= word is the one chosen
      const auto prob = static_cast<float>(static_cast<double>(thresholds[i + 1] - thresholds[i]) * 0x1p-32);
      out_.light_primitives.push_back(
          {static_cast<gpu::uint>(thresholds[i]), slot_of_[first_primitive_[index] + i], prob, 0});
      ++light.primitive_count;
    }
    out_.light_shapes.push_back(light);
  }

  void make_frame() {
    const Camera& camera = scene_.camera;
    const glm::dmat4& m = camera.world_from_camera;
    gpu::Frame& f = out_.frame;
    f.camera_origin = normalization_.point(glm::dvec3(m[3]));
    f.camera_x = glm::vec3(m[0]);
    f.camera_y = glm::vec3(m[1]);
    f.camera_z = glm::vec3(m[2]);
    f.near_clip = static_cast<float>(camera.near_clip * normalization_.scale);
    f.far_clip = static_cast<float>(camera.far_clip * normalization_.scale);
    const double tan_x = std::tan(0.5 * camera.fov * kPi / 180.0);
    f.tan_x = static_cast<float>(tan_x);
    f.tan_y = static_cast<float>(tan_x * camera.height / camera.width);
    f.sky_top = glm::vec3(scene_.sky.top);
    f.sky_horizon = glm::vec3(scene_.sky.horizon);
    f.distance_scale = static_cast<float>(normalization_.scale);
    f.width = camera.width;
    f.height = camera.height;
    f.tiles_x = (camera.width + gpu::kTileSize - 1) / gpu::kTileSize;
    f.max_depth = scene_.integrator.max_depth;
    f.rr_depth = scene_.integrator.rr_depth > 0 ? scene_.integrator.rr_depth : gpu::kNone;
    f.film_exponent = film_exponent(scene_);
    f.light_shape_count = static_cast<gpu::uint>(out_.light_shapes.size());
    const FilterTable table = make_filter_table(camera.filter);
    f.filter_weight = static_cast<float>(table.weight);
    f.filter_zero = table.has_negative_lobes ? static_cast<float>(table.zero) : INFINITY;
    out_.filter_knots = table.knots;
  }

  const Scene& scene_;
  Normalization normalization_;
  CompiledScene out_;
  std::vector<gpu::Primitive> flat_primitives_;  // shape by shape, before the tree orders them
  std::vector<std::size_t> first_primitive_;     // of each shape, into flat_primitives_
  std::vector<gpu::uint> slot_of_;               // flat primitive to its record
};

}  // namespace

CompiledScene compile_scene(const Scene& scene) {
  return Compiler(scene).compile();
}

}  // namespace etendue
