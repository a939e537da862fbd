#include "formats/ply/ply_stream.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 18;
constexpr std::size_t kMaxToken = 256;
constexpr std::size_t kMaxHeaderLine = 4096;

bool is_space(char c) {
  return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\v' || c == '\f';
}

}  // namespace

double largest_of(PlyType type) {
  constexpr double kLargest[] = {127.0, 255.0, 32767.0, 65535.0, 2147483647.0, 4294967295.0};
  return kLargest[static_cast<std::size_t>(type)];
}

PlyStream::PlyStream(ByteSource source, std::string file)
    : source_(std::move(source)), file_(std::move(file)), buffer_(kBuffer) {}

std::size_t PlyStream::fill(std::size_t size) {
  if (available() >= size || at_end_) return available();
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), buffer_.begin() + static_cast<std::ptrdiff_t>(end_),
            buffer_.begin());
  passed_ += begin_;
  end_ -= begin_;
  begin_ = 0;
  while (end_ < size && !at_end_) {
    const std::size_t count = source_(buffer_.data() + end_, buffer_.size() - end_);
    at_end_ = count == 0;
    end_ += count;
  }
  return available();
}

std::string_view PlyStream::header_line() {
  header_line_.clear();
  ++line_;
  for (;;) {
    if (available() == 0 && fill(1) == 0) throw PlyError{line_position(), "the file ends within its header"};
    const char c = buffer_[begin_++];
    if (c == '\n') break;
    if (c == '\r') {
      if (!bare_cr_ && fill(1) > 0 && buffer_[begin_] == '\n') {
        ++begin_;
      } else if (line_ == 1) {
        bare_cr_ = true;  // then an LF after the last line of the header is the first byte of the data
      }
      break;
    }
    if (header_line_.size() == kMaxHeaderLine)
      throw PlyError{line_position(), fmt::format("this line has more than {} bytes", kMaxHeaderLine)};
    header_line_ += c;
  }
  return header_line_;
}

void PlyStream::begin_data(PlyFormat format) {
  format_ = format;
  const bool little = format == PlyFormat::little_endian;
  swap_ = format != PlyFormat::ascii && little != (std::endian::native == std::endian::little);
  ++line_;
  line_start_ = passed_ + begin_;
}

SourcePosition PlyStream::position() const {
  if (is_binary()) return {file_, 0, 0};
  return line_position(static_cast<std::size_t>(value_at_ - line_start_ + 1));
}

void PlyStream::fail(const std::string& message) const {
  throw PlyError{position(), is_binary() ? fmt::format("{} (byte {})", message, value_at_) : message};
}

void PlyStream::fail_at_end() const {
  throw PlyError{{file_, 0, 0},
                 fmt::format("the file ends after {} bytes, earlier than its header announces", passed_ + end_)};
}

std::string_view PlyStream::token() {
  for (;;) {
    if (available() == 0 && fill(1) == 0) fail_at_end();
    const char c = buffer_[begin_];
    if (!is_space(c)) break;
    ++begin_;
    // CR LF is one end of a line; a CR alone ends one only where the header has such lines.
    if (c == '\n' || (c == '\r' && bare_cr_)) {
      ++line_;
      line_start_ = passed_ + begin_;
    }
  }
  if (available() < kMaxToken) fill(kMaxToken);
  value_at_ = passed_ + begin_;
  std::size_t size = 0;
  const std::size_t most = std::min(available(), kMaxToken);
  while (size < most && !is_space(buffer_[begin_ + size])) ++size;
  if (size == kMaxToken) fail(fmt::format("a number of more than {} characters", kMaxToken));
  const std::string_view text(buffer_.data() + begin_, size);
  begin_ += size;
  return text;
}

double PlyStream::read_text(PlyType type) {
  const std::string_view text = token();
  double value = 0;
  if (!is_integer(type)) {
    // Exporters write nan where there is nothing; who uses the value refuses it.
    if (text::equal_ignoring_case(text, "nan") || text::equal_ignoring_case(text, "-nan"))
      return std::numeric_limits<double>::quiet_NaN();
    const text::NumberError error = text::parse_double(text, value);
    if (error != text::NumberError::none) fail(text::describe(error, text, "a number"));
    return value;
  }
  std::int64_t integer = 0;
  const text::NumberError error = text::parse_whole_number(text, integer);
  if (error != text::NumberError::none) fail(text::describe(error, text, "an integer"));
  value = static_cast<double>(integer);
  const bool is_signed = type == PlyType::int8 || type == PlyType::int16 || type == PlyType::int32;
  const double least = is_signed ? -largest_of(type) - 1.0 : 0.0;
  if (value < least || value > largest_of(type))
    fail(fmt::format("{} does not fit the type that the header gives: {} … {}", text, least, largest_of(type)));
  return value;
}

void PlyStream::skip(PlyType type, std::uint64_t count) {
  if (!is_binary()) {
    for (; count > 0; --count) token();
    return;
  }
  const std::size_t run = kMaxRun / size_of(type);
  for (; count > 0; count -= std::min<std::uint64_t>(count, run))
    take(static_cast<std::size_t>(std::min<std::uint64_t>(count, run)) * size_of(type));
}

}  // namespace etendue
