#include "compile/query_scene.h"

#include <algorithm>
#include <cstring>
#include <map>

#include <fmt/core.h>

#include "compile/node_layout.h"
#include "compile/primitive_box.h"
#include "core/errors.h"

namespace etendue {
namespace {

// The margin of boxes in the world, in normalised units. A ray that the kernels pass to the driver begins within
// kNearOrigin = 8 of the centre and is at most 10 long; 128 units in the last place of 1 are 16 roundings of numbers
// below 8. Testing a box takes about six roundings, and testing the primitive in it as many.
constexpr double kWorldSlack = 0x1p-17;

// The slots of the primitives below a node, depth first.
std::vector<std::uint32_t> leaves_below(const TreeReader<gpu::kBvhWidth>& tree, std::uint32_t root) {
  std::vector<std::uint32_t> leaves, pending;
  if (root != gpu::kNone) pending.push_back(root);
  while (!pending.empty()) {
    const std::uint32_t slot = pending.back();
    pending.pop_back();
    if (!tree.is_node(slot)) {
      leaves.push_back(slot);
      continue;
    }
    for (std::uint32_t i = tree.child_count(slot); i-- > 0;) pending.push_back(tree.child_slot(slot, i));
  }
  return leaves;
}

gpu::Record record_at(const TexelVector& texels, std::size_t slot) {
  gpu::Record record;
  std::memcpy(static_cast<void*>(&record), &texels[slot * gpu::kSlotTexels], sizeof record);
  return record;
}

void append(TexelVector& texels, const gpu::Record& record) {
  texels.insert(texels.end(), {record.a, record.b, record.c});
}

// The driver computes its own inverse W of the instance's matrix M to transform the ray into the mesh's space. A ray's
// origin o becomes W (o − origin) with errors of the order of |W| |o| units, and those of the inverse itself are of the
// order of |W| |M| |W| units.
double slack_of(const gpu::Place& place) {
  const glm::dmat3 m(glm::dvec3(place.x), glm::dvec3(place.y), glm::dvec3(place.z));
  const glm::dmat3 w =
      glm::transpose(glm::dmat3(glm::dvec3(place.object_x), glm::dvec3(place.object_y), glm::dvec3(place.object_z)));
  const auto magnitudes = [](const glm::dmat3& a) {
    return glm::dmat3(glm::abs(a[0]), glm::abs(a[1]), glm::abs(a[2]));
  };
  const glm::dvec3 sums = magnitudes(w) * (magnitudes(m) * (magnitudes(w) * glm::dvec3(1.0)));
  return kWorldSlack * std::max({sums.x, sums.y, sums.z, 1.0});
}

QueryInstance placed(std::uint32_t mesh, std::uint32_t name, const gpu::Place& place) {
  QueryInstance instance{.mesh = mesh, .name = name};
  for (int k = 0; k < 3; ++k) {
    float* row = instance.world_from_mesh[k];
    row[0] = place.x[k];
    row[1] = place.y[k];
    row[2] = place.z[k];
    row[3] = place.origin[k];
  }
  return instance;
}

constexpr gpu::Place kWhereItIs{.x = {1, 0, 0}, .y = {0, 1, 0}, .z = {0, 0, 1}};

}  // namespace

QueryScene query_scene(const CompiledScene& scene) {
  const TreeReader<gpu::kBvhWidth> tree(scene.records);
  QueryScene out;
  out.records.assign(scene.records.begin(),
                     scene.records.begin() + std::ptrdiff_t{scene.few_count} * gpu::kRecordTexels);
  std::vector<gpu::Record> instances;
  for (const std::uint32_t slot : leaves_below(tree, scene.tree_root)) {
    const gpu::Record record = record_at(scene.records, slot);
    if ((record.a.w & gpu::kRecordInstance) != 0)
      instances.push_back(record);
    else
      append(out.records, record);
  }
  const auto count = [&] { return static_cast<std::uint32_t>(out.records.size() / gpu::kRecordTexels); };
  if (count() > scene.few_count) {
    out.meshes.push_back({scene.few_count, count() - scene.few_count, static_cast<float>(kWorldSlack)});
    out.instances.push_back(placed(0, gpu::kQueryWorld, kWhereItIs));
  }
  if (instances.size() >= gpu::kQueryWorld)
    throw Error(ErrorKind::lost,
                fmt::format("{} instances are more than the {} that ray queries tell apart; use --traversal tree.",
                            instances.size(), gpu::kQueryWorld - 1));
  out.instances_at = count() * gpu::kPrimitiveSlots;
  const std::uint32_t first_instance = count();
  out.records.resize(out.records.size() + instances.size() * gpu::kRecordTexels);
  std::map<std::uint32_t, std::uint32_t> mesh_of;  // key: the slot of the root of its tree
  for (std::uint32_t i = 0; i < instances.size(); ++i) {
    gpu::Record record = instances[i];
    const gpu::Place& place = scene.places[record.c.w];
    const auto [found, is_new] = mesh_of.try_emplace(record.b.w, static_cast<std::uint32_t>(out.meshes.size()));
    if (is_new) {
      const std::uint32_t first = count();
      for (const std::uint32_t slot : leaves_below(tree, record.b.w))
        append(out.records, record_at(scene.records, slot));
      out.meshes.push_back({first, count() - first});
    }
    QueryMesh& mesh = out.meshes[found->second];
    mesh.slack = std::max(mesh.slack, static_cast<float>(slack_of(place)));
    record.b.w = mesh.first * gpu::kPrimitiveSlots;
    std::memcpy(static_cast<void*>(&out.records[std::size_t{first_instance + i} * gpu::kRecordTexels]), &record,
                sizeof record);
    out.instances.push_back(placed(found->second, i, place));
  }
  return out;
}

std::vector<Box> query_boxes(const QueryScene& scene, const QueryMesh& mesh) {
  std::vector<Box> boxes;
  boxes.reserve(mesh.count);
  for (std::uint32_t i = mesh.first; i < mesh.first + mesh.count; ++i) {
    gpu::Primitive primitive;
    std::memcpy(static_cast<void*>(&primitive), &scene.records[std::size_t{i} * gpu::kRecordTexels], sizeof primitive);
    Box box = primitive_box(primitive);
    box.lower -= mesh.slack;
    box.upper += mesh.slack;
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace etendue
