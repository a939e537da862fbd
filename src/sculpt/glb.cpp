#include "sculpt/glb.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "image/files.h"

namespace etendue::sculpt {
namespace {

static_assert(std::endian::native == std::endian::little, "the file's numbers are written as they lie in memory");

constexpr std::uint32_t kFloat = 5126, kUnsigned = 5125;
constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

void append(std::vector<std::byte>& to, std::span<const std::byte> bytes) {
  to.resize(to.size() + bytes.size());
  std::ranges::copy(bytes, to.end() - static_cast<std::ptrdiff_t>(bytes.size()));
}

void pad(std::vector<std::byte>& bytes, char with) {
  while (bytes.size() % 4 != 0) bytes.push_back(static_cast<std::byte>(with));
}

void append_words(std::vector<std::byte>& to, std::initializer_list<std::size_t> words) {
  for (const std::size_t word : words) {
    const auto small = static_cast<std::uint32_t>(word);
    append(to, std::as_bytes(std::span(&small, 1)));
  }
}

std::vector<float> flat(const std::vector<Vec3>& vectors) {
  std::vector<float> out;
  for (const Vec3& v : vectors)
    for (const double component : {v.x, v.y, v.z}) out.push_back(static_cast<float>(component));
  return out;
}

}  // namespace

std::size_t Glb::add(const std::string& list, Json element) {
  json_[list].push_back(std::move(element));
  return sizes_[list]++;
}

std::size_t Glb::add_view(std::span<const std::byte> bytes) {
  const std::size_t start = buffer_.size();
  append(buffer_, bytes);
  pad(buffer_, 0);
  return add("bufferViews", {{"buffer", 0}, {"byteOffset", start}, {"byteLength", bytes.size()}});
}

std::size_t Glb::add_accessor(std::span<const std::byte> bytes, Json properties) {
  properties["bufferView"] = add_view(bytes);
  return add("accessors", std::move(properties));
}

std::size_t Glb::add_mesh(const Mesh& mesh, std::size_t material) {
  const std::size_t count = mesh.positions.size();
  std::vector<float> uvs;
  for (const auto& uv : mesh.uvs)
    for (const double component : uv) uvs.push_back(static_cast<float>(component));
  const std::vector<float> positions = flat(mesh.positions);
  std::vector<float> least(positions.begin(), positions.begin() + 3), most = least;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    least[i % 3] = std::min(least[i % 3], positions[i]);
    most[i % 3] = std::max(most[i % 3], positions[i]);
  }
  const auto floats = [&](const std::vector<float>& numbers, const char* type) {
    return add_accessor(std::as_bytes(std::span(numbers)),
                        {{"componentType", kFloat}, {"count", count}, {"type", type}});
  };
  Json attributes = Json::object();
  attributes["POSITION"] =
      add_accessor(std::as_bytes(std::span(positions)),
                   {{"componentType", kFloat}, {"count", count}, {"type", "VEC3"}, {"min", least}, {"max", most}});
  attributes["NORMAL"] = floats(flat(mesh.normals), "VEC3");
  if (!uvs.empty()) attributes["TEXCOORD_0"] = floats(uvs, "VEC2");
  const std::size_t indices =
      add_accessor(std::as_bytes(std::span(mesh.triangles)),
                   {{"componentType", kUnsigned}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}});
  Json primitive = {{"attributes", attributes}, {"indices", indices}, {"material", material}};
  return add("meshes", {{"primitives", Json::Array{primitive}}});
}

std::size_t Glb::add_texture(std::span<const std::byte> png) {
  const std::size_t view = add_view(png);
  return add("textures", {{"source", add("images", {{"bufferView", view}, {"mimeType", "image/png"}})}});
}

void Glb::write(const std::string& path) {
  json_["buffers"] = Json::Array{{{"byteLength", buffer_.size()}}};
  const std::string text = json_.dump(-1);
  std::vector<std::byte> json;
  append(json, std::as_bytes(std::span(text)));
  pad(json, ' ');
  std::vector<std::byte> file;
  append_words(file, {kMagic, 2, 12 + 8 + json.size() + 8 + buffer_.size(), json.size(), kJsonChunk});
  append(file, json);
  append_words(file, {buffer_.size(), kBinaryChunk});
  append(file, buffer_);
  write_file_atomically(path, file);
}

}  // namespace etendue::sculpt
