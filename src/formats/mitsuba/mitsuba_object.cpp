#include "formats/mitsuba/mitsuba_object.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/printable.h"
#include "core/text.h"
#include "formats/mitsuba/named_materials.h"
#include "formats/mitsuba/plugins.h"

namespace etendue {
namespace {

constexpr std::string_view kPropertyTags[] = {"boolean", "integer",  "float", "string", "point",     "vector",
                                              "rgb",     "spectrum", "srgb",  "color",  "blackbody", "transform"};

bool is_property_tag(const XmlElement& element) {
  // <spectrum type="…"> has the form of an object, but stands where a property does.
  return std::ranges::find(kPropertyTags, element.name) != std::end(kPropertyTags);
}

/// The table's row for an element's type; reports an unknown type.
const Plugin* find_row(const XmlElement& element, const MitsubaContext& context, const std::string& substitute) {
  const Dialect& dialect = context.dialect;
  const std::string_view tag = dialect.canonical(element.name);
  if (tag == "scene") return dialect.find("scene", "");
  const XmlAttribute* type = element.find("type");
  if (type == nullptr) {
    context.sink.error(context.document.position(element),
                       fmt::format("<{}> lacks its attribute \"type\"; supported are: {}", element.name,
                                   text::join(dialect.types_of(tag))));
    return nullptr;
  }
  if (const Plugin* plugin = dialect.find(tag, type->value)) return plugin;
  const std::vector<std::string> types = dialect.types_of(tag);
  // A type that resembles no known one is probably from a third-party plugin, not a misspelling.
  if (dialect.is_known_but_unsupported(tag, type->value) || text::did_you_mean(type->value, types).empty()) {
    context.missing.add(fmt::format("{} {}", tag, text::printable(type->value, 60)), context.document.position(element),
                        substitute);
    return nullptr;
  }
  context.sink.error(context.document.value_position(*type),
                     fmt::format("unknown {} type {}{}; supported are: {}", element.name, text::quoted(type->value),
                                 text::did_you_mean(type->value, types), text::join(types)));
  return nullptr;
}

/// Also lists unsupported things within an object that is left out, so that one message names everything.
void list_missing_within(const XmlElement& element, const MitsubaContext& context, int depth = 0) {
  constexpr int kMaxDepth = 32;  // references may form chains
  if (depth == kMaxDepth || !context.missing.looks_into(&element)) return;
  const Dialect& dialect = context.dialect;
  for (const XmlElement& child : element.children) {
    const XmlAttribute* id = child.name == "ref" ? child.find("id") : nullptr;
    const XmlElement* object = id != nullptr ? context.document.find(id->value) : &child;
    if (object == nullptr || is_property_tag(*object)) continue;
    const std::string_view tag = dialect.canonical(object->name);
    const XmlAttribute* type = object->find("type");
    if (dialect.is_unsupported_tag(tag) || (type != nullptr && dialect.is_known_but_unsupported(tag, type->value)))
      context.missing.add(type == nullptr ? std::string(tag) : fmt::format("{} {}", tag, type->value),
                          context.document.position(*object), "left out");
    list_missing_within(*object, context, depth + 1);
  }
}

/// The transform of an animation's earliest time.
const XmlElement* first_transform(const XmlElement& animation) {
  const XmlElement* first = nullptr;
  double earliest = 0.0;
  for (const XmlElement& key : animation.children) {
    double time = 0.0;
    if (const XmlAttribute* given = key.find("time")) text::parse_double(text::trim(given->value), time);
    if (key.name != "transform" || (first != nullptr && time >= earliest)) continue;
    first = &key;
    earliest = time;
  }
  return first;
}

}  // namespace

std::optional<MitsubaObject> MitsubaObject::read(const XmlElement& element, const MitsubaContext& context,
                                                 const std::string& substitute) {
  const Plugin* plugin = find_row(element, context, substitute);
  if (plugin == nullptr) {
    list_missing_within(element, context);
    return std::nullopt;
  }
  MitsubaObject object(*plugin, context.document.position(element), context);
  for (const XmlElement& child : element.children) object.read_child(child);
  for (const Parameter& row : plugin->parameters) {
    if (row.default_text == nullptr && !object.given(row.name))
      context.sink.error(object.position_, fmt::format("{} needs its property \"{}\"; add <{} name=\"{}\" …/>",
                                                       object.heading(), row.name, tag_of(row.type), row.name));
  }
  for (const ChildRule& rule : plugin->children) {
    const std::size_t count = object.children(rule.tag).size();
    if (count < rule.min)
      context.sink.error(object.position_, fmt::format("{} needs a <{}>", object.heading(), rule.tag));
    if (count > rule.max)
      context.sink.error(object.position_, fmt::format("{} has {} <{}>; at most {} is supported", object.heading(),
                                                       count, rule.tag, rule.max));
  }
  return object;
}

MitsubaObject MitsubaObject::defaulted(const char* tag, const char* type, const SourcePosition& parent,
                                       const MitsubaContext& context) {
  return {*context.dialect.find(tag, type), parent, context};
}

std::string MitsubaObject::heading() const {
  return *plugin_->type == '\0' ? fmt::format("<{}>", plugin_->tag)
                                : fmt::format("<{} type=\"{}\">", plugin_->tag, plugin_->type);
}

void MitsubaObject::read_child(const XmlElement& child) {
  const MitsubaDocument& document = context_->document;
  if (!context_->sink.wants_errors()) return;
  if (is_property_tag(child)) return add_property(child, child);
  if (child.name != "ref") return add_object(child, child);
  const XmlAttribute* id = child.find("id");
  if (id == nullptr)
    return context_->sink.error(document.position(child), "<ref> lacks its attribute \"id\"; write <ref id=\"…\"/>");
  if (const XmlElement* object = document.find(id->value)) return add_object(child, *object);
  context_->sink.error(document.value_position(*id),
                       fmt::format("nothing in this scene has the id {}{}", text::quoted(id->value),
                                   text::did_you_mean(id->value, document.ids())));
}

void MitsubaObject::add_property(const XmlElement& child, const XmlElement& element) {
  const MitsubaDocument& document = context_->document;
  const XmlAttribute* name = child.find("name");
  if (name == nullptr)
    return context_->sink.error(document.position(child), fmt::format("<{}> lacks its attribute \"name\"", child.name));
  const std::string word = snake_case(name->value);
  const Parameter* row = plugin_->find(word);
  if (row == nullptr) return report_unknown_property(*name);
  const SourcePosition position = document.position(child);
  if (has_no_effect(*row))
    context_->sink.note(position, fmt::format("\"{}\" of {} {}", row->name, heading(), row->doc));
  if (!properties_.emplace(row->name, Property{&element, position}).second)
    context_->sink.error(position, fmt::format("property \"{}\" of {} is given twice; keep one", row->name, heading()));
}

void MitsubaObject::add_object(const XmlElement& child, const XmlElement& object) {
  const Dialect& dialect = context_->dialect;
  const std::string_view tag = dialect.canonical(object.name);
  const SourcePosition position = context_->document.position(child);
  const XmlAttribute* name = child.find("name");
  if (tag == "animation" && name != nullptr && plugin_->find(snake_case(name->value)) != nullptr) {
    context_->missing.add("animation", position, "still, as at its earliest time");
    const XmlElement* still = first_transform(object);
    return still == nullptr ? void() : add_property(child, *still);
  }
  if (dialect.is_unsupported_tag(tag)) {
    const XmlAttribute* type = object.find("type");
    return context_->missing.add(type == nullptr ? std::string(tag) : fmt::format("{} {}", tag, type->value), position,
                                 "left out");
  }
  if (tag == "texture" || is_property_tag(object)) {
    const bool unnamed = name == nullptr || plugin_->find(snake_case(name->value)) == nullptr;
    if (tag == "texture" && unnamed && plugin_->find_child(tag) != nullptr)  // may have any name
      return children_.emplace_back("texture", &object), void();
    if (name == nullptr) return;
    return add_property(child, object);
  }
  const ChildRule* rule = plugin_->find_child(tag);
  if (rule != nullptr) return children_.emplace_back(rule->tag, &object), void();
  if (!dialect.is_object_tag(tag)) {
    const std::vector<std::string> known = dialect.object_tags();
    return context_->sink.error(position, fmt::format("unknown tag {}{}; known are: {}", text::quoted(object.name),
                                                      text::did_you_mean(object.name, known), text::join(known)));
  }
  context_->sink.error(position, fmt::format("<{}> cannot stand inside {}; it belongs inside {}", object.name,
                                             heading(), dialect.parents_of(tag)));
}

void MitsubaObject::report_unknown_property(const XmlAttribute& name) const {
  if (!context_->strict && !context_->sink.wants_warnings()) return;
  const std::vector<std::string> names = plugin_->parameter_names();
  const std::string known = names.empty() ? "it has none" : "it has: " + text::join(names);
  const std::string message = fmt::format("{} has no property {}{}; {}", heading(), text::quoted(name.value),
                                          text::did_you_mean(snake_case(name.value), names), known);
  const SourcePosition position = context_->document.value_position(name);
  context_->strict ? context_->sink.error(position, message) : context_->sink.warning(position, message + "; ignored");
}

std::vector<const XmlElement*> MitsubaObject::children(std::string_view tag) const {
  std::vector<const XmlElement*> found;
  for (const auto& [of, element] : children_) {
    if (of == tag) found.push_back(element);
  }
  return found;
}

const Parameter& MitsubaObject::row_of(const char* name) const {
  if (const Parameter* row = plugin_->find(name)) return *row;
  throw std::logic_error(fmt::format("{} has no row for {}", heading(), name));
}

const MitsubaObject::Property* MitsubaObject::find(const char* name) const {
  const auto found = properties_.find(name);
  return found == properties_.end() ? nullptr : &found->second;
}

SourcePosition MitsubaObject::position_of(const char* name) const {
  const Property* property = find(name);
  return property == nullptr ? position_ : property->position;
}

std::optional<Value> MitsubaObject::parse(const Parameter& row, ParameterType type, const XmlElement& element,
                                          const char* attribute) const {
  const XmlAttribute* text = element.find(attribute);
  if (text == nullptr) {
    context_->sink.error(context_->document.position(element),
                         fmt::format("<{}> lacks its attribute \"{}\"", element.name, attribute));
    return std::nullopt;
  }
  try {
    return parse_value(type, row.range, text->value);
  } catch (const ValueError& error) {
    context_->sink.error(context_->document.value_position(*text, error.offset),
                         fmt::format("\"{}\" of {}: {}", row.name, heading(), error.message));
    return std::nullopt;
  }
}

Value MitsubaObject::default_of(const Parameter& row, ParameterType type) const {
  const std::string text = row.default_text == nullptr ? "" : row.default_text;
  if (type == ParameterType::string) return text;
  const bool triple = type == ParameterType::point || type == ParameterType::vector || type == ParameterType::color;
  return parse_value(type, {},
                     !text.empty()                    ? text
                     : type == ParameterType::boolean ? "false"
                     : triple                         ? "0 0 0"
                                                      : "0");
}

void MitsubaObject::report_wrong_tag(const Parameter& row, const XmlElement& element,
                                     std::initializer_list<std::string_view> tags) const {
  context_->sink.error(position_of(row.name), fmt::format("property \"{}\" of {} takes <{}>, not <{}>", row.name,
                                                          heading(), fmt::join(tags, "> or <"), element.name));
}

Value MitsubaObject::value(const char* name, ParameterType type, std::initializer_list<std::string_view> tags) const {
  const Parameter& row = row_of(name);
  const Property* property = find(name);
  if (property == nullptr) return default_of(row, type);
  if (std::ranges::find(tags, property->element->name) == tags.end()) {
    report_wrong_tag(row, *property->element, tags);
    return default_of(row, type);
  }
  const std::optional<Value> parsed = parse(row, type, *property->element, "value");
  return parsed ? *parsed : default_of(row, type);
}

double MitsubaObject::real(const char* name) const {
  return std::get<double>(value(name, ParameterType::real, {"float", "integer"}));
}
std::int64_t MitsubaObject::integer(const char* name) const {
  return std::get<std::int64_t>(value(name, ParameterType::integer, {"integer"}));
}
bool MitsubaObject::boolean(const char* name) const {
  return std::get<bool>(value(name, ParameterType::boolean, {"boolean"}));
}
std::vector<double> MitsubaObject::numbers(const char* name) const {
  const std::string list = text(name);
  try {
    std::vector<double> values;
    for (const ListedNumber& number : parse_numbers(list)) {
      if (!row_of(name).range.contains(number.value))
        throw ValueError{0,
                         fmt::format("{} is out of range; allowed is {}", number.value, row_of(name).range.describe())};
      values.push_back(number.value);
    }
    return values;
  } catch (const ValueError& error) {
    context_->sink.error(position_of(name), fmt::format("\"{}\" of {}: {}", name, heading(), error.message));
    return {};
  }
}
std::string MitsubaObject::text(const char* name) const {
  return std::get<std::string>(value(name, ParameterType::string, {"string", "float", "integer"}));
}

glm::dvec3 MitsubaObject::triple(const char* name) const {
  const Property* property = find(name);
  const bool by_axes = property != nullptr &&
                       (property->element->name == "point" || property->element->name == "vector") &&
                       property->element->find("value") == nullptr;
  if (!by_axes) return std::get<glm::dvec3>(value(name, ParameterType::point, {"point", "vector"}));
  glm::dvec3 result(0.0);
  const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    if (property->element->find(axes[i]) == nullptr) continue;
    if (const auto parsed = parse(row_of(name), ParameterType::real, *property->element, axes[i]))
      result[i] = std::get<double>(*parsed);
  }
  return result;
}

