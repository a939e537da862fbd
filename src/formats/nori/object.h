#pragma once
/// One object element of a scene file, validated against its row of the plugin table.

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "formats/nori/plugins.h"
#include "formats/xml/xml_document.h"
#include "scene/diagnostics.h"

namespace etendue {

/// "tag.property" and value, as given with -D.
using Overrides = std::vector<std::pair<std::string, std::string>>;

/// What the reading of one file shares.
struct ReadContext {
  const XmlDocument& document;
  Diagnostics& diagnostics;
  const Overrides& overrides;
  bool strict = false;
  std::set<std::string> overridable;   ///< "tag.property" of every object met so far that overrides can reach
  std::vector<bool> override_matched;  ///< one per override
};

class Object {
 public:
  /// Reads an element of a known object tag. Problems are reported; an element without a usable type gives nothing.
  static std::optional<Object> read(const XmlElement& element, ReadContext& context);
  /// An object the file leaves out: defaults and overrides only.
  static Object defaulted(const char* tag, const char* type, const SourcePosition& parent, ReadContext& context);

  const Plugin& plugin() const { return *plugin_; }
  const SourcePosition& position() const { return position_; }
  /// Child objects of an allowed tag, in file order.
  std::vector<const XmlElement*> children(std::string_view tag) const;

  /// True if the file or an override gives the property.
  bool given(const char* name) const { return given_.contains(name); }
  /// Where the property's value stands, or the object if it is not given.
  SourcePosition position_of(const char* name) const;

  /// Value of a property or its default; asking for a type or name that the table does not have is a bug
  /// (std::logic_error).
  template <typename T>
  T get(const char* name) const {
    const Value value = get_value(name);
    if (const T* typed = std::get_if<T>(&value)) return *typed;
    throw_wrong_type(name);
  }
  /// The transform's matrix (identity by default).
  glm::dmat4 matrix(const char* name) const;

 private:
  struct Given {
    Value value;
    SourcePosition position;
  };

  Object(const Plugin& plugin, SourcePosition position) : plugin_(&plugin), position_(std::move(position)) {}
  void read_child(const XmlElement& child, ReadContext& context);
  void read_property(const XmlElement& element, ReadContext& context);
  void read_value(const Parameter& parameter, const XmlElement& element, ReadContext& context);
  void read_object_child(const XmlElement& child, ReadContext& context);
  void apply_overrides(ReadContext& context);
  void check_complete(ReadContext& context) const;
  std::string heading() const;
  Value get_value(const char* name) const;
  [[noreturn]] static void throw_wrong_type(const char* name);

  const Plugin* plugin_;
  SourcePosition position_;
  std::map<std::string, Given, std::less<>> given_;
  std::set<std::string, std::less<>> seen_;  ///< names met, also with values that could not be read
  std::map<std::string, glm::dmat4, std::less<>> transforms_;
  std::vector<const XmlElement*> children_;
  std::map<std::string, std::size_t, std::less<>> child_counts_;
};

/// Reports attributes of `element` that are missing or not in `names`; true if it has exactly those.
bool check_attributes(const XmlElement& element, const std::vector<std::string>& names, ReadContext& context);

/// Position of `offset` bytes into an attribute's value.
SourcePosition value_position(const XmlAttribute& attribute, std::size_t offset, const ReadContext& context);

/// The product of a <transform>'s operations, the last listed leftmost: it is applied last. Problems are reported;
/// identity stands for what cannot be read. The result is affine, invertible and finite.
glm::dmat4 read_transform(const XmlElement& element, ReadContext& context);

}  // namespace etendue
