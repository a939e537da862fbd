# bash complete.bash SCRIPT LINE: prints what the script offers at the end of the line, as pressing Tab would.
source "$1"
[[ $(complete -p etendue) == 'complete -F _etendue etendue' ]] || { echo 'not registered'; exit 1; }
COMP_LINE=$2
COMP_POINT=${#COMP_LINE}
read -r -a COMP_WORDS <<< "$COMP_LINE"
if [[ $COMP_LINE == *' ' ]]; then COMP_WORDS+=(''); fi
COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
_etendue
for reply in "${COMPREPLY[@]}"; do
  if [[ -d $reply ]]; then reply+=/; fi
  printf '%s\n' "$reply"
done
