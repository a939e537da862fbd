#pragma once
/// One object of a Mitsuba scene, held against its row of the table. Values are read when they are asked for.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/dialect/dialect.h"
#include "formats/mitsuba/features.h"
#include "formats/mitsuba/mitsuba_document.h"
#include "formats/mitsuba/spectrum.h"

namespace etendue {

/// What the reading of one scene shares.
struct MitsubaContext {
  const MitsubaDocument& document;
  const Dialect& dialect;
  Diagnostics& sink;
  MissingFeatures& missing;
  const TextLoader& load_text;
  bool strict = false;
  bool camera_given = false;  ///< by the caller, so that the file need not have one
};

/// A colour, or the texture that gives it: then `value` is unused.
struct MitsubaColor {
  glm::dvec3 value{0.0};
  const XmlElement* texture = nullptr;
};

class MitsubaObject {
 public:
  /// Problems are reported; nothing for a type that there is not here, which is noted with its substitute.
  static std::optional<MitsubaObject> read(const XmlElement& element, const MitsubaContext& context,
                                           const std::string& substitute);
  /// An object that the file leaves out.
  static MitsubaObject defaulted(const char* tag, const char* type, const SourcePosition& parent,
                                 const MitsubaContext& context);

  const Plugin& plugin() const { return *plugin_; }
  std::string_view type() const { return plugin_->type; }
  const SourcePosition& position() const { return position_; }
  /// Objects within that are no property's value, in file order, by their tags as the table writes them; a reference
  /// counts as what it refers to.
  std::vector<const XmlElement*> children(std::string_view tag) const;

  bool given(const char* name) const { return properties_.contains(name); }
  SourcePosition position_of(const char* name) const;

  // Values of properties, or the table's defaults where they are not given or wrong. Asking for one that the table
  // does not have is a bug (std::logic_error).
  double real(const char* name) const;
  std::int64_t integer(const char* name) const;
  bool boolean(const char* name) const;
  std::vector<double> numbers(const char* name) const;
  std::string text(const char* name) const;
  glm::dvec3 triple(const char* name) const;
  MitsubaColor color(const char* name, SpectrumUse use) const;
  /// The texture that stands for a value; nullptr where there is none.
  const XmlElement* texture(const char* name) const;
  /// Identity by default.
  glm::dmat4 matrix(const char* name) const;
  /// The same in the plane of textures.
  glm::dmat3 uv_matrix(const char* name) const;
  /// An index of refraction, a number or a name.
  double ior(const char* name) const;

 private:
  struct Property {
    const XmlElement* element;  ///< of a reference, what it refers to
    SourcePosition position;
  };

  MitsubaObject(const Plugin& plugin, SourcePosition position, const MitsubaContext& context)
      : plugin_(&plugin), position_(std::move(position)), context_(&context) {}
  void read_child(const XmlElement& child);
  void add_property(const XmlElement& child, const XmlElement& element);
  void add_object(const XmlElement& child, const XmlElement& object);
  void report_unknown_property(const XmlAttribute& name) const;
  std::string heading() const;
  const Parameter& row_of(const char* name) const;
  const Property* find(const char* name) const;
  /// The value of an attribute, parsed; nothing after a report.
  std::optional<Value> parse(const Parameter& row, ParameterType type, const XmlElement& element,
                             const char* attribute) const;
  Value default_of(const Parameter& row, ParameterType type) const;
  Value value(const char* name, ParameterType type, std::initializer_list<std::string_view> tags) const;
  void report_wrong_tag(const Parameter& row, const XmlElement& element,
                        std::initializer_list<std::string_view> tags) const;

  const Plugin* plugin_;
  SourcePosition position_;
  const MitsubaContext* context_;
  std::map<std::string, Property, std::less<>> properties_;
  std::vector<std::pair<std::string_view, const XmlElement*>> children_;
};

/// Throws ValueError where it is not there.
const XmlAttribute& required(const XmlElement& element, const char* attribute);

/// The colour of <rgb>, <srgb>, <spectrum> or a number. Throws ValueError with an offset in the document.
glm::dvec3 read_color(const XmlElement& element, SpectrumUse use, const MitsubaContext& context);

/// The product of a <transform>'s operations, the last listed leftmost. Problems are reported; identity stands for what
/// cannot be read.
glm::dmat4 read_mitsuba_transform(const XmlElement& element, const MitsubaContext& context);
/// The same in the plane of textures.
glm::dmat3 read_mitsuba_uv_transform(const XmlElement& element, const MitsubaContext& context);

}  // namespace etendue
