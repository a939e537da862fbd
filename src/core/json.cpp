#include "core/json.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace etendue {

struct JsonWriter {
  // The same value as the library's.
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

std::string Json::dump(int indent) const {
  return JsonWriter()(*this).dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace etendue
