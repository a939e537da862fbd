#include "formats/gltf/json_tree.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace etendue {
namespace {

/// An iterator over a text that reports how far the parser has read. The parser copies it.
class TrackedText {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  TrackedText(const char* at, const char** last_read) : at_(at), last_read_(last_read) {}
  reference operator*() const {
    *last_read_ = at_;
    return *at_;
  }
  TrackedText& operator++() {
    ++at_;
    return *this;
  }
  TrackedText operator++(int) {
    TrackedText before = *this;
    ++at_;
    return before;
  }
  bool operator==(const TrackedText& other) const { return at_ == other.at_; }

 private:
  const char* at_;
  const char** last_read_;
};

}  // namespace

/// Builds the tree from the parser's events.
class JsonTreeBuilder {
 public:
  using number_integer_t = std::int64_t;
  using number_unsigned_t = std::uint64_t;
  using number_float_t = double;
  using string_t = std::string;
  using binary_t = std::vector<std::uint8_t>;

  explicit JsonTreeBuilder(std::string_view text) : begin_(text.data()), last_read_(text.data()) {}

  const char** last_read() { return &last_read_; }
  JsonValue take() { return std::move(root_); }

  bool null() { return add({}); }
  bool boolean(bool value) { return add(value); }
  bool number_integer(number_integer_t value) { return add(static_cast<double>(value)); }
  bool number_unsigned(number_unsigned_t value) { return add(static_cast<double>(value)); }
  bool number_float(number_float_t value, const string_t& written) {
    place(value).has_point_ = written.find_first_of(".eE") != string_t::npos;  // without either it is a large integer
    return true;
  }
  bool string(string_t& value) { return add(std::move(value)); }
  bool binary(binary_t&) { return false; }
  bool start_object(std::size_t) { return open(JsonValue::Object()); }
  bool key(string_t& name) {
    names_.back() = std::move(name);
    return true;
  }
  bool end_object() { return close(); }
  bool start_array(std::size_t) { return open(JsonValue::Array()); }
  bool end_array() { return close(); }
  bool parse_error(std::size_t, const std::string& token, const nlohmann::detail::exception&) {
    throw JsonError{offset(), fmt::format("this is not JSON from here on, at {}", shown(token))};
  }

 private:
  static std::string shown(const std::string& token) {
    constexpr std::size_t kMost = 20;
    return token.empty() ? "its end"
                         : fmt::format("\"{}\"", token.substr(token.size() - std::min(token.size(), kMost)));
  }

  std::uint64_t offset() const { return static_cast<std::uint64_t>(last_read_ - begin_); }

  bool add(decltype(JsonValue::value_) value) {
    place(std::move(value));
    return true;
  }

  JsonValue& place(decltype(JsonValue::value_) value) {
    if (++values_ > JsonLimits::kMaxValues)
      throw JsonError{offset(), fmt::format("the JSON has more than {} values", JsonLimits::kMaxValues)};
    JsonValue* target = &root_;
    if (!open_.empty()) {
      JsonValue& parent = *open_.back();
      if (auto* array = std::get_if<JsonValue::Array>(&parent.value_)) {
        target = &array->emplace_back();
      } else {
        auto& object = std::get<JsonValue::Object>(parent.value_);
        target = &object.emplace_back(std::move(names_.back()), JsonValue()).second;
      }
    }
    target->value_ = std::move(value);
    target->offset_ = offset() & JsonValue::kOffsets;
    return *target;
  }

  /// An open array or object is the last element of the one around it, which does not grow meanwhile: pointers stay
  /// valid.
  bool open(decltype(JsonValue::value_) value) {
    if (open_.size() == JsonLimits::kMaxDepth)
      throw JsonError{offset(), fmt::format("arrays and objects are nested more than {} deep", JsonLimits::kMaxDepth)};
    open_.push_back(&place(std::move(value)));
    names_.emplace_back();
    return true;
  }

  bool close() {
    open_.pop_back();
    names_.pop_back();
    return true;
  }

  JsonValue root_;
  std::vector<JsonValue*> open_;
  std::vector<std::string> names_;  ///< name of the next member, for each open array or object
  std::size_t values_ = 0;
  const char* begin_;
  const char* last_read_;
};

const JsonValue* JsonValue::find(std::string_view name) const {
  const Object* members = object();
  if (members == nullptr) return nullptr;
  const auto found = std::find_if(members->rbegin(), members->rend(), [&](const auto& m) { return m.first == name; });
  return found == members->rend() ? nullptr : &found->second;
}

const char* JsonValue::kind() const {
  constexpr const char* kKinds[] = {"null", "true or false", "a number", "a string", "an array", "an object"};
  return kKinds[value_.index()];
}

JsonValue parse_json(std::string_view text) {
  JsonTreeBuilder builder(text);
  const TrackedText begin(text.data(), builder.last_read()), end(text.data() + text.size(), builder.last_read());
  nlohmann::json::sax_parse(begin, end, &builder);
  return builder.take();
}

LineIndex::LineIndex(std::string_view text) : starts_{0} {
  for (std::size_t at = text.find('\n'); at != std::string_view::npos && starts_.size() < JsonLimits::kMaxLines;
       at = text.find('\n', at + 1))
    starts_.push_back(at + 1);
}

std::pair<int, int> LineIndex::place(std::uint64_t offset) const {
  const auto after = std::upper_bound(starts_.begin(), starts_.end(), offset);
  return {static_cast<int>(after - starts_.begin()), static_cast<int>(offset - *(after - 1) + 1)};
}

}  // namespace etendue
