#!/bin/sh
# The Debian packages that cpack makes of this build: their fields, and what is in them. tests/chroot/package.sh installs them.
# usage: package.sh CPACK BUILD
set -eu
cpack=$1
build=$2
for program in dpkg-deb dpkg-shlibdeps file; do
  command -v $program > /dev/null || { echo "$program is not installed"; exit 77; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# gzip, because xz takes minutes.
(cd "$build" && "$cpack" -G DEB -B "$folder" -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip > "$folder/log" 2>&1) || { cat "$folder/log"; exit 1; }
status=0
fault() { echo "$*"; status=1; }
program=$(echo "$folder"/etendue_*.deb)
library=$(echo "$folder"/libetendue-dev_*.deb)

# field DEB NAME PATTERN
field() { dpkg-deb -f "$1" "$2" | grep -qE "$3" || fault "${1##*/}: $2 is '$(dpkg-deb -f "$1" "$2")', without '$3'"; }
field "$program" Section '^graphics$'
field "$program" Depends 'libc6 \('
field "$program" Depends 'libopenexr'
field "$program" Depends 'libvulkan1'
field "$program" Recommends 'mesa-vulkan-drivers'
field "$program" Maintainer '<[^ ]+@[^ ]+>$'
field "$library" Section '^libdevel$'
field "$library" Depends 'libopenexr-dev'
for deb in "$program" "$library"; do
  [ "$(dpkg-deb -f "$deb" Description | wc -l)" -ge 4 ] || fault "${deb##*/}: the description is short"
  [ "$(dpkg-deb -f "$deb" Description | awk '{ print (length > 80) }' | sort -u)" = 0 ] || fault "${deb##*/}: the description has long lines"
  dpkg-deb -x "$deb" "$folder/root"
  for name in copyright changelog.gz changelog.Debian.gz; do
    [ -s "$folder/root/usr/share/doc/$(dpkg-deb -f "$deb" Package)/$name" ] || fault "${deb##*/}: there is no $name"
  done
done
cd "$folder/root/usr"
for name in bin/etendue bin/etendue-sculpt share/man/man1/etendue.1.gz share/man/man1/etendue-sculpt.1.gz share/zsh/vendor-completions/_etendue \
  share/bash-completion/completions/etendue share/fish/vendor_completions.d/etendue.fish share/etendue/scenes/cbox-sphere.xml \
  include/etendue/etendue.h lib/libetendue.a lib/pkgconfig/etendue.pc lib/cmake/Etendue/EtendueConfig.cmake; do
  [ -s "$name" ] || fault "there is no /usr/$name"
done
other=$(find .. -mindepth 1 -not -path '../usr*')
[ -z "$other" ] || fault "outside of /usr: $other"
if file bin/etendue | grep -q 'not stripped'; then fault 'the program is not stripped'; fi
# What the scenes name is there: beside them, or with "etendue:" among the files that the build makes.
cd share/etendue/scenes
named=$(find . -name '*.xml' -exec grep -oE 'value="[A-Za-z0-9_./:-]+\.(obj|ply|png|hdr|exr|jpg)"' {} + |
  sed -E 's/^.*:value="etendue:(.*)"$/..\/meshes\/\1/; s/^(.*)\/[^/]*:value="(.*)"$/\1\/\2/' | sort -u)
[ "$(echo "$named" | wc -l)" -ge 15 ] || fault "the scenes name few files: $named"
for name in $named; do [ -s "$name" ] || fault "a scene names $name, which is not there"; done
# Without lintian this is all.
if command -v lintian > /dev/null; then
  complaints=$(lintian --allow-root --fail-on none "$program" "$library" 2>/dev/null | grep '^E:' || true)
  [ -z "$complaints" ] || fault "$complaints"
fi
exit $status
