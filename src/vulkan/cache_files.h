#pragma once
/// Files that only save time: every failure to read or write them is silent, because no render may depend on them.

#include <filesystem>
#include <span>
#include <string>

namespace etendue::vulkan {

/// The folder of this program in the user's cache folder (XDG_CACHE_HOME, or .cache in HOME); empty if there is none.
std::filesystem::path cache_folder();

/// The bytes of a file; none if it cannot be read.
std::string read_cached(const std::filesystem::path& path);

/// Replaces a file as a whole, and makes its folder.
void write_cached(const std::filesystem::path& path, std::span<const char> bytes);

}  // namespace etendue::vulkan
