#include "formats/xml/xml_document.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

constexpr std::size_t kBlock = 4096;

struct SyntaxError {
  std::size_t offset;
  std::string message;
};

bool is_continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xc0) == 0x80;
}

bool is_name_start(char c) {
  const auto u = static_cast<unsigned char>(c);
  return (u >= 'a' && u <= 'z') || (u >= 'A' && u <= 'Z') || u == '_' || u == ':' || u >= 0x80;
}

bool is_name(char c) {
  return is_name_start(c) || (c >= '0' && c <= '9') || c == '-' || c == '.';
}

void append_utf8(std::string& out, std::uint32_t code) {
  const auto put = [&](std::uint32_t byte) { out += static_cast<char>(byte); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xc0 | code >> 6), put(0x80 | (code & 0x3f));
  } else if (code < 0x10000) {
    put(0xe0 | code >> 12), put(0x80 | (code >> 6 & 0x3f)), put(0x80 | (code & 0x3f));
  } else {
    put(0xf0 | code >> 18), put(0x80 | (code >> 12 & 0x3f)), put(0x80 | (code >> 6 & 0x3f)), put(0x80 | (code & 0x3f));
  }
}

/// Characters XML 1.0 allows.
bool is_xml_character(std::uint32_t code) {
  if (code < 0x20) return code == '\t' || code == '\n' || code == '\r';
  return code < 0xd800 || (code > 0xdfff && code < 0xfffe) || (code > 0xffff && code <= 0x10ffff);
}

/// Recursive descent over the bytes; `depth` is bounded, so the stack is.
class Parser {
 public:
  Parser(std::string_view text, const XmlDocument& document, Diagnostics& diagnostics)
      : text_(text), document_(document), diagnostics_(diagnostics) {}

  XmlElement parse() {
    check_encoding();
    if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;
    if (const char* pointer = text::pointer_sentence(text_)) fail(0, pointer);
    skip_misc();
    if (end()) fail(at_, "the file holds no element; a scene starts with <scene>");
    XmlElement root = parse_element(0);
    skip_misc();
    if (!end()) fail(at_, "there is more after the root element; a file holds one <scene> or <test>");
    return root;
  }

 private:
  [[noreturn]] static void fail(std::size_t offset, std::string message) {
    throw SyntaxError{offset, std::move(message)};
  }

  bool end() const { return at_ >= text_.size(); }
  bool looking_at(std::string_view s) const { return text_.substr(at_, s.size()) == s; }
  void skip_blanks() {
    while (!end() && text::is_blank(text_[at_])) ++at_;
  }

  void check_encoding() const {
    const std::string_view head = text_.substr(0, 4);
    if (head.starts_with("\xff\xfe") || head.starts_with("\xfe\xff") || head.find('\0') != std::string_view::npos) {
      fail(0, "the file is UTF-16, UTF-32 or binary; save it as UTF-8 text");
    }
    bool ascii = true;
    for (std::size_t i = 0; i < text_.size();) {
      const auto c = static_cast<unsigned char>(text_[i]);
      if (c < 0x20 && !text::is_blank(text_[i]))
        fail(i, fmt::format("control character 0x{:02x}; a scene is plain text", c));
      const std::size_t length = text::utf8_length(text_, i);
      if (length == 0) fail(i, fmt::format("byte 0x{:02x} is not valid UTF-8; save the file as UTF-8", c));
      ascii = ascii && length == 1;
      i += length;
    }
    if (!ascii) check_declared_encoding();
  }

  /// A file that says it is Latin-1 and happens to be valid UTF-8 would be misread; pure ASCII is the same in both.
  void check_declared_encoding() const {
    if (text_.find("<?xml") > 3) return;
    const std::string_view declaration = text_.substr(0, text_.find("?>"));
    const std::size_t key = declaration.find("encoding");
    if (key == std::string_view::npos) return;
    const std::size_t open = declaration.find_first_of("\"'", key);
    if (open == std::string_view::npos) return;
    const std::string_view name =
        declaration.substr(open + 1, declaration.find(declaration[open], open + 1) - open - 1);
    if (text::equal_ignoring_case(name, "utf-8") || text::equal_ignoring_case(name, "utf8")) return;
    fail(open + 1, fmt::format("encoding {} is not supported; save the file as UTF-8", text::quoted(name)));
  }

  /// Comments, processing instructions and blanks outside the root element.
  void skip_misc() {
    for (skip_blanks(); !end(); skip_blanks()) {
      if (text_[at_] != '<') fail(at_, "text outside the root element; only comments may be there");
      if (!skip_comment_or_instruction()) return;
    }
  }

  bool skip_comment_or_instruction() {
    if (looking_at("<!--")) {
      skip_past("-->", 4, "this comment is never closed; it ends with -->");
    } else if (looking_at("<?")) {
      skip_past("?>", 2, "this processing instruction is never closed; it ends with ?>");
    } else if (looking_at("<!") && !looking_at("<![CDATA[")) {
      fail(at_, "document types and entity declarations are not supported; remove this declaration");
    } else {
      return false;
    }
    return true;
  }

