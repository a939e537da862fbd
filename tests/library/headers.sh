#!/bin/sh
# Every public header compiles by itself, finds all it includes in the public tree, and includes nothing of its own by a short path.
# usage: headers.sh COMPILER FOLDER
set -eu
status=0
short=$(grep -rnE '^#include "' "$2" | grep -v '#include "etendue/' || true)
[ -z "$short" ] || { echo "$short"; status=1; }
for header in $(cd "$2" && find etendue -name '*.h' | sort); do
  echo "#include <$header>" | "$1" -std=c++20 -fsyntax-only -I "$2" -x c++ - || { echo "$header does not stand alone"; status=1; }
done
exit $status
