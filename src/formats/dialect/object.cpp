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
  return nullptr;
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
    context.lacking.emplace_back(child.name, position);
    context.diagnostics.error(position, fmt::format("<{}> is not supported; remove it", child.name));
  } else if (contains(kOperations, child.name)) {
    context.diagnostics.error(
        position, fmt::format("<{}> is outside a <transform>; put it into <transform name=\"toWorld\">", child.name));
  } else {
    std::vector<std::string> known = property_tags();
    const std::vector<std::string> objects = context.dialect.object_tags();
    known.insert(known.end(), objects.begin(), objects.end());
    known.emplace_back("ref");
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

void Object::add_child(const XmlElement& child, const XmlElement& object, ReadContext& context) {
  const std::string_view tag = context.dialect.canonical(object.name);
  const bool is_reference = &child != &object;
  const bool may_be_named = is_reference || context.dialect.can_be_named(tag);
  if (may_be_named && child.find("name") != nullptr) return add_named_child(child, object, context);
  const ChildRule* rule = plugin_->find_child(tag);
  if (rule == nullptr && retyped_ && (in_file_ == nullptr || in_file_->find_child(tag) != nullptr)) return;
  if (rule == nullptr) {
    if (const Parameter* chief = context.dialect.chief_parameter(*plugin_, tag)) {
      context.diagnostics.note(context.document.position(child.offset),
                               fmt::format("the <{}> without a name is read as \"{}\"", object.name, chief->name));
      return set_named_child(*chief, child, object, context);
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
  const Parameter* parameter = context.dialect.find_parameter(*plugin_, name.value);
  if (parameter == nullptr) return report_unknown_property(name, context);
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

void Object::report_unknown_property(const XmlAttribute& name, ReadContext& context) const {
  if (!context.strict && !context.diagnostics.wants_warnings()) return;
  // Properties of the type that -D has replaced are not errors.
  if (retyped_ && (in_file_ == nullptr || context.dialect.find_parameter(*in_file_, name.value) != nullptr)) return;
  const std::vector<std::string> names = plugin_->parameter_names();
  const std::string known = names.empty() ? "it has none" : "it has: " + text::join(names);
  const std::string message = fmt::format("{} has no property {}{}; {}", heading(), text::quoted(name.value),
                                          text::did_you_mean(name.value, names), known);
  const SourcePosition position = value_position(name, 0, context);
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
  if (parameter == nullptr) return report_unknown_property(*name, context);
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
