#include "core/json.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/printable.h"

namespace etendue {

struct JsonWriter {
  // The same value as an object of the library.
  nlohmann::json operator()(const Json& json) const { return std::visit(*this, json.value_); }
  nlohmann::json operator()(std::monostate) const { return nullptr; }
  nlohmann::json operator()(const Json::Array& array) const {
    nlohmann::json out = nlohmann::json::array();
    for (const Json& element : array) out.push_back((*this)(element));
    return out;
  }
  nlohmann::json operator()(const Json::Object& object) const {
    nlohmann::json out = nlohmann::json::object();
    for (const auto& [name, member] : object) out[name] = (*this)(member);
    return out;
  }
  template <class Plain>
  nlohmann::json operator()(const Plain& plain) const {
    return plain;
  }

  // {"name", value}: a member of an object.
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

namespace {

/// The character of 1 to 3 bytes at `s[i]`, as \\uXXXX.
std::string escaped(const std::string& s, std::size_t i, std::size_t length) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned>(static_cast<unsigned char>(s[i + k])); };
  const unsigned code = length == 1   ? byte(0)
                        : length == 2 ? (byte(0) & 0x1f) << 6 | (byte(1) & 0x3f)
                                      : (byte(0) & 0x0f) << 12 | (byte(1) & 0x3f) << 6 | (byte(2) & 0x3f);
  return fmt::format("\\u{:04x}", code);
}

/// Escapes characters that the library leaves alone but terminals obey: DEL, C1 and the controls of bidirectional text.
/// They can occur only inside strings, so the value does not change.
std::string without_controls(const std::string& json) {
  std::string out;
  out.reserve(json.size());
  for (std::size_t i = 0; i < json.size();) {
    const std::size_t length = std::max<std::size_t>(text::utf8_length(json, i), 1);
    if (json[i] != '\n' && text::is_control(json, i, length)) {
      out += escaped(json, i, length);
    } else {
      out.append(json, i, length);
    }
    i += length;
  }
  return out;
}

}  // namespace

std::string Json::dump(int indent) const {
  return without_controls(JsonWriter()(*this).dump(indent, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace etendue
