#pragma once
/// Ids and references of one scene file: <bsdf id="wood" …> stands once and <ref id="wood"/> wherever it is used,
/// before or after.

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "formats/dialect/dialect.h"
#include "formats/xml/xml_document.h"
#include "scene/diagnostics.h"

namespace etendue {

class References {
 public:
  /// The largest depth of objects within objects, including references, so that they may be read recursively.
  static constexpr std::size_t kMaxNesting = 32;

  /// Finds all ids. Reports an id that is given twice, references that lead back to themselves and chains of them that
  /// are too long; after an error no reference may be followed.
  References(const XmlDocument& document, const Dialect& dialect, Diagnostics& diagnostics);

  /// The element of an id; nullptr if there is none.
  const XmlElement* find(std::string_view id) const;
  /// A suggestion for an unknown id, as the end of a sentence.
  std::string suggest(std::string_view id) const;
  /// True if some <ref> of the file names it.
  bool is_used(std::string_view id) const { return used_.contains(id); }

 private:
  /// Something with an id, and the references within it.
  struct Definition {
    const XmlElement* element;
    std::vector<const XmlElement*> references;
  };
  enum class State { fresh, open, done };
  struct Visit {
    std::size_t definition;
    std::size_t next = 0;  ///< reference to follow
  };

  void collect(const XmlElement& element, std::vector<std::size_t>& around);
  void add(const XmlElement& element, const XmlAttribute& id);
  void check_nesting();
  void visit(std::size_t first);
  void deepen(std::size_t definition, std::size_t target, const XmlElement& ref);
  void report_circle(const std::vector<Visit>& path, std::size_t target, const XmlElement& ref);

  const XmlDocument& document_;
  const Dialect& dialect_;
  Diagnostics& diagnostics_;
  std::vector<Definition> definitions_;
  std::map<std::string, std::size_t, std::less<>> by_id_;
  std::set<std::string, std::less<>> used_;
  std::vector<State> states_;
  std::vector<std::size_t> depths_;  ///< of a finished definition: length of the longest chain of references below it
};

}  // namespace etendue
