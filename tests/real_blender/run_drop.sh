#!/usr/bin/env bash
# Drops a photometric file and assets of both libraries onto the 3D view of a real window, and requires a luminaire of the
# first two and the material on the object where it was dropped.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE="${LUMENRAY_PROFILE:-smoke-profile}"

rm -rf "$LUMENRAY_OUT/drop"
[ -n "${LUMENRAY_INSTALLED:-}" ] || "$here/install.sh"
"$here/blender.sh" run bash -euc '
  Xvfb :77 -screen 0 1600x1000x24 >/dev/null 2>&1 &
  export DISPLAY=:77
  for _ in $(seq 50); do xdotool getdisplaygeometry >/dev/null 2>&1 && break; sleep 0.2; done
  mkdir -p /out/drop
  blender --window-geometry 0 0 1600 1000 --python /project/tests/real_blender/drop.py >/out/drop/log.txt 2>&1 &
  drag() {
    for _ in $(seq 240); do [ -f "/out/drop/$1.txt" ] && break; sleep 0.5; done
    # The pictures of the assets are read in the background.
    sleep 5
    read -r x y to_x to_y <"/out/drop/$1.txt"
    # A busy machine may miss a gesture; a user would try again as well.
    for _ in 1 2 3; do
      xdotool mousemove "$x" "$y"; sleep 1; xdotool mousedown 1; sleep 0.5
      for i in $(seq 20); do
        xdotool mousemove $((x + (to_x - x) * i / 20)) $((y + (to_y - y) * i / 20)); sleep 0.1
      done
      sleep 1; xdotool mouseup 1; sleep 5
      if grep -q "$2" /out/drop/objects.txt; then break; fi
    done
  }
  drag luminaire "^LIGHT luminaire"
  drag material "^CUBE physical"
  import -window root /out/drop/window.png'

for kind in EMPTY LIGHT; do
  if ! grep -q "^$kind luminaire " "$LUMENRAY_OUT/drop/objects.txt"; then
    echo "run_drop.sh: no luminaire of type $kind came of the drop; see $LUMENRAY_OUT/drop" >&2
    exit 1
  fi
done
if ! grep -q "^CUBE physical" "$LUMENRAY_OUT/drop/objects.txt"; then
  echo "run_drop.sh: the material that was dropped is not on the cube; see $LUMENRAY_OUT/drop" >&2
  exit 1
fi
grep -e " luminaire " -e "^CUBE" "$LUMENRAY_OUT/drop/objects.txt" | sed 's/^/  ok     dropped: /'
