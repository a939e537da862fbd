#!/bin/sh
# `etendue view` starts the viewer next to the program; if there is none, it says what to do.
set -eu
etendue=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$etendue" view --help | grep -q -e '--listen ADDR' || { echo "no help of the viewer's"; exit 1; }
"$etendue" --help | grep -q ' view ' || { echo "the command is not listed"; exit 1; }
code=0
"$etendue" view scene.xml --prot 3 > "$folder/out" 2>&1 || code=$?
[ "$code" = 2 ] && grep -q -e '--prot' "$folder/out" || { echo "a wrong option: code $code"; cat "$folder/out"; exit 1; }
code=0
"$etendue" view scene.xml --listen 192.0.2.1 > "$folder/out" 2>&1 || code=$?
[ "$code" = 2 ] && grep -q '192.0.2.1' "$folder/out" || { echo "an address of another machine: code $code"; cat "$folder/out"; exit 1; }
cp "$etendue" "$folder/etendue"
code=0
"$folder/etendue" view scene.xml > "$folder/out" 2>&1 || code=$?
[ "$code" = 2 ] && grep -q './run view' "$folder/out" || { echo "without a viewer: code $code"; cat "$folder/out"; exit 1; }
