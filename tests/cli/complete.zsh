# zsh -f complete.zsh SCRIPT LINE: prints what the script offers at the end of the line when Tab is pressed there: a shell of its own on a
# pseudo terminal, in which compadd prints what it is given.
zmodload zsh/zpty || exit 77
cat > setup.zsh <<'SETUP'
PROMPT=
stty -echo 2>/dev/null
autoload -Uz compinit
compinit -u -D
source ./script
bindkey '^I' complete-word
zstyle ':completion:*' insert-tab false
begin_offers() { print -r -- '<offers>' }
end_offers() { print -r -- '</offers>'; exit }
compprefuncs=(begin_offers)
comppostfuncs=(end_offers)
zmodload zsh/zutil
compadd() {
  # Calls that only fill arrays offer nothing.
  if [[ ${@[1,(i)(-|--)]} == *-(O|A|D)\ * ]]; then builtin compadd "$@"; return $?; fi
  setopt localoptions extendedglob
  local -a hits descriptions
  local -A apre hpre hsuf
  integer folders=0
  zparseopts -E -a ignored P:=apre p:=hpre s:=hsuf
  [[ "${${@//-default-/}% -# *}" == *-[[:alnum:]]#f* ]] && folders=1
  builtin compadd -A hits -D descriptions "$@"
  local hit suffix
  for hit in $hits; do
    suffix=
    (( folders )) && [[ -d $hpre$hit ]] && suffix=/
    print -r -- "$apre$hpre$hit$suffix$hsuf"
  done
  builtin compadd "$@"  # so that _files sees that there were matches, and does not go on to all files
}
print ready
SETUP
zpty shell zsh -f -i
zpty -w shell 'source ./setup.zsh'
local text
repeat 20; do
  zpty -r shell text || break
  [[ $text == *ready* ]] && break
done
zpty -w -n shell "$2"$'\t'
integer offering=0
while zpty -r shell text; do
  text=${text%%$'\r'#$'\n'}
  text=${text//$'\r'/}
  [[ $text == *'</offers>'* ]] && break
  if (( offering )) && [[ -n $text ]]; then print -r -- $text; fi
  [[ $text == *'<offers>'* ]] && offering=1
done
