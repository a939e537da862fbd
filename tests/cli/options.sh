#!/bin/sh
# Every option that a help text or a page of the docs names exists, and options that mean the same are called the same everywhere.
# usage: options.sh ETENDUE SOURCES
set -eu
etendue=$1
cd "$2"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
status=0
fault() { echo "$*"; status=1; }

commands=$("$etendue" --help | sed -n '/^Commands:$/,/^$/s/^  \([a-z][a-z0-9]*\) .*/\1/p')
[ "$(echo "$commands" | wc -w)" -ge 12 ] || fault "--help lists only these commands: $commands"
names=$(echo "$commands" | paste -sd "|" -)
for command in $commands; do "$etendue" "$command" --help > "$folder/$command.help"; done

# exists COMMAND OPTION: asks the program. What is told first is the first unknown option; the first of the two may be taken for a value.
exists() {
  if "$etendue" "$1" "$2" --no-such-option --no-such-option > /dev/null 2> "$folder/answer"; then  # help comes before all mistakes
    case $2 in -h | --help) ;; *) fault "$1 $2 --no-such-option was taken" ;; esac
  fi
  ! grep -qF "has no option '$2'" "$folder/answer"
}
exists render --spp || fault 'render --spp is not known: this test is broken'
if exists render --spq; then fault 'render --spq is known: this test is broken'; fi

# Words like "render --samples" and "--force" in the help of each command.
for command in $commands; do
  for option in $(sed -E "s/\b($names) --[a-z-]+//g" "$folder/$command.help" | grep -oE -- '--[a-z][a-z-]*' | sort -u); do
    exists "$command" "$option" || fault "the help of $command names $option, which it does not have"
  done
done

# "etendue render scene.xml --spp 4" in texts and scripts, as far as the line or the code goes; but for mistakes that are shown with their error.
named=$(cat "$folder"/*.help README.md docs/*.md |
  awk '/^error:/ { held = "" } { if (held != "") print held; held = $0 } END { print held }' |
  grep -oE "\b(etendue|\./run) ($names) [^\`|;&)]*" |
  sed -E 's/^(etendue|\.\/run) //' |
  awk '{ for (i = 2; i <= NF; ++i) if (match($i, /^--[a-z][a-z-]*/)) print $1, substr($i, RSTART, RLENGTH) }' | sort -u)
[ "$(echo "$named" | wc -l)" -ge 30 ] || fault "only these options were found in the docs: $named"
while read -r command option; do
  exists "$command" "$option" || fault "the docs name 'etendue $command … $option', which there is not"
done <<LIST
$named
LIST

# Commands that render take the same words for the same things; so does everything that tells results.
for command in render ttest validate bench explain; do
  for option in --size --spp --seed --define --device; do exists "$command" "$option" || fault "$command lacks $option"; done
done
for command in check convert; do
  for option in --size --spp --define; do exists "$command" "$option" || fault "$command lacks $option"; done
done
for command in $commands; do
  for option in --quiet --json -q -h; do exists "$command" "$option" || fault "$command lacks $option"; done
done
for command in render merge convert; do
  for option in -o --out --output; do exists "$command" "$option" || fault "$command lacks $option"; done
done
for option in --tonemap --exposure; do
  for command in render merge; do exists "$command" "$option" || fault "$command lacks $option"; done
done

# The same description, too, wherever the name is the same.
for option in --size --spp --json --quiet --junit; do
  texts=$(for command in $commands; do
    awk -v option="$option" '
      /^  -|^$|^[A-Z]/ { inside = $0 ~ "^  (-[a-z], )?" option "([ =[]|$)" }
      inside { gsub(/ +/, " "); printf "%s", $0 }
      END { print "" }' "$folder/$command.help"
  done | sed '/^$/d' | sort -u)
  [ "$(echo "$texts" | wc -l)" -eq 1 ] || fault "$option is described in several ways: $texts"
done

# Help is for people: none of the words that the library of options would write, and no lines beyond 80 columns.
for command in $commands; do
  if grep -nE 'TEXT|UINT|INT:|FLOAT|REQUIRED|Excludes|\{|\}| ENUM' "$folder/$command.help"; then fault "jargon in the help of $command"; fi
  if LC_ALL=C.UTF-8 grep -nE '^.{81,}' "$folder/$command.help"; then fault "long lines in the help of $command"; fi
done
exit $status
