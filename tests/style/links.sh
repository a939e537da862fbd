#!/bin/sh
# Every relative link and picture of the Markdown pages leads to a file.
set -eu
cd "$1"
status=0
for page in *.md docs/*.md; do
  [ -f "$page" ] || continue
  # shellcheck disable=SC2013 # links hold no blanks
  for link in $(grep -oE '\]\([^) ]+' "$page" | sed -E 's/^\]\(//; s/#.*//' | sort -u); do
    case $link in http://* | https://* | mailto:*) continue ;; esac
    [ -e "$(dirname "$page")/$link" ] || { echo "$page: link to $link leads nowhere"; status=1; }
  done
done
exit $status
