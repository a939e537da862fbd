/// What a driver's acceleration structures are built of: every primitive of the tree once, in boxes with room for
/// rounding; instances that name their records.

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "compile/node_layout.h"
#include "compile/primitive_box.h"
#include "compile/query_scene.h"
#include "instanced_scenes.h"

namespace etendue {
namespace {

using reference::test::add;
using reference::test::diffuse;

gpu::Primitive primitive_at(const QueryScene& scene, std::size_t record) {
  gpu::Primitive p;
  std::memcpy(static_cast<void*>(&p), &scene.records[record * gpu::kRecordTexels], sizeof p);
  return p;
}

// The records of primitives below a slot of the tree, by their bytes.
std::multiset<std::vector<std::uint32_t>> below(const CompiledScene& scene, std::uint32_t root) {
  const TreeReader<gpu::kBvhWidth> tree(scene.records);
  std::multiset<std::vector<std::uint32_t>> out;
  std::vector<std::uint32_t> pending{root};
  while (!pending.empty()) {
    const std::uint32_t slot = pending.back();
    pending.pop_back();
    if (tree.is_node(slot)) {
      for (std::uint32_t i = 0; i < tree.child_count(slot); ++i) pending.push_back(tree.child_slot(slot, i));
      continue;
    }
    std::vector<std::uint32_t> words(12);
    std::memcpy(words.data(), &scene.records[std::size_t{slot} * gpu::kSlotTexels], 48);
    if ((words[3] & gpu::kRecordInstance) == 0) out.insert(std::move(words));
  }
  return out;
}

std::multiset<std::vector<std::uint32_t>> of_mesh(const QueryScene& scene, const QueryMesh& mesh) {
  std::multiset<std::vector<std::uint32_t>> out;
  for (std::uint32_t i = mesh.first; i < mesh.first + mesh.count; ++i) {
    std::vector<std::uint32_t> words(12);
    std::memcpy(words.data(), &scene.records[std::size_t{i} * gpu::kRecordTexels], 48);
    out.insert(std::move(words));
  }
  return out;
}

Scene round_shapes() {
  Scene scene;
  add(scene, test::bumpy_ball(8), diffuse(0.5));
  add(scene, Sphere{glm::dvec3(2, 0, 0), 0.7}, diffuse(0.5));
  add(scene, Cylinder{glm::dvec3(-2, 0, 0), glm::dvec3(-1, 2, 1), 0.2}, diffuse(0.5));
  add(scene, Disk{}, diffuse(0.5)).world_from_object[3] = glm::dvec4(0, 3, 1, 1);
  return scene;
}

TEST(CompileQuery, EveryPrimitiveOfTheTreeOnce) {
  const CompiledScene scene = compile_scene(round_shapes());
  const QueryScene query = query_scene(scene);
  ASSERT_EQ(query.meshes.size(), 1u);
  ASSERT_EQ(query.instances.size(), 1u);
  EXPECT_EQ(query.instances[0].name, gpu::kQueryWorld);
  EXPECT_EQ(query.meshes[0].first, scene.few_count);
  EXPECT_EQ(of_mesh(query, query.meshes[0]), below(scene, scene.tree_root));
  EXPECT_TRUE(std::equal(query.records.begin(), query.records.begin() + scene.few_count * gpu::kRecordTexels,
                         scene.records.begin()))
      << "the few primitives stay where they are";
}

TEST(CompileQuery, BoxesHoldTheirPrimitivesAndSomeRoom) {
  const QueryScene query = query_scene(compile_scene(round_shapes()));
  const std::vector<Box> boxes = query_boxes(query, query.meshes[0]);
  ASSERT_EQ(boxes.size(), query.meshes[0].count);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box exact = primitive_box(primitive_at(query, query.meshes[0].first + i));
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT(boxes[i].lower[k], exact.lower[k] - 0x1p-18f);
      EXPECT_GT(boxes[i].upper[k], exact.upper[k] + 0x1p-18f);
      EXPECT_GT(boxes[i].lower[k], exact.lower[k] - 0x1p-16f) << "room costs";
    }
  }
}

TEST(CompileQuery, InstancesNameTheirRecordsAndMeshes) {
  const CompiledScene scene = compile_scene(test::instanced_room(1, Instancing::always));
  const QueryScene query = query_scene(scene);
  std::size_t placed = 0;
  for (const QueryInstance& instance : query.instances) {
    if (instance.name == gpu::kQueryWorld) continue;
    ++placed;
    const gpu::Primitive record = primitive_at(query, query.instances_at / gpu::kPrimitiveSlots + instance.name);
    EXPECT_NE(record.instance & gpu::kRecordInstance, 0u);
    EXPECT_EQ(record.primitive, query.meshes[instance.mesh].first * gpu::kPrimitiveSlots);
    const gpu::Place& place = scene.places[record.kind];
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(instance.world_from_mesh[k][1], place.y[k]);
      EXPECT_EQ(instance.world_from_mesh[k][3], place.origin[k]);
    }
    EXPECT_GT(query.meshes[instance.mesh].count, 0u);
  }
  EXPECT_EQ(placed, scene.places.size());
  EXPECT_LT(query.meshes.size(), query.instances.size()) << "meshes are shared";
}

// What a driver loses in the space of a mesh grows as the mesh shrinks in the world.
TEST(CompileQuery, SmallInstancesWidenTheBoxesOfTheirMesh) {
  const auto slack_at = [](double size) {
    Scene scene;
    scene.instancing = Instancing::always;
    add(scene, test::bumpy_ball(8), diffuse(0.5));
    Instance small = scene.instances.front();
    small.world_from_object = glm::scale(glm::dmat4(1.0), glm::dvec3(size));
    small.world_from_object[3] = glm::dvec4(3, 0, 0, 1);
    scene.instances.push_back(small);
    return query_scene(compile_scene(scene)).meshes.back().slack;
  };
  EXPECT_GE(slack_at(1.0), 0x1p-17f);
  EXPECT_GT(slack_at(0.01), 50.0f * slack_at(1.0));
}

TEST(CompileQuery, ASceneWithoutATreeHasNothingToAsk) {
  Scene scene;
  add(scene, Sphere{glm::dvec3(0.0), 1.0}, diffuse(0.5));
  const CompiledScene compiled = compile_scene(scene);
  ASSERT_EQ(compiled.tree_root, gpu::kNone);
  const QueryScene query = query_scene(compiled);
  EXPECT_TRUE(query.meshes.empty());
  EXPECT_TRUE(query.instances.empty());
}

}  // namespace
}  // namespace etendue
