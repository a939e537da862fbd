#include "vulkan/module_cache.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <string>
#include <string_view>

#include <fmt/core.h>
#include <spirv-tools/libspirv.h>
#include <xxhash.h>

#include "vulkan/cache_files.h"

namespace etendue::vulkan {
namespace {

constexpr const char* kExtension = ".spv";

// XXH3 (128 bits) of several pieces, with their lengths, so that they cannot run into each other.
XXH128_hash_t hash_of(std::initializer_list<std::span<const std::byte>> pieces) {
  std::string all;
  for (const std::span<const std::byte> piece : pieces) {
    all += fmt::format("{} ", piece.size());
    all.append(reinterpret_cast<const char*>(piece.data()), piece.size());
  }
  return XXH3_128bits(all.data(), all.size());
}

// Another version of SPIRV-Tools may make another module.
XXH128_hash_t key_of(std::span<const std::uint32_t> spirv, std::span<const Specialization> constants) {
  const std::string_view version = spvSoftwareVersionDetailsString();
  return hash_of({std::as_bytes(std::span(version)), std::as_bytes(spirv), std::as_bytes(constants)});
}

std::filesystem::path path_of(const std::filesystem::path& folder, const XXH128_hash_t& key) {
  return folder / fmt::format("{:016x}{:016x}{}", key.high64, key.low64, kExtension);
}

XXH128_hash_t sum_of(const XXH128_hash_t& key, std::span<const std::uint32_t> words) {
  return hash_of({std::as_bytes(std::span(&key, 1)), std::as_bytes(words)});
}

// A file is the hash of its key and words, then the words.
std::string to_bytes(const XXH128_hash_t& key, std::span<const std::uint32_t> words) {
  const XXH128_hash_t sum = sum_of(key, words);
  std::string bytes(sizeof sum + words.size_bytes(), '\0');
  std::memcpy(bytes.data(), &sum, sizeof sum);
  std::memcpy(bytes.data() + sizeof sum, words.data(), words.size_bytes());
  return bytes;
}

std::optional<std::vector<std::uint32_t>> from_bytes(const XXH128_hash_t& key, const std::string& bytes) {
  XXH128_hash_t sum;
  if (bytes.size() <= sizeof sum || bytes.size() % sizeof(std::uint32_t) != 0) return {};
  std::memcpy(&sum, bytes.data(), sizeof sum);
  std::vector<std::uint32_t> words((bytes.size() - sizeof sum) / sizeof(std::uint32_t));
  std::memcpy(words.data(), bytes.data() + sizeof sum, bytes.size() - sizeof sum);
  if (!XXH128_isEqual(sum, sum_of(key, words))) return {};
  return words;
}

}  // namespace

void ModuleCache::remove_old() const {
  using Entry = std::pair<std::filesystem::file_time_type, std::filesystem::path>;
  std::vector<Entry> entries;
  std::error_code ignored;
  for (std::filesystem::directory_iterator at(folder_, ignored), end; at != end; at.increment(ignored)) {
    if (at->path().extension() == kExtension) entries.emplace_back(at->last_write_time(ignored), at->path());
    if (ignored) break;
  }
  if (entries.size() <= kMost) return;
  std::ranges::sort(entries);
  for (const auto& [time, path] : std::span(entries).first(entries.size() - kMost))
    std::filesystem::remove(path, ignored);
}

std::optional<std::vector<std::uint32_t>> ModuleCache::find(std::span<const std::uint32_t> spirv,
                                                            std::span<const Specialization> constants) const {
  if (folder_.empty()) return {};
  const XXH128_hash_t key = key_of(spirv, constants);
  const std::filesystem::path path = path_of(folder_, key);
  std::optional<std::vector<std::uint32_t>> words = from_bytes(key, read_cached(path));
  std::error_code ignored;
  if (words) std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now(), ignored);
  return words;
}

std::vector<std::uint32_t> ModuleCache::specialized(std::span<const std::uint32_t> spirv,
                                                    std::span<const Specialization> constants) const {
  if (auto words = find(spirv, constants)) return *std::move(words);
  std::vector<std::uint32_t> words = specialize(spirv, constants);
  if (folder_.empty()) return words;
  const XXH128_hash_t key = key_of(spirv, constants);
  write_cached(path_of(folder_, key), to_bytes(key, words));
  remove_old();
  return words;
}

}  // namespace etendue::vulkan