  void skip_past(std::string_view close, std::size_t opening, const char* message) {
    const std::size_t found = text_.find(close, at_ + opening);
    if (found == std::string_view::npos) fail(at_, message);
    at_ = found + close.size();
  }

  std::string parse_name(const char* what) {
    const std::size_t begin = at_;
    if (end() || !is_name_start(text_[at_])) fail(at_, fmt::format("expected {} here", what));
    while (!end() && is_name(text_[at_])) ++at_;
    return std::string(text_.substr(begin, at_ - begin));
  }

  XmlElement parse_element(std::size_t depth) {
    XmlElement element;
    element.offset = at_;
    if (depth >= XmlDocument::kMaxDepth) {
      fail(at_, fmt::format("elements are nested deeper than {} levels; a scene needs 5", XmlDocument::kMaxDepth));
    }
    if (++elements_ > XmlDocument::kMaxElements) {
      fail(at_, fmt::format("the file holds more than {} elements; merge meshes", XmlDocument::kMaxElements));
    }
    ++at_;  // '<'
    element.name = parse_name("the name of an element");
    if (parse_attributes(element)) parse_content(element, depth);
    return element;
  }

  /// Reads up to and including '>' (returns true: content follows) or '/>' (false).
  bool parse_attributes(XmlElement& element) {
    for (;;) {
      const std::size_t before = at_;
      skip_blanks();
      if (end())
        fail(element.offset, fmt::format("the tag {} is never closed with > or />", text::quoted(element.name)));
      if (looking_at("/>")) {
        at_ += 2;
        return false;
      }
      if (text_[at_] == '>') {
        ++at_;
        return true;
      }
      if (text_[at_] == '<')
        fail(at_, fmt::format("'<' inside the tag {}; close the tag with > or />", text::quoted(element.name)));
      if (at_ == before) fail(at_, "expected a blank before the next attribute");
      XmlAttribute attribute = parse_attribute();
      if (element.find(attribute.name) != nullptr) {
        if (diagnostics_.wants_errors())
          diagnostics_.error(document_.position(attribute.offset),
                             fmt::format("attribute {} is given twice; keep one", text::quoted(attribute.name)));
      } else if (element.attributes.size() == XmlDocument::kMaxAttributes) {
        fail(attribute.offset,
             fmt::format("more than {} attributes; no element has more than 3", XmlDocument::kMaxAttributes));
      } else {
        element.attributes.push_back(std::move(attribute));
      }
    }
  }

  XmlAttribute parse_attribute() {
    XmlAttribute attribute;
    attribute.offset = at_;
    attribute.name = parse_name("an attribute, > or />");
    skip_blanks();
    if (end() || text_[at_] != '=')
      fail(at_, fmt::format("expected =\"…\" after attribute {}", text::quoted(attribute.name)));
    ++at_;
    skip_blanks();
    if (end() || (text_[at_] != '"' && text_[at_] != '\'')) {
      fail(at_, fmt::format("the value of attribute {} must be in quotes", text::quoted(attribute.name)));
    }
    const char quote = text_[at_++];
    attribute.value_offset = at_;
    const char stops[] = {quote, '<', '\0'};
    const std::size_t close = text_.find_first_of(stops, at_);
    if (close == std::string_view::npos || text_[close] == '<') {
      fail(attribute.offset,
           fmt::format("the value of attribute {} has no closing quote{}", text::quoted(attribute.name),
                       close == std::string_view::npos ? "" : " before the next '<' (written &lt; in a value)"));
    }
    attribute.value = decode(close, attribute.verbatim);
    at_ = close + 1;
    return attribute;
  }

  /// Text from here to `close` with references replaced.
  std::string decode(std::size_t close, bool& verbatim) const {
    std::string value(text_.substr(at_, close - at_));
    if (value.find('&') == std::string::npos) return value;
    verbatim = false;
    value.clear();
    for (std::size_t i = at_; i < close;) {
      if (text_[i] != '&') {
        value += text_[i++];
        continue;
      }
      const std::size_t semicolon = text_.find(';', i);
      if (semicolon == std::string_view::npos || semicolon > close)
        fail(i, "'&' starts a reference; write &amp; for the character");
      append_reference(value, text_.substr(i + 1, semicolon - i - 1), i);
      i = semicolon + 1;
    }
    return value;
  }

