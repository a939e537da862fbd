#include "formats/gltf/draco.h"

#include <memory>
#include <new>
#include <utility>

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

FloatTable read_attribute(const draco::Mesh& mesh, const draco::PointAttribute& attribute, const JsonValue& where) {
  FloatTable table;
  table.components = static_cast<std::uint32_t>(attribute.num_components());
  table.numbers.resize(std::size_t{mesh.num_points()} * table.components);
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(i));
    const bool known = value.value() < attribute.size() &&
                       attribute.ConvertValue<float>(value, attribute.num_components(),
                                                     &table.numbers[std::size_t{i} * table.components]);
    if (!known) throw GltfError{&where, "the compressed mesh is damaged: a vertex lacks an attribute"};
  }
  return table;
}

std::unique_ptr<draco::Mesh> decode(const JsonValue& where, std::span<const std::byte> stream) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  draco::Decoder decoder;
  try {
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (mesh.ok()) return std::move(mesh).value();
    throw GltfError{&where, fmt::format("the compressed mesh is damaged: {}",
                                        text::printable(mesh.status().error_msg_string(), 200))};
  } catch (const std::bad_alloc&) {
    throw GltfError{&where, "the compressed mesh needs more memory than is available: it is damaged"};
  }
}

}  // namespace

DracoMesh decode_draco(const JsonValue& extension, std::span<const std::byte> stream) {
  const std::unique_ptr<draco::Mesh> mesh = decode(extension, stream);
  DracoMesh result;
  for (std::uint32_t i = 0; i < mesh->num_faces(); ++i) {
    for (const draco::PointIndex& corner : mesh->face(draco::FaceIndex(i))) result.indices.push_back(corner.value());
  }
  const JsonValue* attributes = find_object(extension, "attributes");
  if (attributes == nullptr) throw GltfError{&extension, "the compressed mesh has no \"attributes\""};
  for (const auto& [name, id] : *attributes->object()) {
    const auto number = find_index(*attributes, name);
    const draco::PointAttribute* attribute = number ? mesh->GetAttributeByUniqueId(*number) : nullptr;
    if (attribute == nullptr)
      throw GltfError{attributes, fmt::format("the compressed mesh has no attribute for {}", text::quoted(name))};
    result.attributes[name] = read_attribute(*mesh, *attribute, extension);
  }
  return result;
}

}  // namespace etendue
