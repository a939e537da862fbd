#pragma once
/// What the URIs of a glTF asset lead to: bytes written in the URI itself, or a file in the folder of the asset.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

/// A URI that is not followed, and why, as the end of a sentence.
struct UriError {
  std::string message;
};

/// "data:image/png;base64,…"
struct DataUri {
  std::string media_type;
  std::vector<std::byte> bytes;
};

/// Nothing where it is another kind of URI. Throws UriError.
std::optional<DataUri> parse_data_uri(std::string_view uri);

/// The path of the file that a relative URI names. Throws UriError for other schemes, for absolute paths and for those
/// that lead out of the folder, through ".." or a symbolic link: a model often comes from strangers. A file that is not
/// there has a path, too.
std::string path_of_uri(const std::string& folder, std::string_view uri);

}  // namespace etendue
