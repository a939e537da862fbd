#!/bin/sh
# etendue-sculpt writes the same bytes on every machine: the sums below were taken once and must not move by accident.
set -eu
file=$(mktemp)
trap 'rm -f "$file"' EXIT
case $2 in
  sky) "$1" --kind sky --height 64 -o "$file" ;;
  *) "$1" --kind "$2" --triangles 20000 -o "$file" ;;
esac
sum=$(sha256sum "$file" | cut -d ' ' -f 1)
case $2 in
  bust) want=424713e7a8e3652bd20e9df9cd5f62bc9d7dc0df8ebf78865dcb374fbaa5a01c ;;
  sky) want=c45128d9780cedb50336b5fbcf424c058b8025d9cf9a884cbc04b5584f74c292 ;;
  bumpy-sphere) want=94128efb88e3b0fa7d654b0a786bf4c0cc5d660c7b717ee110565231bf2734f3 ;;
esac
[ "$sum" = "$want" ] || { echo "$2: sha256 is $sum, expected $want"; exit 1; }
