#!/bin/sh
# Scenes find what the build made for them, in the build tree and in an installation, wherever that has been moved; what is missing is an
# error. usage: made_files.sh ETENDUE SOURCES
set -eu
etendue=$1
scene=$2/scenes/cbox-bumpy.xml
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
unset ETENDUE_MESHES
status=0
fault() { echo "$*"; cat "$folder/out"; status=1; }
# check PROGRAM TEXT: `check` fails with this text, or without one succeeds.
check() {
  code=0
  "$1" check "$scene" > "$folder/out" 2>&1 || code=$?
  [ "$code" -eq "$2" ] || fault "$1 ends with $code, not $2"
  grep -qF "$3" "$folder/out" || fault "$1 does not say: $3"
}

# Where the build has made it, which it may not have yet.
build=$(cd "$(dirname "$etendue")/.." && pwd)
made=$build/share/etendue/meshes/bumpy-sphere.obj
if [ -e "$made" ]; then
  check "$etendue" 0 "\"etendue:bumpy-sphere.obj\" is $made"
else
  check "$etendue" 3 "$made: cannot open the file: No such file or directory; 'cmake --build $build --target scenes' makes"
fi

# An installation.
mkdir -p "$folder/bin" "$folder/share/etendue/meshes"
cp "$etendue" "$folder/bin/etendue"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' > "$folder/share/etendue/meshes/bumpy-sphere.obj"
check "$folder/bin/etendue" 0 "is $folder/share/etendue/meshes/bumpy-sphere.obj"
mkdir "$folder/links"
ln -s "$folder/bin/etendue" "$folder/links/etendue"
check "$folder/links/etendue" 0 "is $folder/share/etendue/meshes/bumpy-sphere.obj"
mkdir "$folder/moved"
mv "$folder/bin" "$folder/share" "$folder/moved/"
check "$folder/moved/bin/etendue" 0 "is $folder/moved/share/etendue/meshes/bumpy-sphere.obj"
mv "$folder/moved/share/etendue/meshes" "$folder/elsewhere"
check "$folder/moved/bin/etendue" 3 "$folder/moved/share/etendue/meshes/bumpy-sphere.obj: cannot open the file: No such file or directory; set ETENDUE_MESHES"
export ETENDUE_MESHES="$folder/elsewhere"
check "$folder/moved/bin/etendue" 0 "is $folder/elsewhere/bumpy-sphere.obj"
exit $status
