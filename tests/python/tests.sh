#!/bin/sh
# pytest in the virtual environment that build.cmake made. $1: its Python, $2: the folder of the tests
set -eu
[ -x "$1" ] || { echo 'skipped: the module was not built, see python.build'; exit 77; }
exec "$1" -m pytest -q -p no:cacheprovider --durations=5 "$2"
