#!/usr/bin/env bash
# Measures in a real Blender's window how soon the sphere of a paint follows a slider; numbers go to LUMENRAY_OUT/paint.
#
#   VENV, LUMENRAY_OUT, LUMENRAY_PROFILE   as for run_smoke.sh
#   LUMENRAY_INSTALLED=1                   the extension is there already, in LUMENRAY_PROFILE
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"

[ -n "${LUMENRAY_INSTALLED:-}" ] || "$here/install.sh"
rm -rf "$LUMENRAY_OUT/paint"
"$here/blender.sh" run bash -euc '
  Xvfb :79 -screen 0 1600x1200x24 >/dev/null 2>&1 &
  export DISPLAY=:79
  for _ in $(seq 50); do xdotool getdisplaygeometry >/dev/null 2>&1 && break; sleep 0.2; done
  mkdir -p /out/paint
  blender --window-geometry 0 0 1600 1200 --python /project/tests/real_blender/paint_slider.py >/out/paint/log.txt 2>&1 || true'
grep -e "FAILED" -e "Traceback" "$LUMENRAY_OUT/paint/log.txt" >&2 && exit 1
grep -e "processors" -e "clock" -e "other" "$LUMENRAY_OUT/paint/log.txt"
