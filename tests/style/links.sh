#!/bin/sh
# Every relative link and picture of the Markdown pages leads to a file, and so does every path of the source tree they name in
# backticks (but for the material velvet, which is only an example).
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
  for name in $(grep -oE '`(src|shaders|tests|cmake|tools|scenes|docs)/[A-Za-z0-9_./-]+`' "$page" | tr -d '`' | grep -v velvet | sort -u); do
    [ -e "$name" ] || { echo "$page: there is no $name"; status=1; }
  done
done
exit $status
