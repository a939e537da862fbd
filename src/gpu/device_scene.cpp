#include "gpu/device_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include <fmt/core.h>

#include "compile/discrete.h"
#include "compile/node_layout.h"
#include "compile/query_scene.h"
#include "core/errors.h"
#include "scene/limits.h"
#include "scene/sharing.h"

namespace etendue {
// The tables of one buffer, one after the other.
struct TableGroup {
  struct Table {
    const char* what;
    std::uint32_t at;  // the constant for its start
    std::span<const std::byte> bytes;

    /// Bytes up to the next table: whole texels.
    std::uint64_t size() const {
      return (bytes.size() + sizeof(gpu::uvec4) - 1) / sizeof(gpu::uvec4) * sizeof(gpu::uvec4);
    }
  };
  std::uint32_t binding;
  const char* what;
  std::vector<Table> tables;

  std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const Table& table : tables) sum += table.size();
    return sum;
  }
};

namespace {

using Table = TableGroup::Table;

constexpr std::uint32_t kFirst = gpu::kNone;  // for a table at the beginning of its buffer

template <typename Entries>
Table table(const char* what, std::uint32_t at, const Entries& entries) {
  static_assert(sizeof(entries[0]) % sizeof(gpu::uvec4) == 0);
  return {what, at, std::as_bytes(std::span(entries))};
}

// Everything that shaders/scene.glsl reads. The materials and lights may differ from those of the scene. `records` are
// the tree, or what replaces it.
std::array<TableGroup, 3> table_groups(const CompiledScene& s, const CompiledMaterials& m, const CompiledLights& l,
                                       const PageVector<gpu::uvec4>& records) {
  const CompiledTextures& t = s.textures;
  std::array<TableGroup, 3> groups{
      {{gpu::kBindingRecords, "tree", {table("tree", kFirst, records)}},
       {gpu::kBindingGeometry,
        "geometry",
        {table("vertex normals", kFirst, s.vertex_normals),
         table("attributes", gpu::kConstantAttributesAt, t.attributes)}},
       {gpu::kBindingTables,
        "instances, materials, lights and environment",
        {table("instances", kFirst, l.instances), table("materials", gpu::kConstantMaterialsAt, m.materials),
         table("places of instances", gpu::kConstantPlacesAt, s.places),
         table("textures of materials", gpu::kConstantMaterialTexturesAt, m.material_textures),
         table("uses of textures", gpu::kConstantTextureUsesAt, m.texture_uses),
         table("emitters", gpu::kConstantLightInstancesAt, l.light_instances),
         table("lights without extent", gpu::kConstantDeltaLightsAt, l.delta_lights),
         table("emitting primitives", gpu::kConstantLightPrimitivesAt, l.light_primitives),
         table("transmittances", gpu::kConstantTransmittancesAt, m.transmittances),
         table("light tree", gpu::kConstantLightPairsAt, l.light_pairs),
         table("trails of the light tree", gpu::kConstantLightTrailsAt, l.light_trails),
         table("rows of the environment", gpu::kConstantEnvironmentRowsAt, l.environment.rows),
         table("picture of the environment", gpu::kConstantEnvironmentTexelsAt, l.environment.texels),
         table("search in the environment", gpu::kConstantEnvironmentSearchAt, l.environment.search),
         table("textures", gpu::kConstantTexturesAt, t.textures),
         table("attributes of instances", gpu::kConstantInstanceAttributesAt, t.instances)}}}};
  for (const auto& bitmap : t.bitmaps)
    groups[1].tables.push_back({"pictures", bitmap == t.bitmaps.front() ? gpu::kConstantTexelsAt : kFirst,
                                std::as_bytes(std::span(bitmap->texels))});
  return groups;
}
std::array<TableGroup, 3> table_groups(const CompiledScene& scene, const CompiledMaterials& materials,
                                       const CompiledLights& lights) {
  return table_groups(scene, materials, lights, scene.records);
}

std::array<TableGroup, 3> table_groups(const CompiledScene& scene) {
  return table_groups(scene, scene, scene);
}

std::vector<DeviceNeed> needs_of(std::span<const TableGroup> groups) {
  std::vector<DeviceNeed> needs;
  for (const TableGroup& group : groups) needs.push_back({group.what, group.bytes()});
  return needs;
}

VkBufferUsageFlags table_usage(TableLoads loads) {
  return loads == TableLoads::texel_buffer ? VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT
                                           : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
}

// The memory of the driver's structures, plus the most that building one takes in addition.
DeviceNeed structures_need(const vulkan::Context& context, const QueryScene& scene) {
  std::uint64_t kept = 0, building = 0;
  const auto add = [&](vulkan::StructureKind kind, std::size_t count, std::size_t bytes) {
    const vulkan::StructureSize size = vulkan::structure_size(context, kind, static_cast<std::uint32_t>(count));
    kept += size.kept;
    building = std::max<std::uint64_t>(building, size.scratch + count * bytes);
  };
  for (const QueryMesh& mesh : scene.meshes) add(vulkan::StructureKind::boxes, mesh.count, sizeof(VkAabbPositionsKHR));
  add(vulkan::StructureKind::instances, scene.instances.size(), sizeof(VkAccelerationStructureInstanceKHR));
  return {"acceleration structures", kept + building, DeviceNeed::Kind::memory};
}

void check_room(std::vector<DeviceNeed> needs, std::span<const DeviceNeed> planned, const vulkan::Context& context) {
  needs.insert(needs.end(), planned.begin(), planned.end());
  check_needs(needs, limits_of(context));
}

std::vector<vulkan::AccelerationStructure> build_structures(GpuDevice& device, const QueryScene& scene) {
  static_assert(sizeof(Box) == sizeof(VkAabbPositionsKHR));
  std::vector<vulkan::AccelerationStructure> structures;
  for (const QueryMesh& mesh : scene.meshes) {
    const std::vector<Box> boxes = query_boxes(scene, mesh);
    structures.emplace_back(*device.context, device.commands, vulkan::StructureKind::boxes,
                            std::as_bytes(std::span(boxes)), mesh.count);
  }
  std::vector<VkAccelerationStructureInstanceKHR> instances;
  for (const QueryInstance& i : scene.instances)
    instances.push_back(vulkan::structure_instance(structures[i.mesh], i.world_from_mesh, i.name));
  structures.emplace_back(*device.context, device.commands, vulkan::StructureKind::instances,
                          std::as_bytes(std::span(instances)), static_cast<std::uint32_t>(instances.size()));
  return structures;
}

// The properties of the materials on surfaces: kernels are specialised for exactly these.
struct MaterialsUsed {
  MaterialsUsed(std::span<const gpu::Instance> instances, const CompiledMaterials& materials)
      : depths(materials.materials.size(), kUnknown) {
    for (const gpu::Instance& instance : instances)
      adapter_depth = std::max(adapter_depth, look_at(materials, instance.material));
  }

