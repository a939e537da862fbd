#!/bin/sh
# The arrows of docs/architecture.md: what each folder of src may include besides itself.
set -eu
cd "$1/src"
status=0
while read -r folder allowed; do
  [ -d "$folder" ] || continue
  offences=$(grep -rnE '^ *#include "[a-z_]+/' "$folder" --include='*.h' --include='*.cpp' |
    grep -vE "#include \"($folder${allowed:+|$(echo "$allowed" | tr ' ' '|')})/" || true)
  # Only compile and gpu (and what stands above them) may see the structs shared with the shaders.
  case $folder in
    core | image | scene | formats | render | reference | vulkan | sculpt)
      offences="$offences$(grep -rn 'gpu_types\.h' "$folder" --include='*.h' --include='*.cpp' || true)" ;;
  esac
  if [ -n "$offences" ]; then
    printf 'src/%s may include %s only:\n%s\n' "$folder" "${allowed:-itself}" "$offences"
    status=1
  fi
done <<'RULES'
core
image core
scene image core
formats scene image core
render scene image core
compile scene image core
vulkan core
gpu compile vulkan render scene image core
reference render scene image core
sculpt image core
validate gpu compile vulkan reference render scene image core
bench gpu compile vulkan reference render scene image core
library etendue formats validate gpu compile vulkan reference render scene image core
cli library etendue formats bench validate gpu compile vulkan reference render scene image core
view cli library etendue formats validate gpu compile vulkan reference render scene image core
mutants cli validate gpu compile vulkan reference render scene image core
RULES
# A new folder has to be given its place above.
known=" core image scene formats render compile vulkan gpu reference sculpt validate bench library cli view mutants "
for folder in */; do
  case $known in
    *" ${folder%/} "*) ;;
    *) echo "src/$folder has no rule in tests/style/layers.sh"; status=1 ;;
  esac
done
exit $status
