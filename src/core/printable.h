#pragma once
/// Makes text from outside (files, names, drivers) safe to print. Everything that the program prints goes through here:
/// a file must not be able to control the terminal, hide what follows it, or fill the screen.

#include <cstddef>
#include <string>
#include <string_view>

namespace etendue::text {

/// Byte length of the UTF-8 sequence at `s[i]`, or 0 if it is malformed (overlong, surrogate, out of range, truncated).
std::size_t utf8_length(std::string_view s, std::size_t i);

/// Whether the UTF-8 sequence of `length` bytes at `s[i]` moves the cursor, ends the line or changes the direction of
/// text: C0 and C1 control characters, DEL, U+2028, U+2029, and the controls of bidirectional text (U+202A to U+202E,
/// U+2066 to U+2069).
bool is_control(std::string_view s, std::size_t i, std::size_t length);

/// One line: control characters, newlines included, and bytes that are not UTF-8 become U+FFFD; text longer than `most`
/// characters is cut and ends in "…".
std::string printable(std::string_view s, std::size_t most);

/// A piece of the user's text for a message: printable, at most 40 characters, in double quotes.
std::string quoted(std::string_view s);

/// The longest line that is printed, in characters.
inline constexpr std::size_t kLongestLine = 4000;
/// Text of several lines, each of them printable with at most kLongestLine characters.
std::string printable_lines(std::string_view s);

}  // namespace etendue::text