  // Number of adapters between a surface with this material and the material that scatters. The candidates of an
  // adapter precede it in the table.
  std::uint32_t look_at(const CompiledMaterials& all, gpu::uint row) {
    if (depths[row] != kUnknown) return depths[row];
    const gpu::MaterialRecord& record = all.materials[row];
    const gpu::uint type = record.header & gpu::kMaterialTypeMask;
    if (type < gpu::kAdapterFirst) {
      types |= 1u << type;
      flags_some |= record.header & ~gpu::kMaterialTypeMask;
      flags_all &= record.header & ~gpu::kMaterialTypeMask;
      if (type == gpu::kBsdfNull) adapters |= gpu::kAdaptersPass;
      return depths[row] = 0;
    }
    adapters |= 1u << (type - gpu::kAdapterFirst) | (type == gpu::kAdapterMask ? gpu::kAdaptersPass : 0u);
    const bool map = type == gpu::kAdapterNormalMap || type == gpu::kAdapterBumpMap;
    if (map && (static_cast<gpu::uint>(record.params.y) & ~gpu::kMapVertexTangents) != 0)
      adapters |= gpu::kAdaptersLooseMaps;
    std::uint32_t depth = look_at(all, static_cast<gpu::uint>(record.params.x));
    if (type == gpu::kAdapterTwoSided || type == gpu::kAdapterBlend)
      depth = std::max(depth, look_at(all, static_cast<gpu::uint>(record.params.y)));
    return depths[row] = depth + 1;
  }

