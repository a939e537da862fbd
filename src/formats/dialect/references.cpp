#include "formats/dialect/references.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/text.h"

namespace etendue {

References::References(const XmlDocument& document, const Dialect& dialect, Diagnostics& diagnostics)
    : document_(document), dialect_(dialect), diagnostics_(diagnostics) {
  std::vector<std::size_t> around;
  if (document.root()) collect(*document.root(), around);
  check_nesting();
}

const XmlElement* References::find(std::string_view id) const {
  const auto found = by_id_.find(id);
  return found == by_id_.end() ? nullptr : definitions_[found->second].element;
}

std::string References::suggest(std::string_view id) const {
  constexpr std::size_t kSearched = 1000, kListed = 10;  // limits the length of the sentence and the time to make it
  if (by_id_.empty()) return "; no object has one";
  std::vector<std::string> ids;
  for (auto next = by_id_.begin(); next != by_id_.end() && ids.size() < kSearched; ++next) ids.push_back(next->first);
  std::string text = text::did_you_mean(id, ids);
  if (ids.size() > kListed) return text;
  for (std::string& known : ids) known = text::quoted(known);
  return text + "; there are: " + text::join(ids);
}

/// `around` are the definitions that contain `element`: whatever uses them also uses the references inside.
void References::collect(const XmlElement& element, std::vector<std::size_t>& around) {
  const XmlAttribute* id = element.find("id");
  if (element.name == "ref" && id != nullptr) {
    used_.insert(id->value);
    for (const std::size_t definition : around) definitions_[definition].references.push_back(&element);
  }
  const bool defines = id != nullptr && dialect_.is_object_tag(dialect_.canonical(element.name));
  if (defines) {
    around.push_back(definitions_.size());
    add(element, *id);
  }
  for (const XmlElement& child : element.children) collect(child, around);
  if (defines) around.pop_back();
}

void References::add(const XmlElement& element, const XmlAttribute& id) {
  definitions_.push_back({&element, {}});
  const SourcePosition position = document_.position(id.value_offset);
  if (id.value.empty()) {
    diagnostics_.error(position, fmt::format("the id of this <{}> is empty; give it a name or none", element.name));
    return;
  }
  const auto [first, is_new] = by_id_.emplace(id.value, definitions_.size() - 1);
  if (is_new || !diagnostics_.wants_errors()) return;
  const XmlElement& other = *definitions_[first->second].element;
  diagnostics_.error(position, fmt::format("the id {} is given twice, first to the <{}> in line {}; rename one",
                                           text::quoted(id.value), other.name, document_.position(other.offset).line));
}

void References::check_nesting() {
  states_.assign(definitions_.size(), State::fresh);
  depths_.assign(definitions_.size(), 0);
  for (std::size_t i = 0; i < definitions_.size(); ++i) {
    if (states_[i] == State::fresh) visit(i);
  }
}

/// Depth first, with an explicit stack, because a file may contain a chain of a hundred thousand.
void References::visit(std::size_t first) {
  std::vector<Visit> path = {{first}};
  states_[first] = State::open;
  while (!path.empty()) {
    const std::size_t at = path.back().definition;
    if (path.back().next < definitions_[at].references.size()) {
      const XmlElement& ref = *definitions_[at].references[path.back().next];
      const auto target = by_id_.find(ref.find("id")->value);
      if (target == by_id_.end() || states_[target->second] == State::done) {
        ++path.back().next;
        if (target != by_id_.end()) deepen(at, target->second, ref);
      } else if (states_[target->second] == State::open) {
        ++path.back().next;
        report_circle(path, target->second, ref);
      } else {
        states_[target->second] = State::open;
        path.push_back({target->second});
      }
      continue;
    }
    states_[at] = State::done;
    path.pop_back();
  }
}

void References::deepen(std::size_t definition, std::size_t target, const XmlElement& ref) {
  std::size_t& depth = depths_[definition];
  const std::size_t before = depth;
  depth = std::max(depth, depths_[target] + 1);
  if (before >= kMaxNesting || depth < kMaxNesting) return;
  diagnostics_.error(
      document_.position(ref.offset),
      fmt::format("a chain of {} references starts here; at most {} are supported", depth, kMaxNesting - 1));
}

void References::report_circle(const std::vector<Visit>& path, std::size_t target, const XmlElement& ref) {
  constexpr std::size_t kShown = 8;
  std::vector<std::string> names;
  auto step = std::find_if(path.begin(), path.end(), [&](const Visit& v) { return v.definition == target; });
  for (; step != path.end() && names.size() < kShown; ++step)
    names.push_back(text::quoted(definitions_[step->definition].element->find("id")->value));
  if (step != path.end()) names.emplace_back("…");
  names.push_back(names.front());
  diagnostics_.error(document_.position(ref.offset),
                     fmt::format("this reference leads back to itself: {}; break the cycle", fmt::join(names, " → ")));
}

}  // namespace etendue
