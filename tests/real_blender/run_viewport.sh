#!/usr/bin/env bash
# Installs the extension into a real Blender and uses the rendered view of its window there: what is seen, faults, memory,
# closing. Pictures of the screen and results come to LUMENRAY_OUT/viewport.
#
#   run_viewport.sh [PART...]   look, faults, memory, close (default: all), some_memory, previews (of materials,
#                               worlds and lights), office (times of the view, no checks)
#   VENV, LUMENRAY_OUT          as for run_smoke.sh
#   LUMENRAY_INSTALLED=1        the extension is there already, in LUMENRAY_PROFILE
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE="${LUMENRAY_PROFILE:-viewport-profile}"

[ -n "${LUMENRAY_INSTALLED:-}" ] || "$here/install.sh"
rm -rf "${LUMENRAY_OUT:?}/viewport"
"$here/blender.sh" run python3 /project/tests/real_blender/watch_viewport.py /out/viewport "$@"
