#!/bin/sh
# Names from files reach the screen through cli/results.h and core/terminal.h only, which clean them.
set -eu
cd "$1"
found=$(grep -rnE 'fmt::print\(|std::(cout|cerr)|(^|[^a-zA-Z_:])(printf|puts|fputs|fprintf|putchar)\(|fwrite\(' src \
  --include='*.cpp' --include='*.h' | grep -vE '^src/cli/results\.cpp:|^src/core/terminal\.cpp:' || true)
[ -z "$found" ] || { echo "$found"; echo 'results go through print_text, print_result or print_json, messages through log::'; exit 1; }
