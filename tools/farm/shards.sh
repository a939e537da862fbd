#!/bin/sh
# Prints the sample range of shard I of N for a render of SPP samples per pixel: shards.sh I N SPP
# Shards are as equal as they can be; I counts from 0.
set -eu
[ $# -eq 3 ] || { echo "usage: shards.sh I N SPP" >&2; exit 2; }
[ "$1" -ge 0 ] && [ "$1" -lt "$2" ] && [ "$2" -le "$3" ] || { echo "shards.sh: expected 0 <= I < N <= SPP, got $1 $2 $3" >&2; exit 2; }
echo "$(($1 * $3 / $2)):$((($1 + 1) * $3 / $2))"
