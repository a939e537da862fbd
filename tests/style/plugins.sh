#!/bin/sh
# The scene-file word is the file name: each material has its shader, its reference and its test scene, and each of those
# files belongs to a material that the plugin table of src/formats/nori names.
set -eu
cd "$1"
status=0
# shellcheck disable=SC2012 # names without odd characters
words=$({ ls shaders/bsdf src/reference tests/scenes | sed -nE 's/^bsdf_(.*)\.(cpp|xml)$/\1/p'
  ls shaders/bsdf | sed -nE '/^bsdf\.glsl$/d; s/^(.*)\.glsl$/\1/p'; } | sort -u)
[ -n "$words" ] || { echo 'no material found in shaders/bsdf'; exit 1; }
for word in $words; do
  for file in "shaders/bsdf/$word.glsl" "src/reference/bsdf_$word.cpp" "tests/scenes/bsdf_$word.xml"; do
    [ -f "$file" ] || { echo "material $word: $file is missing"; status=1; }
  done
  grep -rqF "\"$word\"" src/formats/nori || { echo "material $word: no row in the plugin table of src/formats/nori"; status=1; }
done
exit $status
