#include "compile/compiled_scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include <fmt/core.h>

#include "compile/bvh.h"
#include "compile/delta_lights.h"
#include "compile/discrete.h"
#include "compile/few_primitives.h"
#include "compile/light_tree.h"
#include "compile/material_records.h"
#include "compile/normalization.h"
#include "compile/primitive_box.h"
#include "compile/reinsertion.h"
#include "compile/shared_mesh.h"
#include "compile/twins.h"
#include "compile/vertex_normals.h"
#include "compile/wide_bvh.h"
#include "core/errors.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "image/vectors.h"
#include "scene/film_unit.h"
#include "scene/invariants.h"
#include "scene/lamp_parts.h"
#include "scene/materials.h"
#include "scene/parameters.h"
#include "scene/placed.h"
#include "scene/sharing.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

constexpr std::uint64_t kFlattenGrain = 1u << 14;  // primitives for one thread

// A shape placed by its instance; only the member for its kind of shape is set.
struct Placed {
  Placed(const Scene& scene, const Instance& instance) {
    const Shape& shape = scene.shape_of(instance);
    if (const auto* s = std::get_if<Sphere>(&shape)) {
      sphere = placed_sphere(*s, instance);
      inward = instance.flip_normals;
    }
    if (const auto* m = std::get_if<TriangleMesh>(&shape)) mesh.emplace(*m, instance);
    if (std::holds_alternative<Disk>(shape)) disk = placed_disk(instance);
    if (const auto* c = std::get_if<Cylinder>(&shape)) cylinder = placed_cylinder(*c, instance);
  }
  std::size_t primitive_count() const { return mesh ? mesh->triangle_count() : 1; }
  // The area of primitive i, in world units.
  double area(std::size_t i) const {
    if (mesh) return triangle_area(mesh->triangle(i));
    if (disk) return disk->area();
    return cylinder ? cylinder->area() : 4.0 * kPi * sphere->radius * sphere->radius;
  }

  std::optional<Sphere> sphere;
  bool inward = false;  // the sphere's normal points inward
  std::optional<PlacedMesh> mesh;
  std::optional<PlacedDisk> disk;
  std::optional<PlacedCylinder> cylinder;
};

// A triangle with vertex normals emits on the side of its shading normals, which lie between those of its corners. If
// these have no half-space in common, it may emit to any side.
void use_corner_normals(const PlacedMesh& mesh, std::size_t triangle, LightLeaf& leaf) {
  const glm::uvec3 t = mesh.indices(triangle);
  leaf.corner_normals = {mesh.normal(t.x), mesh.normal(t.y), mesh.normal(t.z)};
  const glm::dvec3 sum = leaf.corner_normals[0] + leaf.corner_normals[1] + leaf.corner_normals[2];
  leaf.normal = glm::length(sum) > 0.0 ? glm::normalize(sum) : glm::dvec3(0.0);
  for (const glm::dvec3& normal : leaf.corner_normals) {
    if (!(glm::dot(leaf.normal, normal) > 0.0)) leaf.normal = glm::dvec3(0.0);
  }
}

// The leaf for radiance 1. The power is 0 for a triangle whose normal consists of rounding errors.
LightLeaf light_leaf(const Placed& placed, std::size_t i) {
  LightLeaf leaf;
  leaf.area = placed.area(i);
  if (placed.sphere) {
    leaf.power = leaf.area / 4.0;  // its area as seen from any side
    leaf.lower = placed.sphere->center - placed.sphere->radius;
    leaf.upper = placed.sphere->center + placed.sphere->radius;
    return leaf;
  }
  if (placed.disk) {
    leaf.power = leaf.area;
    leaf.lower = placed.disk->center - placed.disk->reach();
    leaf.upper = placed.disk->center + placed.disk->reach();
    leaf.normal = placed.disk->normal();
    return leaf;
  }
  if (const auto& cylinder = placed.cylinder) {
    leaf.power = leaf.area / kPi;  // its area as seen from the side
    leaf.lower = glm::min(cylinder->p0, cylinder->p1) - cylinder->reach();
    leaf.upper = glm::max(cylinder->p0, cylinder->p1) + cylinder->reach();
    return leaf;
  }
  const auto [p0, p1, p2] = placed.mesh->triangle(i);
  leaf.lower = glm::min(p0, glm::min(p1, p2));
  leaf.upper = glm::max(p0, glm::max(p1, p2));
  constexpr double kLeastShare = 1e-14;  // smallest ratio of twice the area to the longest edge squared
  const double longest = std::max({glm::dot(p1 - p0, p1 - p0), glm::dot(p2 - p1, p2 - p1), glm::dot(p0 - p2, p0 - p2)});
  if (!(2.0 * leaf.area > kLeastShare * longest)) return leaf;
  leaf.power = leaf.area;
  leaf.normal = glm::cross(p1 - p0, p2 - p0) / (2.0 * leaf.area);
  if (placed.mesh->has_normals()) use_corner_normals(*placed.mesh, i, leaf);
  return leaf;
}

