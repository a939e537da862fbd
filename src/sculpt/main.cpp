// etendue-sculpt makes the large meshes and the pictures of the scenes, so that the repository need not contain them
// and no scan has to be licensed. The same command writes the same bytes on every machine.

#include <fmt/format.h>

#include "core/command_line.h"
#include "core/errors.h"
#include "core/log.h"
#include "core/terminal.h"
#include "core/version.h"
#include "sculpt/mesh.h"
#include "sculpt/pictures.h"
#include "sculpt/polygonise.h"
#include "sculpt/robot.h"
#include "sculpt/sky.h"
#include "sculpt/turned.h"

using namespace etendue;

namespace {

sculpt::Mesh make(const std::string& kind, std::uint64_t triangles) {
  if (kind != "lamps" && kind != "tile" && triangles < 100) {
    throw Error(ErrorKind::usage,
                fmt::format("--triangles {} is too few for the kind {}, which needs at least 100.", triangles, kind));
  }
  if (kind == "grid") return sculpt::grid(triangles);
  if (kind == "soup") return sculpt::soup(triangles);
  if (kind == "lamps") return sculpt::lamps(triangles);
  if (kind == "vase") return sculpt::vase(triangles);
  if (kind == "bowl") return sculpt::bowl(triangles);
  if (kind == "goblet") return sculpt::goblet(triangles);
  if (kind == "curtain") return sculpt::curtain(triangles);
  if (kind == "tile") return sculpt::tile();
  const sculpt::Solid solid = kind == "bust" ? sculpt::bust() : kind == "fir" ? sculpt::fir() : sculpt::bumpy_sphere();
  sculpt::Mesh mesh = sculpt::polygonise(solid, triangles);
  sculpt::check_closed(mesh);
  return mesh;
}

int run(int argc, char** argv) {
  Command app("makes triangle meshes, pictures and a sky for the scenes, the same bytes on every machine",
              "etendue-sculpt");
  std::string kind, picture, output;
  std::uint64_t triangles = 500000;
  std::uint32_t size = 512;
  app.add_option(
         "--kind", kind,
         "bust: a head with curls, 1 high, standing on y = 0, facing +z; bumpy-sphere: around the origin, radius "
         "about 0.5; fir: the crown of a tree, about 1 high (all closed, with normals); grid: a wavy square; soup: "
         "loose random triangles; lamps: triangles "
         "that hover over a square and look down; vase, bowl: turned, with texture coordinates; goblet: a closed "
         "wine glass, 1 high; curtain: a sheet of folds, 1 wide and high; tile: a square with texture coordinates; "
         "sky: a picture of a day's sky, Radiance HDR, of --height rows; robot: a toy on a table with lamps and a "
         "camera, "
         "a binary glTF asset")
      ->type_name("KIND")
      ->check(one_of({"bust", "bumpy-sphere", "fir", "grid", "soup", "lamps", "vase", "bowl", "goblet", "curtain",
                      "tile", "sky", "robot"}));
  app.add_option("--picture", picture, "make a PNG instead of a mesh: wood, porcelain, cloth, or orange (for a sphere)")
      ->type_name("KIND")
      ->check(one_of(sculpt::picture_kinds()));
  app.add_option("--size", size, "width and height of a picture in pixels")
      ->capture_default_str()
      ->check(in_range(1, 8192));
  app.add_option("--triangles", triangles,
                 "minimum number of triangles, at least 100 except for lamps; solids usually get up to 5 per cent more")
      ->capture_default_str()
      ->check(in_range(1, 50'000'000));
  std::uint32_t height = 512;
  app.add_option("--height", height, "height of the sky's picture in pixels; it is twice as wide")
      ->capture_default_str()
      ->check(in_range(2, 4096));
  app.add_option("-o,--output,--out", output,
                 "file to write: OBJ for a mesh, PNG for a picture, HDR for a sky, GLB for an asset")
      ->required()
      ->file({".obj", ".png", ".hdr"});
  app.set_version_flag(std::string("etendue-sculpt ") + version());
  if (const std::optional<bool> end = app.parse(argc, argv)) return *end ? 0 : 2;
  if (kind.empty() == picture.empty())
    throw Error(ErrorKind::usage, "Give --kind for a mesh or a sky, or --picture for a picture.");
  if (!picture.empty()) {
    write_png(output, sculpt::make_picture(picture, size));
    return 0;
  }
  if (kind == "sky") {
    sculpt::write_sky(height, fmt::format("Made by etendue-sculpt --kind sky --height {}", height), output);
    return 0;
  }
  if (kind == "robot") {
    sculpt::robot().write(output);
    return 0;
  }
  const sculpt::Mesh mesh = make(kind, triangles);
  sculpt::write_obj(mesh, fmt::format("Made by etendue-sculpt --kind {} --triangles {}", kind, triangles), output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const etendue::TerminalLog messages;
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    log::error(error.what());
    return error.kind() == etendue::ErrorKind::file ? 6 : 2;
  } catch (const std::exception& error) {
    log::error(error.what());
    return 6;
  }
}
