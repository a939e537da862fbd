#include "core/printable.h"

namespace etendue::text {

std::size_t utf8_length(std::string_view s, std::size_t i) {
  const auto byte = [&](std::size_t k) { return k < s.size() ? static_cast<unsigned char>(s[k]) : 0u; };
  const unsigned lead = byte(i);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4) return 0;
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xc0) != 0x80) return 0;
  }
  const unsigned second = byte(i + 1);
  const bool bad = (lead == 0xe0 && second < 0xa0) || (lead == 0xed && second > 0x9f) ||
                   (lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second > 0x8f);
  return bad ? 0 : length;
}

bool is_control(std::string_view s, std::size_t i, std::size_t length) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(s[i + k]); };
  if (length == 1) return byte(0) < 0x20 || byte(0) == 0x7f;
  if (length == 2) return byte(0) == 0xc2 && byte(1) < 0xa0;
  if (length != 3 || byte(0) != 0xe2) return false;
  return (byte(1) == 0x80 && byte(2) >= 0xa8 && byte(2) <= 0xae) ||
         (byte(1) == 0x81 && byte(2) >= 0xa6 && byte(2) <= 0xa9);
}

std::string printable(std::string_view s, std::size_t most) {
  std::string shown;
  std::size_t characters = 0;
  for (std::size_t i = 0; i < s.size(); ++characters) {
    if (characters == most) {
      shown += "…";
      break;
    }
    const std::size_t length = utf8_length(s, i);
    if (length == 0 || is_control(s, i, length)) {
      shown += "\ufffd";
    } else {
      shown += s.substr(i, length);
    }
    i += length == 0 ? 1 : length;
  }
  return shown;
}

std::string quoted(std::string_view s) {
  constexpr std::size_t kMaxShown = 40;
  return '"' + printable(s, kMaxShown) + '"';
}

std::string printable_lines(std::string_view s) {
  std::string out;
  while (!s.empty()) {
    const std::size_t end = s.find('\n');
    out += printable(s.substr(0, end), kLongestLine);
    if (end == std::string_view::npos) break;
    out += '\n';
    s.remove_prefix(end + 1);
  }
  return out;
}

}  // namespace etendue::text
