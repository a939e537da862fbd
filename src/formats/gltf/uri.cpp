#include "formats/gltf/uri.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

int hexadecimal(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// "%20" becomes a blank. A percent sign without a code stands for itself, because some exporters write it like that.
std::string percent_decoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool code =
        text[i] == '%' && i + 2 < text.size() && hexadecimal(text[i + 1]) >= 0 && hexadecimal(text[i + 2]) >= 0;
    decoded += code ? static_cast<char>(16 * hexadecimal(text[i + 1]) + hexadecimal(text[i + 2])) : text[i];
    if (code) i += 2;
  }
  return decoded;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;  // '-' and '_' are from the alphabet for URLs
  if (c == '/' || c == '_') return 63;
  return -1;
}

std::vector<std::byte> base64_decoded(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  if (text.size() % 4 == 1) throw UriError{"its base64 text has an impossible length"};
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) throw UriError{fmt::format("its base64 text has the character {}", text::quoted({&c, 1}))};
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count & 0xffu));
  }
  return bytes;
}

/// "https" for "https://…", empty for a file name.
std::string_view scheme_of(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string_view::npos || colon == 0) return {};
  const std::string_view scheme = uri.substr(0, colon);
  const bool letters = std::ranges::all_of(scheme, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '+' || c == '-' ||
           c == '.';
  });
  return letters ? scheme : std::string_view{};
}

bool begins_with_parent(const fs::path& path) {
  return !path.empty() && *path.begin() == "..";
}

}  // namespace

std::optional<DataUri> parse_data_uri(std::string_view uri) {
  constexpr std::string_view kScheme = "data:";
  if (!text::equal_ignoring_case(uri.substr(0, kScheme.size()), kScheme)) return std::nullopt;
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) throw UriError{"it is a data URI without data"};
  const std::string_view header = uri.substr(kScheme.size(), comma - kScheme.size());
  constexpr std::string_view kBase64 = ";base64";
  const std::string_view content = uri.substr(comma + 1);
  DataUri data;
  data.media_type = std::string(header.substr(0, header.find(';')));
  if (header.ends_with(kBase64)) {
    data.bytes =
        base64_decoded(content.find('%') == std::string_view::npos ? std::string(content) : percent_decoded(content));
  } else {
    for (const char c : percent_decoded(content)) data.bytes.push_back(static_cast<std::byte>(c));
  }
  return data;
}

std::string path_of_uri(const std::string& folder, std::string_view uri) {
  if (const std::string_view scheme = scheme_of(uri); !scheme.empty())
    throw UriError{fmt::format("only files next to the model are read, not \"{}:\"", scheme)};
  std::string name = percent_decoded(uri);
  if (name.empty()) throw UriError{"the name is empty"};
  if (name.find('\0') != std::string::npos) throw UriError{"the name holds a zero byte"};
  std::ranges::replace(name, '\\', '/');
  if (name.front() == '/') throw UriError{"absolute paths are not followed; name a file in the folder of the model"};
  const fs::path inside = fs::path(name).lexically_normal();
  const UriError outside{
      "it is outside the folder of the model, where nothing is read; put the file next to the model"};
  if (begins_with_parent(inside)) throw outside;
  const fs::path base = folder.empty() ? fs::path(".") : fs::path(folder);
  const fs::path path = base / inside;
  std::error_code error;
  const fs::path real_base = fs::canonical(base, error);
  const fs::path real = error ? fs::path() : fs::canonical(path, error);
  if (error) return path.string();  // there is no such file, which the caller finds out when opening it
  if (begins_with_parent(real.lexically_relative(real_base))) throw outside;
  return real.string();
}

}  // namespace etendue
