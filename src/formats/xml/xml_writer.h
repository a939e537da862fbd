#pragma once
/// Scene files in the making: XML text with properties as the dialects write them.

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

namespace etendue {

using XmlAttributes = std::vector<std::pair<std::string_view, std::string>>;

/// The shortest decimal that reads as the same double.
std::string shortest(double value);
std::string shortest(const glm::dvec3& v);

class XmlWriter {
 public:
  void comment(std::string_view text);
  void open(std::string_view tag, const XmlAttributes& attributes = {});
  void close();
  void leaf(std::string_view tag, const XmlAttributes& attributes);
  /// <tag name="…" value="…"/>
  void property(std::string_view tag, std::string_view name, std::string value);

  void number(std::string_view name, double value) { property("float", name, shortest(value)); }
  void integer(std::string_view name, std::int64_t value) { property("integer", name, std::to_string(value)); }
  void boolean(std::string_view name, bool value) { property("boolean", name, value ? "true" : "false"); }
  void text(std::string_view name, std::string value) { property("string", name, std::move(value)); }
  /// A transform by its matrix; nothing for identity.
  void transform(std::string_view name, const glm::dmat4& matrix);

  /// All of it, once everything is closed.
  const std::string& result() const { return text_; }
  /// The same without the declaration: elements to be pasted into a file.
  std::string elements() const { return text_.substr(text_.find('\n') + 1); }

 private:
  void start(std::string_view tag, const XmlAttributes& attributes);

  std::string text_ = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n";
  std::vector<std::string> open_;
};

}  // namespace etendue
