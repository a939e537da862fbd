#!/bin/sh
# The loops of docs/farm.md, taken from the page and run as they stand there: farm_loops.sh ETENDUE SOURCE
set -eu
binary=$1
source=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir bin
ln -s "$binary" bin/etendue
PATH=$folder/bin:$PATH
cp -r "$source/scenes" scenes
sed -i 's/value="800"/value="40"/; s/value="600"/value="30"/' scenes/cbox-sphere.xml

# Prints the code block of the page that follows the marker comment.
block() {
  sed -n "/<!-- test: $1 -->/,/^\`\`\`\$/p" "$source/docs/farm.md" | sed '1,2d;$d'
}

etendue render scenes/cbox-sphere.xml --spp 64 --film -o one.exr -q || { [ $? -eq 4 ] && exit 77; exit 1; }

block loop > loop.sh
[ "$(wc -l < loop.sh)" -eq 3 ] || { echo "the shell loop has not three lines"; exit 1; }
sh -eu loop.sh
cmp one.exr result.exr

# A shard that failed is rendered again alone.
rm shard-2.exr result.exr
if etendue merge shard-[0-9]*.exr -o gap.exr --json | grep -q '"missing": 0'; then echo 'a missing shard went unnoticed'; exit 1; fi
block again > again.sh
sh -eu again.sh
cmp one.exr result.exr

# Frames: the same as one task would have made.
sed -i 's/value="480"/value="24"/; s/value="270"/value="14"/; s/name="sampleCount" value="64"/name="sampleCount" value="16"/' scenes/cameras/turntable.xml
block frames > frames.sh
sh -eu frames.sh
etendue render scenes/cameras/turntable.xml --frames 0:6 -o all-####.exr -q
for frame in 0 1 2 3 4 5; do cmp all-000$frame.exr turn-000$frame.exr; done

if command -v parallel >/dev/null; then
  rm -f shard-*.exr result.exr
  block parallel > parallel.sh
  [ "$(wc -l < parallel.sh)" -le 3 ] || { echo "GNU parallel takes more than three lines"; exit 1; }
  sh -eu parallel.sh
  cmp one.exr result.exr
else
  echo 'GNU parallel is not installed; its lines were not tried'
fi
