#include "formats/nori/object.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

/// Tags of which a scene has one at most, so that -D can name them.
bool is_overridable(std::string_view tag) {
  static constexpr std::string_view kTags[] = {"scene", "integrator", "camera", "sampler", "rfilter", "test"};
  return std::find(std::begin(kTags), std::end(kTags), tag) != std::end(kTags);
}

bool contains(const std::vector<std::string>& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// The row for an element's type; reports what is wrong with it.
const Plugin* find_row(const XmlElement& element, ReadContext& context) {
  if (element.name == "scene") {
    check_attributes(element, {}, context);
    return find_plugin("scene", "");
  }
  const XmlAttribute* type = element.find("type");
  check_attributes(element, {"type"}, context);
  if (type == nullptr) return nullptr;
  if (const Plugin* plugin = find_plugin(element.name, type->value)) return plugin;
  const std::vector<std::string> types = plugin_types(element.name);
  const SourcePosition position = value_position(*type, 0, context);
  if (is_known_but_unsupported(element.name, type->value)) {
    context.diagnostics.error(position, fmt::format("{} type {} is not supported; supported are: {}", element.name,
                                                    text::quoted(type->value), text::join(types)));
  } else {
    context.diagnostics.error(
        position, fmt::format("unknown {} type {}{}; supported are: {}", element.name, text::quoted(type->value),
                              text::did_you_mean(type->value, types), text::join(types)));
  }
  return nullptr;
}

}  // namespace

SourcePosition value_position(const XmlAttribute& attribute, std::size_t offset, const ReadContext& context) {
  return context.document.position(attribute.value_offset + (attribute.verbatim ? offset : 0));
}

bool check_attributes(const XmlElement& element, const std::vector<std::string>& names, ReadContext& context) {
  bool good = true;
  for (const XmlAttribute& attribute : element.attributes) {
    if (contains(names, attribute.name)) continue;
    good = false;
    const std::string expected = names.empty() ? "none" : text::join(names);
    context.diagnostics.error(
        context.document.position(attribute.offset),
        fmt::format("<{}> has no attribute {}{}; it takes: {}", element.name, text::quoted(attribute.name),
                    text::did_you_mean(attribute.name, names), expected));
  }
  for (const std::string& name : names) {
    if (element.find(name) != nullptr) continue;
    good = false;
    context.diagnostics.error(
        context.document.position(element.offset),
        fmt::format("<{}> lacks its attribute \"{}\"; it takes: {}", element.name, name, text::join(names)));
  }
  return good;
}

std::optional<Object> Object::read(const XmlElement& element, ReadContext& context) {
  const Plugin* plugin = find_row(element, context);
  if (plugin == nullptr) return std::nullopt;
  Object object(*plugin, context.document.position(element.offset));
  for (const XmlElement& child : element.children) object.read_child(child, context);
  object.apply_overrides(context);
  object.check_complete(context);
  return object;
}

Object Object::defaulted(const char* tag, const char* type, const SourcePosition& parent, ReadContext& context) {
  Object object(*find_plugin(tag, type), parent);
  object.apply_overrides(context);
  return object;
}

std::string Object::heading() const {
  return *plugin_->type == '\0' ? fmt::format("<{}>", plugin_->tag)
                                : fmt::format("<{} type=\"{}\">", plugin_->tag, plugin_->type);
}

void Object::read_child(const XmlElement& child, ReadContext& context) {
  if (!context.diagnostics.wants_errors()) return;  // the file is refused anyhow, and nobody reads the rest
  static const std::vector<std::string> kOperations = {"translate", "scale", "rotate", "matrix", "lookat"};
  if (contains(property_tags(), child.name)) {
    read_property(child, context);
  } else if (contains(object_tags(), child.name)) {
    read_object_child(child, context);
  } else {
    const SourcePosition position = context.document.position(child.offset);
    if (is_unsupported_tag(child.name)) {
      context.diagnostics.error(position, fmt::format("<{}> is not supported; remove it", child.name));
    } else if (contains(kOperations, child.name)) {
      context.diagnostics.error(
          position,
          fmt::format("<{}> stands outside a <transform>; put it into <transform name=\"toWorld\">", child.name));
    } else {
      std::vector<std::string> known = property_tags();
      known.insert(known.end(), object_tags().begin(), object_tags().end());
      context.diagnostics.error(position, fmt::format("unknown tag {}{}; known are: {}", text::quoted(child.name),
                                                      text::did_you_mean(child.name, known), text::join(known)));
    }
  }
}

void Object::read_object_child(const XmlElement& child, ReadContext& context) {
  const SourcePosition position = context.document.position(child.offset);
  const ChildRule* rule = plugin_->find_child(child.name);
  if (rule == nullptr) {
    const std::string parents = parents_of(child.name);
    const std::string remedy = parents.empty() ? "it is the root of a file" : "it belongs inside " + parents;
    context.diagnostics.error(position, fmt::format("<{}> cannot stand inside {}; {}", child.name, heading(), remedy));
    return;
  }
  if (++child_counts_[child.name] > rule->max) {
    context.diagnostics.error(position, fmt::format("{} has more than one <{}>; keep one", heading(), child.name));
    return;
  }
  children_.push_back(&child);
}

