#include "formats/dialect/object.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "core/printable.h"
#include "core/text.h"

namespace etendue {
namespace {

/// Tags that occur at most once in a scene, so that -D can name them.
bool is_overridable(std::string_view tag) {
  static constexpr std::string_view kTags[] = {"scene", "integrator", "camera", "sampler", "rfilter", "test"};
  return std::find(std::begin(kTags), std::end(kTags), tag) != std::end(kTags);
}

bool contains(const std::vector<std::string>& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Attributes of an object that may be left out.
std::vector<std::string> optional_attributes(std::string_view tag, const Dialect& dialect) {
  if (dialect.forgiving || dialect.can_be_named(tag)) return {"id", "name"};
  return {"id"};
}

/// The row for an element's type; reports what is wrong with it.
/// The type that -D gives the objects of a tag, "-D integrator.type=ao"; nullptr if it gives none.
const std::pair<std::string, std::string>* find_type_override(std::string_view tag, ReadContext& context) {
  if (!is_overridable(tag) || context.dialect.find(tag, "") != nullptr) return nullptr;
  const std::string path = fmt::format("{}.type", tag);
  context.overridable.insert(path);
  const std::pair<std::string, std::string>* last = nullptr;
  for (std::size_t i = 0; i < context.overrides.size(); ++i) {
    if (context.overrides[i].first != path) continue;
    context.override_matched[i] = true;
    last = &context.overrides[i];
  }
  return last;
}

/// The row of a type given by -D; reports unknown types.
const Plugin* find_overriding_row(std::string_view tag, const std::pair<std::string, std::string>& type,
                                  ReadContext& context) {
  if (const Plugin* plugin = context.dialect.find(tag, type.second)) return plugin;
  const std::vector<std::string> types = context.dialect.types_of(tag);
  context.diagnostics.error({fmt::format("-D {}={}", type.first, type.second), 0, 0},
                            fmt::format("unknown {} type {}{}; supported are: {}", tag, text::quoted(type.second),
                                        text::did_you_mean(type.second, types), text::join(types)),
                            ErrorKind::usage);
  return nullptr;
}

/// "medium homogeneous": what a file calls a thing that is not supported.
std::string feature_name(const XmlElement& element) {
  const XmlAttribute* type = element.find("type");
  return type == nullptr ? element.name : fmt::format("{} {}", element.name, type->value);
}

/// Names what an element that is passed over holds and what is not supported, either.
void collect_lacking(const XmlElement& parent, ReadContext& context) {
  const Dialect& dialect = context.dialect;
  for (const XmlElement& child : parent.children) {
    const std::string_view tag = dialect.canonical(child.name);
    const XmlAttribute* type = child.find("type");
    const bool is_object = dialect.is_object_tag(tag) && type != nullptr;
    if (dialect.is_unsupported_tag(child.name) || (is_object && dialect.find(tag, type->value) == nullptr))
      context.lacking.emplace_back(feature_name(child), context.document.position(child.offset));
    collect_lacking(child, context);
  }
}

const Plugin* find_row(const XmlElement& element, ReadContext& context) {
  const Dialect& dialect = context.dialect;
  const std::string_view tag = dialect.canonical(element.name);
  if (const Plugin* only = dialect.find(tag, "")) {  // the tag has only one type, which need not be named
    const bool may_have_version = dialect.forgiving && tag == "scene";
    check_attributes(element, {}, context,
                     may_have_version ? std::vector<std::string>{"version"} : std::vector<std::string>{});
    return only;
  }
  const XmlAttribute* type = element.find("type");
  check_attributes(element, {"type"}, context, optional_attributes(tag, dialect));
  if (type == nullptr) return nullptr;
  if (const auto* other = find_type_override(tag, context)) return find_overriding_row(tag, *other, context);
  if (const Plugin* plugin = dialect.find(tag, type->value)) return plugin;
  const std::vector<std::string> types = dialect.types_of(tag);
  const SourcePosition position = value_position(*type, 0, context);
  // A typo is not a missing feature.
  if (dialect.is_known_but_unsupported(tag, type->value) || text::did_you_mean(type->value, types).empty())
    context.lacking.emplace_back(fmt::format("{} {}", tag, type->value), position);
  if (dialect.is_known_but_unsupported(tag, type->value)) {
    context.diagnostics.error(position, fmt::format("{} type {} is not supported; supported are: {}", element.name,
                                                    text::quoted(type->value), text::join(types)));
  } else {
    context.diagnostics.error(
        position, fmt::format("unknown {} type {}{}; supported are: {}", element.name, text::quoted(type->value),
                              text::did_you_mean(type->value, types), text::join(types)));
  }
  collect_lacking(element, context);
  return nullptr;
}

/// Whether a property says that its effect is off: false, or nothing but zeros.
bool is_off(const XmlElement& element) {
  const XmlAttribute* value = element.find("value");
  if (value == nullptr) return false;
  const std::string_view word = text::trim(value->value);
  if (element.name == "boolean") return word == "false" || word == "False" || word == "FALSE";
  return element.name != "string" && word.find_first_not_of("0., \t\r\n") == std::string_view::npos;
}

/// "<color> or <texture>": the tags that can give a property.
std::string tags_of(const Parameter& parameter) {
  if (parameter.type == ParameterType::object) return fmt::format("<{}>", parameter.child);
  const std::string value = fmt::format("<{}>", tag_of(parameter.type));
  return *parameter.child == '\0' ? value : fmt::format("{} or <{}>", value, parameter.child);
}

/// Whether a value under another tag fits the type: 3 is a number of any type, (1, 2, 3) a point or a vector, and a
/// single number a grey.
bool says_the_same(std::string_view tag, ParameterType type) {
  using enum ParameterType;
  const bool number = tag == "integer" || tag == "float", triple = tag == "point" || tag == "vector";
  if (type == integer || type == real || type == color) return number;
  return triple && (type == point || type == vector || type == point2 || type == vector2);
}

}  // namespace

SourcePosition value_position(const XmlAttribute& attribute, std::size_t offset, const ReadContext& context) {
  return context.document.position(attribute.value_offset + (attribute.verbatim ? offset : 0));
}

bool check_attributes(const XmlElement& element, const std::vector<std::string>& names, ReadContext& context,
                      const std::vector<std::string>& optional) {
  bool good = true;
  std::vector<std::string> all = names;
  all.insert(all.end(), optional.begin(), optional.end());
  for (const XmlAttribute& attribute : element.attributes) {
    if (contains(all, attribute.name)) continue;
    good = false;
    const std::string expected = all.empty() ? "none" : text::join(all);
    context.diagnostics.error(
        context.document.position(attribute.offset),
        fmt::format("<{}> has no attribute {}{}; it takes: {}", element.name, text::quoted(attribute.name),
                    text::did_you_mean(attribute.name, all), expected));
  }
  for (const std::string& name : names) {
    if (element.find(name) != nullptr) continue;
    good = false;
    context.diagnostics.error(
        context.document.position(element.offset),
        fmt::format("<{}> lacks its attribute \"{}\"; it takes: {}", element.name, name, text::join(all)));
  }
  return good;
}

void ReadContext::approximated(const std::string& what, const std::string& substitute, const SourcePosition& position) {
  diagnostics.warning(position, fmt::format("{} is approximated: {}", text::printable(what, 60), substitute));
  const std::string line = fmt::format("{}: {}", text::printable(what, 60), substitute);
  if (!contains(approximations, line)) approximations.push_back(line);
}

void report_lacking(const ReadContext& context) {
  constexpr std::size_t kMostPlaces = 5, kMostFeatures = 30;
  std::map<std::string, std::vector<SourcePosition>> features;
  for (const auto& [what, place] : context.lacking) features[what].push_back(place);
  if (features.size() < 2) return;
  std::string list;
  std::size_t listed = 0;
  for (const auto& [what, places] : features) {
    if (listed++ == kMostFeatures) {
      list += fmt::format("; and {} more", features.size() - kMostFeatures);
      break;
    }
    list += (list.empty() ? "" : "; ") + text::printable(what, 60) + " (";
    for (std::size_t i = 0; i < std::min(places.size(), kMostPlaces); ++i)
      list += (i > 0 ? ", " : "") + fmt::format("{}:{}", places[i].line, places[i].column);
    if (places.size() > kMostPlaces) list += fmt::format(" and {} more", places.size() - kMostPlaces);
    list += ")";
  }
  const SourcePosition& first = context.lacking.front().second;
  context.diagnostics.error_first({first.file, 0, 0},
                                  fmt::format("the scene needs things that are not supported: {}", list));
}

std::optional<Object> Object::read(const XmlElement& element, ReadContext& context) {
  const Plugin* plugin = find_row(element, context);
  if (plugin == nullptr) return std::nullopt;
  Object object(*plugin, element.name, context.document.position(element.offset));
  const XmlAttribute* type = element.find("type");
  object.retyped_ = type != nullptr && context.dialect.canonical_type(plugin->tag, type->value) != plugin->type;
  if (object.retyped_) object.in_file_ = context.dialect.find(plugin->tag, type->value);
  for (const XmlElement& child : element.children) object.read_child(child, context);
  object.apply_overrides(context);
  object.check_complete(context);
  return object;
}

Object Object::defaulted(const char* tag, const char* type, const SourcePosition& parent, ReadContext& context) {
  const Plugin* plugin = context.dialect.find(tag, type);
  if (const auto* other = find_type_override(tag, context)) {
    if (const Plugin* row = find_overriding_row(tag, *other, context)) plugin = row;
  }
  Object object(*plugin, tag, parent);
  object.apply_overrides(context);
  return object;
}

std::string Object::heading() const {
  return *plugin_->type == '\0' ? fmt::format("<{}>", tag_) : fmt::format("<{} type=\"{}\">", tag_, plugin_->type);
}

void Object::read_child(const XmlElement& child, ReadContext& context) {
  if (!context.diagnostics.wants_errors()) return;  // the file is refused anyway, and nobody reads further errors
  if (contains(property_tags(), child.name)) {
    read_property(child, context);
  } else if (child.name == "ref") {
    read_reference(child, context);
  } else if (context.dialect.is_object_tag(context.dialect.canonical(child.name))) {
    add_child(child, child, context);
  } else {
    report_unknown_tag(child, context);
  }
}

void Object::report_unknown_tag(const XmlElement& child, ReadContext& context) const {
  static const std::vector<std::string> kOperations = {"translate", "scale", "rotate", "matrix", "lookat"};
  const SourcePosition position = context.document.position(child.offset);
  for (const IgnoredTag& ignored : context.dialect.ignored_tags) {
    if (ignored.tag != child.name) continue;
    const std::string message = fmt::format("<{}> is ignored: {}", child.name, ignored.why);
    ignored.changes_picture ? context.diagnostics.warning(position, message)
                            : context.diagnostics.note(position, message);
    return;
  }
  if (context.dialect.is_unsupported_tag(child.name)) {
    if (context.approximate) return context.approximated(child.name, "left out", position);
    context.lacking.emplace_back(feature_name(child), position);
    context.diagnostics.error(position, fmt::format("<{}> is not supported; remove it", child.name));
    collect_lacking(child, context);
  } else if (contains(kOperations, child.name)) {
    context.diagnostics.error(
        position, fmt::format("<{}> is outside a <transform>; put it into <transform name=\"toWorld\">", child.name));
  } else {
    std::vector<std::string> known = property_tags();
    const std::vector<std::string> objects = context.dialect.object_tags();
    known.insert(known.end(), objects.begin(), objects.end());
    known.emplace_back("ref");
    if (child.find("type") != nullptr && text::did_you_mean(child.name, known).empty()) {
      context.lacking.emplace_back(feature_name(child), position);
      collect_lacking(child, context);
    }
    context.diagnostics.error(position, fmt::format("unknown tag {}{}; known are: {}", text::quoted(child.name),
                                                    text::did_you_mean(child.name, known), text::join(known)));
  }
}

void Object::read_reference(const XmlElement& ref, ReadContext& context) {
  if (!check_attributes(ref, {"id"}, context, {"name"})) return;
  if (!ref.children.empty()) {
    context.diagnostics.error(context.document.position(ref.children.front().offset),
                              "<ref> cannot hold elements; write it as <ref id=\"…\"/>");
  }
  const XmlAttribute& id = *ref.find("id");
  if (const XmlElement* object = context.references.find(id.value)) return add_child(ref, *object, context);
  context.diagnostics.error(value_position(id, 0, context),
                            fmt::format("nothing in this file has the id {}{}", text::quoted(id.value),
                                        context.references.suggest(id.value)));
}

/// The property that an object without a name is meant for: its type or id may say so, as "normal_map" does.
const Parameter* Object::meant_parameter(const XmlElement& object, const ReadContext& context) const {
  const Dialect& dialect = context.dialect;
  const std::string_view tag = dialect.canonical(object.name);
  const Parameter* chief = dialect.chief_parameter(*plugin_, tag);
  if (chief == nullptr) return nullptr;
  std::vector<std::string_view> words;
  for (const XmlElement& child : object.children) {
    const XmlAttribute *name = child.find("name"), *value = child.find("value");
    if (name != nullptr && name->value == "id" && value != nullptr) words.emplace_back(value->value);
  }
  if (const XmlAttribute* type = object.find("type")) words.emplace_back(type->value);
  for (const std::string_view word : words) {
    const Parameter* meant = dialect.find_parameter(*plugin_, word, tag);
    if (meant != nullptr && meant->child == tag) return meant;
  }
  return chief;
}

void Object::add_child(const XmlElement& child, const XmlElement& object, ReadContext& context) {
  const std::string_view tag = context.dialect.canonical(object.name);
  const bool is_reference = &child != &object;
  const bool may_be_named = is_reference || context.dialect.can_be_named(tag);
  if (may_be_named && child.find("name") != nullptr) return add_named_child(child, object, context);
  const ChildRule* rule = plugin_->find_child(tag);
  if (rule == nullptr && retyped_ && (in_file_ == nullptr || in_file_->find_child(tag) != nullptr)) return;
  if (rule == nullptr) {
    if (const Parameter* chief = meant_parameter(object, context)) {
      context.diagnostics.note(context.document.position(child.offset),
                               fmt::format("the <{}> without a name is read as \"{}\"", object.name, chief->name));
      return set_unnamed_picture(*chief, child, object, context);
    }
  }
  if (rule == nullptr || (is_reference && rule->use != ChildUse::element_or_reference))
    return report_misplaced(child, object.name, context);
  const SourcePosition position = context.document.position(child.offset);
  if (rule->use == ChildUse::definition && child.find("id") == nullptr) {
    context.diagnostics.error(
        position, fmt::format("<{}> inside {} needs an id, or nothing can use it; it belongs inside {}", child.name,
                              heading(), context.dialect.parents_of(tag)));
    return;
  }
  if (++child_counts_[rule->tag] > rule->max) {
    context.diagnostics.error(position, fmt::format("{} has more than one <{}>; keep one", heading(), object.name));
    return;
  }
  children_.emplace_back(rule->tag, &object);
}

/// `tag` is that of the object as the file writes it.
void Object::report_misplaced(const XmlElement& child, std::string_view tag, ReadContext& context) const {
  const SourcePosition position = context.document.position(child.offset);
  const std::string_view canonical = context.dialect.canonical(tag);
  std::vector<std::string> properties;
  for (const Parameter& parameter : plugin_->parameters) {
    if (parameter.child == canonical) properties.push_back(text::quoted(parameter.name));
  }
  const std::string what =
      child.name == "ref" ? fmt::format("<ref id={}/>, which is a <{}>,", text::quoted(child.find("id")->value), tag)
                          : fmt::format("<{}>", tag);
  if (!properties.empty()) {
    context.diagnostics.error(position, fmt::format("{} inside {} needs the name of a property: {}", what, heading(),
                                                    text::join(properties)));
    return;
  }
  const std::string parents = context.dialect.parents_of(canonical), owners = context.dialect.owners_of(canonical);
  const std::string remedy =
      !parents.empty()  ? "it belongs inside " + parents
      : !owners.empty() ? fmt::format("it gives a property of {}, as <{} name=\"…\" type=\"…\">", owners, canonical)
                        : "it is the root of a file";
  if (parents.empty() && !owners.empty()) {
    const std::string feature = fmt::format("{} in {}", tag, tag_);
    if (context.approximate) return context.approximated(feature, "left out", position);
    context.lacking.emplace_back(feature, position);
  }
  context.diagnostics.error(position, fmt::format("{} cannot stand inside {}; {}", what, heading(), remedy));
}

void Object::add_named_child(const XmlElement& child, const XmlElement& object, ReadContext& context) {
  const XmlAttribute& name = *child.find("name");
  const Parameter* parameter =
      context.dialect.find_parameter(*plugin_, name.value, context.dialect.canonical(object.name));
  if (parameter == nullptr) return report_unknown_property(child, context);
  // "roughnessMap" may stand beside a roughness.
  const bool other_word = !context.dialect.is_name_of(*parameter, name.value);
  if (context.dialect.forgiving && other_word && parameter->type != ParameterType::object)
    return set_unnamed_picture(*parameter, child, object, context);
  set_named_child(*parameter, child, object, context);
}

void Object::set_named_child(const Parameter& parameter, const XmlElement& child, const XmlElement& object,
                             ReadContext& context) {
  if (is_given_twice(parameter, child, context)) return;
  const SourcePosition position = context.document.position(child.offset);
  if (parameter.child != context.dialect.canonical(object.name)) {
    const bool is_reference = &child != &object;
    context.diagnostics.error(
        position, fmt::format("property \"{}\" of {} takes {}, {} <{}>", parameter.name, heading(), tags_of(parameter),
                              is_reference ? "but this refers to a" : "not", object.name));
    return;
  }
  named_children_[parameter.name] = &object;
  given_[parameter.name] = {Value{}, position};
}

/// Whether other renderers have the property, and what it means is known; if so, reports it.
bool Object::is_known_elsewhere(const XmlElement& element, ReadContext& context) const {
  const XmlAttribute& name = *element.find("name");
  const SourcePosition position = value_position(name, 0, context);
  if (const IgnoredProperties* ignored = context.dialect.ignored_property(*plugin_, name.value)) {
    context.diagnostics.note(position, fmt::format("\"{}\" of {} is ignored: {}", name.value, heading(), ignored->why));
    return true;
  }
  const UnsupportedProperties* lacking = context.dialect.unsupported_property(*plugin_, name.value);
  if (lacking == nullptr) return false;
  if (is_off(element)) {
    context.diagnostics.note(position, fmt::format("\"{}\" of {} is ignored: it says that there is no {}", name.value,
                                                   heading(), lacking->what));
    return true;
  }
  const std::string feature = fmt::format("{} of {}", name.value, tag_);
  if (context.approximate) {
    context.approximated(feature, "left out", position);
    return true;
  }
  context.lacking.emplace_back(feature, position);
  context.diagnostics.error(position, fmt::format("\"{}\" of {} is not supported: there is no {}; remove it",
                                                  name.value, heading(), lacking->what));
  return true;
}

void Object::report_unknown_property(const XmlElement& element, ReadContext& context) const {
  const XmlAttribute& name = *element.find("name");
  // Properties of the type that -D has replaced are not errors.
  if (retyped_ && (in_file_ == nullptr || context.dialect.find_parameter(*in_file_, name.value) != nullptr)) return;
  if (is_known_elsewhere(element, context)) return;
  if (!context.strict && !context.diagnostics.wants_warnings()) return;
  const std::vector<std::string> names = plugin_->parameter_names();
  const std::string known = names.empty() ? "it has none" : "it has: " + text::join(names);
  const std::string guess = text::did_you_mean(name.value, names);
  const std::string message =
      fmt::format("{} has no property {}{}; {}", heading(), text::quoted(name.value), guess, known);
  const SourcePosition position = value_position(name, 0, context);
  if (context.strict && guess.empty() && context.dialect.forgiving) {
    const bool typed = *plugin_->type != '\0';
    context.lacking.emplace_back(
        fmt::format("{} of {}{}", name.value, tag_, typed ? fmt::format(" {}", plugin_->type) : ""), position);
  }
  context.strict ? context.diagnostics.error(position, message)
                 : context.diagnostics.warning(position, message + "; ignored");
}

/// Whether the element repeats an earlier property with the same value.
bool Object::repeats(const Parameter& parameter, const XmlElement& element) const {
  const auto before = given_.find(parameter.name);
  const XmlAttribute* value = element.find("value");
  const bool readable = value != nullptr && element.name == tag_of(parameter.type);
  if (before == given_.end() || !readable || named_children_.contains(parameter.name)) return false;
  try {
    return parse_value(parameter.type, parameter.range, value->value) == before->second.value;
  } catch (const ValueError&) {
    return false;
  }
}

bool Object::replaces(const Parameter& parameter, const XmlElement& element, bool picture, ReadContext& context) {
  if (!seen_.contains(parameter.name)) return false;
  const bool had_picture = pictures_.contains(parameter.name);
  if (picture == had_picture) return false;
  context.diagnostics.note(
      context.document.position(element.offset),
      fmt::format("\"{}\" of {} is given by a picture and by a value; the picture counts", parameter.name, heading()));
  return true;
}

void Object::read_picture(const Parameter& parameter, const XmlElement& element, ReadContext& context) {
  const XmlAttribute* value = element.find("value");
  XmlAttribute type{"type", "bitmap", element.offset, element.offset, false};
  XmlAttribute name{"name", "filename", element.offset, element.offset, false};
  XmlElement texture{"texture", element.offset, {std::move(type)}, {}};
  texture.children.push_back({"string", element.offset, {std::move(name), *value}, {}});
  const XmlElement& made = context.made.emplace_back(std::move(texture));
  set_unnamed_picture(parameter, made, made, context);
}

/// A picture that the file gives in other words than <texture name="…">.
void Object::set_unnamed_picture(const Parameter& parameter, const XmlElement& child, const XmlElement& object,
                                 ReadContext& context) {
  if (replaces(parameter, child, true, context)) {
    seen_.erase(parameter.name);
    given_.erase(parameter.name);
  }
  pictures_.insert(parameter.name);
  set_named_child(parameter, child, object, context);
}

bool Object::is_given_twice(const Parameter& parameter, const XmlElement& element, ReadContext& context) {
  if (seen_.insert(parameter.name).second) return false;
  if (context.dialect.forgiving && repeats(parameter, element)) {
    context.diagnostics.warning(
        context.document.position(element.offset),
        fmt::format("property \"{}\" of {} is given twice with the same value; keep one", parameter.name, heading()));
    return true;
  }
  context.diagnostics.error(context.document.position(element.offset),
                            fmt::format("property \"{}\" of {} is given twice; keep one", parameter.name, heading()));
  return true;
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
  const Parameter* parameter = context.dialect.find_parameter(*plugin_, name->value, element.name);
  if (parameter == nullptr) return report_unknown_property(element, context);
  const bool has_picture = std::string_view(parameter->child) == "texture" && parameter->type != ParameterType::object;
  if (context.dialect.forgiving && has_picture && element.name == "string" && well_formed)
    return read_picture(*parameter, element, context);
  if (context.dialect.forgiving && has_picture && replaces(*parameter, element, false, context)) return;
  if (is_given_twice(*parameter, element, context)) return;
  if (parameter->type == ParameterType::object) {
    context.diagnostics.error(
        context.document.position(element.offset),
        fmt::format("property \"{}\" of {} takes {}, not a value", parameter->name, heading(), tags_of(*parameter)));
    return;
  }
  if (element.name != tag_of(parameter->type) &&
      !(context.dialect.forgiving && says_the_same(element.name, parameter->type))) {
    context.diagnostics.error(
        context.document.position(element.offset),
        fmt::format("property \"{}\" of {} is of type {}, not {}; write <{} name=\"{}\" …>", parameter->name, heading(),
                    tag_of(parameter->type), element.name, tag_of(parameter->type), parameter->name));
    return;
  }
  if (is_transform) {
    transforms_[parameter->name] = read_transform(element, context);
    if (std::ranges::any_of(element.children, [](const XmlElement& child) { return child.name == "matrix"; }))
      matrices_.insert(parameter->name);
    given_[parameter->name] = {Value{}, context.document.position(element.offset)};
  } else if (well_formed) {
    read_value(*parameter, element, context);
  }
}

void Object::read_value(const Parameter& parameter, const XmlElement& element, ReadContext& context) {
  const XmlAttribute& value = *element.find("value");
  try {
    const bool alone = text::trim(value.value).find_first_of(" ,\t\r\n") == std::string_view::npos;
    const bool grey = parameter.type == ParameterType::color && alone && context.dialect.forgiving;
    Value read = parse_value(grey ? ParameterType::real : parameter.type, parameter.range, value.value);
    if (grey) read = glm::dvec3(std::get<double>(read));
    given_[parameter.name] = {std::move(read), value_position(value, 0, context)};
  } catch (const ValueError& error) {
    given_.erase(parameter.name);
    context.diagnostics.error(value_position(value, error.offset, context),
                              fmt::format("\"{}\" of {}: {}", parameter.name, heading(), error.message));
  }
}

void Object::apply_overrides(ReadContext& context) {
  if (!is_overridable(plugin_->tag)) return;
  for (const Parameter& parameter : plugin_->parameters) {
    if (parameter.type == ParameterType::transform || parameter.type == ParameterType::object) continue;
    const std::string path = fmt::format("{}.{}", plugin_->tag, parameter.name);
    context.overridable.insert(path);
    for (std::size_t i = 0; i < context.overrides.size(); ++i) {
      const auto& [wanted, value] = context.overrides[i];
      if (wanted != path) continue;
      context.override_matched[i] = true;
      const SourcePosition position{fmt::format("-D {}={}", path, value), 0, 0};
      try {
        given_[parameter.name] = {parse_value(parameter.type, parameter.range, value), position};
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
    const bool is_object = parameter.type == ParameterType::object;
    context.diagnostics.error(
        position_, fmt::format("{} needs its property \"{}\"; add <{} name=\"{}\" …/>", heading(), parameter.name,
                               is_object ? parameter.child : tag_of(parameter.type), parameter.name));
  }
  for (const ChildRule& rule : plugin_->children) {
    if (children(rule.tag).size() >= rule.min) continue;
    context.diagnostics.error(position_, fmt::format("{} needs a <{}>; supported types are: {}", heading(), rule.tag,
                                                     text::join(context.dialect.types_of(rule.tag))));
  }
}

std::vector<const XmlElement*> Object::children(std::string_view tag) const {
  std::vector<const XmlElement*> found;
  for (const auto& [rule, element] : children_) {
    if (rule == tag) found.push_back(element);
  }
  return found;
}

const XmlElement* Object::child_of(const char* name) const {
  const auto found = named_children_.find(name);
  return found == named_children_.end() ? nullptr : found->second;
}

SourcePosition Object::position_of(const char* name) const {
  const auto found = given_.find(name);
  return found == given_.end() ? position_ : found->second.position;
}

namespace {

/// For a required property that is missing, which has been reported: reading continues and finds the next problem.
Value substitute(ParameterType type) {
  using enum ParameterType;
  switch (type) {
    case boolean:
      return false;
    case integer:
      return std::int64_t{1};
    case real:
      return 1.0;
    case string:
      return std::string();
    case number_list:
      return std::vector<double>{};
    default:
      return glm::dvec3(0.0);
  }
}

}  // namespace

Value Object::get_value(const char* name) const {
  const Parameter* parameter = plugin_->find(name);
  if (parameter == nullptr) throw std::logic_error(fmt::format("{} has no row for {}", heading(), name));
  const auto found = given_.find(name);
  if (found != given_.end() && !named_children_.contains(name)) return found->second.value;
  if (parameter->default_text == nullptr) return substitute(parameter->type);
  if (parameter->type == ParameterType::number_list && parameter->default_text[0] == '\0') return std::vector<double>{};
  return parse_value(parameter->type, parameter->range, parameter->default_text);
}

glm::dmat4 Object::matrix(const char* name) const {
  const auto found = transforms_.find(name);
  return found == transforms_.end() ? glm::dmat4(1.0) : found->second;
}

void Object::throw_wrong_type(const char* name) {
  throw std::logic_error(fmt::format("property {} has another type", name));
}

}  // namespace etendue
