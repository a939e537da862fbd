#pragma once
/// Small text tools shared by the readers. Nothing here depends on the locale.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/printable.h"

namespace etendue::text {

enum class NumberError { none, not_a_number, not_finite, too_large };

/// Reads the whole token as a finite decimal number (an optional leading '+' or '-', no hexadecimal). A number too
/// small for a double becomes zero.
NumberError parse_double(std::string_view token, double& value);
/// Reads the whole token as a decimal integer.
NumberError parse_integer(std::string_view token, std::int64_t& value);
/// The same, but the integer may be written like any number: `640.0`, `3.1e+2`.
NumberError parse_whole_number(std::string_view token, std::int64_t& value);
/// What a NumberError says about `token`: `"1e999" is too large`.
std::string describe(NumberError error, std::string_view token, const char* kind);

/// XML's white space: blank, tab, carriage return, newline.
bool is_blank(char c);
std::string_view trim(std::string_view s);
/// The pieces between separators, including empty ones; an empty text has none.
std::vector<std::string_view> split(std::string_view s, char separator);
bool equal_ignoring_case(std::string_view a, std::string_view b);

/// Detects a pointer file of Git LFS, and says what to do about it.
bool is_lfs_pointer(std::string_view beginning);
inline constexpr const char* kLfsPointer =
    "this is a Git LFS pointer, not the file itself; fetch it with `git lfs pull`";
/// The advice for a placeholder of Git LFS or git-annex, which stands for a large file until the file itself is
/// fetched; nullptr if `beginning` is not the beginning of one.
const char* pointer_sentence(std::string_view beginning);
/// The same for the target of a dangling symbolic link, as git-annex leaves them.
const char* link_sentence(std::string_view target);

/// The candidate closest to `word`, or "" if none is close enough to be a typo.
std::string closest(std::string_view word, const std::vector<std::string>& candidates);
/// `; did you mean "width"?` or nothing.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& candidates);
/// Escapes `&`, `<`, `>` and `"` for XML and HTML, in elements and in attributes.
std::string xml_escaped(std::string_view s);
/// "a, b, c".
std::string join(const std::vector<std::string>& words);

}  // namespace etendue::text
