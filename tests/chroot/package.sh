#!/bin/bash
# The Debian packages on a bare system: package.sh RELEASE [BUILD]
#   RELEASE  bookworm, trixie (Debian 12, 13): that of this machine, as packages are for the release that they were made on
#   BUILD    a build folder that is complete (default: build/release)
# Makes the packages, installs them in a bare system with apt, renders a scene of theirs, compiles programs against the library with
# CMake and with pkg-config, removes everything and looks for what was left behind. Needs root, debootstrap, dpkg-dev, the network;
# ETENDUE_CHROOTS and ETENDUE_MIRROR as in bare.sh, which makes the bare system if there is none yet.
set -eu
release=${1:?usage: package.sh RELEASE [BUILD]}
here=$(cd "$(dirname "$0")" && pwd)
source=$(cd "$here/../.." && pwd)
build=$(cd "${2:-$source/build/release}" && pwd)
chroots=${ETENDUE_CHROOTS:-/var/tmp/etendue-chroots}
copy=$chroots/$release-package
say() { printf 'package.sh: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }
[ "$(id -u)" -eq 0 ] || die 'needs root: a chroot is made'

packages=$(mktemp -d)
leave() {
  code=$?
  for folder in proc sys dev; do umount -R -l "$copy/$folder" 2>/dev/null || true; done
  rm -rf "$packages"
  exit "$code"
}
trap leave EXIT

say "making the packages of $build"
(cd "$build" && cpack -G DEB -B "$packages" > "$packages/log" 2>&1) || { tail -n 20 "$packages/log" >&2; die 'cpack failed'; }
ls -l "$packages"/*.deb >&2

[ -d "$chroots/$release" ] || "$here/bare.sh" "$release" none true
say "copying $chroots/$release to $copy"
for folder in proc sys dev; do umount -R -l "$copy/$folder" 2>/dev/null || true; done
rm -rf --one-file-system "$copy"
cp -a "$chroots/$release" "$copy"
cp /etc/resolv.conf "$copy/etc/resolv.conf"
for folder in proc sys dev; do
  mount --rbind "/$folder" "$copy/$folder"
  mount --make-rslave "$copy/$folder"
done
inside() { chroot "$copy" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
# All files but those that packages of apt and dpkg keep for themselves.
files() { (cd "$copy" && find . -xdev \( -path ./proc -o -path ./sys -o -path ./dev -o -path ./tmp -o -path ./var \) -prune -o -print | sort); }

inside apt-get -q update > /dev/null
# What our packages need comes first, so that afterwards only what is ours is gone.
mkdir "$copy/root/packages"
cp "$packages"/*.deb "$copy/root/packages/"
say 'installing etendue'
inside sh -c 'apt-get -q install -y --no-install-recommends /root/packages/etendue_*.deb mesa-vulkan-drivers' > "$packages/apt" 2>&1 ||
  { tail -n 20 "$packages/apt" >&2; die 'etendue cannot be installed'; }
installed=$(inside dpkg-query -L etendue)
for file in /usr/bin/etendue /usr/share/doc/etendue/copyright /usr/share/etendue/scenes/cbox-sphere.xml; do
  echo "$installed" | grep -qxF "$file" || die "$file is not in the package"
done
say 'using it as a plain user'
inside useradd -m somebody
as_somebody() { inside su -l somebody -c "$1"; }
as_somebody 'etendue --version && etendue devices' || die 'it does not run'
as_somebody 'etendue render /usr/share/etendue/scenes/cbox-ajax.xml --size 64x48 --spp 1 && ls -l cbox-ajax.exr cbox-ajax.png' || die 'it does not render'
# dpkg of minimal images may leave manual pages and completions out; where it does not, they are there.
if ! inside sh -c 'grep -rqs "path-exclude.*man" /etc/dpkg/dpkg.cfg.d'; then
  [ -s "$copy/usr/share/man/man1/etendue.1.gz" ] || [ -s "$copy/usr/share/man/man1/etendue.1" ] || die 'there is no manual page'
fi

say 'installing libetendue-dev'
inside sh -c 'apt-get -q install -y --no-install-recommends /root/packages/libetendue-dev_*.deb g++ cmake ninja-build pkgconf' > "$packages/apt" 2>&1 ||
  { tail -n 20 "$packages/apt" >&2; die 'libetendue-dev cannot be installed'; }
cp -r "$source/examples/two_devices" "$copy/root/example"
inside sh -c 'cd /root && cmake -G Ninja -S example -B built > log 2>&1 && cmake --build built >> log 2>&1' || { tail -n 30 "$copy/root/log" >&2; die 'CMake does not find the library'; }
# shellcheck disable=SC2016 # expanded inside
inside sh -c 'cd /root && g++ $(pkg-config --cflags etendue) example/main.cpp -o two_devices $(pkg-config --libs etendue)' || die 'pkg-config does not find the library'
inside sh -c 'cd /root && ./built/two_devices auto 4 && ./two_devices auto 4' || die 'the programs do not run'

say 'removing both'
inside apt-get -q purge -y etendue libetendue-dev > "$packages/apt" 2>&1 || { cat "$packages/apt" >&2; die 'they cannot be removed'; }
left=$(files | grep -i etendue | grep -vE '^\./(root|home)(/|$)' || true)
[ -z "$left" ] || die "left behind: $left"
if inside dpkg -l 2>/dev/null | grep -i etendue; then die 'dpkg still knows them'; fi
say "the packages install, run and are removed on a bare $release"
