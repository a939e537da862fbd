#include "formats/line_reader.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

namespace etendue {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 18;
constexpr std::string_view kMark = "\xef\xbb\xbf";  // a byte order mark

/// First CR or LF in [from, end), or `end`. One pass over both: a memchr for LF alone would scan the whole buffer for
/// every line of a file that ends its lines with CR.
const char* find_line_end(const char* from, const char* end) {
  return std::find_if(from, end, [](char c) { return c == '\n' || c == '\r'; });
}

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

std::string_view without_blanks_at_end(std::string_view s) {
  while (!s.empty() && is_blank(s.back())) s.remove_suffix(1);
  return s;
}

/// Where a comment begins: a # at the start of a word; npos where there is none.
std::size_t find_comment(std::string_view line) {
  std::size_t at = line.find('#');
  if (at == kMark.size() && line.starts_with(kMark)) return at;
  while (at != std::string_view::npos && at > 0 && !is_blank(line[at - 1])) at = line.find('#', at + 1);
  return at;
}

/// True for lines that hold names, which may end with a backslash of their own: "usemtl wood\", "mtllib c:\models\".
bool holds_names(std::string_view line) {
  if (line.starts_with(kMark)) line.remove_prefix(kMark.size());
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  const std::string_view keyword(line.begin(), std::find_if(line.begin(), line.end(), is_blank));
  static constexpr std::string_view kNames[] = {"o", "g", "usemtl", "mtllib", "usemap", "maplib"};
  return std::find(std::begin(kNames), std::end(kNames), keyword) != std::end(kNames);
}

/// What a physical line contributes to its logical one, and whether the next one does, too.
struct Piece {
  std::string_view text;
  bool continues = false;
};

/// `first` is the first physical line of the logical one.
Piece read_piece(std::string_view physical, std::string_view first) {
  if (physical.find('\\') == std::string_view::npos) return {physical};
  const std::string_view text = without_blanks_at_end(physical.substr(0, find_comment(physical)));
  if (text.empty() || text.back() != '\\') return {physical};
  if (text.size() > 1 && !is_blank(text[text.size() - 2]) && holds_names(first)) return {physical};
  return {text.substr(0, text.size() - 1), true};
}

bool is_comment(std::string_view physical) {
  while (!physical.empty() && is_blank(physical.front())) physical.remove_prefix(1);
  return physical.starts_with('#');
}

}  // namespace

LineReader::LineReader(Source source, std::string file, std::size_t max_line)
    : source_(std::move(source)), file_(std::move(file)), max_line_(max_line), buffer_(kChunk) {}

bool LineReader::refill() {
  if (at_end_) return false;
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  if (end_ == buffer_.size()) buffer_.resize(buffer_.size() * 2);
  const std::size_t count = source_(buffer_.data() + end_, buffer_.size() - end_);
  at_end_ = count == 0;
  end_ += count;
  return !at_end_;
}

bool LineReader::next_physical(std::string_view& physical) {
  std::size_t searched = 0;
  for (;;) {
    const char* first = buffer_.data() + begin_;
    const char* last = buffer_.data() + end_;
    const char* stop = find_line_end(first + searched, last);
    // A CR at the end of the buffer may be half of a CR LF.
    const bool undecided = stop == last || (*stop == '\r' && stop + 1 == last);
    const auto length = static_cast<std::size_t>(stop - first);
    if (length > max_line_)
      throw TooLong{
          {file_, static_cast<int>(std::min<std::uint64_t>(number_ + 1, std::numeric_limits<int>::max())), 1}};
    if (undecided && !at_end_) {
      searched = length;
      refill();
      continue;
    }
    if (stop == last && length == 0) return false;
    physical = std::string_view(first, length);
    std::size_t used = length;
    if (stop != last) used += *stop == '\r' && stop + 1 != last && stop[1] == '\n' ? 2 : 1;
    begin_ += used;
    ++number_;
    return true;
  }
}

bool LineReader::next_physical_past_comments(std::string_view& physical) {
  while (next_physical(physical)) {
    if (!is_comment(physical)) return true;
  }
  return false;
}

void LineReader::skip_empty_lines() {
  while (begin_ < end_) {
    const bool crlf = buffer_[begin_] == '\r' && begin_ + 1 < end_ && buffer_[begin_ + 1] == '\n';
    if (!crlf && buffer_[begin_] != '\n') return;
    begin_ += crlf ? 2 : 1;
    ++number_;
  }
}

bool LineReader::next() {
  joins_.clear();
  skip_empty_lines();
  std::string_view physical;
  if (!next_physical(physical)) return false;
  joins_.push_back({0, number_});
  Piece piece = read_piece(physical, physical);
  if (!piece.continues) {
    line_ = physical;
    return true;
  }
  joined_.clear();
  for (;;) {
    joined_ += piece.text;
    if (joined_.size() > max_line_) throw TooLong{position(0)};
    if (!piece.continues) break;
    joined_ += ' ';  // a backslash separates: it stands where a blank would
    if (!next_physical_past_comments(physical)) break;
    joins_.push_back({joined_.size(), number_});
    piece = read_piece(physical, joined_);
  }
  line_ = joined_;
  return true;
}

SourcePosition LineReader::position(std::size_t offset) const {
  const auto after = std::upper_bound(joins_.begin(), joins_.end(), offset,
                                      [](std::size_t o, const Join& join) { return o < join.offset; });
  const Join join = after == joins_.begin() ? Join{0, number_} : *(after - 1);
  constexpr std::uint64_t kMax = std::numeric_limits<int>::max();
  return {file_, static_cast<int>(std::min(join.number, kMax)),
          static_cast<int>(std::min<std::uint64_t>(offset - join.offset + 1, kMax))};
}

}  // namespace etendue
