#pragma once
/// An object of a Mitsuba scene, checked against its row of the table. Values are parsed on request.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/dialect/dialect.h"
#include "formats/mitsuba/features.h"
#include "formats/mitsuba/mitsuba_document.h"
#include "formats/mitsuba/spectrum.h"

namespace etendue {

/// Whether an axis of rotation counts with its length, as in Mitsuba 2 and 3, where a length other than 1 makes it no
/// rotation. In scenes for 0.6, all are `unit`.
enum class RotationAxes { as_given, unit };

/// What everything that reads one scene shares.
struct MitsubaContext {
  const MitsubaDocument& document;
  const Dialect& dialect;
  Diagnostics& sink;
  MissingFeatures& missing;
  const TextLoader& load_text;
  bool strict = false;
  bool shows_uv = false;      ///< texture coordinates are kept although no texture needs them
  bool camera_given = false;  ///< the caller places a camera, so the file need not have one
};

/// A colour, or a texture; then `value` is unused.
struct MitsubaColor {
  glm::dvec3 value{0.0};
  const XmlElement* texture = nullptr;
};

class MitsubaObject {
 public:
  /// Reports problems. Returns nothing for an unsupported type, which is noted together with its substitute.
  static std::optional<MitsubaObject> read(const XmlElement& element, const MitsubaContext& context,
                                           const std::string& substitute);
  /// The default for an object that is missing in the file.
  static MitsubaObject defaulted(const char* tag, const char* type, const SourcePosition& parent,
                                 const MitsubaContext& context);

  const Plugin& plugin() const { return *plugin_; }
  std::string_view type() const { return plugin_->type; }
  const SourcePosition& position() const { return position_; }
  /// Child objects with this tag (as in the table) that are not values of properties, in file order. A reference counts
  /// as the object that it refers to.
  std::vector<const XmlElement*> children(std::string_view tag) const;

  bool given(const char* name) const { return properties_.contains(name); }
  SourcePosition position_of(const char* name) const;

  // Values of properties; the table's defaults if they are missing or wrong. Asking for a property that is not in the
  // table is a bug (std::logic_error).
  double real(const char* name) const;
  std::int64_t integer(const char* name) const;
  bool boolean(const char* name) const;
  std::vector<double> numbers(const char* name) const;
  std::string text(const char* name) const;
  glm::dvec3 triple(const char* name) const;
  MitsubaColor color(const char* name, SpectrumUse use) const;
  /// The texture that is the value of a property; nullptr if it is not a texture.
  const XmlElement* texture(const char* name) const;
  /// A transform; by default the identity.
  glm::dmat4 matrix(const char* name, RotationAxes axes = RotationAxes::as_given) const;
  /// The same for texture coordinates.
  glm::dmat3 uv_matrix(const char* name) const;
  /// An index of refraction, given as a number or by name.
  double ior(const char* name) const;

 private:
  struct Property {
    const XmlElement* element;  ///< for a reference, the object that it refers to
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
  /// Parses the value of an attribute; returns nothing after reporting an error.
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

/// An attribute that must exist; otherwise throws ValueError.
const XmlAttribute& required(const XmlElement& element, const char* attribute);

/// The colour of <rgb>, <srgb>, <spectrum> or a number. Throws ValueError with an offset in the document.
glm::dvec3 read_color(const XmlElement& element, SpectrumUse use, const MitsubaContext& context);

/// The product of the operations in a <transform>, the last one on the left. Problems are reported; an operation that
/// cannot be read counts as the identity.
glm::dmat4 read_mitsuba_transform(const XmlElement& element, const MitsubaContext& context,
                                  RotationAxes axes = RotationAxes::as_given);
/// The same for texture coordinates.
glm::dmat3 read_mitsuba_uv_transform(const XmlElement& element, const MitsubaContext& context);

}  // namespace etendue
