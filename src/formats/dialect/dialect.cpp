#include "formats/dialect/dialect.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/text.h"

namespace etendue {
namespace {

template <typename Words>
bool contains(const Words& words, std::string_view word) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

/// Whether two words differ only in capitals, hyphens and underscores: pointLight, point_light, PointLight.
bool is_spelling_of(std::string_view a, std::string_view b) {
  std::size_t i = 0, j = 0;
  const auto skip = [](std::string_view word, std::size_t& at) {
    while (at < word.size() && (word[at] == '_' || word[at] == '-')) ++at;
  };
  const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  for (;;) {
    skip(a, i);
    skip(b, j);
    if (i == a.size() || j == b.size()) return i == a.size() && j == b.size();
    if (small(a[i++]) != small(b[j++])) return false;
  }
}

std::string type_of(const Parameter& p) {
  if (p.type == ParameterType::object) return fmt::format("`<{}>`", p.child);
  return *p.child == '\0' ? tag_of(p.type) : fmt::format("{} or `<{}>`", tag_of(p.type), p.child);
}

std::string parameter_table(const std::vector<Parameter>& parameters) {
  std::string out = "| property | type | default | allowed | meaning |\n|---|---|---|---|---|\n";
  for (const Parameter& p : parameters) {
    const std::string default_text = p.default_text == nullptr ? "required"
                                     : *p.default_text == '\0' ? "none"
                                                               : fmt::format("`{}`", p.default_text);
    out += fmt::format("| `{}` | {} | {} | {} | {} |\n", p.name, type_of(p), default_text, p.range.describe(), p.doc);
  }
  return out;
}

std::string describe(const ChildRule& rule) {
  if (rule.use == ChildUse::definition) return fmt::format("`<{}>` with an id, for `<ref>`", rule.tag);
  const char* count = rule.min == 1   ? (rule.max == 1 ? "exactly one" : "one or more")
                      : rule.max == 1 ? "at most one"
                                      : "any number of";
  return fmt::format("{} `<{}>`", count, rule.tag);
}

}  // namespace

const char* tag_of(ParameterType type) {
  using enum ParameterType;
  switch (type) {
    case boolean:
      return "boolean";
    case integer:
      return "integer";
    case real:
      return "float";
    case string:
    case number_list:
      return "string";
    case point:
    case point2:
      return "point";
    case vector:
    case vector2:
      return "vector";
    case color:
      return "color";
    case transform:
      return "transform";
    case object:
      break;
  }
  return "";
}

const std::vector<std::string>& property_tags() {
  static const std::vector<std::string> kTags = {"boolean", "integer", "float", "string",
                                                 "point",   "vector",  "color", "transform"};
  return kTags;
}

const Parameter* Plugin::find(std::string_view parameter) const {
  const auto found =
      std::find_if(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.name == parameter; });
  return found == parameters.end() ? nullptr : &*found;
}

const ChildRule* Plugin::find_child(std::string_view child_tag) const {
  const auto found =
      std::find_if(children.begin(), children.end(), [&](const ChildRule& rule) { return rule.tag == child_tag; });
  return found == children.end() ? nullptr : &*found;
}

std::vector<std::string> Plugin::parameter_names() const {
  std::vector<std::string> names;
  for (const Parameter& parameter : parameters) names.emplace_back(parameter.name);
  return names;
}

std::string_view Dialect::canonical(std::string_view tag) const {
  const auto found = std::find_if(aliases.begin(), aliases.end(), [&](const TagAlias& a) { return a.word == tag; });
  return found == aliases.end() ? tag : found->tag;
}

std::string_view Dialect::canonical_type(std::string_view tag, std::string_view type) const {
  const auto find_alias = [&](const auto& is_word) {
    const auto found = std::ranges::find_if(type_aliases, [&](const TypeAliases& entry) {
      return entry.tag == tag && std::ranges::any_of(entry.words, is_word);
    });
    return found == type_aliases.end() ? std::string_view() : found->type;
  };
  if (const std::string_view known = find_alias([&](std::string_view word) { return word == type; }); !known.empty())
    return known;
  if (!any_spelling) return type;
  for (const Plugin& plugin : plugins) {
    if (plugin.tag == tag && plugin.type == type) return type;
  }
  for (const Plugin& plugin : plugins) {
    if (plugin.tag == tag && is_spelling_of(plugin.type, type)) return plugin.type;
  }
  const std::string_view known = find_alias([&](std::string_view word) { return is_spelling_of(word, type); });
  return known.empty() ? type : known;
}

const Parameter* Dialect::find_parameter(const Plugin& plugin, std::string_view name, std::string_view element) const {
  const auto is_same = [&](std::string_view word) { return any_spelling ? is_spelling_of(word, name) : word == name; };
  const auto concerns = [&](const ParameterAlias& alias) { return alias.tag.empty() || alias.tag == plugin.tag; };
  for (const ParameterAlias& alias : parameter_aliases) {
    if (alias.element.empty() || alias.element != element || !concerns(alias) || !is_same(alias.word)) continue;
    if (const Parameter* parameter = plugin.find(alias.name)) return parameter;
  }
  if (const Parameter* parameter = plugin.find(name)) return parameter;
  const auto find_alias = [&](const auto& is_word) -> const Parameter* {
    for (const ParameterAlias& alias : parameter_aliases) {
      if (!alias.element.empty() || !concerns(alias) || !is_word(alias.word)) continue;
      if (const Parameter* parameter = plugin.find(alias.name)) return parameter;
    }
    return nullptr;
  };
  if (const Parameter* known = find_alias([&](std::string_view word) { return word == name; })) return known;
  if (!any_spelling) return nullptr;
  for (const Parameter& parameter : plugin.parameters) {
    if (is_spelling_of(parameter.name, name)) return &parameter;
  }
  return find_alias([&](std::string_view word) { return is_spelling_of(word, name); });
}

