#include "compile/compiled_scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/core.h>

#include "compile/bvh.h"
#include "compile/discrete.h"
#include "compile/few_primitives.h"
#include "compile/light_tree.h"
#include "compile/normalization.h"
#include "compile/reinsertion.h"
#include "compile/wide_bvh.h"
#include "core/errors.h"

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

// Of radiance 1. Power 0 for a triangle whose normal is made of rounding errors.
LightLeaf light_leaf(const Shape& shape, std::size_t i) {
  LightLeaf leaf;
  leaf.area = primitive_area(shape, i);
  if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
    leaf.power = leaf.area / 4.0;  // what it shows to each side
    leaf.lower = sphere->center - sphere->radius;
    leaf.upper = sphere->center + sphere->radius;
    return leaf;
  }
  const auto& mesh = std::get<TriangleMesh>(shape.geometry);
  const glm::uvec3 t = mesh.triangles[i];
  const glm::dvec3 &p0 = mesh.positions[t.x], &p1 = mesh.positions[t.y], &p2 = mesh.positions[t.z];
  leaf.lower = glm::min(p0, glm::min(p1, p2));
  leaf.upper = glm::max(p0, glm::max(p1, p2));
  constexpr double kLeastShare = 1e-14;  // of the longest edge squared, for twice the area
  const double longest = std::max({glm::dot(p1 - p0, p1 - p0), glm::dot(p2 - p1, p2 - p1), glm::dot(p0 - p2, p0 - p2)});
  if (!(2.0 * leaf.area > kLeastShare * longest)) return leaf;
  leaf.power = leaf.area;
  leaf.normal = glm::cross(p1 - p0, p2 - p0) / (2.0 * leaf.area);
  return leaf;
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
    check_size();
    flatten_shapes();
    build_tree();
    make_lights();
    if (wants_light_tree(scene_)) make_light_tree();
    out_.normalization = normalization_;
    out_.sky = scene_.sky;
    out_.film_exponent = film_exponent(scene_, Integrator::Type::path);
    return std::move(out_);
  }

 private:
  // The tree refuses what it cannot address; here it costs neither time nor memory.
  void check_size() const {
    std::size_t primitives = 0;
    for (const Shape& shape : scene_.shapes) primitives += primitive_count(shape);
    if (primitives < kMaxPrimitives) return;
    throw Error(ExitCode::scene_error,
                fmt::format("The scene {} has {} primitives; kernels address fewer than {}. Use coarser meshes or "
                            "--device reference.",
                            scene_.name, primitives, kMaxPrimitives));
  }

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
    const auto spheres = std::stable_partition(
        few.begin(), few.end(), [&](std::uint32_t i) { return flat_primitives_[i].kind == gpu::kPrimitiveTriangle; });
    out_.few_triangles = static_cast<std::uint32_t>(spheres - few.begin());
    out_.few_spheres = static_cast<std::uint32_t>(few.end() - spheres);
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
    WideBvh tree = make_wide_bvh<gpu::kBvhWidth>(bvh, flat_primitives_, few);
    out_.records = std::move(tree.texels);
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

  // The primitives that emit, in the order of the scene; where[i] = (shape, primitive) of leaf i.
  std::vector<LightLeaf> light_leaves(std::vector<std::pair<std::size_t, std::size_t>>& where) const {
    std::vector<LightLeaf> leaves;
    for (std::size_t s = 0; s < scene_.shapes.size(); ++s) {
      const Shape& shape = scene_.shapes[s];
      const double radiance = shape.emitter ? luminance(shape.emitter->radiance) : 0.0;
      for (std::size_t i = 0; radiance > 0.0 && i < primitive_count(shape); ++i) {
        LightLeaf leaf = light_leaf(shape, i);
        leaf.power *= radiance;
        if (!(leaf.power > 0.0)) continue;
        leaf.slot = slot_of_[first_primitive_[s] + i];
        leaves.push_back(leaf);
        where.emplace_back(s, i);
      }
    }
    return leaves;
  }

  void make_light_tree() {
    std::vector<std::pair<std::size_t, std::size_t>> where;
    const std::vector<LightLeaf> leaves = light_leaves(where);
    if (leaves.size() < 2) return;  // nothing to choose: by power is the same
    FlatLightTree tree = build_light_tree(leaves, normalization_);
    std::vector<gpu::LightTrail>& trails = out_.light_trails;
    trails.resize(scene_.shapes.size());
    for (std::size_t s = 0; s < scene_.shapes.size(); ++s) {
      if (!scene_.shapes[s].emitter) continue;
      trails[s].turns = static_cast<gpu::uint>(trails.size());
      trails.resize(trails.size() + primitive_count(scene_.shapes[s]), gpu::LightTrail{0, 1.0f, 0, 0});
    }
    for (std::size_t i = 0; i < where.size(); ++i) {
      const auto [shape, primitive] = where[i];
      trails[trails[shape].turns + primitive] = tree.trails[i];
    }
    out_.light_pairs = std::move(tree.pairs);
    out_.light_tree_depth = tree.depth;
  }

  const Scene& scene_;
  Normalization normalization_;
  CompiledScene out_;
  std::vector<gpu::Primitive> flat_primitives_;  // shape by shape, before the tree orders them
  std::vector<std::size_t> first_primitive_;     // of each shape, into flat_primitives_
  std::vector<gpu::uint> slot_of_;               // of each flat primitive
};

std::atomic<std::uint64_t> g_compilations{0};

}  // namespace

std::uint64_t scene_compilations() {
  return g_compilations;
}

CompiledScene compile_scene(const Scene& scene) {
  ++g_compilations;
  return Compiler(scene).compile();
}

}  // namespace etendue
