/// Lights compiled alone are those of the scene as a whole.

#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "compile/compiled_scene.h"

namespace etendue {
namespace {

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same(const CompiledLights& a, const CompiledLights& b) {
  EXPECT_TRUE(same_bytes(a.instances, b.instances));
  EXPECT_TRUE(same_bytes(a.light_instances, b.light_instances));
  EXPECT_TRUE(same_bytes(a.light_primitives, b.light_primitives));
  EXPECT_TRUE(same_bytes(a.delta_lights, b.delta_lights));
  EXPECT_EQ(a.distant_lights, b.distant_lights);
  EXPECT_TRUE(same_bytes(a.light_pairs, b.light_pairs));
  EXPECT_TRUE(same_bytes(a.light_trails, b.light_trails));
  EXPECT_EQ(a.light_tree_depth, b.light_tree_depth);
  EXPECT_EQ(a.two_sided_lights, b.two_sided_lights);
  EXPECT_EQ(a.lamp_parts, b.lamp_parts);
  EXPECT_EQ(a.radiance_exponent, b.radiance_exponent);
  EXPECT_EQ(a.environment.facts.kind, b.environment.facts.kind);
  EXPECT_EQ(a.environment.facts.threshold, b.environment.facts.threshold);
  EXPECT_EQ(a.environment.facts.lights_prob, b.environment.facts.lights_prob);
  EXPECT_EQ(a.environment.facts.top, b.environment.facts.top);
  EXPECT_TRUE(same_bytes(a.environment.rows, b.environment.rows));
  EXPECT_TRUE(same_bytes(a.environment.search, b.environment.search));
}

TriangleMesh fan(const glm::dvec3& at, bool normals) {
  TriangleMesh mesh{.positions = {at, at + glm::dvec3(1, 0, 0), at + glm::dvec3(1, 1, 0.1), at + glm::dvec3(0, 1, 0)},
                    .normals = {},
                    .triangles = {{0, 1, 2}, {0, 2, 3}}};
  if (normals) mesh.normals = std::vector<glm::dvec3>(4, {0, 0, 1});
  mesh.uv_sets.push_back({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  return mesh;
}

/// A picture that is bright in one corner, for a lamp to be divided.
void add_picture(Scene& scene) {
  auto bitmap = std::make_shared<Bitmap>();
  bitmap->width = bitmap->height = 16;
  bitmap->channels = 1;
  bitmap->format = BitmapFormat::u8;
  bitmap->color_space = ColorSpace::linear;
  for (int i = 0; i < 256; ++i) bitmap->texels.push_back(static_cast<std::byte>(i % 16 < 4 && i < 64 ? 250 : 3));
  scene.bitmaps.push_back(bitmap);
  scene.textures.push_back({.source = BitmapTexture{.bitmap = 0, .filter = TextureFilter::nearest}});
}

/// Lamps of every kind among shapes that do not emit; all lights of one brightness, or of their own.
Scene many_lights(double level, double others, bool shared) {
  Scene scene;
  scene.instancing = shared ? Instancing::always : Instancing::never;
  add_picture(scene);
  const auto lamp = [](double value) { return AreaEmitter{ColorParameter(glm::dvec3(value))}; };
  scene.add(fan({0, 0, 0}, true));
  scene.add(Sphere{{5, 0, 0}, 0.5}, DiffuseBsdf{}, lamp(level));
  scene.add(fan({2, 0, 0}, true), DiffuseBsdf{}, lamp(others));
  scene.add(Sphere{{-5, 0, 0}, 0.7});
  scene.add(Disk{}, DiffuseBsdf{}, lamp(level)).world_from_object[3] = {0, 4, 0, 1};
  scene.add(Cylinder{{0, -4, 0}, {0, -4, 1}, 0.3}, DiffuseBsdf{}, lamp(others));
  scene.add(fan({4, 4, 0}, false), DiffuseBsdf{}, lamp(level));
  scene.emitters.back().two_sided = true;
  scene.add(fan({-4, 4, 0}, false), DiffuseBsdf{}, AreaEmitter{ColorParameter(glm::dvec3(level), 0)});
  Instance copy = scene.add(fan({0, 0, 6}, true), DiffuseBsdf{}, lamp(others));  // a shared mesh, once dark
  copy.world_from_object[3].x = 3.0;
  scene.instances.push_back(copy);
  copy.emitter.reset();
  copy.world_from_object[3].x = 6.0;
  scene.instances.push_back(copy);
  for (const DeltaLight::Type type : {DeltaLight::Type::point, DeltaLight::Type::directional, DeltaLight::Type::spot}) {
    DeltaLight light{.type = type, .intensity = ColorParameter(glm::dvec3(level))};
    light.world_from_light[3] = {1, 2, 9, 1};
    scene.delta_lights.push_back(light);
  }
  scene.sky.top = glm::dvec3(level);
  scene.sky.horizon = glm::dvec3(0.1 * level);
  return scene;
}

void expect_alone_as_with_the_scene(const Scene& before, const Scene& after) {
  const CompiledScene base = compile_scene(before), whole = compile_scene(after);
  const std::uint64_t compilations = scene_compilations();
  expect_same(compile_lights(after, base), whole);
  EXPECT_EQ(scene_compilations(), compilations);
  EXPECT_EQ(base.records, whole.records) << "the tree of the shapes does not depend on the lights";
}

TEST(CompileLights, AloneOrWithTheSceneAreTheSame) {
  using enum Integrator::LightSampler;
  for (const auto sampler : {power, tree}) {
    for (const auto& [from, to] : {std::pair(1.0, 3.0), std::pair(0.0, 2.0), std::pair(2.0, 0.0)}) {
      for (const double others : {0.0, 0.7}) {
        for (const bool shared : {false, true}) {
          SCOPED_TRACE(testing::Message()
                       << from << " to " << to << " beside " << others << (shared ? ", shared" : ""));
          Scene before = many_lights(from, 0.3, shared), after = many_lights(to, others, shared);
          before.integrator.light_sampler = after.integrator.light_sampler = sampler;
          expect_alone_as_with_the_scene(before, after);
        }
      }
    }
  }
  Scene scene = many_lights(1.0, 1.0, false);
  scene.integrator.light_sampler = tree;
  const CompiledScene compiled = compile_scene(scene);
  EXPECT_TRUE(compiled.lamp_parts && compiled.two_sided_lights && compiled.light_tree_depth > 0 &&
              compiled.distant_lights == 1);
  scene.instancing = Instancing::always;
  EXPECT_FALSE(compile_scene(scene).places.empty());
}

}  // namespace
}  // namespace etendue