MitsubaColor MitsubaObject::color(const char* name, SpectrumUse use) const {
  const Parameter& row = row_of(name);
  const auto fallback = [&] { return MitsubaColor{std::get<glm::dvec3>(default_of(row, ParameterType::color))}; };
  const Property* property = find(name);
  if (property == nullptr) return fallback();
  if (property->element->name == "texture") return {glm::dvec3(0.0), property->element};
  try {
    const glm::dvec3 color = read_color(*property->element, use, *context_);
    for (int i = 0; i < 3; ++i) {
      if (!row.range.contains(color[i]))
        throw ValueError{property->element->offset,
                         fmt::format("{} is out of range; allowed is {}", color[i], row.range.describe())};
    }
    return {color};
  } catch (const ValueError& error) {
    context_->sink.error(context_->document.position(error.offset),
                         fmt::format("\"{}\" of {}: {}", row.name, heading(), error.message));
    return fallback();
  }
}

const XmlElement* MitsubaObject::texture(const char* name) const {
  const Property* property = find(row_of(name).name);
  return property != nullptr && property->element->name == "texture" ? property->element : nullptr;
}

glm::dmat4 MitsubaObject::matrix(const char* name, RotationAxes axes) const {
  const Parameter& row = row_of(name);
  const Property* property = find(name);
  if (property == nullptr) return glm::dmat4(1.0);
  if (property->element->name == "transform") return read_mitsuba_transform(*property->element, *context_, axes);
  report_wrong_tag(row, *property->element, {"transform"});
  return glm::dmat4(1.0);
}

glm::dmat3 MitsubaObject::uv_matrix(const char* name) const {
  const Parameter& row = row_of(name);
  const Property* property = find(name);
  if (property == nullptr) return glm::dmat3(1.0);
  if (property->element->name == "transform") return read_mitsuba_uv_transform(*property->element, *context_);
  report_wrong_tag(row, *property->element, {"transform"});
  return glm::dmat3(1.0);
}

double MitsubaObject::ior(const char* name) const {
  const Property* property = find(name);
  const Parameter& row = row_of(name);
  if (property != nullptr && property->element->name != "string") return real(name);
  const std::string word = property == nullptr ? row.default_text : text(name);
  if (const auto known = named_ior(word)) return *known;
  context_->sink.error(position_of(name),
                       fmt::format("{} is not a material with a known index of refraction{}; known are: {}",
                                   text::quoted(word), text::did_you_mean(word, ior_names()), text::join(ior_names())));
  return 1.0;
}

const XmlAttribute& required(const XmlElement& element, const char* attribute) {
  if (const XmlAttribute* found = element.find(attribute)) return *found;
  throw ValueError{element.offset, fmt::format("<{}> lacks its attribute \"{}\"", element.name, attribute)};
}

}  // namespace etendue
