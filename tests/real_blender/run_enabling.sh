#!/usr/bin/env bash
# Tells what enabling the extension takes in a real Blender: a line of JSON for each start, see enabling.py. Before the first
# one nothing of it is compiled, as after Blender has installed it; later ones find what Python has kept.
#
#   VENV, LUMENRAY_OUT   as for run_smoke.sh
#   LUMENRAY_INSTALLED   not empty: the extension is in its profile already
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE="${LUMENRAY_PROFILE:-enabling-profile}"
starts=6

if [ -z "${LUMENRAY_INSTALLED:-}" ]; then "$here/install.sh"; fi
find "$LUMENRAY_OUT/$LUMENRAY_PROFILE/extensions/user_default/lumenray" -name __pycache__ -prune -exec rm -rf {} +
for _ in $(seq "$starts"); do
  "$here/blender.sh" run blender -b --factory-startup --python-exit-code 1 \
    --python /project/tests/real_blender/enabling.py
done
