#pragma once

#include <string>

namespace etendue {

/// A position in a text file; line and column count from 1 (0: unknown).
struct SourcePosition {
  std::string file;
  int line = 0;
  int column = 0;
};

}  // namespace etendue
