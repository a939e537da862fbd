#pragma once
/// A strict reader for the part of XML 1.0 that scene files use: elements and attributes in UTF-8. It exists because
/// scene errors need the exact place of every attribute and value in the original bytes, and because the DOM libraries
/// at hand accept what XML forbids (duplicate attributes, undefined entities, malformed UTF-8) without a word.
///
/// Document types are refused, so there are no entities but the five predefined ones and nothing can expand.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/diagnostics.h"

namespace etendue {

struct XmlAttribute {
  std::string name;
  std::string value;       ///< references replaced
  std::size_t offset = 0;  ///< of the name, in bytes of the file
  std::size_t value_offset = 0;
  bool verbatim = true;  ///< `value` is byte for byte what the file holds, so offsets into it are offsets into the file
};

struct XmlElement {
  std::string name;
  std::size_t offset = 0;  ///< of the '<'
  std::vector<XmlAttribute> attributes;
  std::vector<XmlElement> children;

  const XmlAttribute* find(std::string_view attribute) const;
};

class XmlDocument {
 public:
  static constexpr std::size_t kMaxBytes = std::size_t{32} << 20;
  static constexpr std::size_t kMaxDepth = 32;
  static constexpr std::size_t kMaxElements = 1'000'000;
  static constexpr std::size_t kMaxAttributes = 16;  ///< of one element

  /// Parses `text`. Stray text and duplicate attributes are reported and skipped; after a syntax error parsing ends and
  /// there is no root. Never throws for anything in `text`.
  XmlDocument(std::string text, std::string file, Diagnostics& diagnostics);

  /// A document without a text, of elements that a program made: their offsets, and those of their attributes, which
  /// are not verbatim, are indices into `places`, the names of their positions.
  XmlDocument(XmlElement root, std::string file, std::vector<std::string> places)
      : file_(std::move(file)), places_(std::move(places)), root_(std::move(root)) {}

  const std::optional<XmlElement>& root() const { return root_; }
  /// The root, for who changes or owns the elements; the document keeps none and goes on giving positions.
  std::optional<XmlElement> take_root() { return std::exchange(root_, std::nullopt); }
  const std::string& file() const { return file_; }
  /// Of the range of offsets.
  std::size_t size() const { return places_.empty() ? text_.size() : places_.size(); }
  /// Line and column of a byte. Lines end with LF, CR LF or CR; columns count characters (code points), a tab is one.
  SourcePosition position(std::size_t offset) const;

 private:
  void index_lines();

  std::string text_;
  std::string file_;
  std::vector<std::string> places_;  ///< empty for a text
  std::vector<std::uint32_t> line_starts_;
  std::vector<std::uint32_t> continuation_bytes_;  ///< UTF-8 continuation bytes before every 4096th byte
  std::optional<XmlElement> root_;
};

}  // namespace etendue
