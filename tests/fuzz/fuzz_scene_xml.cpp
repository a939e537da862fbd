/// Any bytes as a scene file: the reader must return a scene, or an error with its position, without a fault.

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "formats/nori/nori_reader.h"
#include "formats/obj/obj_reader.h"
#include "scene/check.h"
#include "scene/coincident.h"

namespace {

/// Used for every mesh file, so the fuzzer never opens one.
std::optional<etendue::TriangleMesh> load_triangle(const etendue::MeshFormat&, const std::string& path,
                                                   const etendue::MeshContent&, etendue::Diagnostics& sink) {
  bool done = false;
  const etendue::ByteSource source = [&](char* buffer, std::size_t) {
    static constexpr std::string_view kMesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
    if (std::exchange(done, true)) return std::size_t{0};
    return kMesh.copy(buffer, kMesh.size());
  };
  return etendue::read_obj(source, path, {}, sink);
}

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  etendue::Diagnostics diagnostics;
  const auto file =
      etendue::parse_scene_file(text, "fuzz.xml", {{{"camera.width", "8"}}, false}, load_triangle, diagnostics);
  require(file.has_value() != diagnostics.has_errors());
  for (const etendue::Diagnostic& d : diagnostics.list()) {
    require(!d.message.empty() && d.message.find('\n') == std::string::npos);
    const bool in_file = d.position.file == "fuzz.xml" && d.position.line > 0;
    if (in_file) require(d.position.column > 0 && static_cast<std::size_t>(d.position.line) <= size + 1);
  }
  if (!file) return 0;
  etendue::check_scene_file(*file, diagnostics);
  etendue::check_coincident(*file, diagnostics);
  if (const auto* scene = std::get_if<etendue::Scene>(&*file)) {
    etendue::scene_hash(*scene);
    const int exponent = etendue::film_exponent(*scene);
    require(exponent >= -67 && exponent <= 67);  // 1e-20 … 1e20
    require(scene->camera.width == 8);
  }
  return 0;
}