class Compiler {
 public:
  Compiler(const Scene& scene, const Normalization& normalization)
      : scene_(scene),
        sharing_(scene),
        normalization_(normalization),
        meshes_(scene.shapes.size()),
        texture_facts_(scene),
        passable_shapes_(scene.shapes.size()),
        lamp_parts_(lamp_parts(scene)) {
    for (const Instance& instance : scene_.instances) {
      const bool passes = may_pass(scene_, instance.material);
      passing_.push_back(passes);
      passes_ |= passes;
      if (passes) passable_shapes_.at(instance.shape) = true;
    }
  }

  CompiledScene compile() {
    check_size();
    flatten_materials();
    flatten_instances();
    build_tree();
    light();
    out_.normalization = normalization_;
    out_.bounds = bounds_of(scene_);
    return std::move(out_);
  }

  CompiledLights compile_lights(const CompiledScene& base) {
    out_.instances = base.instances;
    flatten_emitters();
    light();
    return std::move(static_cast<CompiledLights&>(out_));
  }

 private:
  void light() {
    make_lights();
    if (wants_light_tree(scene_)) make_light_tree();
    if (out_.lamp_parts && out_.light_tree_depth == 0) make_part_trails();
    out_.environment = compile_environment(scene_, lights_power_);
    for (std::uint32_t i = 0; i < out_.distant_lights; ++i) {
      const std::vector<std::uint64_t>& thresholds = out_.environment.distant_thresholds;
      out_.delta_lights[i].threshold = static_cast<gpu::uint>(thresholds[i]);
      out_.delta_lights[i].prob = static_cast<float>(static_cast<double>(thresholds[i + 1] - thresholds[i]) * 0x1p-32);
    }
    out_.radiance_exponent = radiance_exponent(scene_);
  }

  // The tree would refuse a scene that it cannot address; checking here costs neither time nor memory.
  void check_size() const {
    std::size_t primitives = 0;
    for (std::size_t i = 0; i < scene_.instances.size(); ++i)
      primitives += sharing_.has_instance(i) ? 1 : primitive_count(scene_.shape_of(scene_.instances[i]));
    for (std::size_t s = 0; s < scene_.shapes.size(); ++s)
      primitives += sharing_.has_shape(s) ? primitive_count(scene_.shapes[s]) : 0;
    if (primitives < kMaxPrimitives) return;
    throw Error(ErrorKind::scene,
                fmt::format("The scene {} has {} primitives; kernels address fewer than {}. Use coarser meshes or "
                            "--device reference.",
                            scene_.name, primitives, kMaxPrimitives));
  }

  void flatten_materials() {
    out_.textures = compile_textures(scene_);
    static_cast<CompiledMaterials&>(out_) = compile_materials(scene_.materials, out_.textures.features != 0);
  }

  void flatten_instances() {
    for (const Instance& instance : scene_.instances) {
      gpu::Instance flat{};
      flat.radiance = radiance_of(instance);
      flat.material = instance.material;
      flat.first_triangle = gpu::kNone;
      flat.place = gpu::kNone;
      first_primitive_.push_back(flat_primitives_.size());
      if (sharing_.has_instance(out_.instances.size())) {
        place_shared(instance, static_cast<gpu::uint>(out_.instances.size()), flat);
      } else {
        flatten_shape(Placed(scene_, instance), static_cast<gpu::uint>(out_.instances.size()), flat);
      }
      out_.instances.push_back(flat);
    }
    if (flat_primitives_.empty())
      flat_primitives_.push_back({});  // a triangle of size 0: bindings are never empty, and nothing is hit
    if (out_.instances.empty()) out_.instances.push_back({.place = gpu::kNone});
  }

  glm::vec3 radiance_of(const Instance& instance) const {
    const AreaEmitter* emitter = scene_.emitter_of(instance);
    return emitter != nullptr ? glm::vec3(emitter->radiance.value) : glm::vec3(0.0f);
  }

