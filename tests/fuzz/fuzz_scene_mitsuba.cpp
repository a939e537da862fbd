/// Any bytes as a scene for Mitsuba: the reader must return a scene, or an error with its position, without a fault.
/// Included files are the text itself and another one.

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "core/errors.h"
#include "formats/mitsuba/mitsuba_reader.h"
#include "scene/check.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  etendue::Diagnostics diagnostics;
  auto document = std::make_unique<etendue::XmlDocument>(text, "fuzz.xml", diagnostics);
  if (!document->root()) return 0;
  const std::size_t errors_before = diagnostics.error_count();  // text between elements: the rest is read
  // A triangle is used for every mesh file, so the fuzzer never opens one.
  etendue::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const auto load_mesh = [&](const auto&...) { return std::optional(mesh); };
  const auto load_serialized = [&](const auto&...) { return std::optional(etendue::SerializedMesh{mesh, false}); };
  const etendue::TextLoader load_text = [&](const std::string& path) {
    return path.size() % 2 == 0 ? text : std::string("<bsdf type=\"diffuse\" id=\"included\"/>");
  };
  const auto load_picture = [](const std::string& path) {
    if (path.size() % 3 == 0) throw etendue::Error(etendue::ErrorKind::file, path + ": no such file");
    etendue::Bitmap bitmap{.width = 1, .height = 1, .channels = 1, .format = etendue::BitmapFormat::u8};
    bitmap.texels = {std::byte{7}};
    return bitmap;
  };
  const etendue::ReadOptions options{.overrides = {}, .strict = false, .approximate = size % 2 == 0};
  const auto scene = etendue::parse_mitsuba_scene(std::move(document), options,
                                                  {load_mesh, load_text, load_serialized, load_picture}, diagnostics);
  require(scene.has_value() == (diagnostics.error_count() == errors_before));
  for (const etendue::Diagnostic& d : diagnostics.list()) {
    require(!d.message.empty() && d.message.find('\n') == std::string::npos);
    if (d.position.file == "fuzz.xml" && d.position.line > 0)
      require(d.position.column > 0 && static_cast<std::size_t>(d.position.line) <= size + 1);
  }
  if (!scene) return 0;
  etendue::SceneFile file = *scene;
  etendue::check_scene_file(file, diagnostics);
  etendue::scene_hash(*scene);
  return 0;
}
