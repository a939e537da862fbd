/// Any scene that `check` accepts must render without a fault: on the reference, and on a Vulkan device if the
/// environment variable ETENDUE_FUZZ_DEVICE names one (which is slow, because a kernel is compiled for each scene).
///
/// An input is a scene file, optionally followed by a line "%%%" and an OBJ file, which is used for every mesh that the
/// scene names. Only sizes are clamped, to save time. The number of rendered scenes is printed at the end.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "core/errors.h"
#include "core/parallel.h"
#include "formats/nori/nori_reader.h"
#include "formats/obj/obj_reader.h"
#include "gpu/gpu_renderer.h"
#include "reference/reference_renderer.h"
#include "scene/check.h"

namespace {

constexpr std::string_view kSeparator = "\n%%%\n";
constexpr std::uint32_t kSamples = 2;

/// Printed when the process ends.
struct Counts {
  unsigned inputs = 0, on_reference = 0, on_device = 0;
  ~Counts() {
    std::fprintf(stderr, "%u inputs, %u rendered on the reference, %u on a device\n", inputs, on_reference, on_device);
  }
} counts;

void require(bool condition) {
  if (!condition) std::abort();
}

std::optional<etendue::TriangleMesh> load_from(std::string_view obj, const std::string& path,
                                               etendue::Diagnostics& sink) {
  const etendue::ByteSource source = [obj](char* buffer, std::size_t capacity) mutable {
    const std::size_t count = obj.copy(buffer, capacity);
    obj.remove_prefix(count);
    return count;
  };
  return etendue::read_obj(source, path, {}, sink);
}

/// The scene in an input, with a small film; nothing if `check` would refuse it.
std::optional<etendue::Scene> read_input(std::string_view input) {
  const std::size_t end = std::min(input.find(kSeparator), input.size());
  const std::string_view obj = end < input.size() ? input.substr(end + kSeparator.size())
                                                  : "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
  etendue::Diagnostics diagnostics;
  const auto load = [obj](const etendue::MeshFormat&, const std::string& path, const etendue::MeshContent&,
                          etendue::Diagnostics& sink) { return load_from(obj, path, sink); };
  auto file = etendue::parse_scene_file(std::string(input.substr(0, end)), "fuzz.xml", {}, load, diagnostics);
  if (!file || !std::holds_alternative<etendue::Scene>(*file)) return std::nullopt;
  etendue::check_scene_file(*file, diagnostics);
  etendue::Scene scene = std::move(std::get<etendue::Scene>(*file));
  scene.camera.width = std::min(scene.camera.width, 6u);
  scene.camera.height = std::min(scene.camera.height, 5u);
  scene.integrator.max_depth = std::min(scene.integrator.max_depth, 24u);
  if (scene.instances.size() > 100) return std::nullopt;
  return scene;
}

/// Renders, and requires that every sample is either in the film or counted as rejected.
void render(etendue::Renderer& renderer, const etendue::Scene& scene) {
  etendue::Film film(scene.camera.width, scene.camera.height, etendue::film_exponent(scene));
  std::vector<etendue::RejectedSample> rejected;
  require(renderer.render({0, kSamples}, film, {}, rejected) == kSamples);
  for (const etendue::FilmPixel& pixel : film.pixels()) require(pixel.count + pixel.rejected == kSamples);
}

/// Does nothing if there is no device.
void render_on_device(const etendue::Scene& scene, const char* device) {
  etendue::GpuOptions options;
  options.device = device;
  std::unique_ptr<etendue::Renderer> renderer;
  try {
    renderer = etendue::make_gpu_renderer(scene, {}, options);
  } catch (const etendue::Error& error) {
    require(error.kind() == etendue::ErrorKind::device);
    return;
  }
  render(*renderer, scene);
  ++counts.on_device;
}

}  // namespace

#ifdef ETENDUE_FUZZ
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t capacity);

// Most changes of a scene make one that is refused. Such inputs are tested by fuzz_scene_xml and fuzz_scene_obj; here
// they would crowd out scenes that render. So this tries again from the original, up to 30 times.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t capacity, unsigned) {
  constexpr int kTries = 30;
  const std::string original(reinterpret_cast<const char*>(data), size);
  for (int i = 1;; ++i) {
    const std::size_t changed = LLVMFuzzerMutate(data, size, capacity);
    if (i == kTries || read_input({reinterpret_cast<const char*>(data), changed})) return changed;
    original.copy(reinterpret_cast<char*>(data), size);
  }
}
#endif

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  etendue::set_thread_count(1);
  ++counts.inputs;
  const std::optional<etendue::Scene> scene = read_input({reinterpret_cast<const char*>(data), size});
  if (!scene) return 0;
  render(*etendue::make_reference_renderer(*scene, {}), *scene);
  ++counts.on_reference;
  static const char* const device = std::getenv("ETENDUE_FUZZ_DEVICE");
  if (device != nullptr) render_on_device(*scene, device);
  return 0;
}
