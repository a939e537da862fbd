#pragma once
/// Scene → vectors of GPU-ready structs.

#include <cstdint>
#include <span>
#include <vector>

#include "compile/environment.h"
#include "compile/normalization.h"
#include "compile/textures.h"
#include "core/page_memory.h"
#include "gpu_types.h"
#include "scene/bounds.h"
#include "scene/scene.h"

namespace etendue {

/// The tables that follow from the materials and the kinds of their textures.
struct CompiledMaterials {
  std::vector<gpu::MaterialRecord> materials;
  std::vector<gpu::MaterialTextures> material_textures;  ///< one for each material, or empty if none has a texture
  std::vector<gpu::TextureUse> texture_uses;
  std::vector<gpu::vec4> transmittances;  ///< tables of rough coats, kTransmittanceNodes floats each
};

/// The tables that follow from what emits.
struct CompiledLights {
  EnvironmentTables environment;
  int radiance_exponent = 0;             ///< see scene/film_unit.h
  std::vector<gpu::Instance> instances;  ///< all of them, with the radiance of each
  std::vector<gpu::LightInstance> light_instances;
  std::vector<gpu::LightPrimitive> light_primitives;
  std::vector<gpu::DeltaLight> delta_lights;  ///< those infinitely far away first
  std::uint32_t distant_lights = 0;           ///< how many these are
  std::vector<gpu::LightPair> light_pairs;    ///< of the light tree; empty if lights are chosen by power
  /// For each instance an entry whose `turns` is the index, in this table, of its first primitive's trail, or 0; then
  /// the trails. Empty if there is neither a light tree nor a lamp divided into parts.
  std::vector<gpu::LightTrail> light_trails;
  std::uint32_t light_tree_depth = 0;  ///< levels below the root; 0 if there is no tree
  bool two_sided_lights = false;       ///< some light emits on both sides
  bool lamp_parts = false;             ///< some lamp is divided into parts
};

/// Everything a device needs to render a scene, in the layouts of shaders/gpu_types.h. Positions are normalised:
/// translated and scaled by a power of two, so that single precision suffices for scenes of any size and position.
struct CompiledScene : CompiledMaterials, CompiledLights {
  Normalization normalization;
  Bounds bounds;                   ///< of all instances, world space
  PageVector<gpu::uvec4> records;  ///< the few primitives outside the tree, then the tree: nodes and primitives
  std::vector<gpu::Place> places;  ///< of the instances of shared meshes; empty in flattened scenes
  CompiledTextures textures;
  std::vector<gpu::uvec4> vertex_normals;  ///< of the triangles of meshes that have them, see kOctahedron
  std::uint32_t tree_root = gpu::kNone;    ///< slot of the root; kNone if all primitives are outside the tree
  std::uint32_t tree_depth = 0;            ///< levels of nodes, including those of the deepest shared mesh
  bool has_spheres = false, inward_spheres = false, has_disks = false, has_cylinders = false;
  std::uint32_t few_count = 0;                     ///< number of primitives outside the tree, see kFewPrimitives
  std::uint32_t few_spheres = 0;                   ///< bit i: the i-th of them is a sphere
  std::uint32_t few_disks = 0, few_cylinders = 0;  ///< the same
};

/// Compiles shapes, materials and lights; compile_view compiles cameras, samplers and integrators. Lights get a tree if
/// the scene's light sampler asks for one, whether or not the scene's integrator uses it.
CompiledScene compile_scene(const Scene& scene);

/// Compiles the materials alone, for a scene with or without textures, whose other tables are kept.
CompiledMaterials compile_materials(std::span<const Material> materials, bool has_textures);

/// Compiles the lights alone: `scene` is the one that `base` was compiled from, but for the radiance and intensity of
/// its lights and its sky.
CompiledLights compile_lights(const Scene& scene, const CompiledScene& base);

/// How often this process has called compile_scene; tests use it to check what is not recompiled.
std::uint64_t scene_compilations();

}  // namespace etendue