  static constexpr std::uint32_t kUnknown = ~0u;
  std::vector<std::uint32_t> depths;
  std::uint32_t adapters = 0, adapter_depth = 0;
  std::uint32_t types = 0;  // bit i for the type kBsdf… = i
  std::uint32_t flags_some = 0, flags_all = ~gpu::kMaterialTypeMask;
};

bool has_lights(const CompiledLights& lights, gpu::uint kind) {
  return std::any_of(
      lights.light_primitives.begin(), lights.light_primitives.end(),
      [kind](const gpu::LightPrimitive& light) { return (light.primitive.kind & gpu::kPrimitiveKindMask) == kind; });
}

bool has_light_normals(const CompiledLights& all) {
  return std::ranges::any_of(all.light_instances, [&](const gpu::LightInstance& light) {
    const bool delta = (light.instance & gpu::kLightLeafDelta) != 0;
    return !delta && all.instances[light.instance].first_triangle != gpu::kNone;
  });
}

// Of a material.
std::uint32_t most_texture_uses(const CompiledMaterials& materials) {
  std::uint32_t most = 0;
  for (const gpu::MaterialTextures& m : materials.material_textures) most = std::max(most, m.end - m.begin);
  return most;
}

std::uint32_t delta_light_kinds(const CompiledLights& lights) {
  std::uint32_t kinds = 0;
  for (const gpu::DeltaLight& light : lights.delta_lights) kinds |= light.header;
  return kinds;
}

}  // namespace

LoopRounds::LoopRounds(const CompiledScene& scene, const CompiledLights& lights) {
  std::uint32_t most = 1;
  for (const gpu::LightInstance& light : lights.light_instances) most = std::max(most, light.primitive_count);
  instances = static_cast<std::uint32_t>(std::bit_width(std::max<std::size_t>(lights.light_instances.size(), 1) - 1));
  primitives = static_cast<std::uint32_t>(std::bit_width(most - 1));
  distant = static_cast<std::uint32_t>(std::bit_width(lights.distant_lights));
  const std::uint32_t adapters = MaterialsUsed(lights.instances, scene).adapter_depth,
                      textures = most_texture_uses(scene);
  // Includes the adapters at hits of shadow rays, and those of the half that a blend has not chosen; each loop tests
  // its end once more.
  const std::uint32_t adapter_steps = adapters > 0 ? 3 * (adapters + 2) : 0;
  materials = adapter_steps + (textures > 0 ? textures + 1 : 0);
  // There is a loop in each look-up: by an adapter, for the parameters of two materials and the normals of their coats,
  // and for an emitter.
  if ((scene.textures.features & gpu::kTexturesNested) != 0)
    materials += (adapter_steps + 2 * (textures + 1) + 1) * (kMaxNestedTextures + 1);
  const EnvironmentFacts& sky = lights.environment.facts;
  if (sky.kind == gpu::kEnvironmentNone) return;
  environment_rows = SearchTree(sky.cell_rows).levels;
  environment_columns = SearchTree(sky.columns).levels;
}