void Object::read_property(const XmlElement& element, ReadContext& context) {
  const bool is_transform = element.name == "transform";
  const std::vector<std::string> attributes =
      is_transform ? std::vector<std::string>{"name"} : std::vector<std::string>{"name", "value"};
  const bool well_formed = check_attributes(element, attributes, context);
  const XmlAttribute* name = element.find("name");
  if (!is_transform && !element.children.empty()) {
    context.diagnostics.error(
        context.document.position(element.children.front().offset),
        fmt::format("<{}> cannot hold elements; write it as <{} name=\"…\" value=\"…\"/>", element.name, element.name));
  }
  if (name == nullptr) return;
  const Parameter* parameter = plugin_->find(name->value);
  if (parameter == nullptr) {
    if (!context.strict && !context.diagnostics.wants_warnings()) return;
    const std::vector<std::string> names = plugin_->parameter_names();
    const std::string known = names.empty() ? "it has none" : "it has: " + text::join(names);
    const std::string message = fmt::format("{} has no property {}{}; {}", heading(), text::quoted(name->value),
                                            text::did_you_mean(name->value, names), known);
    const SourcePosition position = value_position(*name, 0, context);
    context.strict ? context.diagnostics.error(position, message)
                   : context.diagnostics.warning(position, message + "; ignored");
    return;
  }
  if (!seen_.insert(parameter->name).second) {
    context.diagnostics.error(
        context.document.position(element.offset),
        fmt::format("property \"{}\" of {} is given twice; keep one", parameter->name, heading()));
    return;
  }
  if (element.name != tag_of(parameter->type)) {
    context.diagnostics.error(
        context.document.position(element.offset),
        fmt::format("property \"{}\" of {} is of type {}, not {}; write <{} name=\"{}\" …>", parameter->name, heading(),
                    tag_of(parameter->type), element.name, tag_of(parameter->type), parameter->name));
    return;
  }
  if (is_transform) {
    transforms_[parameter->name] = read_transform(element, context);
    given_[parameter->name] = {Value{}, context.document.position(element.offset)};
  } else if (well_formed) {
    read_value(*parameter, element, context);
  }
}

void Object::read_value(const Parameter& parameter, const XmlElement& element, ReadContext& context) {
  const XmlAttribute& value = *element.find("value");
  try {
    given_[parameter.name] = {parse_value(parameter, value.value), value_position(value, 0, context)};
  } catch (const ValueError& error) {
    given_.erase(parameter.name);
    context.diagnostics.error(value_position(value, error.offset, context),
                              fmt::format("\"{}\" of {}: {}", parameter.name, heading(), error.message));
  }
}

void Object::apply_overrides(ReadContext& context) {
  if (!is_overridable(plugin_->tag)) return;
  for (const Parameter& parameter : plugin_->parameters) {
    if (parameter.type == ParameterType::transform) continue;
    const std::string path = fmt::format("{}.{}", plugin_->tag, parameter.name);
    context.overridable.insert(path);
    for (std::size_t i = 0; i < context.overrides.size(); ++i) {
      const auto& [wanted, value] = context.overrides[i];
      if (wanted != path) continue;
      context.override_matched[i] = true;
      const SourcePosition position{fmt::format("-D {}={}", path, value), 0, 0};
      try {
        given_[parameter.name] = {parse_value(parameter, value), position};
        seen_.insert(parameter.name);
      } catch (const ValueError& error) {
        context.diagnostics.error(position, error.message, ErrorKind::usage);
      }
    }
  }
}

void Object::check_complete(ReadContext& context) const {
  for (const Parameter& parameter : plugin_->parameters) {
    if (parameter.default_text != nullptr || seen_.contains(parameter.name)) continue;
    context.diagnostics.error(position_, fmt::format("{} needs its property \"{}\"; add <{} name=\"{}\" …/>", heading(),
                                                     parameter.name, tag_of(parameter.type), parameter.name));
  }
  for (const ChildRule& rule : plugin_->children) {
    if (children(rule.tag).size() >= rule.min) continue;
    context.diagnostics.error(position_, fmt::format("{} needs a <{}>; supported types are: {}", heading(), rule.tag,
                                                     text::join(plugin_types(rule.tag))));
  }
}

std::vector<const XmlElement*> Object::children(std::string_view tag) const {
  std::vector<const XmlElement*> found;
  for (const XmlElement* child : children_) {
    if (child->name == tag) found.push_back(child);
  }
  return found;
}

SourcePosition Object::position_of(const char* name) const {
  const auto found = given_.find(name);
  return found == given_.end() ? position_ : found->second.position;
}

Value Object::get_value(const char* name) const {
  const Parameter* parameter = plugin_->find(name);
  if (parameter == nullptr) throw std::logic_error(fmt::format("{} has no row for {}", heading(), name));
  const auto found = given_.find(name);
  if (found != given_.end()) return found->second.value;
  // A required property that is missing was reported; a stand-in lets reading go on and find the next problem.
  if (parameter->type == ParameterType::number_list) return std::vector<double>{};
  if (parameter->type == ParameterType::string)
    return std::string(parameter->default_text == nullptr ? "" : parameter->default_text);
  return parse_value(*parameter, parameter->default_text == nullptr ? "0 0 0" : parameter->default_text);
}

glm::dmat4 Object::matrix(const char* name) const {
  const auto found = transforms_.find(name);
  return found == transforms_.end() ? glm::dmat4(1.0) : found->second;
}

void Object::throw_wrong_type(const char* name) {
  throw std::logic_error(fmt::format("property {} has another type", name));
}

}  // namespace etendue
