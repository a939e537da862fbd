/// Any bytes as an OBJ file: the reader must return a valid mesh or an error, without a fault.

#include "formats/obj/obj_reader.h"
#include "meshes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = [&](const etendue::ByteSource& source, etendue::Diagnostics& diagnostics) {
    return etendue::read_obj(source, "fuzz.obj", {}, diagnostics);
  };
  etendue::fuzz::read_any_mesh(data, size, read);
  return 0;
}
