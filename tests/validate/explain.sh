#!/bin/sh
# `etendue explain`: device and reference report the same path for the same sample, all lights are counted, and a pixel outside
# the picture is refused.
set -eu
etendue=$1
scene=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# The columns with decisions. Radiance agrees only up to rounding, and the first line names the device.
decisions() { sed 1d "$1" | cut -c 1-74; }

for pixel in 95,100 110,100 120,30; do
  "$etendue" explain "$scene" --size 240x135 --pixel "$pixel" --sample 3 --device reference > "$folder/reference"
  "$etendue" explain "$scene" --size 240x135 --pixel "$pixel" --sample 3 --device auto > "$folder/device" || exit $?
  decisions "$folder/reference" > "$folder/a"
  decisions "$folder/device" > "$folder/b"
  [ "$(wc -l < "$folder/a")" -gt 2 ] || { echo "pixel $pixel: a path of one segment proves nothing"; exit 1; }
  diff "$folder/a" "$folder/b" || { echo "pixel $pixel: device and reference differ"; exit 1; }
done

"$etendue" explain "$scene" --size 240x135 --lights 5000 > "$folder/lights"
awk 'NR == 1 { total = $(NF - 5) } NR > 2 { sum += $(NF - 4); lights += 1 }
  END { if (lights != 4 || sum != total || total < 1000) { print "lights: " lights ", samples: " sum " of " total; exit 1 } }' "$folder/lights"

code=0
"$etendue" explain "$scene" --size 240x135 --pixel 240,0 > "$folder/out" 2> "$folder/error" || code=$?
[ "$code" = 2 ] && grep -q "'--pixel 240,0' names no pixel of 240x135" "$folder/error" || { cat "$folder/error"; exit 1; }
