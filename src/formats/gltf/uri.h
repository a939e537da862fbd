#pragma once
/// Resolves the URIs of a glTF asset: they contain data themselves or name a file in the folder of the asset.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

/// Why a URI is not followed, as the end of a sentence.
struct UriError {
  std::string message;
};

/// "data:image/png;base64,…"
struct DataUri {
  std::string media_type;
  std::vector<std::byte> bytes;
};

/// Returns nothing for other kinds of URI. Throws UriError.
std::optional<DataUri> parse_data_uri(std::string_view uri);

/// The path of the file that a relative URI names; the file need not exist. Because models often come from strangers,
/// this throws UriError for other schemes, absolute paths, and paths that lead out of the folder through ".." or a
/// symbolic link.
std::string path_of_uri(const std::string& folder, std::string_view uri);

}  // namespace etendue
