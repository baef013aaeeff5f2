#!/usr/bin/env bash
# Drags sun and ground of a photomontage, drops pictures of the surroundings onto the 3D view and drags their sun, in a real
# window with mouse and keyboard; requires the sun within a degree of the one that threw the shadow, and that all else
# followed. Pictures of the screen come to LUMENRAY_OUT/environment.
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
  timeout 900 blender --window-geometry 0 0 1280 800 --python /project/tests/real_blender/environment.py \
    >log.txt 2>&1 || echo "Blender ended with $?" >>log.txt'

"$VENV/bin/python" - "$LUMENRAY_OUT/environment" <<'END'
import json
import sys
from pathlib import Path

folder = Path(sys.argv[1])
record = folder / "record.json"
if not record.exists():
    sys.exit(f"nothing was done; the end of the log:\n{(folder / 'log.txt').read_text()[-2000:]}")
made = json.loads(record.read_text(encoding="utf-8"))
for name, value in made["numbers"].items():
    print(f"  {name}: {value}")
for check in made["checks"]:
    print(f"  {'ok    ' if check['holds'] else 'FAILED'} {check['text']}")
if not made["complete"] or not all(check["holds"] for check in made["checks"]):
    sys.exit(f"not all holds, or not all was done; see {folder}")
END
