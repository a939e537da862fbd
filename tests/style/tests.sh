#!/bin/sh
# Files of tests are named after what they test, without the word test. Exceptions: test_*.py, the names that pytest looks for, and
# device_test.h, named after the fixture DeviceTest. All functions in C++ have at most 60 lines; longer tables are constants outside of
# them.
set -eu
cd "$1"
status=0

names=$(find tests -type f \( -name '*_test.*' -o -name '*_tests.*' -o -name 'test_*.cpp' -o -name 'test_*.py' \) \
  ! -path 'tests/python/test_*.py' ! -path 'tests/bench/compare/test_*.py' ! -path 'tests/gpu/device_test.*' | sort)
for name in $names; do
  echo "$name: leave the word test out of the name"
  status=1
done

# Relies on clang-format: a function that begins in the first column ends with a } there; members of a class are two columns further.
# shellcheck disable=SC2046 # one word per file
awk '
  function check(end) {
    lines = end - body - 1
    if (body && lines > 60) { print FILENAME ":" start ": " lines " lines, more than 60: " name; bad = 1 }
    body = 0
  }
  FNR == 1 { start = body = member = 0; raw = "" }
  raw != "" { if (index($0, raw)) raw = ""; next }
  match($0, /R"[A-Za-z_]*\(/) {
    delimiter = ")" substr($0, RSTART + 2, RLENGTH - 3) "\""
    if (!index(substr($0, RSTART + RLENGTH), delimiter)) raw = delimiter
  }
  /^[A-Za-z_]/ {
    start = FNR; body = 0; name = $0
    member = /^(struct|class) /
  }
  member && /^  [A-Za-z_~]/ { start = FNR; body = 0; name = $0 }
  start && !body && /\{$/ && !(member && /^(struct|class) /) { body = FNR }
  /^\}$/ || (member && /^  \}$/) { check(FNR) }
  END { exit bad }
' $(find tests src include python examples -name '*.cpp' -o -name '*.h' | sort) || status=1
exit $status
