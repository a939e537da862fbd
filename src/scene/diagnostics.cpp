#include "scene/diagnostics.h"

#include <utility>

#include <fmt/format.h>

#include "core/log.h"
#include "core/printable.h"

namespace etendue {

const char* to_string(Severity severity) {
  switch (severity) {
    case Severity::error:
      return "error";
    case Severity::warning:
      return "warning";
    case Severity::note:
      break;
  }
  return "note";
}

std::string to_string(const SourcePosition& position) {
  constexpr std::size_t kMostShown = 300;
  const std::string file = text::printable(position.file, kMostShown);
  return position.line == 0 ? file : fmt::format("{}:{}:{}", file, position.line, position.column);
}

std::string to_string(const Diagnostic& diagnostic) {
  const std::string place = to_string(diagnostic.position);
  const std::string message = text::printable(diagnostic.message, text::kLongestLine);
  return place.empty() ? message : place + ": " + message;
}

void Diagnostics::add(Diagnostic diagnostic) {
  const bool is_error = diagnostic.severity == Severity::error;
  if (is_error) ++errors_;
  // The first error is always kept, or a thousand warnings before it would hide why a file is refused.
  if (list_.size() < kMaxListed || (is_error && errors_ == 1)) {
    list_.push_back(std::move(diagnostic));
  } else {
    ++dropped_;
  }
}

void Diagnostics::error(const SourcePosition& position, std::string message, ErrorKind kind) {
  add({Severity::error, position, std::move(message), kind});
}

void Diagnostics::error_first(const SourcePosition& position, std::string message) {
  ++errors_;
  list_.insert(list_.begin(), {Severity::error, position, std::move(message), ErrorKind::scene});
}

void Diagnostics::warning(const SourcePosition& position, std::string message) {
  add({Severity::warning, position, std::move(message), ErrorKind::scene});
}

void Diagnostics::note(const SourcePosition& position, std::string message) {
  add({Severity::note, position, std::move(message), ErrorKind::scene});
}

void Diagnostics::throw_first_error() const {
  for (const Diagnostic& diagnostic : list_) {
    if (diagnostic.severity == Severity::error) throw Error(diagnostic.kind, to_string(diagnostic));
  }
}

void Diagnostics::log_warnings() const {
  for (const Diagnostic& diagnostic : list_) {
    if (diagnostic.severity == Severity::warning) log::warning(to_string(diagnostic));
    if (diagnostic.severity == Severity::note) log::debug(to_string(diagnostic));
  }
}

}  // namespace etendue
