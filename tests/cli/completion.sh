#!/bin/sh
# Real shells complete commands, options, values and files with the script that the program writes for them.
# usage: completion.sh ETENDUE bash|zsh|fish
set -eu
etendue=$1
shell=$2
command -v "$shell" > /dev/null || { echo "$shell is not installed"; exit 77; }
here=$(cd "$(dirname "$0")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir bin files folder
ln -s "$etendue" bin/etendue
"$etendue" --completion "$shell" > script
"$shell" -n script
touch files/room.xml files/room.exr files/room.png files/notes.txt files/model.glb
mkdir files/rooms

# offers LINE: what is offered for the last word of the line, one a line.
offers() {
  case $shell in
    bash) bash --norc "$here/complete.bash" ./script "$1" ;;
    zsh) PATH=$folder/bin:$PATH zsh -f "$here/complete.zsh" script "$1" ;;
    fish) HOME=$folder fish --no-config -c 'source script; complete -C $argv[1]' "$1" | cut -f 1 ;;
  esac | sed 's/ *$//; /^$/d' | sort -u
}
status=0
# expect LINE WORDS: exactly these words are offered.
expect() {
  found=$(offers "$1" | tr '\n' ' ' | sed 's/ $//')
  [ "$found" = "$2" ] || { echo "$shell: '$1' offers '$found', not '$2'"; status=1; }
}
expect 'etendue re' 'render'
expect 'etendue che' 'check'
expect 'etendue render --no' '--no-clobber'
expect 'etendue render --se' '--seed'
expect 'etendue compare --no-f' '--no-flip'
expect 'etendue render --no-f' ''
expect 'etendue convert --to ' 'etendue mitsuba'
expect 'etendue render room.xml --tonemap a' 'aces'
expect 'etendue render files/room' 'files/room.xml files/rooms/'
expect 'etendue render files/m' 'files/model.glb'
expect 'etendue render room.xml -o files/room' 'files/room.exr files/room.png files/rooms/'
expect 'etendue render room.xml --resume files/room' 'files/room.exr files/rooms/'
expect 'etendue --completion f' 'fish'
expect 'etendue render room.xml --size ' ''
exit $status