namespace {

TableLoads choose_table_loads(const vulkan::Context& context, std::span<const TableGroup> groups,
                              std::optional<TableLoads> wanted) {
  const TableGroup& longest = *std::ranges::max_element(groups, {}, &TableGroup::bytes);
  const std::uint64_t texels = longest.bytes() / sizeof(gpu::uvec4);
  const std::string unbound = kernel_requirements(TableLoads::storage_buffer).missing(context.limits());
  const bool fits_texels = texels <= context.limits().maxTexelBufferElements;
  const bool fits_storage = longest.bytes() <= context.limits().maxStorageBufferRange && unbound.empty();
  if (fits_texels && wanted != TableLoads::storage_buffer) return TableLoads::texel_buffer;
  if (fits_storage && wanted != TableLoads::texel_buffer) return TableLoads::storage_buffer;
  if (fits_storage)
    throw Error(
        ErrorKind::lost,
        fmt::format("The table '{}' of the scene has {} bytes, but '{}' reads at most {} texels of 16 bytes "
                    "(maxTexelBufferElements), and kernels for ray queries read no other buffers; use "
                    "--traversal tree.",
                    longest.what, longest.bytes(), context.info().name, context.limits().maxTexelBufferElements));
  throw Error(
      ErrorKind::lost,
      fmt::format("The table '{}' of the scene has {} bytes, but '{}' reads at most {} texels of 16 bytes "
                  "(maxTexelBufferElements) or {} bytes (maxStorageBufferRange){}; use a smaller mesh or "
                  "another --device.",
                  longest.what, longest.bytes(), context.info().name, context.limits().maxTexelBufferElements,
                  context.limits().maxStorageBufferRange, unbound.empty() ? "" : ", and for the latter " + unbound));
}

}  // namespace

TableLoads choose_table_loads(const vulkan::Context& context, const CompiledScene& scene,
                              std::optional<TableLoads> wanted) {
  return choose_table_loads(context, table_groups(scene), wanted);
}

std::vector<DeviceNeed> scene_needs(const CompiledScene& scene) {
  return needs_of(table_groups(scene));
}

DeviceNeed least_scene_need(const Scene& scene) {
  std::uint64_t texels = 0;
  const Sharing sharing(scene);
  std::vector<bool> counted(scene.shapes.size(), false);  // shared meshes count once
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const auto* mesh = std::get_if<TriangleMesh>(&scene.shape_of(instance));
    if (sharing.has_instance(i)) {
      if (counted[instance.shape]) continue;
      counted[instance.shape] = true;
    }
    if (mesh != nullptr && !mesh->normals.empty()) texels += mesh->triangles.size();
  }
  return {"vertex normals", texels * sizeof(gpu::uvec4), DeviceNeed::Kind::memory};
}

std::vector<vulkan::Specialization> table_places(const CompiledScene& scene, const CompiledMaterials& materials,
                                                 const CompiledLights& lights) {
  std::vector<vulkan::Specialization> places;
  for (const TableGroup& group : table_groups(scene, materials, lights)) {
    std::size_t texels = 0;
    for (const Table& table : group.tables) {
      if (table.at != kFirst) places.push_back({table.at, static_cast<std::uint32_t>(texels)});
      texels += table.size() / sizeof(gpu::uvec4);
    }
  }
  return places;
}

