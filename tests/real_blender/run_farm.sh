#!/usr/bin/env bash
# Does the tasks of Flamenco's jobs by hand in a real Blender, as Flamenco Worker would: an animation, a bake, and what has
# to fail. Needs Node.js, which compiles the jobs. Every step that does not succeed ends it with an error.
#
#   VENV, LUMENRAY_OUT   as for run_smoke.sh
#   LUMENRAY_INSTALLED   1: the extension is installed already
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export VENV="${VENV:-$project/.venv}"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE="${LUMENRAY_PROFILE:-farm-profile}"

[ "${LUMENRAY_INSTALLED:-0}" = 1 ] || "$here/install.sh"
"$VENV/bin/python" "$here/farm.py"
