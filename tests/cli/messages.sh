#!/bin/sh
# Every line on stderr begins with error:, warning: or note:, unless it tells progress; -q leaves errors and warnings only; --json is JSON and
# nothing else. usage: messages.sh ETENDUE SOURCES
set -eu
etendue=$1
scene=$2/scenes/cbox-sphere.xml
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
status=0
fault() { echo "$*"; status=1; }

# labelled NAME: what the last command wrote to stderr.
labelled() {
  if grep -vE '^(error|warning|note): .|^ *[0-9]+ %  |^[A-Z][a-z ]+: [0-9]+ %$' err; then fault "$1: the lines above have no label"; fi
}
json() {
  case $(head -c 1 "$1") in '{' | '[') ;; *) fault "$2: no JSON: $(head -n 1 "$1")" ;; esac
}

reference='--device reference --size 8x6 --spp 2'
# shellcheck disable=SC2086 # several words
{
  "$etendue" render "$scene" $reference -o a.exr -o a.png > out 2> err
  labelled render
  grep -q '^note: Rendered 8x6 at 2 spp' err || fault 'render says nothing'
  [ ! -s out ] || fault 'render writes to stdout'
  "$etendue" render "$scene" $reference -o a.exr -o a.png > out 2> err
  labelled 'render again'
  grep -q '^note: a.exr exists' err || fault 'render does not say what it replaces'
  "$etendue" render "$scene" $reference -o a.exr -q > out 2> err
  [ ! -s out ] && [ ! -s err ] || fault 'render -q is not quiet'
  "$etendue" render "$scene" $reference --film -o b.exr -q --seed 3 --json > out 2> err
  json out 'render --json'
  [ ! -s err ] || fault 'render -q --json is not quiet'
  "$etendue" render "$scene" $reference --out c.exr --json=c.json > out 2> err
  json c.json 'render --json=FILE'
  [ ! -s out ] || fault 'render --json=FILE writes to stdout'
  grep -q '^note: Rendered' err || fault 'render --json=FILE says nothing'
  "$etendue" validate "$scene" $reference --samples 100 --allow-untested -q > out 2> err || [ $? -eq 1 ]
  [ ! -s out ] || fault 'validate -q is not quiet'
  "$etendue" explain "$scene" $reference --seed 3 --sample 1 --json > out
  json out 'explain --json'
  if "$etendue" explain "$scene" $reference --sample 2 > out 2> err; then fault 'sample 2 of 2 is explained'; fi
  grep -q "'--sample 2' is not one of the 2 samples" err || fault 'explain: wrong complaint'
  "$etendue" bench "$scene" $reference --repetitions 1 --rays 64 --json > out
  json out 'bench --json'
  grep -q '"repeated_spp": 2\|"spp": 2' out || fault "bench does not take --spp: $(grep -i spp out)"
}
"$etendue" ttest "$2/scenes/ttest-furnace.xml" --device reference --spp 300 --seed 5 --json > out || [ $? -eq 1 ]
json out 'ttest --json'
grep -q '"samplesPerPixel": 300' out || fault "ttest does not take --spp: $(grep -i sample out | head -n 2)"
if "$etendue" ttest "$2/scenes/ttest-bsdfs.xml" --device reference --spp 3 2> err; then fault 'ttest --spp of materials'; fi
labelled 'ttest --spp of materials'
"$etendue" compare a.exr c.exr --no-flip --json > out 2> err
json out 'compare --json'
"$etendue" compare a.exr c.exr --no-flip --json=d.json > out 2> err
json d.json 'compare --json=FILE'
grep -q '^verdict' out || fault 'compare --json=FILE hides the text'
"$etendue" compare a.exr c.exr --no-flip -q > out 2> err
[ ! -s out ] && [ ! -s err ] || fault 'compare -q is not quiet'
"$etendue" check "$scene" --size 8x6 --json > out
json out 'check --json'
"$etendue" check "$scene" -q > out
[ ! -s out ] || fault 'check -q is not quiet'
"$etendue" merge b.exr --output whole.exr -o whole.png --json > out 2> err
json out 'merge --json'
"$etendue" convert "$scene" -o out.xml --size 20x10 --spp 7 2> err
labelled convert
grep -q '"width" value="20"' out.xml && grep -q '"sampleCount" value="7"' out.xml || fault 'convert does not take --size and --spp'
if "$etendue" convert "$scene" 2> err; then fault 'convert writes nothing and is content'; fi
labelled 'convert without a name'

# Tone mapping changes PNG files, says so in them, and leaves EXR files alone.
cp whole.exr before.exr
"$etendue" merge b.exr -o whole.exr -o shown.png --tonemap aces --exposure +1 -q
cmp -s whole.exr before.exr || fault '--tonemap changes the film'
if cmp -s whole.png shown.png; then fault '--tonemap does nothing'; fi
grep -aq 'toneMapping' shown.png && grep -aq 'exposure' shown.png || fault 'shown.png does not say how it is shown'
if "$etendue" merge b.exr -o whole.exr --tonemap aces 2> err; then fault '--tonemap without a PNG file'; fi
labelled '--tonemap without a PNG file'
"$etendue" compare shown.png whole.png --no-flip > out 2> err || true
grep -q '^warning: shown.png: was written with --tonemap' err || fault 'compare does not warn of a tone-mapped picture'

# Mistakes.
for line in 'rendr' 'render --spq 3' 'render a.xml --spp 0' 'render a.xml b.xml' '' 'render missing.xml' 'compare a.exr' '--what'; do
  # shellcheck disable=SC2086
  if "$etendue" $line > out 2> err; then fault "'$line' is no mistake"; fi
  labelled "'$line'"
  [ ! -s out ] || fault "'$line' writes to stdout"
done
exit $status