  static void append_reference(std::string& out, std::string_view name, std::size_t offset) {
    static constexpr std::pair<std::string_view, char> kPredefined[] = {
        {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}};
    for (const auto& [entity, character] : kPredefined) {
      if (name == entity) {
        out += character;
        return;
      }
    }
    if (!name.starts_with('#')) {
      fail(offset, fmt::format("entity {} is not defined; only amp, lt, gt, quot and apos are", text::quoted(name)));
    }
    const bool hex = name.starts_with("#x");
    const std::string_view digits = name.substr(hex ? 2 : 1);
    std::uint32_t code = 0;
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), code, hex ? 16 : 10);
    if (error != std::errc() || stop != digits.data() + digits.size() || !is_xml_character(code)) {
      fail(offset, fmt::format("character reference {} is not a character XML allows", text::quoted(name)));
    }
    append_utf8(out, code);
  }

  void parse_content(XmlElement& element, std::size_t depth) {
    for (;;) {
      report_stray_text(element);
      if (end()) fail(element.offset, fmt::format("<{0}> is never closed; add </{0}>", element.name));
      if (skip_comment_or_instruction()) continue;
      if (looking_at("<![CDATA[")) {
        diagnostics_.error(document_.position(at_),
                           "text between tags is not allowed here; put values into attributes");
        skip_past("]]>", 9, "this CDATA section is never closed");
      } else if (looking_at("</")) {
        parse_closing_tag(element);
        return;
      } else {
        element.children.push_back(parse_element(depth + 1));
      }
    }
  }

  void report_stray_text(const XmlElement& element) {
    const std::size_t stop = std::min(text_.find('<', at_), text_.size());
    skip_blanks();
    if (at_ < stop && diagnostics_.wants_errors()) {
      const std::string_view stray = text::trim(text_.substr(at_, stop - at_));
      diagnostics_.error(document_.position(at_),
                         fmt::format("stray text {} inside <{}>; put values into attributes or into a comment",
                                     text::quoted(stray), element.name));
    }
    at_ = stop;
  }

  void parse_closing_tag(const XmlElement& element) {
    const std::size_t begin = at_;
    at_ += 2;
    const std::string name = parse_name("the name of the element to close");
    if (name != element.name) {
      fail(begin, fmt::format("</{}> does not close <{}>, which was opened at line {}", name, element.name,
                              document_.position(element.offset).line));
    }
    skip_blanks();
    if (end() || text_[at_] != '>') fail(at_, fmt::format("expected > after </{}", name));
    ++at_;
  }

  std::string_view text_;
  const XmlDocument& document_;
  Diagnostics& diagnostics_;
  std::size_t at_ = 0;
  std::size_t elements_ = 0;
};

}  // namespace

const XmlAttribute* XmlElement::find(std::string_view attribute) const {
  for (const XmlAttribute& candidate : attributes) {
    if (candidate.name == attribute) return &candidate;
  }
  return nullptr;
}

XmlDocument::XmlDocument(std::string text, std::string file, Diagnostics& diagnostics)
    : text_(std::move(text)), file_(std::move(file)) {
  if (text_.size() > kMaxBytes) {
    diagnostics.error({file_, 0, 0},
                      fmt::format("the scene file has more than {} bytes; put geometry into mesh files", kMaxBytes));
    return;
  }
  index_lines();
  try {
    root_ = Parser(text_, *this, diagnostics).parse();
  } catch (const SyntaxError& error) {
    diagnostics.error(position(error.offset), error.message);
  }
}

void XmlDocument::index_lines() {
  line_starts_.push_back(text_.starts_with("\xef\xbb\xbf") ? 3 : 0);
  std::uint32_t continuation = 0;
  for (std::size_t i = 0; i < text_.size(); ++i) {
    if (i % kBlock == 0) continuation_bytes_.push_back(continuation);
    if (is_continuation(text_[i])) ++continuation;
    const bool line_end = text_[i] == '\n' || (text_[i] == '\r' && (i + 1 == text_.size() || text_[i + 1] != '\n'));
    if (line_end) line_starts_.push_back(static_cast<std::uint32_t>(i + 1));
  }
  continuation_bytes_.push_back(continuation);
}

SourcePosition XmlDocument::position(std::size_t offset) const {
  if (!places_.empty()) return {places_[std::min(offset, places_.size() - 1)], 0, 0};
  offset = std::min(offset, text_.size());
  const auto next = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
  const std::size_t line = static_cast<std::size_t>(std::max<std::ptrdiff_t>(next - line_starts_.begin(), 1));
  const std::size_t start = std::min<std::size_t>(line_starts_[line - 1], offset);
  const auto continuation_before = [&](std::size_t end) {
    const std::size_t block = end / kBlock;
    const auto first = text_.begin() + static_cast<std::ptrdiff_t>(std::min(block * kBlock, end));
    return continuation_bytes_[std::min(block, continuation_bytes_.size() - 1)] +
           static_cast<std::size_t>(
               std::count_if(first, text_.begin() + static_cast<std::ptrdiff_t>(end), is_continuation));
  };
  const std::size_t column = offset - start - (continuation_before(offset) - continuation_before(start)) + 1;
  return {file_, static_cast<int>(line), static_cast<int>(column)};
}

}  // namespace etendue