bool Dialect::is_name_of(const Parameter& parameter, std::string_view word) const {
  return any_spelling ? is_spelling_of(parameter.name, word) : parameter.name == word;
}

const IgnoredProperties* Dialect::ignored_property(const Plugin& plugin, std::string_view name) const {
  const auto found = std::ranges::find_if(ignored_properties, [&](const IgnoredProperties& row) {
    return row.tag == plugin.tag && (row.types.empty() || contains(row.types, plugin.type)) &&
           std::ranges::any_of(row.words, [&](std::string_view word) { return is_spelling_of(word, name); });
  });
  return found == ignored_properties.end() ? nullptr : &*found;
}

const UnsupportedProperties* Dialect::unsupported_property(const Plugin& plugin, std::string_view name) const {
  const auto found = std::ranges::find_if(unsupported_properties, [&](const UnsupportedProperties& row) {
    return row.tag == plugin.tag &&
           std::ranges::any_of(row.words, [&](std::string_view word) { return is_spelling_of(word, name); });
  });
  return found == unsupported_properties.end() ? nullptr : &*found;
}

const Parameter* Dialect::chief_parameter(const Plugin& plugin, std::string_view tag) const {
  if (!forgiving) return nullptr;
  const Parameter* only = nullptr;
  std::size_t count = 0;
  for (const Parameter& parameter : plugin.parameters) {
    if (parameter.child != tag) continue;
    // A texture without a name is meant for the colour of the surface.
    static constexpr std::string_view kColors[] = {"albedo", "kd", "base_color", "diffuse_reflectance", "texture"};
    if (contains(kColors, parameter.name)) return &parameter;
    only = &parameter;
    ++count;
  }
  return count == 1 ? only : nullptr;
}

const Plugin* Dialect::find(std::string_view tag, std::string_view type) const {
  const std::string_view word = canonical_type(tag, type);
  for (const Plugin& plugin : plugins) {
    if (plugin.tag == tag && plugin.type == word) return &plugin;
  }
  return nullptr;
}

std::vector<std::string> Dialect::types_of(std::string_view tag) const {
  std::vector<std::string> types;
  for (const Plugin& plugin : plugins) {
    if (plugin.tag == tag) types.emplace_back(plugin.type);
  }
  return types;
}

bool Dialect::is_known_but_unsupported(std::string_view tag, std::string_view type) const {
  for (const UnsupportedTypes& row : unsupported_types) {
    if (row.tag == tag) return contains(row.types, type);
  }
  return false;
}

std::vector<std::string> Dialect::object_tags() const {
  std::vector<std::string> tags;
  for (const Plugin& plugin : plugins) {
    if (!contains(tags, plugin.tag)) tags.emplace_back(plugin.tag);
  }
  return tags;
}

bool Dialect::is_object_tag(std::string_view tag) const {
  return std::any_of(plugins.begin(), plugins.end(), [&](const Plugin& plugin) { return plugin.tag == tag; });
}

bool Dialect::is_unsupported_tag(std::string_view tag) const {
  return contains(unsupported_tags, tag);
}

bool Dialect::can_be_named(std::string_view tag) const {
  for (const Plugin& plugin : plugins) {
    for (const Parameter& parameter : plugin.parameters) {
      if (parameter.child == tag) return true;
    }
  }
  return false;
}

std::string Dialect::parents_of(std::string_view tag) const {
  std::vector<std::string> parents;
  for (const Plugin& plugin : plugins) {
    const std::string name = fmt::format("<{}>", plugin.tag);
    const ChildRule* rule = plugin.find_child(tag);
    const bool uses = rule != nullptr && rule->use != ChildUse::definition;
    if (uses && !contains(parents, name)) parents.push_back(name);
  }
  return fmt::format("{}", fmt::join(parents, " or "));
}

std::string Dialect::owners_of(std::string_view tag) const {
  std::vector<std::string> owners;
  for (const Plugin& plugin : plugins) {
    const std::string name = fmt::format("<{}>", plugin.tag);
    const bool owns = std::ranges::any_of(plugin.parameters, [&](const Parameter& p) { return p.child == tag; });
    if (owns && !contains(owners, name)) owners.push_back(name);
  }
  return fmt::format("{}", fmt::join(owners, " or "));
}

std::string parameter_tables(const Dialect& dialect) {
  std::string out;
  for (const Plugin& plugin : dialect.plugins) {
    const std::string heading = *plugin.type == '\0' ? fmt::format("<{}>", plugin.tag)
                                                     : fmt::format("<{} type=\"{}\">", plugin.tag, plugin.type);
    out += fmt::format("### `{}`\n\n{}\n\n", heading, plugin.doc);
    if (!plugin.parameters.empty()) out += parameter_table(plugin.parameters) + "\n";
    if (plugin.children.empty()) continue;
    std::vector<std::string> rules;
    for (const ChildRule& rule : plugin.children) rules.push_back(describe(rule));
    out += fmt::format("Children: {}.\n\n", text::join(rules));
  }
  return out;
}

}  // namespace etendue
