#!/bin/sh
# Every camera of our scenes names its pixel filter: pictures and known answers do not move when a default does.
set -eu
cd "$1"
ls scenes/*.xml tests/scenes/*.xml >/dev/null
awk '
  FNR == 1 { camera = 0 }
  /<camera[^>]*\/>/ { print FILENAME ":" FNR ": this camera names no <rfilter>"; bad = 1; next }
  /<camera/ { camera = FNR }
  /<rfilter/ { camera = 0 }
  /<\/camera>/ && camera { print FILENAME ":" camera ": this camera names no <rfilter>"; bad = 1; camera = 0 }
  END { exit bad }' scenes/*.xml tests/scenes/*.xml
