#!/usr/bin/env bash
# Takes a picture of every panel at default width in a real Blender's window, into LUMENRAY_OUT/panels, for reading.
#
#   run_panels.sh [PART...]     first_steps, lights, tubes, light_list, luminaires, sensors, goniometers, materials, cloths, inks, worlds,
#                               renders, clusters, modelling, bakes, views, mixes (default: all)
#   VENV, LUMENRAY_OUT          as for run_smoke.sh
#   LUMENRAY_INSTALLED=1        the extension is there already, in LUMENRAY_PROFILE
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE="${LUMENRAY_PROFILE:-panels-profile}"

[ -n "${LUMENRAY_INSTALLED:-}" ] || "$here/install.sh"
rm -rf "$LUMENRAY_OUT/panels"
"$here/blender.sh" run bash -euc '
  Xvfb :78 -screen 0 1600x2400x24 >/dev/null 2>&1 &
  export DISPLAY=:78
  for _ in $(seq 50); do xdotool getdisplaygeometry >/dev/null 2>&1 && break; sleep 0.2; done
  mkdir -p /out/panels
  blender --window-geometry 0 0 1600 2400 --python /project/tests/real_blender/panel_pictures.py -- "$@" \
    >/out/panels/log.txt 2>&1 || true' panels "$@"
grep -e "^FAILED" -e "Traceback" "$LUMENRAY_OUT/panels/log.txt" >&2 && exit 1
[ -f "$LUMENRAY_OUT/panels/done" ] || { tail -5 "$LUMENRAY_OUT/panels/log.txt" >&2; exit 1; }
ls "$LUMENRAY_OUT"/panels/*.png