std::vector<vulkan::Specialization> scene_constants(const CompiledScene& scene, const CompiledMaterials& materials,
                                                    const CompiledLights& lights) {
  const LoopRounds loop_rounds(scene, lights);
  const MaterialsUsed used(lights.instances, materials);
  std::vector<vulkan::Specialization> constants = table_places(scene, materials, lights);
  constants.insert(constants.end(), {{gpu::kConstantStackSize, std::max(1u, scene.tree_depth)},
                                     {gpu::kConstantHasSpheres, scene.has_spheres ? 1u : 0u},
                                     {gpu::kConstantInwardSpheres, scene.inward_spheres ? 1u : 0u},
                                     {gpu::kConstantFewCount, scene.few_count},
                                     {gpu::kConstantFewSpheres, scene.few_spheres},
                                     {gpu::kConstantLightInstanceRounds, loop_rounds.instances},
                                     {gpu::kConstantLightPrimitiveRounds, loop_rounds.primitives},
                                     {gpu::kConstantBsdfsUsed, used.types},
                                     {gpu::kConstantMaterialFlagsSome, used.flags_some},
                                     {gpu::kConstantMaterialFlagsAll, used.flags_all},
                                     {gpu::kConstantAdapters, used.adapters},
                                     {gpu::kConstantAdapterDepth, used.adapter_depth},
                                     {gpu::kConstantVertexNormals, scene.vertex_normals.empty() ? 0u : 1u},
                                     {gpu::kConstantSphereLights, has_lights(lights, gpu::kPrimitiveSphere) ? 1u : 0u},
                                     {gpu::kConstantLightNormals, has_light_normals(lights) ? 1u : 0u},
                                     {gpu::kConstantInstanced, scene.places.empty() ? 0u : 1u},
                                     {gpu::kConstantTextureFeatures, scene.textures.features},
                                     {gpu::kConstantTextureUses, most_texture_uses(materials)},
                                     {gpu::kConstantTreeRoot, scene.tree_root}});
  const EnvironmentFacts& sky = lights.environment.facts;
  constants.insert(constants.end(), {{gpu::kConstantEnvironment, sky.kind},
                                     {gpu::kConstantEnvironmentAlone, sky.alone ? 1u : 0u},
                                     {gpu::kConstantEnvironmentColumns, sky.columns},
                                     {gpu::kConstantEnvironmentTexelRows, sky.texel_rows},
                                     {gpu::kConstantEnvironmentCellRows, sky.cell_rows},
                                     {gpu::kConstantEnvironmentRowLevels, loop_rounds.environment_rows},
                                     {gpu::kConstantEnvironmentColumnLevels, loop_rounds.environment_columns}});
  constants.insert(constants.end(),
                   {{gpu::kConstantHasDisks, scene.has_disks ? 1u : 0u},
                    {gpu::kConstantHasCylinders, scene.has_cylinders ? 1u : 0u},
                    {gpu::kConstantFewDisks, scene.few_disks},
                    {gpu::kConstantFewCylinders, scene.few_cylinders},
                    {gpu::kConstantCylinderLights, has_lights(lights, gpu::kPrimitiveCylinder) ? 1u : 0u},
                    {gpu::kConstantTwoSidedLights, lights.two_sided_lights ? 1u : 0u},
                    {gpu::kConstantLampParts, lights.lamp_parts ? 1u : 0u},
                    {gpu::kConstantDeltaLights, delta_light_kinds(lights)},
                    {gpu::kConstantDistantLights, lights.distant_lights}});
  for (std::uint32_t i = 0; i < scene.few_count; ++i) {
    const std::uint32_t first = gpu::kConstantFew + gpu::kFewWords * i;
    const gpu::uvec4* texels = &scene.records[gpu::kRecordTexels * i];
    for (std::uint32_t k = 0; k < gpu::kFewFloats; ++k)
      constants.push_back({first + k, texels[k / 3][static_cast<int>(k % 3)]});
    if ((used.adapters & gpu::kAdaptersPass) != 0) constants.push_back({first + gpu::kFewFloats, texels[0].w});
  }
  return constants;
}

