#include "core/json.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/printable.h"

namespace etendue {

struct JsonWriter {
  int indent;
  std::string out = {};
  int depth = 0;

  void operator()(const Json& json) { std::visit(*this, json.value_); }
  void operator()(std::monostate) { out += "null"; }
  void operator()(bool value) { out += value ? "true" : "false"; }
  void operator()(std::int64_t value) { out += fmt::format("{}", value); }
  void operator()(std::uint64_t value) { out += fmt::format("{}", value); }
  void operator()(double value);
  void operator()(const std::string& text);
  void operator()(const Json::Array& array) {
    list(array, "[]", [&](const Json& element) { (*this)(element); });
  }
  void operator()(const Json::Object& object) {
    list(object, "{}", [&](const auto& member) {
      (*this)(member.first);
      out += indent < 0 ? ":" : ": ";
      (*this)(member.second);
    });
  }
  template <class List, class Write>
  void list(const List& elements, const char* brackets, const Write& write) {
    out += brackets[0];
    ++depth;
    const char* comma = "";
    for (const auto& element : elements) {
      out += comma;
      new_line();
      write(element);
      comma = ",";
    }
    --depth;
    if (!elements.empty()) new_line();
    out += brackets[1];
  }
  void new_line() {
    if (indent >= 0) out += "\n" + std::string(static_cast<std::size_t>(indent * depth), ' ');
  }

  // {"name", value}: what an object is made of.
  static bool is_member(const Json& json) {
    const auto* pair = std::get_if<Json::Array>(&json.value_);
    return pair != nullptr && pair->size() == 2 && std::holds_alternative<std::string>(pair->front().value_);
  }
};

Json::Json(std::initializer_list<Json> list) {
  if (!std::ranges::all_of(list, JsonWriter::is_member)) {
    value_ = Array(list);
    return;
  }
  Object object;
  for (const Json& element : list) {
    const auto& pair = std::get<Array>(element.value_);
    object.insert_or_assign(std::get<std::string>(pair.front().value_), pair.back());
  }
  value_ = std::move(object);
}

bool Json::contains(std::string_view name) const {
  const auto* object = std::get_if<Object>(&value_);
  return object != nullptr && object->contains(name);
}

Json& Json::operator[](std::string_view name) {
  if (is_null()) value_ = Object();
  return std::get<Object>(value_)[std::string(name)];
}

void Json::push_back(Json element) {
  if (is_null()) value_ = Array();
  std::get<Array>(value_).push_back(std::move(element));
}

// As short as reads back the same; with a point or an exponent, so that readers take it for no integer.
void JsonWriter::operator()(double value) {
  if (!std::isfinite(value)) return (*this)(std::monostate());
  const std::string text = fmt::format("{}", value);
  out += text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

namespace {

/// The character of 1 to 3 bytes at `s[i]`, as \\uXXXX.
std::string escaped(const std::string& s, std::size_t i, std::size_t length) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned>(static_cast<unsigned char>(s[i + k])); };
  const unsigned code = length == 1   ? byte(0)
                        : length == 2 ? (byte(0) & 0x1f) << 6 | (byte(1) & 0x3f)
                                      : (byte(0) & 0x0f) << 12 | (byte(1) & 0x3f) << 6 | (byte(2) & 0x3f);
  static constexpr std::string_view kShort = "\b\f\n\r\t", kLetters = "bfnrt";
  if (const std::size_t at = code < 0x20 ? kShort.find(static_cast<char>(code)) : kShort.npos; at != kShort.npos)
    return std::string("\\") + kLetters[at];
  return fmt::format("\\u{:04x}", code);
}

}  // namespace

// What a terminal obeys is escaped, too: DEL, C1 and the controls of bidirectional text.
void JsonWriter::operator()(const std::string& text) {
  out += '"';
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t valid = text::utf8_length(text, i), length = std::max<std::size_t>(valid, 1);
    if (valid == 0) {
      out += "\ufffd";
    } else if (text::is_control(text, i, length)) {
      out += escaped(text, i, length);
    } else {
      if (text[i] == '"' || text[i] == '\\') out += '\\';
      out.append(text, i, length);
    }
    i += length;
  }
  out += '"';
}

std::string Json::dump(int indent) const {
  JsonWriter writer{indent};
  writer(*this);
  return std::move(writer.out);
}

}  // namespace etendue
