#include "core/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace etendue::text {
namespace {

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// True if a number that std::from_chars found out of range is too small rather than too large: its first non-zero
/// digit stands for a negative power of ten.
bool is_underflow(std::string_view token) {
  const std::size_t e = token.find_first_of("eE");
  const std::string_view mantissa = token.substr(0, e);
  std::int64_t exponent = 0;
  if (e != std::string_view::npos) {
    const std::string_view digits = token.substr(e + 1);
    if (parse_integer(digits, exponent) != NumberError::none) return digits.front() == '-';
  }
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  const std::size_t first = mantissa.find_first_of("123456789");
  if (first == std::string_view::npos) return true;
  const auto power = static_cast<std::int64_t>(point) - static_cast<std::int64_t>(first);
  return exponent < -power;
}

std::string_view without_plus(std::string_view token) {
  if (token.size() > 1 && token[0] == '+' && token[1] != '-' && token[1] != '+') token.remove_prefix(1);
  return token;
}

}  // namespace

NumberError parse_double(std::string_view token, double& value) {
  const std::string_view digits = without_plus(token);
  double result = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), result);
  if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) return NumberError::not_a_number;
  if (error == std::errc::result_out_of_range) {
    if (!is_underflow(digits)) return NumberError::too_large;
    result = 0;
  }
  if (!std::isfinite(result)) return NumberError::not_finite;
  value = result;
  return NumberError::none;
}

NumberError parse_integer(std::string_view token, std::int64_t& value) {
  const std::string_view digits = without_plus(token);
  std::int64_t result = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), result);
  if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) return NumberError::not_a_number;
  if (error == std::errc::result_out_of_range) return NumberError::too_large;
  value = result;
  return NumberError::none;
}

NumberError parse_whole_number(std::string_view token, std::int64_t& value) {
  const NumberError error = parse_integer(token, value);
  double number = 0;
  if (error != NumberError::not_a_number || parse_double(token, number) != NumberError::none) return error;
  constexpr double kExact = 0x1p53;  // up to here a double knows every integer
  if (std::abs(number) > kExact) return NumberError::too_large;
  if (number != std::floor(number)) return NumberError::not_a_number;
  value = static_cast<std::int64_t>(number);
  return NumberError::none;
}

namespace {

const char* example(std::string_view kind) {
  return kind == "an integer" ? "640" : kind == "an index" ? "3 or -1" : "1.5 or -2e3";
}

}  // namespace

std::string describe(NumberError error, std::string_view token, const char* kind) {
  switch (error) {
    case NumberError::none:
      return {};
    case NumberError::not_a_number:
      return fmt::format("{} is not {}; write it like {}", quoted(token), kind, example(kind));
    case NumberError::not_finite:
      return fmt::format("{} is not a finite number; write it like {}", quoted(token), example(kind));
    case NumberError::too_large:
      return fmt::format("{} is too large to be {}", quoted(token), kind);
  }
  return {};
}

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

std::string_view trim(std::string_view s) {
  while (!s.empty() && is_blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && is_blank(s.back())) s.remove_suffix(1);
  return s;
}

std::vector<std::string_view> split(std::string_view s, char separator) {
  std::vector<std::string_view> pieces;
  for (std::size_t begin = 0; !s.empty() && begin <= s.size();) {
    const std::size_t end = std::min(s.find(separator, begin), s.size());
    pieces.push_back(s.substr(begin, end - begin));
    begin = end + 1;
  }
  return pieces;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

namespace {

constexpr std::string_view kAnnexFolder = "/annex/objects/";  // below .git, which may be a file that says where it is
constexpr const char* kAnnexPointer = "this is a git-annex pointer, not the file itself; fetch it with `git annex get`";

}  // namespace

bool is_lfs_pointer(std::string_view beginning) {
  return beginning.starts_with("version https://git-lfs.");
}

const char* pointer_sentence(std::string_view beginning) {
  if (is_lfs_pointer(beginning)) return kLfsPointer;
  // An unlocked file holds "/annex/objects/KEY"; a locked one is a link, and its target is the text where links are not
  // supported: "../.git/annex/objects/xx/yy/KEY/KEY".
  const std::string_view line = beginning.substr(0, beginning.find('\n'));
  const bool path = line.starts_with("/annex/") || line.starts_with(".git/") || line.starts_with("../");
  return path && line.find(kAnnexFolder) != std::string_view::npos ? kAnnexPointer : nullptr;
}

const char* link_sentence(std::string_view target) {
  return target.find(kAnnexFolder) != std::string_view::npos
             ? "git-annex keeps it elsewhere; fetch it with `git annex get`"
             : nullptr;
}

namespace {

/// Number of insertions, deletions, substitutions and swaps of neighbours (optimal string alignment) between two short
/// words, ignoring case.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), previous(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      row[j] = std::min({previous[j] + 1, row[j - 1] + 1, previous[j - 1] + (same ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, previous);
    std::swap(previous, row);
  }
  return previous[b.size()];
}

}  // namespace

std::string closest(std::string_view word, const std::vector<std::string>& candidates) {
  constexpr std::size_t kMaxWord = 64;  // keeps the quadratic distance cheap whatever the file contains
  if (word.empty() || word.size() > kMaxWord) return {};
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(1, std::min<std::size_t>(3, word.size() / 3)) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string best = closest(word, candidates);
  return best.empty() ? std::string() : fmt::format("; did you mean \"{}\"?", best);
}

std::string xml_escaped(std::string_view s) {
  std::string out;
  for (const char c : s) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string join(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace etendue::text