DeviceScene::DeviceScene(std::shared_ptr<GpuDevice> device, const std::shared_ptr<const CompiledScene>& compiled,
                         std::optional<TableLoads> wanted, std::span<const DeviceNeed> planned, const Layouts& like,
                         bool queries)
    : device_(std::move(device)),
      loads_(choose_table_loads(*device_->context, *compiled, wanted)),
      queries_(queries),
      facts_(*compiled),
      loop_rounds_(*compiled, *compiled),
      has_tree_(compiled->tree_root != gpu::kNone),
      light_tree_depth_(compiled->light_tree_depth),
      constants_(scene_constants(*compiled, *compiled, *compiled)),
      layouts_(like && like->loads == loads_ && like->queries == queries
                   ? like
                   : std::make_shared<const SceneLayouts>(*device_->context, loads_, queries)),
      set_(*device_->context, layouts_->set) {
  const CompiledScene& scene = *compiled;
  if (!queries) {
    check_room(scene_needs(scene), planned, *device_->context);
    for (const TableGroup& group : table_groups(scene))
      bind(group.binding, group.binding == gpu::kBindingRecords ? use_in_place(group, compiled) : upload(group));
    return;
  }
  const QueryScene query = query_scene(scene);
  const std::array<TableGroup, 3> groups = table_groups(scene, scene, scene, query.records);
  std::vector<DeviceNeed> needs = needs_of(groups);
  needs.push_back(structures_need(*device_->context, query));
  check_room(std::move(needs), planned, *device_->context);
  for (const TableGroup& group : groups) bind(group.binding, upload(group));
  structures_ = std::make_shared<const std::vector<vulkan::AccelerationStructure>>(build_structures(*device_, query));
  use_structures(query.instances_at);
}

DeviceScene::DeviceScene(const DeviceScene& base, const CompiledScene& scene, const CompiledMaterials& materials,
                         const CompiledLights& lights)
    : device_(base.device_),
      loads_(base.loads_),
      queries_(base.queries_),
      facts_(scene, lights),
      loop_rounds_(scene, lights),
      has_tree_(base.has_tree_),
      light_tree_depth_(lights.light_tree_depth),
      constants_(scene_constants(scene, materials, lights)),
      layouts_(base.layouts_),
      structures_(base.structures_),
      set_(*device_->context, layouts_->set) {
  const auto groups = table_groups(scene, materials, lights);
  choose_table_loads(*device_->context, groups, loads_);  // may throw: a sky that was dark takes room, too
  for (const TableGroup& group : groups) {
    const bool others = group.binding == gpu::kBindingTables;
    bind(group.binding, others ? upload(group) : base.entries_.at(group.binding));
  }
  if (queries_) use_structures(base.instances_at_);
}

// Binds them, and passes the position of the records of instances to the kernels.
void DeviceScene::use_structures(std::uint32_t instances_at) {
  instances_at_ = instances_at;
  if (has_tree_)
    std::ranges::find(constants_, gpu::kConstantTreeRoot, &vulkan::Specialization::id)->value = instances_at;
  set_.bind(gpu::kBindingStructure, structures_->back());
}

std::shared_ptr<const DeviceScene::Entry> DeviceScene::finish(Entry entry) {
  if (loads_ == TableLoads::texel_buffer)
    entry.view = vulkan::make_texel_view(*device_->context, entry.buffer, VK_FORMAT_R32G32B32A32_UINT);
  return std::make_shared<const Entry>(std::move(entry));
}

std::shared_ptr<const DeviceScene::Entry> DeviceScene::upload(const TableGroup& group) {
  Entry entry;
  entry.buffer = {*device_->context, group.bytes(), table_usage(loads_), vulkan::Buffer::Memory::device, group.what};
  std::uint64_t at = 0;
  for (const Table& table : group.tables) {
    device_->commands.upload(entry.buffer, at, table.bytes);
    at += table.size();
  }
  return finish(std::move(entry));
}

std::shared_ptr<const DeviceScene::Entry> DeviceScene::use_in_place(const TableGroup& group,
                                                                    const std::shared_ptr<const CompiledScene>& owner) {
  std::optional<vulkan::Buffer> buffer =
      vulkan::Buffer::in_place(*device_->context, owner, group.tables.front().bytes, table_usage(loads_), group.what);
  return buffer ? finish({std::move(*buffer), {}}) : upload(group);
}

void DeviceScene::bind(std::uint32_t binding, std::shared_ptr<const Entry> entry) {
  if (loads_ == TableLoads::texel_buffer) {
    set_.bind(binding, entry->view);
  } else {
    set_.bind(binding, entry->buffer);
  }
  entries_[binding] = std::move(entry);
}

}  // namespace etendue
