/// A binary glTF asset assembled from any JSON and, after a line "%%%", any bytes for its buffer. The lengths in the
/// container are thus always right, whatever the fuzzer changes.

#include <algorithm>
#include <string>
#include <string_view>

#include "gltf_assets.h"

namespace {

std::string word(std::size_t n) {
  const auto value = static_cast<std::uint32_t>(n);
  return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string chunk(const char* type, std::string_view content) {
  std::string padded(content);
  while (padded.size() % 4 != 0) padded += ' ';
  return word(padded.size()) + std::string(type, 4) + padded;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::string_view kSeparator = "\n%%%\n";
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(input.find(kSeparator), input.size());
  const std::string_view binary = end < input.size() ? input.substr(end + kSeparator.size()) : std::string_view{};
  const std::string chunks = chunk("JSON", input.substr(0, end)) + chunk("BIN\0", binary);
  const std::string file = "glTF" + word(2) + word(12 + chunks.size()) + chunks;
  const auto* bytes = reinterpret_cast<const std::byte*>(file.data());
  etendue::fuzz::read_any_asset({bytes, bytes + file.size()});
  return 0;
}
