/// Every field of every table of the scene arrives in the kernels as the host wrote it, through texel buffers and
/// through storage buffers.

#include <array>
#include <fstream>
#include <regex>
#include <sstream>

#include "device_test.h"
#include "kernels_storage.h"

namespace etendue::test {
namespace {

class DeviceTables : public DeviceTest {};

constexpr std::uint32_t kEntries = 37;
constexpr std::uint32_t kTrails = 3;  // of each shape

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
  scene.shapes = numbered<gpu::Shape>(2);
  scene.light_shapes = numbered<gpu::LightShape>(3);
  scene.light_primitives = numbered<gpu::LightPrimitive>(4);
  scene.light_pairs = numbered<gpu::LightPair>(5);
  scene.light_trails = numbered<gpu::LightTrail>(6, kEntries * (1 + kTrails));
  for (std::uint32_t i = 0; i < kEntries; ++i) scene.light_trails[i].turns = kEntries + kTrails * i;
  // The host follows these two: they must name a material and a primitive that are there.
  for (std::uint32_t i = 0; i < kEntries; ++i) {
    scene.shapes[i].bsdf = i % 3;
    scene.light_primitives[i].slot = i * gpu::kPrimitiveSlots;
  }
  scene.triangles = numbered<gpu::uvec4>(7);
  scene.normals = numbered<gpu::vec4>(8);
  return scene;
}

gpu::TablesAnswer expected(const CompiledScene& scene, std::uint32_t i, std::uint32_t trail,
                           const std::vector<float>& knots) {
  gpu::TablesAnswer a{};
  std::memcpy(static_cast<void*>(&a.primitive), &scene.records[std::size_t{i} * gpu::kRecordTexels],
              sizeof a.primitive);
  std::memcpy(static_cast<void*>(&a.record), &scene.records[std::size_t{i} * gpu::kRecordTexels], sizeof a.record);
  a.shape = scene.shapes[i];
  a.light_shape = scene.light_shapes[i];
  a.light_primitive = scene.light_primitives[i];
  a.left_bounds = scene.light_pairs[i].left_bounds;
  a.light_pair = scene.light_pairs[i];
  a.light_trail = scene.light_trails[scene.light_trails[i].turns + trail];
  a.triangle = gpu::uvec4(glm::uvec3(scene.triangles[i]), 0u);
  a.normal = gpu::vec4(glm::vec3(scene.normals[i]), 0.0f);
  a.filter_knot.x = knots[i];
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
