#include "formats/mitsuba/mitsuba_document.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.h"
#include "core/text.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

bool is_identifier(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

/// The canonical path of a folder or file, for comparisons.
std::string canonical(const std::string& path) {
  std::error_code unknown;
  const fs::path whole = fs::weakly_canonical(path, unknown);
  return unknown ? path : whole.string();
}

std::string slashed(std::string path) {
  std::ranges::replace(path, '\\', '/');
  return path;
}

bool has_child(const XmlElement& root, std::initializer_list<std::string_view> names) {
  return std::ranges::any_of(root.children, [&](const XmlElement& child) {
    return std::find(names.begin(), names.end(), child.name) != names.end();
  });
}

}  // namespace

bool is_mitsuba(const XmlElement& root) {
  if (root.name != "scene") return false;
  if (has_child(root, {"sensor"})) return true;
  if (has_child(root, {"camera"})) return false;
  return root.find("version") != nullptr || has_child(root, {"include", "default", "path", "alias"});
}

MitsubaDocument::MitsubaDocument(std::unique_ptr<XmlDocument> document, const ReadOptions& options,
                                 const TextLoader& load, Diagnostics& diagnostics)
    : diagnostics_(diagnostics) {
  for (const auto& [name, value] : options.overrides) {
    parameters_[name] = value;
    given_[name] = false;
  }
  folders_.push_back(fs::path(document->file()).parent_path().string());
  Expansion expansion{{canonical(document->file())}, load};
  take(std::move(document), root_);
  if (const XmlAttribute* version = root_.find("version")) version_ = version->value;
  has_only(root_, {"version"});
  expand(root_, expansion);
  collect_ids(root_);
  for (const auto& [name, id] : aliases_) {
    if (const XmlElement* target = find(id)) by_id_.emplace(name, target);
  }
  if (!diagnostics_.has_errors()) report_unused_overrides(options);
}

void MitsubaDocument::take(std::unique_ptr<XmlDocument> document, XmlElement& root) {
  root = *document->take_root();
  if (bytes_ > 0) shift(root, bytes_);
  const std::size_t base = bytes_;
  bytes_ += document->size() + 1;
  sources_.push_back({base, std::move(document)});
}

void MitsubaDocument::shift(XmlElement& element, std::size_t base) {
  element.offset += base;
  for (XmlAttribute& attribute : element.attributes) {
    attribute.offset += base;
    attribute.value_offset += base;
  }
  for (XmlElement& child : element.children) shift(child, base);
}

SourcePosition MitsubaDocument::position(std::size_t offset) const {
  const auto next = std::ranges::upper_bound(sources_, offset, {}, [](const Source& source) { return source.base; });
  const Source& source = next == sources_.begin() ? *next : *std::prev(next);
  return source.document->position(offset - source.base);
}

SourcePosition MitsubaDocument::value_position(const XmlAttribute& attribute, std::size_t offset) const {
  return position(attribute.value_offset + (attribute.verbatim ? offset : 0));
}

const XmlElement* MitsubaDocument::find(std::string_view id) const {
  const auto found = by_id_.find(id);
  return found == by_id_.end() ? nullptr : found->second;
}

std::vector<std::string> MitsubaDocument::ids() const {
  std::vector<std::string> ids;
  for (const auto& [id, element] : by_id_) ids.push_back(id);
  return ids;
}

std::string MitsubaDocument::resolve(std::string filename) const {
  filename = std::string(text::trim(filename));
  std::error_code unknown;
  for (const std::string& name : {filename, slashed(filename)}) {
    for (const std::string& folder : folders_) {
      const fs::path path = fs::path(folder) / name;
      if (fs::exists(path, unknown)) return path.string();
    }
  }
  return (fs::path(folders_.back()) / slashed(filename)).string();
}

