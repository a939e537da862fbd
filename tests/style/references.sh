#!/bin/sh
# Every citation key in brackets is defined once in docs/references.md, and every key defined there is cited somewhere.
set -eu
cd "$1"
key='\[[A-Z][A-Za-z]+[12][0-9]{3}[a-z]?\]'
places='shaders src scenes tests tools docs cmake README.md CONTRIBUTING.md'
list=docs/references.md
status=0

cited() {
  # shellcheck disable=SC2086 # one word per place
  grep -srIoE "$key" $places --exclude="${list##*/}" --exclude='*.obj' --exclude-dir=corpus
}
used=$(cited | sed 's/.*:\[/[/' | sort -u)
defined=$(grep -oE "^- \*\*$key\*\*" "$list" | grep -oE "$key" | sort)
[ -n "$used" ] || { echo 'no citation found: does this test still look in the right places?'; exit 1; }

for entry in $(printf '%s\n' "$defined" | uniq -d); do
  echo "$list: $entry is defined twice"
  status=1
done
for entry in $used; do
  printf '%s\n' "$defined" | grep -qxF "$entry" && continue
  echo "$entry is not in $list; it is cited in:"
  cited | grep -F ":$entry" | sed 's/:\[.*//; s/^/  /' | sort -u
  status=1
done
for entry in $defined; do
  printf '%s\n' "$used" | grep -qxF "$entry" || { echo "$list: $entry is cited nowhere"; status=1; }
done
exit $status
