#pragma once
/// What is wrong, or probably not meant, in the files a user gave: collected in one pass, so that all of it can be
/// listed.

#include <cstddef>
#include <string>
#include <vector>

#include "core/errors.h"
#include "scene/scene.h"

namespace etendue {

enum class Severity {
  error,    ///< the file cannot be used
  warning,  ///< legal, but probably not meant
  note,     ///< worth knowing when a file comes from somebody else
};

/// One finding. `message` is one sentence without a full stop: the thing, the number, what would be right.
struct Diagnostic {
  Severity severity = Severity::error;
  SourcePosition position;
  std::string message;
  ErrorKind kind = ErrorKind::scene;
};

/// "error", "warning", "note".
const char* to_string(Severity severity);
/// "file:line:column", or less where less is known.
std::string to_string(const SourcePosition& position);
/// "file:line:column: message".
std::string to_string(const Diagnostic& diagnostic);

/// Collects findings in reading order. At most `kMaxListed` are kept, so that a hostile file cannot fill the memory;
/// errors are counted beyond that.
class Diagnostics {
 public:
  static constexpr std::size_t kMaxListed = 1000;

  void error(const SourcePosition& position, std::string message, ErrorKind kind = ErrorKind::scene);
  /// The same before all that was found so far: what sums it up.
  void error_first(const SourcePosition& position, std::string message);
  void warning(const SourcePosition& position, std::string message);
  void note(const SourcePosition& position, std::string message);

  const std::vector<Diagnostic>& list() const { return list_; }
  std::size_t error_count() const { return errors_; }
  bool has_errors() const { return errors_ > 0; }
  /// False when another finding of that kind would only be counted: then its sentence need not be made, which keeps
  /// files with millions of problems quick.
  bool wants_errors() const { return errors_ < kMaxListed; }
  bool wants_warnings() const { return list_.size() < kMaxListed; }
  /// Findings that were not kept.
  std::size_t dropped() const { return dropped_; }

  /// Throws Error with the first error's position and sentence, if there is one.
  void throw_first_error() const;
  /// Sends warnings to the log (notes at debug level).
  void log_warnings() const;

 private:
  void add(Diagnostic diagnostic);

  std::vector<Diagnostic> list_;
  std::size_t errors_ = 0;
  std::size_t dropped_ = 0;
};

}  // namespace etendue