/// Replaces directives by the elements that they include, and parameters by their values. This follows the order of the
/// text, which decides if several places set a parameter.
void MitsubaDocument::expand(XmlElement& element, Expansion& expansion) {
  std::vector<XmlElement> children = std::move(element.children);
  element.children.clear();
  element.children.reserve(children.size());
  for (XmlElement& child : children) {
    if (!diagnostics_.wants_errors()) return;
    if (++elements_ > MitsubaLimits::kMaxElements) {
      if (elements_ == MitsubaLimits::kMaxElements + 1)
        diagnostics_.error(position(child), fmt::format("with the files it includes the scene has more than {} "
                                                        "elements; merge meshes",
                                                        MitsubaLimits::kMaxElements));
      return;
    }
    substitute(child);
    if (child.name == "default") {
      add_default(child);
    } else if (child.name == "path") {
      add_path(child);
    } else if (child.name == "alias") {
      add_alias(child);
    } else if (child.name == "include") {
      include(child, element.children, expansion);
    } else {
      expand(child, expansion);
      element.children.push_back(std::move(child));
    }
  }
}

void MitsubaDocument::include(const XmlElement& element, std::vector<XmlElement>& into, Expansion& expansion) {
  if (!has_only(element, {"filename"})) return;
  const XmlAttribute& filename = *element.find("filename");
  const SourcePosition where = value_position(filename);
  std::string path = resolve(filename.value);
  std::error_code unknown;
  if (!fs::exists(path, unknown)) {  // next to the file that includes it
    const fs::path beside = fs::path(expansion.open.back()).parent_path() / slashed(filename.value);
    if (fs::exists(beside, unknown)) path = beside.string();
  }
  const std::string whole = canonical(path);
  if (std::ranges::find(expansion.open, whole) != expansion.open.end())
    return diagnostics_.error(where, fmt::format("{} includes itself, directly or through others; break the cycle",
                                                 text::quoted(filename.value)));
  if (expansion.open.size() > MitsubaLimits::kMaxIncludeDepth)
    return diagnostics_.error(where, fmt::format("includes are nested {} deep; at most {} are supported",
                                                 expansion.open.size(), MitsubaLimits::kMaxIncludeDepth));
  if (sources_.size() > MitsubaLimits::kMaxFiles) {
    if (std::exchange(too_many_files_, true)) return;
    return diagnostics_.error(
        where, fmt::format("the scene includes more than {} files; put them together", MitsubaLimits::kMaxFiles));
  }
  std::unique_ptr<XmlDocument> document;
  try {
    document = std::make_unique<XmlDocument>(expansion.load(path), path, diagnostics_);
  } catch (const Error& error) {
    return diagnostics_.error(where, fmt::format("included file {}", error.what()), error.kind());
  }
  if (!document->root()) return;
  if (bytes_ + document->size() > MitsubaLimits::kMaxBytes)
    return diagnostics_.error(where, fmt::format("with this file the scene has {} bytes; at most {} are supported",
                                                 bytes_ + document->size(), MitsubaLimits::kMaxBytes));
  XmlElement root;
  take(std::move(document), root);
  expansion.open.push_back(whole);
  substitute(root);
  expand(root, expansion);
  expansion.open.pop_back();
  if (root.name == "scene") {
    for (XmlElement& child : root.children) into.push_back(std::move(child));
  } else {
    into.push_back(std::move(root));
  }
}

void MitsubaDocument::add_default(const XmlElement& element) {
  if (!has_only(element, {"name", "value"})) return;
  const XmlAttribute& name = *element.find("name");
  if (name.value.empty() || !std::ranges::all_of(name.value, is_identifier))
    return diagnostics_.error(value_position(name), fmt::format("{} cannot be the name of a parameter; use letters, "
                                                                "digits and _",
                                                                text::quoted(name.value)));
  // The command line takes precedence, then the first place in the text.
  parameters_.emplace(name.value, element.find("value")->value);
  const auto given = given_.find(name.value);
  if (given != given_.end()) given->second = true;
}

void MitsubaDocument::add_path(const XmlElement& element) {
  if (!has_only(element, {"value"})) return;
  const XmlAttribute& value = *element.find("value");
  const std::string folder = resolve(value.value);
  std::error_code unknown;
  if (!fs::is_directory(folder, unknown))
    diagnostics_.warning(value_position(value),
                         fmt::format("{} is not a folder; it is not searched for files", text::quoted(value.value)));
  else
    folders_.insert(folders_.begin(), folder);
}

void MitsubaDocument::add_alias(const XmlElement& element) {
  if (has_only(element, {"id", "as"})) aliases_.emplace_back(element.find("as")->value, element.find("id")->value);
}

