#pragma once
/// The outcomes of commands.

#include <variant>

#include "core/errors.h"

namespace etendue::cli {

/// The outcome of a command that threw no Error.
enum class Ending {
  ok,
  failed,       ///< a comparison or a statistical test failed
  interrupted,  ///< by a signal, after saving what was done
};

/// The result of a command: its outcome, or the kind of an error that it has already reported.
using Result = std::variant<Ending, ErrorKind>;

/// The exit code of the process. The numbers are in main.cpp and nowhere else.
int exit_code(Ending ending);
int exit_code(ErrorKind kind);

}  // namespace etendue::cli
