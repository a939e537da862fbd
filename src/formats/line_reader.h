#pragma once
/// Lines of a text stream in bounded memory.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace etendue {

/// Logical lines: they end with LF, CR LF, CR or the end of the stream. A backslash at the end of a line joins it with
/// the next; blanks and a comment may follow it, and lines of comment may stand between. A backslash within a comment,
/// or at the end of a name ("usemtl wood\"), joins nothing.
class LineReader {
 public:
  using Source = std::function<std::size_t(char* buffer, std::size_t capacity)>;

  /// `max_line` bounds a logical line in bytes.
  LineReader(Source source, std::string file, std::size_t max_line);

  /// Moves to the next line, past some or all empty ones; false at the end. Throws TooLong.
  bool next();
  /// The current line without its end; valid until the next call.
  std::string_view line() const { return line_; }
  /// Line and column (in bytes) of a byte of the current line.
  SourcePosition position(std::size_t offset) const;

  struct TooLong {
    SourcePosition position;
  };

 private:
  struct Join {
    std::size_t offset;  ///< in the logical line, where the physical line `number` starts
    std::uint64_t number;
  };
  bool next_physical(std::string_view& physical);
  bool next_physical_past_comments(std::string_view& physical);
  /// Only for speed: gigabytes of empty lines should not take minutes.
  void skip_empty_lines();
  bool refill();

  Source source_;
  std::string file_;
  std::size_t max_line_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;  ///< unread bytes of the buffer
  bool at_end_ = false;
  std::uint64_t number_ = 0;  ///< of the physical line read last
  std::string_view line_;
  std::string joined_;
  std::vector<Join> joins_;
};

}  // namespace etendue
