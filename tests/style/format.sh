#!/bin/sh
# C++ is formatted as .clang-format says.
set -eu
cd "$1"
find src tests include examples python -name '*.h' -o -name '*.cpp' | sort | xargs "$2" --dry-run -Werror
