#!/bin/sh
# The manual page is one that groff and man set without a warning, and has every command and option. usage: manual.sh ETENDUE SOURCES
set -eu
etendue=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$etendue" --man > etendue.1
checked=
if command -v groff > /dev/null; then
  groff -ww -man -Tutf8 -Kutf8 etendue.1 > page 2> warnings
  checked=groff
fi
if command -v man > /dev/null && [ -z "$(man --warnings -l etendue.1 2>&1 > page | head -n 1)" ]; then checked="$checked man"; fi
if command -v mandoc > /dev/null; then mandoc -Tlint -Werror etendue.1; fi
[ -n "$checked" ] || { echo 'neither groff nor man is installed'; exit 77; }
[ ! -e warnings ] || [ ! -s warnings ] || { cat warnings; exit 1; }
status=0
col -b < page > text 2>/dev/null || sed 's/\x1b\[[0-9;]*m//g' page > text
for command in $("$etendue" --help | sed -n '/^Commands:$/,/^$/s/^  \([a-z][a-z0-9]*\) .*/\1/p'); do
  grep -q "etendue $command" text || { echo "etendue $command is not in the page"; status=1; }
  for option in $("$etendue" "$command" --help | sed -nE 's/^  (-.*)/\1/p' | grep -oE -- '^[^ ].{0,40}' | grep -oE -- '--[a-z][a-z-]*'); do
    grep -q -- "$option" text || { echo "$option of $command is not in the page"; status=1; }
  done
done
grep -q '130 interrupted' text || { echo 'exit codes are not in the page'; status=1; }
exit $status
