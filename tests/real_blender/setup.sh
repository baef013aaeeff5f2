#!/usr/bin/env bash
# Puts a real Blender with a system of its own into a cache folder, made by debootstrap: Debian 13 (trixie)
# with Blender 4.3 on Python 3.13, or Debian unstable (sid) with Blender 5.2 on Python 3.14. The bpy wheel has no
# window, no command line and no way to install an extension from a zip, so these can only be tested in here.
#
# Needs root, Debian's archive, about 3 GB and five minutes once; later runs only look.
#
#   LUMENRAY_BLENDER        which one: 4.3 (default) or 5.2
#   LUMENRAY_REAL_BLENDER   where to put it (default ~/.cache/lumenray/real-blender; -trixie or -sid is added)
set -euo pipefail

root="$("$(dirname "${BASH_SOURCE[0]}")/blender.sh" root)"
suite="${root##*-}"
log="$root.log"
packages=(blender ca-certificates imagemagick libatomic1 libgl1-mesa-dri python3-numpy
  python3-requests xauth xdotool xvfb)
# What Blender's own tools for extensions need there, and what builds the wheels that no index has.
if [ "$suite" = sid ]; then packages+=(cmake g++ git ninja-build python3-cattr python3-dev python3-venv); fi

fail() { printf 'real Blender: %s\n' "$1" >&2; exit 1; }

missing_packages() {
  local package
  for package in "${packages[@]}"; do
    if ! chroot "$root" dpkg-query -W -f '${Status}\n' "$package" 2>/dev/null | grep -q ' installed$'; then
      echo "$package"
    fi
  done
}

[ "$(uname -s)" = Linux ] || fail "this way to a Blender works on Linux only"
[ "$(id -u)" -eq 0 ] || fail "root is needed to set up a system in a folder (debootstrap, chroot, mount)"

mkdir -p "$(dirname "$root")"
exec 9>"$root.lock"
flock 9  # one setup at a time; the others wait and then find everything there

if [ ! -e "$root/usr/bin/dpkg" ] || [ -d "$root/debootstrap" ]; then
  if ! command -v debootstrap >/dev/null; then
    command -v apt-get >/dev/null || fail "debootstrap is needed; install it"
    echo "real Blender: installing debootstrap"
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq debootstrap; } \
      >"$log" 2>&1 </dev/null || fail "debootstrap cannot be installed, see $log"
  fi
  echo "real Blender: making a Debian $suite in $root"
  rm -rf "$root.partial" "$root"
  debootstrap --variant=minbase "$suite" "$root.partial" >"$log" 2>&1 </dev/null \
    || fail "debootstrap did not succeed, the end of $log: $(tail -3 "$log")"
  mv "$root.partial" "$root"
fi

ln -sf /proc/self/mounts "$root/etc/mtab"
mapfile -t missing < <(missing_packages)
if [ "${#missing[@]}" -gt 0 ]; then
  echo "real Blender: installing ${missing[*]}"
  if [ -e /etc/resolv.conf ]; then cp -fL /etc/resolv.conf "$root/etc/resolv.conf"; fi
  unshare --mount bash -c '
    mount -t proc proc "$1/proc"; root=$1; shift
    chroot "$root" apt-get update -qq
    DEBIAN_FRONTEND=noninteractive chroot "$root" \
      apt-get install -y -qq --no-install-recommends "$@"' \
    install "$root" "${missing[@]}" >>"$log" 2>&1 </dev/null \
    || fail "the packages could not be installed, the end of $log: $(tail -3 "$log")"
  chroot "$root" apt-get clean
fi
echo "real Blender: $(chroot "$root" blender --version 2>/dev/null | head -1) in $root"