void MitsubaDocument::collect_ids(const XmlElement& element) {
  for (const XmlElement& child : element.children) {
    const XmlAttribute* id = child.find("id");
    if (id != nullptr && child.name != "ref" && !by_id_.emplace(id->value, &child).second)
      diagnostics_.error(value_position(*id),
                         fmt::format("the id {} is given twice, first in line {}; rename one", text::quoted(id->value),
                                     position(*by_id_.find(id->value)->second).line));
    collect_ids(child);
  }
}

void MitsubaDocument::substitute(XmlElement& element) {
  for (XmlAttribute& attribute : element.attributes) {
    if (attribute.value.find('$') == std::string::npos) continue;
    attribute.value = substituted(attribute);
    attribute.verbatim = false;
  }
}

std::string MitsubaDocument::substituted(const XmlAttribute& attribute) {
  std::string out;
  for (std::size_t i = 0; i < attribute.value.size();) {
    if (attribute.value[i] != '$') {
      out += attribute.value[i++];
      continue;
    }
    i = append_parameter(attribute, i, out);
    if (out.size() <= MitsubaLimits::kMaxValue && substituted_bytes_ + out.size() <= MitsubaLimits::kMaxSubstituted)
      continue;
    if (substituted_bytes_ <= MitsubaLimits::kMaxSubstituted)
      diagnostics_.error(value_position(attribute, i),
                         fmt::format("with its parameters this value has over {} bytes, or all such values together "
                                     "over {}; write less",
                                     MitsubaLimits::kMaxValue, MitsubaLimits::kMaxSubstituted));
    substituted_bytes_ = MitsubaLimits::kMaxSubstituted + 1;  // no further value is substituted
    return {};
  }
  substituted_bytes_ += out.size();
  return out;
}

/// The longest name that exists counts: with parameters `w` and `width`, $width is the latter. Returns the offset after
/// the name.
std::size_t MitsubaDocument::append_parameter(const XmlAttribute& attribute, std::size_t dollar, std::string& out) {
  const std::string& value = attribute.value;
  std::size_t end = dollar + 1;
  while (end < value.size() && is_identifier(value[end])) ++end;
  for (std::size_t stop = end; stop > dollar + 1; --stop) {
    const auto found = parameters_.find(std::string_view(value).substr(dollar + 1, stop - dollar - 1));
    if (found == parameters_.end()) continue;
    const auto given = given_.find(found->first);
    if (given != given_.end()) given->second = true;
    out += found->second;
    return stop;
  }
  const std::string name = value.substr(dollar + 1, end - dollar - 1);
  if (diagnostics_.wants_errors())
    diagnostics_.error(value_position(attribute, dollar),
                       name.empty() ? "a $ introduces the value of a parameter, but no name follows it"
                                    : fmt::format("the parameter ${} has no value; give one with -D {}=VALUE or by "
                                                  "<default name=\"{}\" value=\"…\"/> before this place",
                                                  name, name, name));
  return end;
}

bool MitsubaDocument::has_only(const XmlElement& element, std::initializer_list<const char*> names) {
  bool good = true;
  for (const XmlAttribute& attribute : element.attributes) {
    if (std::ranges::any_of(names, [&](const char* name) { return attribute.name == name; })) continue;
    good = false;
    diagnostics_.error(position(attribute.offset), fmt::format("<{}> has no attribute {}; it takes: {}", element.name,
                                                               text::quoted(attribute.name), fmt::join(names, ", ")));
  }
  if (&element == &root_) return good;
  for (const char* name : names) {
    if (element.find(name) != nullptr) continue;
    good = false;
    diagnostics_.error(position(element), fmt::format("<{}> lacks its attribute \"{}\"", element.name, name));
  }
  return good;
}

void MitsubaDocument::report_unused_overrides(const ReadOptions& options) {
  std::vector<std::string> known;
  for (const auto& [name, value] : parameters_) {
    if (!given_.contains(name)) known.push_back(name);
  }
  for (const auto& [name, value] : options.overrides) {
    if (given_[name]) continue;
    const std::string there = known.empty() ? "it has none" : "it has: " + text::join(known);
    diagnostics_.error({fmt::format("-D {}={}", name, value), 0, 0},
                       fmt::format("{} has no parameter {}{}; {}", file(), text::quoted("$" + name),
                                   text::did_you_mean(name, known), there),
                       ErrorKind::usage);
  }
}

}  // namespace etendue
