#pragma once
/// A Mitsuba scene after expansion: included files are in place, and parameters are replaced by their values. What
/// remains is objects, their properties, and references between them.

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/read_options.h"
#include "formats/xml/xml_document.h"
#include "scene/diagnostics.h"

namespace etendue {

/// Reads a text file that a scene names. Throws Error.
using TextLoader = std::function<std::string(const std::string& path)>;

/// Limits, so that small files cannot ask for much memory.
struct MitsubaLimits {
  static constexpr std::size_t kMaxIncludeDepth = 15;  ///< nesting of files; Mitsuba has the same limit
  static constexpr std::size_t kMaxFiles = 1000;       ///< included files; one that is named twice counts twice
  static constexpr std::size_t kMaxBytes = std::size_t{64} << 20;  ///< of all files together
  static constexpr std::size_t kMaxElements = 1'000'000;           ///< of all files together
  static constexpr std::size_t kMaxValue = std::size_t{1} << 20;   ///< bytes of a value after substitution
  static constexpr std::size_t kMaxSubstituted = std::size_t{16}
                                                 << 20;  ///< bytes of all values that contain parameters
};

/// True for a scene that is written for Mitsuba rather than Nori. This is told by its sensor or camera, otherwise by
/// the version of the root or by elements that only Mitsuba has.
bool is_mitsuba(const XmlElement& root);

class MitsubaDocument {
 public:
  /// Expands the document. Problems are reported; after an error the result may be incomplete.
  MitsubaDocument(std::unique_ptr<XmlDocument> document, const ReadOptions& options, const TextLoader& load,
                  Diagnostics& diagnostics);

  /// A single <scene>. Offsets run through all files, one after another; `position` converts them.
  const XmlElement& root() const { return root_; }
  const std::string& file() const { return sources_.front().document->file(); }
  /// For example "3.0.0"; "" if the file does not say.
  const std::string& version() const { return version_; }
  SourcePosition position(std::size_t offset) const;
  SourcePosition position(const XmlElement& element) const { return position(element.offset); }
  /// The position of a byte in an attribute's value.
  SourcePosition value_position(const XmlAttribute& attribute, std::size_t offset = 0) const;
  /// The object with an id or with an <alias> of it; nullptr if there is none.
  const XmlElement* find(std::string_view id) const;
  std::vector<std::string> ids() const;
  /// The path of a file that the scene names: searched for in the folders of <path>, then in that of the scene. If it
  /// does not exist, the path in the scene's folder.
  std::string resolve(std::string filename) const;

 private:
  struct Source {
    std::size_t base = 0;  ///< offset of its first byte
    std::unique_ptr<XmlDocument> document;
  };
  struct Expansion {
    std::vector<std::string> open;  ///< files being read, outermost first
    const TextLoader& load;
  };

  void take(std::unique_ptr<XmlDocument> document, XmlElement& root);
  void shift(XmlElement& element, std::size_t base);
  void expand(XmlElement& element, Expansion& expansion);
  void include(const XmlElement& element, std::vector<XmlElement>& into, Expansion& expansion);
  void add_default(const XmlElement& element);
  void add_path(const XmlElement& element);
  void add_alias(const XmlElement& element);
  void collect_ids(const XmlElement& element);
  void substitute(XmlElement& element);
  std::string substituted(const XmlAttribute& attribute);
  std::size_t append_parameter(const XmlAttribute& attribute, std::size_t dollar, std::string& out);
  /// Checks the attributes of a directive; reports missing and unknown ones.
  bool has_only(const XmlElement& element, std::initializer_list<const char*> names);
  void report_unused_overrides(const ReadOptions& options);

  Diagnostics& diagnostics_;
  std::vector<Source> sources_;
  std::size_t bytes_ = 0, elements_ = 0, substituted_bytes_ = 0;
  bool too_many_files_ = false;
  XmlElement root_;
  std::string version_;
  std::map<std::string, std::string, std::less<>> parameters_;
  std::map<std::string, bool, std::less<>> given_;  ///< names given with -D: whether some $name uses it
  std::vector<std::string> folders_;                ///< folders to search for files, in this order
  std::map<std::string, const XmlElement*, std::less<>> by_id_;
  std::vector<std::pair<std::string, std::string>> aliases_;  ///< other name, id
};

}  // namespace etendue
