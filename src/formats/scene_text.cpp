#include "formats/scene_text.h"

#include <fmt/format.h>

#include "core/errors.h"
#include "formats/input_file.h"
#include "formats/xml/xml_document.h"

namespace etendue {

std::string read_scene_text(const std::string& path) {
  InputFile file(path);
  if (file.size() > XmlDocument::kMaxBytes) {
    throw Error(ErrorKind::scene,
                fmt::format("{}: the file has {} bytes; a scene file has at most {}, geometry belongs in mesh files",
                            path, file.size(), XmlDocument::kMaxBytes));
  }
  std::string text(static_cast<std::size_t>(file.size()), '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const std::size_t count = file.read(text.data() + size, text.size() - size);
    if (count == 0) break;  // somebody shortens the file while it is read
    size += count;
  }
  text.resize(size);
  return text;
}

}  // namespace etendue
