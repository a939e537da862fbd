#pragma once
/// A dialect of scene files as a value: a row per tag and type with its parameters, their defaults, ranges and meaning,
/// other words for tags, and the defaults for what its files leave open. Elements are validated by it (object.h), and
/// docs/scene_format.md prints it.

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "formats/dialect/values.h"

namespace etendue {

struct Parameter {
  const char* name;
  ParameterType type;
  const char* default_text;  ///< as written in a file; nullptr: required; "" is none, and the only one of an object
  Range range;
  const char* doc;
  const char* child = "";  ///< tag of the objects that may stand for the value: <texture name="albedo" type="…">
};

/// How children belong to an object: by their element or a <ref> to it; only by their element; or not at all, if they
/// are only defined there, with an id, for use by <ref> elsewhere.
enum class ChildUse { element_or_reference, element, definition };

/// How many unnamed children of a tag an object accepts.
struct ChildRule {
  const char* tag;
  std::size_t min;
  std::size_t max;
  ChildUse use = ChildUse::element_or_reference;
};

struct Plugin {
  const char* tag;
  const char* type;  ///< "" for <scene>
  const char* doc;
  std::vector<Parameter> parameters;
  std::vector<ChildRule> children;

  const Parameter* find(std::string_view parameter) const;
  const ChildRule* find_child(std::string_view child_tag) const;
  std::vector<std::string> parameter_names() const;
};

inline constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

/// Types that other renderers know and the dialect's reader does not.
struct UnsupportedTypes {
  std::string_view tag;
  std::vector<std::string_view> types;
};

/// Another word for a tag.
struct TagAlias {
  std::string_view word;
  std::string_view tag;
};

/// Other words for a type of a tag: properties have the meaning and the defaults of that type.
struct TypeAliases {
  std::string_view tag, type;
  std::vector<std::string_view> words;
};

/// Another word for a property, for every object that has it.
struct ParameterAlias {
  std::string_view word, name;
  std::string_view tag = {};      ///< if set, only for objects of this tag
  std::string_view element = {};  ///< if set, only if the property is written like this: <vector name="scale" …>
};

/// A tag of other renderers without counterpart here; it is ignored.
struct IgnoredTag {
  std::string_view tag, why;
  bool changes_picture;  ///< a warning, not only a note
};

/// The edge of a picture where texture coordinates have v = 0.
enum class VOrigin { bottom, top };

/// Properties of other renderers that change nothing in the picture; they are passed over with a note.
struct IgnoredProperties {
  std::string_view tag;
  std::vector<std::string_view> types;  ///< of the objects; none: of all
  std::vector<std::string_view> words;
  std::string_view why;
};

/// Properties of other renderers that do change it, and that the dialect's reader lacks; unless they say false or 0.
struct UnsupportedProperties {
  std::string_view tag;
  std::vector<std::string_view> words;
  std::string_view what;
};

/// Conventions that mesh files and shapes leave to the dialect.
struct MeshFacts {
  bool smooth_without_normals = false;  ///< a mesh file without normals gets smooth ones; otherwise it is flat
  VOrigin v_origin = VOrigin::bottom;   ///< if the file format does not say
};

/// Tag of the property element: "float" for a real, "string" for a list of numbers.
const char* tag_of(ParameterType type);
/// All of them.
const std::vector<std::string>& property_tags();

struct Dialect {
  std::vector<Plugin> plugins;
  std::vector<UnsupportedTypes> unsupported_types;
  std::vector<std::string> unsupported_tags;  ///< tags without a usable type: "medium"
  std::vector<TagAlias> aliases;
  MeshFacts mesh_facts;
  std::vector<TypeAliases> type_aliases = {};
  std::vector<ParameterAlias> parameter_aliases = {};
  /// Words of types and properties may differ in capitals, hyphens and underscores.
  bool any_spelling = false;
  /// Input that can mean only one thing is accepted: a number under another tag, a texture without a name, a name on an
  /// object that needs none, a property given twice with the same value.
  bool forgiving = false;
  std::vector<IgnoredTag> ignored_tags = {};
  std::vector<IgnoredProperties> ignored_properties = {};
  std::vector<UnsupportedProperties> unsupported_properties = {};

  /// The table's word for a tag.
  std::string_view canonical(std::string_view tag) const;
  /// The table's word for a type of a canonical tag.
  std::string_view canonical_type(std::string_view tag, std::string_view type) const;
  /// The parameter of a row by its name or another word for it; nullptr if there is none.
  /// `element` is the tag that gives it.
  const Parameter* find_parameter(const Plugin& plugin, std::string_view name, std::string_view element = {}) const;
  /// Whether a word is the name of a parameter, in some spelling, and not another word for it.
  bool is_name_of(const Parameter& parameter, std::string_view word) const;
  /// The rows for a property that the dialect's table does not have; nullptr if there is none.
  const IgnoredProperties* ignored_property(const Plugin& plugin, std::string_view name) const;
  const UnsupportedProperties* unsupported_property(const Plugin& plugin, std::string_view name) const;
  /// The only property that an unnamed object of `tag` can be meant for; nullptr if there are several or none.
  const Parameter* chief_parameter(const Plugin& plugin, std::string_view tag) const;
  /// The row of a canonical tag and a type, or nullptr.
  const Plugin* find(std::string_view tag, std::string_view type) const;
  /// The usable types of a tag, in table order; empty for tags that are not objects.
  std::vector<std::string> types_of(std::string_view tag) const;
  bool is_known_but_unsupported(std::string_view tag, std::string_view type) const;
  /// Object tags of the table ("scene", "mesh", …).
  std::vector<std::string> object_tags() const;
  bool is_object_tag(std::string_view tag) const;
  bool is_unsupported_tag(std::string_view tag) const;
  /// Whether objects of the tag can be the value of a property.
  bool can_be_named(std::string_view tag) const;
  /// Where `tag` can be used: "<mesh> or <scene>"; "" for the root of a file, and for tags that can only be values of
  /// properties.
  std::string parents_of(std::string_view tag) const;
  /// The tags of objects with a property whose value can be an object of `tag`: "<bsdf> or <emitter>".
  std::string owners_of(std::string_view tag) const;
};

/// The parameter tables as Markdown, for docs/scene_format.md.
std::string parameter_tables(const Dialect& dialect);

}  // namespace etendue
