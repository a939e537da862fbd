#!/bin/bash
# Both commands of the README on a bare system: bare.sh RELEASE [STATE [COMMAND...]]
#   RELEASE  bookworm, trixie (Debian 12, 13), or another that debootstrap knows; one of Ubuntu, noble (24.04), with ETENDUE_MIRROR
#   STATE    none         nothing is installed (the default)
#            half-gtest   googletest and libgtest-dev are there, libgmock-dev is not
#            no-tests     no test package can be had: only `./run render` has to work, `./run tests` has to say what is missing
#   COMMAND  instead of the two commands; it runs in the copy of the sources
# Needs root, debootstrap and the network. Everything is under ETENDUE_CHROOTS (default: /var/tmp/etendue-chroots): the bare system, which is
# made once for each release, and a copy for the state, which is made afresh. Packages come from where this machine gets Debian's, else from
# where debootstrap takes them: ETENDUE_MIRROR changes that. ETENDUE_CHROOT_CCACHE=1 lets the copy use this machine's compiler cache.
set -eu
release=${1:?usage: bare.sh RELEASE [none|half-gtest|no-tests [COMMAND...]]}
state=${2:-none}
shift $(($# > 1 ? 2 : 1))
case $state in none | half-gtest | no-tests) ;; *) echo "bare.sh: '$state' is no state; none, half-gtest or no-tests is one" >&2; exit 2 ;; esac
source=$(cd "$(dirname "$0")/../.." && pwd)
chroots=${ETENDUE_CHROOTS:-/var/tmp/etendue-chroots}
bare=$chroots/$release
copy=$chroots/$release-$state
say() { printf 'bare.sh: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

[ "$(id -u)" -eq 0 ] || die 'needs root: a chroot is made'
command -v debootstrap >/dev/null || die 'debootstrap is not installed'
debian_mirror() { { cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null; } | grep -oE 'https?://[^ ]*/debian/?( |$)' | head -n 1 | tr -d ' '; }
mirror=${ETENDUE_MIRROR:-$(debian_mirror)}
# debootstrap has a script for each release; all those of Ubuntu are links to its first one.
script=${DEBOOTSTRAP_DIR:-/usr/share/debootstrap}/scripts/$release
[ -e "$script" ] || die "debootstrap does not know '$release'; install a newer one"
components=main
if [ "$(readlink "$script")" = gutsy ]; then
  [ -z "$mirror" ] || [ -n "${ETENDUE_MIRROR-}" ] || die "$release is a release of Ubuntu, and this machine's packages are Debian's; set ETENDUE_MIRROR to a mirror of Ubuntu"
  components=main,universe
fi

# The test packages of every release; with a priority below zero apt finds no version of them.
test_packages='googletest libgtest-dev libgmock-dev google-mock vulkan-validationlayers'

mounted=
leave() {
  code=$?
  for folder in $mounted; do umount "$folder" || say "$folder stays mounted"; done
  exit "$code"
}
trap leave EXIT

inside() { chroot "$copy" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }

make_bare() {
  say "making a bare $release in $bare"
  mkdir -p "$chroots"
  debootstrap --variant=minbase --components="$components" "$release" "$bare.new" ${mirror:+"$mirror"} > "$chroots/debootstrap.log" 2>&1 || {
    tail -n 5 "$chroots/debootstrap.log" >&2
    die "debootstrap failed, see $chroots/debootstrap.log"
  }
  # Proxies and the like: how apt reaches the mirror from here.
  grep -lE '^ *Acquire' /etc/apt/apt.conf.d/* 2>/dev/null | while read -r file; do cp "$file" "$bare.new/etc/apt/apt.conf.d/"; done
  mv "$bare.new" "$bare"
}

make_copy() {
  say "copying it to $copy"
  rm -rf --one-file-system "$copy"
  cp -a "$bare" "$copy"
  cp /etc/resolv.conf "$copy/etc/resolv.conf"
  git clone -q --no-hardlinks "$source" "$copy/root/etendue"
  for folder in proc sys dev; do
    mount --rbind "/$folder" "$copy/$folder"
    mount --make-rslave "$copy/$folder"
  done
}

# proc, sys and dev hold mounts of their own, so all that is below goes with them.
unmount_copy() { for folder in proc sys dev; do umount -R -l "$copy/$folder" 2>/dev/null || true; done; }

use_ccache() {
  inside apt-get -q install -y --no-install-recommends ccache >/dev/null
  mkdir -p "$copy/root/.cache/ccache"
  mount --bind "${CCACHE_DIR:-$HOME/.cache/ccache}" "$copy/root/.cache/ccache"
  mounted="$mounted $copy/root/.cache/ccache"
}

prepare_state() {
  case $state in
    half-gtest) inside apt-get -q install -y --no-install-recommends googletest libgtest-dev >/dev/null ;;
    no-tests)
      for package in $test_packages; do printf 'Package: %s\nPin: release *\nPin-Priority: -1\n\n' "$package"; done \
        > "$copy/etc/apt/preferences.d/no-tests"
      ;;
  esac
}

# run COMMAND...: in the copy of the sources; says how long it took, with the processor time.
run() {
  say "$*"
  # shellcheck disable=SC2016 # expanded inside
  inside bash -c 'cd /root/etendue && TIMEFORMAT="bare.sh: %R s, %U s + %S s of processor time" && time "$@"' bash "$@"
}

[ -d "$bare" ] || make_bare
unmount_copy
make_copy
# shellcheck disable=SC2064 # the copy's name is known now
trap "unmount_copy; leave" EXIT
inside apt-get -q update >/dev/null
[ -z "${ETENDUE_CHROOT_CCACHE-}" ] || use_ccache
prepare_state

if [ $# -gt 0 ]; then
  run "$@"
  exit
fi
run ./run render scenes/cbox-sphere.xml --spp 64
for file in cbox-sphere.exr cbox-sphere.png; do [ -s "$copy/root/etendue/$file" ] || die "no $file was written"; done
[ ! -e "$copy/root/etendue/build/release/share/etendue/meshes/bust.obj" ] || die 'a mesh was made that the scene does not name'
for package in googletest libgtest-dev libgmock-dev; do
  if [ "$state" != half-gtest ] && inside dpkg-query -W "$package" >/dev/null 2>&1; then die "$package was installed to render"; fi
done
if [ "$state" = no-tests ]; then
  said=$(run ./run tests 2>&1) && die './run tests worked without its packages'
  case $said in *libgtest-dev*) ;; *) die "./run tests does not say what is missing: $said" ;; esac
  # It must have spoilt nothing.
  run ./run render scenes/cbox-sphere.xml --spp 64 -o again.exr
else
  run ./run tests
fi
say "both commands work on a bare $release ($state)"
