#!/usr/bin/env bash
# Drags sun and ground of a photomontage, drops a picture of the surroundings onto the 3D view and drags its sun, in a real
# window with the mouse; requires the sun within a degree of the one that threw the shadow, and that all else followed.
#
#   VENV, LUMENRAY_OUT          as for run_smoke.sh
#   LUMENRAY_INSTALLED=1        the extension is there already, in LUMENRAY_PROFILE
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE="${LUMENRAY_PROFILE:-smoke-profile}"
export VENV="${VENV:-$project/.venv}"

rm -rf "$LUMENRAY_OUT/environment"
mkdir -p "$LUMENRAY_OUT/environment"
[ -n "${LUMENRAY_INSTALLED:-}" ] || "$here/install.sh"
"$VENV/bin/python" "$here/environment_files.py" "$LUMENRAY_OUT/environment"
"$here/blender.sh" run bash -euc '
  Xvfb :77 -screen 0 1280x800x24 >/dev/null 2>&1 &
  export DISPLAY=:77
  for _ in $(seq 50); do xdotool getdisplaygeometry >/dev/null 2>&1 && break; sleep 0.2; done
  cd /out/environment
  blender --window-geometry 0 0 1280 800 --python /project/tests/real_blender/environment.py >log.txt 2>&1 &
  # The last two places are those of a drag; a place before them is clicked.
  gesture() {
    for _ in $(seq 1800); do
      [ -f "$1.txt" ] && break
      if [ -f end.txt ]; then echo "the mouse was not heard; is the machine busy?" >&2; exit 1; fi
      sleep 0.5
    done
    sleep 2
    mapfile -t places <"$1.txt"
    if [ "${#places[@]}" -gt 2 ]; then
      xdotool mousemove ${places[0]}; sleep 1.5; xdotool click 1; sleep 1.5; places=("${places[@]:1}")
    fi
    read -r x y <<<"${places[0]}"; read -r to_x to_y <<<"${places[1]}"
    xdotool mousemove "$x" "$y"; sleep 2; xdotool mousedown 1; sleep 1
    for i in $(seq 15); do
      xdotool mousemove $((x + (to_x - x) * i / 15)) $((y + (to_y - y) * i / 15)); sleep 0.2
    done
    for _ in $(seq 180); do [ -f "$1.moved" ] && break; sleep 0.5; done
    import -window root "$1.png"
    xdotool mouseup 1; sleep 1
    touch "$1.done"
  }
  for name in shadow ground sun; do gesture "$name"; done
  for _ in $(seq 1800); do [ -f drop.txt ] && break; sleep 0.5; done
  # The menu of what a dropped picture may become opens with its last item, ours, below the mouse.
  sleep 15; xdotool mousemove_relative -- -4 -4; sleep 3; import -window root drop.png
  xdotool click 1; sleep 5
  touch drop.done
  gesture picture
  for _ in $(seq 600); do [ -f end.txt ] && break; sleep 0.5; done'

told="$LUMENRAY_OUT/environment/told.txt"
cat "$told"
awk '
  { for (i = 2; i <= NF; i++) value[$1, i] = $i }
  function apart(a, b,  i, sum) { for (i = 2; i <= 4; i++) sum += (value[a, i] - value[b, i]) ^ 2; return sqrt(sum) }
  END {
    if (value["shadow", 2] == "" || value["shadow", 2] > 1) { print "the sun is off by more than a degree"; bad = 1 }
    if (value["ground", 2] < 0.2) { print "the ground did not follow its arrow"; bad = 1 }
    if (apart("sun_before", "sun_after") < 0.1) { print "the sun did not follow its handle"; bad = 1 }
    if (value["dropped", 2] != "outside.hdr") { print "the picture was not dropped"; bad = 1 }
    if (apart("picture_before", "picture_after") < 0.1) { print "the sun of the picture did not follow"; bad = 1 }
    exit bad
  }' "$told"
