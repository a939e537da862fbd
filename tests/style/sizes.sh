#!/bin/sh
# The repository stays quick to clone: no tracked file over 1.5 MB, no more than 12 MiB of pictures.
set -eu
cd "$1"
git() { command git -c safe.directory="*" "$@"; }  # of whoever the checkout is
git rev-parse --git-dir >/dev/null 2>&1 || exit 77
git ls-files -z | xargs -0 -r stat -c '%s %n' 2>/dev/null | awk '
  $1 > 1500000 { print $2 ": " $1 " bytes, more than 1.5 MB"; bad = 1 }
  $2 ~ /\.(png|jpg|jpeg|gif|exr|webp|svg)$/ { pictures += $1 }
  END {
    if (pictures > 12 * 1024 * 1024) { print "pictures: " pictures " bytes, more than 12 MiB"; bad = 1 }
    exit bad
  }'
