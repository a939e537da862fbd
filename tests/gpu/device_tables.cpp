/// Every field of every table of the scene arrives in the kernels as the host wrote it, through texel buffers and
/// through storage buffers.

#include <array>
#include <bit>
#include <fstream>
#include <regex>
#include <sstream>

#include "device_test.h"
#include "kernels_storage.h"

namespace etendue::test {
namespace {

class DeviceTables : public DeviceTest {};

constexpr std::uint32_t kEntries = 37;
constexpr std::uint32_t kTrails = 3;  // of each instance

// A table whose words all differ, from each other and from those of other tables, and are normal floats: no field can
// be taken for another, and a device keeps their bits.
template <typename T>
std::vector<T> numbered(std::uint32_t table, std::size_t count = kEntries) {
  std::vector<T> entries(count);
  std::vector<std::uint32_t> words(count * sizeof(T) / sizeof(std::uint32_t));
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = 0x3f800000u + (table << 16) + static_cast<std::uint32_t>(i);
  std::memcpy(static_cast<void*>(entries.data()), words.data(), words.size() * sizeof words[0]);
  return entries;
}

CompiledScene numbered_scene() {
  CompiledScene scene = compile_scene(Scene{});
  const auto primitives = numbered<gpu::Primitive>(1);
  scene.records.resize(primitives.size() * gpu::kRecordTexels);
  std::memcpy(static_cast<void*>(scene.records.data()), primitives.data(), primitives.size() * sizeof primitives[0]);
  scene.instances = numbered<gpu::Instance>(2);
  scene.light_instances = numbered<gpu::LightInstance>(3);
  scene.light_primitives = numbered<gpu::LightPrimitive>(4);
  scene.light_pairs = numbered<gpu::LightPair>(5);
  scene.light_trails = numbered<gpu::LightTrail>(6, kEntries * (1 + kTrails));
  for (std::uint32_t i = 0; i < kEntries; ++i) scene.light_trails[i].turns = kEntries + kTrails * i;
  scene.materials = numbered<gpu::MaterialRecord>(9);
  // The host follows these: they must name a material that is there, and its type.
  for (std::uint32_t i = 0; i < kEntries; ++i) {
    scene.instances[i].material = i;
    scene.light_instances[i].instance = i;
    scene.materials[i].header = 3 * i << 8 | i % 3;
  }
  scene.material_textures = numbered<gpu::MaterialTextures>(10);
  scene.texture_uses = numbered<gpu::TextureUse>(20);
  scene.textures.textures = numbered<gpu::TextureRecord>(11);
  scene.textures.instances = numbered<gpu::InstanceAttributes>(12);
  scene.textures.attributes = numbered<gpu::vec4>(14);
  auto picture = std::make_shared<Bitmap>();
  const auto texels = numbered<gpu::uvec4>(15);
  picture->texels.assign(std::as_bytes(std::span(texels)).begin(), std::as_bytes(std::span(texels)).end());
  scene.textures.bitmaps = {picture};
  scene.transmittances = numbered<gpu::vec4>(16);
  scene.environment.rows = numbered<gpu::EnvironmentRow>(17);
  scene.environment.texels = numbered<gpu::EnvironmentTexel>(18);
  scene.environment.search = numbered<gpu::uvec4>(13);
  scene.delta_lights = numbered<gpu::DeltaLight>(19);
  scene.vertex_normals = numbered<gpu::uvec4>(7);
  scene.places = numbered<gpu::Place>(10);
  return scene;
}

gpu::TablesAnswer expected(const CompiledScene& scene, std::uint32_t i, std::uint32_t trail,
                           const std::vector<float>& knots) {
  gpu::TablesAnswer a{};
  std::memcpy(static_cast<void*>(&a.record), &scene.records[std::size_t{i} * gpu::kRecordTexels], sizeof a.record);
  a.instance = scene.instances[i];
  a.material = scene.materials[i];
  a.material_textures = scene.material_textures[i];
  a.texture_use = scene.texture_uses[i];
  a.light_instance = scene.light_instances[i];
  a.light_primitive = scene.light_primitives[i];
  a.light_threshold.x = scene.light_primitives[i].threshold;
  a.left_bounds = scene.light_pairs[i].left_bounds;
  a.light_pair = scene.light_pairs[i];
  a.light_trail = scene.light_trails[scene.light_trails[i].turns + trail];
  a.vertex_normals = scene.vertex_normals[i];
  a.filter_knot.x = knots[i];
  a.place = scene.places[i];
  a.place_again = gpu::vec4(scene.places[i].origin, std::bit_cast<float>(scene.instances[i].place));
  a.texture_record = scene.textures.textures[i];
  a.instance_attributes = scene.textures.instances[i];
  a.attributes = scene.textures.attributes[i];
  std::memcpy(static_cast<void*>(&a.picture), &scene.textures.bitmaps[0]->texels[16 * std::size_t{i}],
              sizeof a.picture);
  a.transmittances = scene.transmittances[i];
  a.environment_row = scene.environment.rows[i];
  a.environment_search = scene.environment.search[i];
  a.environment_texel = scene.environment.texels[i];
  a.delta_light = scene.delta_lights[i];
  a.delta_light_threshold.x = scene.delta_lights[i].threshold;
  return a;
}

TEST_F(DeviceTables, EveryFieldComesBack) {
  const CompiledScene scene = numbered_scene();
  std::vector<gpu::uvec4> inputs;
  for (std::uint32_t i = 0; i < kEntries; ++i) inputs.emplace_back(i, i % kTrails, 0, 0);
  View view = view_of(Scene{});
  view.camera.filter.type = ReconstructionFilter::Type::mitchell;
  const std::vector<float> knots = compile_view(SceneFacts(scene), view, 0).filter_knots;
  for (const TableLoads loads : {TableLoads::texel_buffer, TableLoads::storage_buffer}) {
    SCOPED_TRACE(loads == TableLoads::texel_buffer ? "texel buffers" : "storage buffers");
    KernelRun kernel{loads == TableLoads::texel_buffer ? kernels::tables : kernels::tables_storage, "tables", &scene};
    kernel.loads = loads;
    kernel.view = view;
    const auto answers = run<gpu::TablesAnswer>(kernel, inputs);
    for (std::uint32_t i = 0; i < kEntries; ++i) {
      std::array<std::uint32_t, sizeof(gpu::TablesAnswer) / 4> got, wanted;
      const gpu::TablesAnswer answer = expected(scene, i, inputs[i].y, knots);
      std::memcpy(got.data(), &answers[i], sizeof got);
      std::memcpy(wanted.data(), &answer, sizeof wanted);
      EXPECT_EQ(got, wanted) << "entry " << i;
    }
  }
}

TEST(DeviceTablesSource, NoFetchIsForgotten) {
  const auto read = [](const char* path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  };
  const std::string scene = read(SHADER_DIR "/scene.glsl"), kernel = read(TEST_DIR "/kernels/tables.comp");
  const std::regex declaration(R"(\n\w+ (fetch_\w+)\()");
  int functions = 0;
  for (std::sregex_iterator it(scene.begin(), scene.end(), declaration), end; it != end; ++it, ++functions)
    EXPECT_NE(kernel.find((*it)[1].str() + "("), std::string::npos)
        << "tests/gpu/kernels/tables.comp does not call " << (*it)[1];
  EXPECT_GE(functions, 10);
}

}  // namespace
}  // namespace etendue::test
