#!/usr/bin/env bash
# Works with the real Blender that setup.sh made; LUMENRAY_BLENDER says which one: 4.3 (default) or 5.2.
#
#   blender.sh setup                     make it, if need be
#   blender.sh run COMMAND...            run a command inside
#   blender.sh shot SECONDS OUT.png [BLENDER ARGUMENTS...]
#                                        open Blender's window, wait, take a picture of the screen
#   blender.sh root                      print the folder that it lies in
#
# Inside, the repository is /project and cannot be written to; what is to come out goes to /out, which
# is the folder that LUMENRAY_OUT names (default: out/real-blender in the repository). Settings and
# extensions are those of LUMENRAY_PROFILE, a folder in /out (default: profile); remove it to start
# from Blender's factory settings. Every call has its own mounts and processes, which end with it.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
case "${LUMENRAY_BLENDER:-4.3}" in
  4.3) suite=trixie ;;
  5.2) suite=sid ;;
  *) echo "blender.sh: LUMENRAY_BLENDER is '$LUMENRAY_BLENDER', and only 4.3 and 5.2 are known" >&2; exit 2 ;;
esac
root="${LUMENRAY_REAL_BLENDER:-$HOME/.cache/lumenray/real-blender}-$suite"
out="${LUMENRAY_OUT:-$project/out/real-blender}"
profile="${LUMENRAY_PROFILE:-profile}"

fail() { printf 'blender.sh: %s\n' "$1" >&2; exit 1; }
usage() { sed -n 's/^# \{0,3\}//; 4,9p' "$0" >&2; exit 2; }

inside() {
  [ "$(id -u)" -eq 0 ] || fail "root is needed to enter the real Blender (unshare, mount, chroot)"
  [ -x "$root/usr/bin/blender" ] || fail "no Blender in $root: run tests/real_blender/setup.sh"
  mkdir -p "$out/$profile" "$root/project" "$root/out"
  local status=0
  unshare --mount --pid --fork --kill-child "$here/blender.sh" enter "$root" "$project" "$out" \
    -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 LIBGL_ALWAYS_SOFTWARE=1 \
    "BLENDER_USER_RESOURCES=/out/$profile" "$@" || status=$?
  [ "$status" -eq 0 ] || echo "blender.sh: '$1' inside the real Blender ended with $status" >&2
  return "$status"
}

# What happens in the mount and process namespace of a call, before its command takes over.
enter() {
  local root="$1" project="$2" out="$3"; shift 3
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  # Shared memory of its own, so that what is left there can be told from what others have.
  mkdir -p "$root/dev/shm"
  mount -t tmpfs tmpfs "$root/dev/shm"
  mount -t tmpfs tmpfs "$root/tmp"
  mount --bind "$project" "$root/project"
  mount -o remount,bind,ro "$root/project"
  mount --bind "$out" "$root/out"
  # Not by exec: this shell stays as the first process, which has duties that Blender does not know.
  chroot "$root" env --chdir=/out "$@" || exit $?
}

verb="${1:-}"
[ -n "$verb" ] || usage
shift
case "$verb" in
  setup) "$here/setup.sh" ;;
  run) [ $# -gt 0 ] || usage; inside "$@" ;;
  shot)
    [ $# -ge 2 ] || usage
    seconds="$1"; picture="$2"; shift 2
    rm -f "$out/shot.png"
    # Blender is not asked to quit: it ends with the process namespace.
    inside bash -euc '
      seconds=$1; shift
      Xvfb :77 -screen 0 1600x1000x24 >/dev/null 2>&1 &
      export DISPLAY=:77
      for _ in $(seq 50); do xdotool getdisplaygeometry >/dev/null 2>&1 && break; sleep 0.2; done
      blender --window-geometry 0 0 1600 1000 "$@" >/out/shot.log 2>&1 & blender=$!
      sleep "$seconds"
      if ! kill -0 "$blender" 2>/dev/null; then
        echo "Blender ended before the picture was taken:" >&2; tail -20 /out/shot.log >&2; exit 1
      fi
      import -window root /out/shot.png' shot "$seconds" "$@"
    mkdir -p "$(dirname "$picture")"
    mv "$out/shot.png" "$picture"
    echo "$picture" ;;
  root) echo "$root" ;;
  enter) enter "$@" ;;  # by unshare only
  *) usage ;;
esac