  // Only the primitives that emit, but numbered as if all were there.
  void flatten_emitters() {
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
      const Instance& instance = scene_.instances[i];
      gpu::Instance& flat = out_.instances[i];
      flat.radiance = radiance_of(instance);
      flat.light_prob = flat.light_area = 0.0f;
      first_primitive_.push_back(flat_primitives_.size());
      if (sharing_.has_instance(i)) {
        std::unique_ptr<SharedMesh>& mesh = meshes_[instance.shape];
        if (instance.emitter && !mesh)
          mesh = std::make_unique<SharedMesh>(prepare_shared_primitives(scene_.shapes[instance.shape]));
      } else if (instance.emitter) {
        add_primitives(Placed(scene_, instance), static_cast<gpu::uint>(i));
      } else {
        order_ += primitive_count(scene_.shape_of(instance));
      }
    }
  }

  const SharedMesh& shared_mesh(std::uint32_t shape) {
    std::unique_ptr<SharedMesh>& mesh = meshes_[shape];
    if (mesh) return *mesh;
    const auto& object = std::get<TriangleMesh>(scene_.shapes[shape]);
    mesh = std::make_unique<SharedMesh>(prepare_shared_mesh(scene_.shapes[shape]));
    if (passable_shapes_.at(shape))
      for (gpu::Primitive& p : mesh->primitives) p.kind |= gpu::kPrimitivePassable;
    if (!object.normals.empty()) {
      mesh->first_triangle = static_cast<gpu::uint>(out_.vertex_normals.size());
      add_vertex_normals(object.triangles.size(), [&](std::size_t i) {
        const glm::uvec3& t = object.triangles[i];
        return pack_normals(object.normals[t.x], object.normals[t.y], object.normals[t.z]);
      });
    }
    return *mesh;
  }

  // An instance of a shared mesh: the record names its place and, later, the root of the mesh's tree.
  void place_shared(const Instance& instance, gpu::uint index, gpu::Instance& flat) {
    const SharedMesh& mesh = shared_mesh(instance.shape);
    flat.first_triangle = mesh.first_triangle;
    flat.place = static_cast<gpu::uint>(out_.places.size());
    const gpu::Place place = make_place(mesh, instance, normalization_);
    out_.places.push_back(place);
    if (mesh.bvh.nodes.empty() || !can_be_met(place)) return;
    gpu::Primitive record{};
    record.p0 = place.object_x;
    record.p1 = place.object_y;
    record.p2 = place.object_z;
    record.instance = index | gpu::kRecordInstance;
    record.primitive = instance.shape;  // replaced once its tree has a root
    record.kind = flat.place;
    shared_records_.push_back(record);
    shared_boxes_.push_back(placed_box(mesh, place));
  }

  // Instances so small that single precision cannot distinguish them from a point are left out.
  static bool can_be_met(const gpu::Place& place) {
    constexpr float kLeast = 0x1p-60f, kMost = 0x1p55f;
    float most = 0.0f, inverse = 0.0f;
    for (const glm::vec3& v : {glm::vec3(place.x), glm::vec3(place.y), glm::vec3(place.z)})
      most = std::max({most, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    for (const glm::vec3& v : {glm::vec3(place.object_x), glm::vec3(place.object_y), glm::vec3(place.object_z)})
      inverse = std::max({inverse, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    return most >= kLeast && inverse <= kMost;
  }

  // Instances that show the same mesh at the same place are always hit together, so the first one stands for all.
  void drop_shared_twins() {
    const auto same = [&](const gpu::Primitive& a, const gpu::Primitive& b) {
      return a.primitive == b.primitive && a.p0 == b.p0 && a.p1 == b.p1 && a.p2 == b.p2 &&
             out_.places[a.kind].origin == out_.places[b.kind].origin;
    };
    const auto key = [&](const gpu::Primitive& r) {
      const glm::vec3 o = out_.places[r.kind].origin;
      return std::tuple(r.primitive, o.x, o.y, o.z, r.p0.x, r.p0.y, r.p0.z, r.p1.x, r.p1.y, r.p1.z, r.p2.x, r.p2.y,
                        r.p2.z);
    };
    std::vector<std::uint32_t> order(shared_records_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(
        order, [&](std::uint32_t a, std::uint32_t b) { return key(shared_records_[a]) < key(shared_records_[b]); });
    std::vector<bool> twin(order.size(), false);
    for (std::size_t i = 1; i < order.size(); ++i)
      twin[order[i]] = same(shared_records_[order[i - 1]], shared_records_[order[i]]) &&
                       !passing_.at(shared_records_[order[i - 1]].instance & ~gpu::kRecordInstance);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < twin.size(); ++i) {
      if (twin[i]) continue;
      shared_records_[kept] = shared_records_[i];
      shared_boxes_[kept++] = shared_boxes_[i];
    }
    shared_records_.resize(kept);
    shared_boxes_.resize(kept);
  }

  static gpu::uint order_bits(std::size_t order) { return static_cast<gpu::uint>(order) << gpu::kPrimitiveOrderShift; }
  gpu::uint passable_bit(gpu::uint instance) const { return passing_.at(instance) ? gpu::kPrimitivePassable : 0; }

  void flatten_shape(const Placed& placed, gpu::uint index, gpu::Instance& flat) {
    add_primitives(placed, index);
    if (placed.mesh && placed.mesh->has_normals()) add_normals(*placed.mesh, flat);
  }

  void add_primitives(const Placed& placed, gpu::uint index) {
    if (placed.mesh) return add_triangles(*placed.mesh, index);
    gpu::Primitive p{};
    p.instance = index;
    if (placed.disk) {
      const PlacedDisk& disk = *placed.disk;
      p.p0 = normalization_.point(disk.center);
      p.p1 = normalization_.point(disk.center + disk.a);
      p.p2 = normalization_.point(disk.center + disk.b);
      p.kind = gpu::kPrimitiveDisk;
      out_.has_disks = true;
    } else if (placed.cylinder) {
      p.p0 = normalization_.point(placed.cylinder->p0);
      p.p1 = normalization_.point(placed.cylinder->p1);
      p.p2.x = static_cast<float>(placed.cylinder->radius * normalization_.scale);
      p.p2.y = placed.cylinder->inward ? -1.0f : 1.0f;
      p.kind = gpu::kPrimitiveCylinder;
      out_.has_cylinders = true;
    } else {
      p.p0 = normalization_.point(placed.sphere->center);
      p.p1.x = static_cast<float>(placed.sphere->radius * normalization_.scale);
      p.p1.y = placed.inward ? 1.0f : 0.0f;
      p.kind = gpu::kPrimitiveSphere;
      out_.has_spheres = true;
      out_.inward_spheres |= placed.inward;
    }
    p.kind |= order_bits(order_++) | passable_bit(index);
    flat_primitives_.push_back(p);
  }

  void add_triangles(const PlacedMesh& mesh, gpu::uint index) {
    const std::size_t first = flat_primitives_.size();
    flat_primitives_.resize(first + mesh.triangle_count());
    const gpu::uint passable = passable_bit(index);
    parallel_for(mesh.triangle_count(), kFlattenGrain, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) {
        const auto [p0, p1, p2] = mesh.triangle(i);
        gpu::Primitive& p = flat_primitives_[first + i];
        p.p0 = normalization_.point(p0);
        p.p1 = normalization_.point(p1);
        p.p2 = normalization_.point(p2);
        p.instance = index;
        p.primitive = static_cast<gpu::uint>(i);
        p.kind = order_bits(order_ + i) | passable;
      }
    });
    order_ += mesh.triangle_count();
  }

  void add_normals(const PlacedMesh& mesh, gpu::Instance& flat) {
    flat.first_triangle = static_cast<gpu::uint>(out_.vertex_normals.size());
    add_vertex_normals(mesh.triangle_count(), [&](std::size_t i) {
      const glm::uvec3 t = mesh.indices(i);
      return pack_normals(mesh.normal(t.x), mesh.normal(t.y), mesh.normal(t.z));
    });
  }

  template <typename Packed>
  void add_vertex_normals(std::size_t triangles, const Packed& packed) {
    const std::size_t first = out_.vertex_normals.size();
    out_.vertex_normals.resize(first + triangles);
    parallel_for(triangles, kFlattenGrain, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) out_.vertex_normals[first + i] = packed(i);
    });
  }

  // The primitives outside the tree, in the order of the scene.
  std::vector<std::uint32_t> take_few_primitives(const std::vector<Box>& boxes) {
    std::vector<std::uint32_t> few = choose_few_primitives(boxes, boxes.size() - shared_records_.size());
    out_.few_count = static_cast<std::uint32_t>(few.size());
    for (std::size_t i = 0; i < few.size(); ++i) {
      const gpu::uint kind = flat_primitives_[few[i]].kind & gpu::kPrimitiveKindMask;
      out_.few_spheres |= static_cast<std::uint32_t>(kind == gpu::kPrimitiveSphere) << i;
      out_.few_disks |= static_cast<std::uint32_t>(kind == gpu::kPrimitiveDisk) << i;
      out_.few_cylinders |= static_cast<std::uint32_t>(kind == gpu::kPrimitiveCylinder) << i;
    }
    return few;
  }

  void build_tree() {
    std::vector<Box> boxes(flat_primitives_.size());
    parallel_for(boxes.size(), kFlattenGrain, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) boxes[i] = primitive_box(flat_primitives_[i]);
    });
    const std::vector<Twin> twins = find_twins(flat_primitives_, passes_ ? passing_ : std::vector<bool>());
    for (const Twin& twin : twins) boxes[twin.primitive] = {};
    drop_shared_twins();
    const std::size_t first_shared = flat_primitives_.size();
    flat_primitives_.insert(flat_primitives_.end(), shared_records_.begin(), shared_records_.end());
    boxes.insert(boxes.end(), shared_boxes_.begin(), shared_boxes_.end());
    const std::vector<std::uint32_t> few = take_few_primitives(boxes);
    std::vector<std::uint32_t> outside = few;
    for (const Twin& twin : twins) outside.push_back(twin.primitive);
    std::ranges::sort(outside);
    outside.erase(std::ranges::unique(outside).begin(), outside.end());
    Bvh bvh;
    if (outside.size() < boxes.size()) {
      bvh = build_bvh(std::move(boxes), outside);
      reinsert_subtrees(bvh);
    }
    WideBvh tree = make_wide_bvh<gpu::kBvhWidth>(bvh, flat_primitives_, few);
    out_.records = std::move(tree.texels);
    out_.tree_root = tree.root;
    out_.tree_depth = tree.depth;
    if (!shared_records_.empty()) add_shared_trees(tree.slot_of, first_shared);
  }

  // Appends the trees of the shared meshes to that of the scene, and sets the roots in the records of the instances.
  void add_shared_trees(const std::vector<std::uint32_t>& slot_of, std::size_t first_shared) {
    std::vector<std::uint32_t> roots(meshes_.size(), gpu::kNone);
    std::uint32_t deepest = 0;
    for (std::size_t i = first_shared; i < flat_primitives_.size(); ++i) {
      const std::uint32_t shape = flat_primitives_[i].primitive;
      if (roots[shape] == gpu::kNone) {
        SharedMesh& mesh = *meshes_[shape];
        WideBvh tree = make_wide_bvh<gpu::kBvhWidth>(mesh.bvh, mesh.primitives, {}, std::move(out_.records));
        out_.records = std::move(tree.texels);
        roots[shape] = tree.root;
        deepest = std::max(deepest, tree.depth);
        release(mesh.bvh.nodes);
      }
      out_.records[std::size_t{slot_of[i]} * gpu::kSlotTexels + 1].w = roots[shape];
    }
    out_.tree_depth += deepest;
  }

  void make_lights() {
    std::vector<double> weights;
    std::vector<double> areas;
    for (const Instance& instance : scene_.instances) {
      const AreaEmitter* emitter = scene_.emitter_of(instance);
      double area = 0.0, power = 0.0;
      if (emitter != nullptr && sharing_.has_instance(areas.size())) {
        area = placed_area(shared_light(instance.shape).light, instance);
        power = luminance(EmitterRadiance(texture_facts_, instance).mean_of_all()) * area;
      } else if (emitter != nullptr) {
        const Placed placed(scene_, instance);
        const EmitterRadiance radiance(texture_facts_, instance);
        const LampParts* const parts = parts_of(areas.size());
        for (std::size_t i = 0; i < placed.primitive_count(); ++i) {
          area += placed.area(i);
          if (parts == nullptr && !radiance.uniform()) power += luminance(radiance.mean(i)) * placed.area(i);
        }
        if (parts != nullptr) {
          for (const double part : part_powers(placed, *parts)) power += part;
        } else if (radiance.uniform()) {
          power = luminance(radiance.mean()) * area;
        }
      }
      areas.push_back(area);
      weights.push_back(power);
    }
    flatten_delta_lights(weights);
    for (const double weight : weights) lights_power_ += weight;
    const std::vector<std::uint64_t> thresholds = integer_thresholds(weights);
    for (std::size_t i = 0; i < areas.size() && !thresholds.empty(); ++i) {
      if (!(weights[i] > 0.0)) continue;
      gpu::Instance& flat = out_.instances[i];
      flat.light_prob = static_cast<float>(static_cast<double>(thresholds[i + 1] - thresholds[i]) * 0x1p-32);
      flat.light_area = static_cast<float>(areas[i] * normalization_.scale * normalization_.scale);
      if (sharing_.has_instance(i)) {
        const SharedMesh& mesh = shared_light(scene_.instances[i].shape);
        const double scale = mesh.normalization.scale;
        flat.light_area = static_cast<float>(mesh.light.area * scale * scale);
        mark_two_sided(i);
        out_.light_instances.push_back({static_cast<gpu::uint>(thresholds[i]), static_cast<gpu::uint>(i),
                                        mesh.first_light_primitive, mesh.light_primitive_count});
        continue;
      }
      mark_two_sided(i);
      add_light(Placed(scene_, scene_.instances[i]), static_cast<gpu::uint>(i), static_cast<gpu::uint>(thresholds[i]));
    }
    if (!thresholds.empty()) add_delta_lights(std::span(thresholds).subspan(areas.size()));
  }

  // Null for an instance that is not divided.
  const LampParts* parts_of(std::size_t instance) const {
    const auto found = lamp_parts_.find(static_cast<std::uint32_t>(instance));
    return found == lamp_parts_.end() ? nullptr : &found->second;
  }

  // Luminance times area.
  static std::vector<double> part_powers(const Placed& placed, const LampParts& parts) {
    std::vector<double> powers;
    for (std::size_t i = 0; i < parts.cells.size(); ++i) {
      const double area = placed.area(i) / (parts.cells[i] * parts.cells[i]);
      for (std::uint32_t p = parts.first[i]; p < parts.first[i + 1]; ++p) powers.push_back(parts.brightness[p] * area);
    }
    return powers;
  }

  // Those that have a position are chosen along with the instances, and follow them in `weights`.
  void flatten_delta_lights(std::vector<double>& weights) {
    for (const std::uint32_t number : delta_light_order(scene_)) {
      const DeltaLight& light = scene_.delta_lights[number];
      out_.delta_lights.push_back(flatten_delta_light(scene_, number, normalization_));
      if (light.type == DeltaLight::Type::directional) {
        ++out_.distant_lights;
      } else {
        weights.push_back(delta_light_power(scene_, light));
      }
    }
  }

  void add_delta_lights(std::span<const std::uint64_t> thresholds) {
    for (std::size_t i = 0; i + 1 < thresholds.size(); ++i) {
      const auto index = static_cast<gpu::uint>(out_.distant_lights + i);
      out_.delta_lights[index].prob =
          static_cast<float>(static_cast<double>(thresholds[i + 1] - thresholds[i]) * 0x1p-32);
      out_.light_instances.push_back({static_cast<gpu::uint>(thresholds[i]), gpu::kLightLeafDelta | index, 0, 0});
    }
  }

  bool is_two_sided(std::size_t instance) const {
    const AreaEmitter* emitter = scene_.emitter_of(scene_.instances[instance]);
    return emitter != nullptr && emitter->two_sided;
  }
  void mark_two_sided(std::size_t instance) {
    if (!is_two_sided(instance)) return;
    out_.two_sided_lights = true;
    out_.instances[instance].light_area = -out_.instances[instance].light_area;
  }

  void add_light(const Placed& placed, gpu::uint index, gpu::uint threshold) {
    gpu::LightInstance light{threshold, index, static_cast<gpu::uint>(out_.light_primitives.size()), 0};
    const gpu::Primitive* const primitives = &flat_primitives_[first_primitive_[index]];
    if (const LampParts* const parts = parts_of(index)) {
      light.primitive_count = add_light_parts(part_powers(placed, *parts), *parts, primitives);
    } else {
      std::vector<double> areas;
      for (std::size_t i = 0; i < placed.primitive_count(); ++i) areas.push_back(placed.area(i));
      light.primitive_count = add_light_primitives(areas, primitives);
    }
    out_.light_instances.push_back(light);
  }

  // Returns how many there are.
  gpu::uint add_light_primitives(const std::vector<double>& areas, const gpu::Primitive* primitives) {
    const std::vector<std::uint64_t> thresholds = integer_thresholds(areas);
    gpu::uint count = 0;
    for (std::size_t i = 0; i < areas.size(); ++i) {
      if (!(areas[i] > 0.0))
        continue;  // entries of zero weight are left out, so the last one with T <= word is the one chosen
      const auto prob = static_cast<float>(static_cast<double>(thresholds[i + 1] - thresholds[i]) * 0x1p-32);
      out_.light_primitives.push_back({primitives[i], static_cast<gpu::uint>(thresholds[i]), prob, 0, 0});
      ++count;
    }
    return count;
  }

  gpu::uint add_light_parts(const std::vector<double>& powers, const LampParts& parts,
                            const gpu::Primitive* primitives) {
    const std::vector<std::uint64_t> thresholds = integer_thresholds(powers);
    gpu::uint count = 0;
    for (std::size_t i = 0; i < parts.cells.size(); ++i) {
      for (std::uint32_t p = parts.first[i]; p < parts.first[i + 1]; ++p) {
        if (!(powers[p] > 0.0)) continue;
        const auto prob = static_cast<float>(static_cast<double>(thresholds[p + 1] - thresholds[p]) * 0x1p-32);
        out_.light_primitives.push_back(
            {primitives[i], static_cast<gpu::uint>(thresholds[p]), prob, parts.cells[i], p - parts.first[i]});
        ++count;
      }
    }
    out_.lamp_parts = true;
    return count;
  }

  // Adds a shared mesh with its light primitives, which all its instances share.
  const SharedMesh& shared_light(std::uint32_t shape) {
    SharedMesh& mesh = *meshes_[shape];
    if (mesh.first_light_primitive != gpu::kNone) return mesh;
    mesh.light = measure_mesh_light(std::get<TriangleMesh>(scene_.shapes[shape]));
    mesh.first_light_primitive = static_cast<gpu::uint>(out_.light_primitives.size());
    mesh.light_primitive_count = add_light_primitives(mesh.light.areas, mesh.primitives.data());
    return mesh;
  }

  static void shine_to_all_sides(LightLeaf& leaf) {
    leaf.normal = glm::dvec3(0.0);
    leaf.corner_normals.clear();
  }

  // The primitives that emit, in the order of the scene: light primitives of positive power.
  std::vector<LightLeaf> light_leaves() {
    std::vector<LightLeaf> leaves;
    for (std::size_t l = 0; l < out_.light_instances.size(); ++l) {
      const gpu::LightInstance& light = out_.light_instances[l];
      if ((light.instance & gpu::kLightLeafDelta) != 0) {
        const gpu::uint index = light.instance & ~gpu::kLightLeafDelta;
        leaves.push_back(delta_light_leaf(scene_, scene_.delta_lights[out_.delta_lights[index].number]));
        leaves.back().light_primitive = light.instance;
        if (!(leaves.back().power > 0.0)) leaves.pop_back();
        continue;
      }
      const Instance& instance = scene_.instances[light.instance];
      const EmitterRadiance radiance(texture_facts_, instance);
      if (sharing_.has_instance(light.instance)) {
        leaves.push_back(placed_light_leaf(*meshes_[instance.shape], instance));
        leaves.back().power *= luminance(radiance.mean_of_all());
        if (is_two_sided(light.instance)) shine_to_all_sides(leaves.back());
        leaves.back().light_primitive = gpu::kLightLeafShared | static_cast<gpu::uint>(l);
        if (!(leaves.back().power > 0.0)) leaves.pop_back();
        continue;
      }
      const Placed placed(scene_, instance);
      for (gpu::uint i = light.first_primitive; i < light.first_primitive + light.primitive_count; ++i) {
        const gpu::LightPrimitive& part = out_.light_primitives[i];
        LightLeaf leaf = light_leaf(placed, part.primitive.primitive);
        if (part.cells > 0)
          divide(leaf, placed, part, lamp_parts_.at(light.instance));
        else
          leaf.power *= luminance(radiance.mean(part.primitive.primitive));
        if (!(leaf.power > 0.0)) continue;
        leaf.light_primitive = i;
        if (is_two_sided(light.instance)) shine_to_all_sides(leaf);
        leaves.push_back(leaf);
      }
    }
    return leaves;
  }

  // Turns the leaf of a triangle into that of a part of it, of its own brightness.
  static void divide(LightLeaf& leaf, const Placed& placed, const gpu::LightPrimitive& part, const LampParts& parts) {
    const gpu::uint triangle = part.primitive.primitive, n = part.cells;
    const auto [p0, p1, p2] = placed.mesh->triangle(triangle);
    leaf.power *= parts.brightness[parts.first[triangle] + part.cell] / (n * n);
    leaf.area /= n * n;
    leaf.lower = glm::dvec3(std::numeric_limits<double>::infinity());
    leaf.upper = -leaf.lower;
    for (const gpu::uint i : {part.cell / n, part.cell / n + 1}) {
      for (const gpu::uint j : {part.cell % n, part.cell % n + 1}) {
        const double root = std::sqrt(static_cast<double>(i) / n), v = static_cast<double>(j) / n;
        const glm::dvec3 p = (1.0 - root) * p0 + root * v * p1 + root * (1.0 - v) * p2;
        leaf.lower = glm::min(leaf.lower, p);
        leaf.upper = glm::max(leaf.upper, p);
      }
    }
  }

  // Trails without turns: room for those of all instances that are lights, or only for lamps divided into parts.
  void make_trails(bool all) {
    std::vector<gpu::LightTrail>& trails = out_.light_trails;
    const gpu::LightTrail none{0, 1.0f, 0, 0};
    trails.resize(scene_.instances.size());
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
      const LampParts* const parts = parts_of(i);
      if (!scene_.instances[i].emitter || (!all && parts == nullptr)) continue;
      const auto first = static_cast<gpu::uint>(trails.size());
      trails[i].turns = first;
      // An instance of a shared mesh has one.
      const bool shared = sharing_.has_instance(i);
      trails.resize(first + (shared ? 1 : primitive_count(scene_.shape_of(scene_.instances[i]))), none);
      if (parts == nullptr) continue;
      for (std::size_t t = 0; t < parts->cells.size(); ++t) {
        const gpu::uint n = parts->cells[t];
        trails[first + t] = {0, 1.0f, n, static_cast<gpu::uint>(trails.size())};
        trails.resize(trails.size() + std::size_t{n} * n, none);
      }
    }
  }

  gpu::LightTrail& trail_of(const gpu::LightPrimitive& light) {
    std::vector<gpu::LightTrail>& trails = out_.light_trails;
    const gpu::uint own = trails[light.primitive.instance].turns + light.primitive.primitive;
    return light.cells > 0 ? trails[trails[own].first + light.cell] : trails[own];
  }

  // For the choice by power.
  void make_part_trails() {
    make_trails(false);
    for (const gpu::LightInstance& light : out_.light_instances) {
      if ((light.instance & gpu::kLightLeafDelta) != 0) continue;
      if (parts_of(light.instance) == nullptr) continue;
      const Placed placed(scene_, scene_.instances[light.instance]);
      for (gpu::uint i = light.first_primitive; i < light.first_primitive + light.primitive_count; ++i) {
        const gpu::LightPrimitive& part = out_.light_primitives[i];
        const double area = placed.area(part.primitive.primitive) / (part.cells * part.cells);
        const double scale = normalization_.scale;
        trail_of(part).area = static_cast<float>(area * scale * scale / static_cast<double>(part.prob));
      }
    }
  }

  void make_light_tree() {
    const std::vector<LightLeaf> leaves = light_leaves();
    if (leaves.size() < 2) return;  // nothing to choose: the choice by power is the same
    FlatLightTree tree = build_light_tree(leaves, normalization_);
    make_trails(true);
    std::vector<gpu::LightTrail>& trails = out_.light_trails;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if ((leaves[i].light_primitive & gpu::kLightLeafDelta) != 0) continue;  // no ray can hit it
      if ((leaves[i].light_primitive & gpu::kLightLeafShared) != 0) {
        const gpu::uint instance = out_.light_instances[leaves[i].light_primitive & ~gpu::kLightLeafShared].instance;
        trails[trails[instance].turns] = {tree.trails[i].turns, std::abs(out_.instances[instance].light_area), 0, 0};
        continue;
      }
      trail_of(out_.light_primitives[leaves[i].light_primitive]) = tree.trails[i];
    }
    out_.light_pairs = std::move(tree.pairs);
    out_.light_tree_depth = tree.depth;
  }

  const Scene& scene_;
  Sharing sharing_;
  Normalization normalization_;
  std::vector<bool> passing_;                        // by instance: whether rays may pass it
  bool passes_ = false;                              // whether any of them is true
  std::vector<std::unique_ptr<SharedMesh>> meshes_;  // by shape; null if not shared
  KnownTextureFacts texture_facts_;
  std::vector<bool> passable_shapes_;                    // by shape: whether rays may pass one of its instances
  const std::map<std::uint32_t, LampParts> lamp_parts_;  // by instance
  std::vector<gpu::Primitive> shared_records_;           // instances of these
  std::vector<Box> shared_boxes_;
  CompiledScene out_;
  std::vector<gpu::Primitive> flat_primitives_;  // instance by instance, before the tree reorders them
  std::vector<std::size_t> first_primitive_;     // of each instance, into flat_primitives_
  std::size_t order_ = 0;                        // of the next primitive in the scene
  double lights_power_ = 0.0;                    // Σ luminance · area
};

std::atomic<std::uint64_t> g_compilations{0};

}  // namespace

std::uint64_t scene_compilations() {
  return g_compilations;
}

CompiledMaterials compile_materials(std::span<const Material> materials, bool has_textures) {
  CompiledMaterials out;
  for (const Material& material : materials) out.materials.push_back(material_record(material, out.transmittances));
  if (out.materials.empty()) out.materials.push_back({});
  if (!has_textures) return out;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    out.material_textures.push_back(material_textures(materials[i], out.texture_uses));
    if (is_textured(materials[i])) out.materials[i].header |= gpu::kMaterialTextured;
    if (is_aligned(materials[i])) out.materials[i].header |= gpu::kMaterialAligned;
  }
  return out;
}

CompiledScene compile_scene(const Scene& scene) {
  ++g_compilations;
  require_invariants(scene);
  return Compiler(scene, find_normalization(scene)).compile();
}

CompiledLights compile_lights(const Scene& scene, const CompiledScene& base) {
  return Compiler(scene, base.normalization).compile_lights(base);
}

}  // namespace etendue
