#include "formats/xml/xml_writer.h"

#include <stdexcept>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
std::string shortest(double value) {
  return fmt::format("{}", value);
}

std::string shortest(const glm::dvec3& v) {
  return fmt::format("{}, {}, {}", v.x, v.y, v.z);
}

void XmlWriter::comment(std::string_view text) {
  std::string safe(text);
  for (std::size_t at = safe.find("--"); at != std::string::npos; at = safe.find("--")) safe.insert(at + 1, 1, ' ');
  text_ += fmt::format("{:{}}<!-- {} -->\n", "", 2 * open_.size(), safe);
}

void XmlWriter::start(std::string_view tag, const XmlAttributes& attributes) {
  text_ += fmt::format("{:{}}<{}", "", 2 * open_.size(), tag);
  for (const auto& [name, value] : attributes) text_ += fmt::format(" {}=\"{}\"", name, text::xml_escaped(value));
}

void XmlWriter::open(std::string_view tag, const XmlAttributes& attributes) {
  start(tag, attributes);
  text_ += ">\n";
  open_.emplace_back(tag);
}

void XmlWriter::close() {
  if (open_.empty()) throw std::logic_error("no element is open");
  const std::string tag = std::move(open_.back());
  open_.pop_back();
  text_ += fmt::format("{:{}}</{}>\n", "", 2 * open_.size(), tag);
}

void XmlWriter::leaf(std::string_view tag, const XmlAttributes& attributes) {
  start(tag, attributes);
  text_ += "/>\n";
}

void XmlWriter::property(std::string_view tag, std::string_view name, std::string value) {
  leaf(tag, {{"name", std::string(name)}, {"value", std::move(value)}});
}

void XmlWriter::transform(std::string_view name, const glm::dmat4& matrix) {
  if (matrix == glm::dmat4(1.0)) return;
  std::string numbers;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      numbers += (numbers.empty() ? "" : column == 0 ? ",  " : ", ") + shortest(matrix[column][row]);
  }
  open("transform", {{"name", std::string(name)}});
  leaf("matrix", {{"value", numbers}});
  close();
}

}  // namespace etendue
