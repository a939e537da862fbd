#pragma once
/// One object element of a scene file, validated against its row of the dialect.

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "formats/dialect/dialect.h"
#include "formats/dialect/references.h"
#include "formats/xml/xml_document.h"
#include "scene/diagnostics.h"

namespace etendue {

/// "tag.property" and value, as given with -D.
using Overrides = std::vector<std::pair<std::string, std::string>>;

/// The state shared while one file is read.
struct ReadContext {
  const Dialect& dialect;
  const XmlDocument& document;
  const References& references;
  Diagnostics& diagnostics;
  const Overrides& overrides;
  bool strict = false;
  std::set<std::string> overridable;   ///< "tag.property" of every object met so far that overrides can reach
  std::vector<bool> override_matched;  ///< one per override
  /// Unsupported types and tags, such as "bsdf phong", and their positions. Each was reported as well, unless it lies
  /// within another.
  std::vector<std::pair<std::string, SourcePosition>> lacking = {};
  /// Unsupported features are replaced, with a warning for each, instead of being refused.
  bool approximate = false;
  bool shows_uv = false;                         ///< texture coordinates are kept although no texture needs them
  std::vector<std::string> approximations = {};  ///< "medium: left out", each once
  std::deque<XmlElement> made = {};              ///< elements that stand for what the file says in other words

  /// Warns about a substitute, and records it for the metadata of pictures.
  void approximated(const std::string& what, const std::string& substitute, const SourcePosition& position);
};

/// If the file needs several unsupported features, adds an error before all others that names them all.
void report_lacking(const ReadContext& context);

class Object {
 public:
  /// Reads an element of a known object tag. Problems are reported; an element without a usable type yields nothing.
  static std::optional<Object> read(const XmlElement& element, ReadContext& context);
  /// An object the file leaves out: defaults and overrides only.
  static Object defaulted(const char* tag, const char* type, const SourcePosition& parent, ReadContext& context);

  const Plugin& plugin() const { return *plugin_; }
  const SourcePosition& position() const { return position_; }
  /// Child objects of an allowed tag that have no name, in file order; for a <ref>, the element it refers to. One
  /// element may therefore be the child of many, so a caller that reads it into a table must remember its row.
  std::vector<const XmlElement*> children(std::string_view tag) const;
  /// The object that is the value of a property; nullptr if there is none.
  const XmlElement* child_of(const char* name) const;

  /// True if the file or an override gives the property, by a value or by an object.
  bool given(const char* name) const { return given_.contains(name); }
  /// The position of the property's value, or of the object if it is not given.
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
  /// Whether the file gives the transform as numbers, perhaps among others.
  bool is_matrix(const char* name) const { return matrices_.contains(name); }

 private:
  struct Given {
    Value value;
    SourcePosition position;
  };

  Object(const Plugin& plugin, std::string tag, SourcePosition position)
      : plugin_(&plugin), tag_(std::move(tag)), position_(std::move(position)) {}
  void read_child(const XmlElement& child, ReadContext& context);
  void report_unknown_tag(const XmlElement& child, ReadContext& context) const;
  /// The name of a picture in the place of its colour or number.
  void read_picture(const Parameter& parameter, const XmlElement& element, ReadContext& context);
  void read_property(const XmlElement& element, ReadContext& context);
  void read_value(const Parameter& parameter, const XmlElement& element, ReadContext& context);
  void read_reference(const XmlElement& ref, ReadContext& context);
  /// `object` is `child`, or what `child`, a <ref>, refers to.
  void add_child(const XmlElement& child, const XmlElement& object, ReadContext& context);
  void add_named_child(const XmlElement& child, const XmlElement& object, ReadContext& context);
  void set_named_child(const Parameter& parameter, const XmlElement& child, const XmlElement& object,
                       ReadContext& context);
  void set_unnamed_picture(const Parameter& parameter, const XmlElement& child, const XmlElement& object,
                           ReadContext& context);
  void report_misplaced(const XmlElement& child, std::string_view tag, ReadContext& context) const;
  void report_unknown_property(const XmlElement& element, ReadContext& context) const;
  const Parameter* meant_parameter(const XmlElement& object, const ReadContext& context) const;
  bool is_known_elsewhere(const XmlElement& element, ReadContext& context) const;
  bool repeats(const Parameter& parameter, const XmlElement& element) const;
  bool is_given_twice(const Parameter& parameter, const XmlElement& element, ReadContext& context);
  /// Whether a picture and a plain value stand for one property; the picture counts.
  bool replaces(const Parameter& parameter, const XmlElement& element, bool picture, ReadContext& context);
  void apply_overrides(ReadContext& context);
  void check_complete(ReadContext& context) const;
  std::string heading() const;
  Value get_value(const char* name) const;
  [[noreturn]] static void throw_wrong_type(const char* name);

  const Plugin* plugin_;
  bool retyped_ = false;             ///< -D gives another type than the file
  const Plugin* in_file_ = nullptr;  ///< then the row of the file's type; nullptr where there is none
  std::string tag_;                  ///< as the file writes it: an alias of the row's tag, perhaps
  SourcePosition position_;
  std::map<std::string, Given, std::less<>> given_;
  std::set<std::string, std::less<>> seen_;  ///< names met, also with values that could not be read
  std::map<std::string, glm::dmat4, std::less<>> transforms_;
  std::set<std::string, std::less<>> matrices_;                           ///< transforms that hold a <matrix>
  std::vector<std::pair<std::string_view, const XmlElement*>> children_;  ///< with the tags of their rules
  std::map<std::string, const XmlElement*, std::less<>> named_children_;
  std::map<std::string, std::size_t, std::less<>> child_counts_;
  std::set<std::string, std::less<>> pictures_;  ///< properties given by pictures without their names
};

/// Reports attributes of `element` that are missing or in neither list; true if there are none.
bool check_attributes(const XmlElement& element, const std::vector<std::string>& names, ReadContext& context,
                      const std::vector<std::string>& optional = {});

/// Position of `offset` bytes into an attribute's value.
SourcePosition value_position(const XmlAttribute& attribute, std::size_t offset, const ReadContext& context);

/// The product of a <transform>'s operations, the last listed leftmost: it is applied last. Problems are reported;
/// identity stands for what cannot be read. The result is affine, invertible and finite.
glm::dmat4 read_transform(const XmlElement& element, ReadContext& context);

}  // namespace etendue
