#!/usr/bin/env bash
# Installs the extension into a real Blender, uses it there, and compares what it measures with the
# bpy wheel; then looks at the rendered view in a window. Every step that does not succeed ends it with an error.
#
#   VENV           the virtual environment (default: .venv in the repository)
#   LUMENRAY_OUT   folder of all results (default: out/real-blender in the repository)
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export VENV="${VENV:-$project/.venv}"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE=smoke-profile

step() { printf '\n-- %s\n' "$1"; }
blender() { "$here/blender.sh" run blender "$@"; }

"$here/install.sh"
rm -rf "${LUMENRAY_OUT:?}"/{real,wheel}

step "register, render, bake, register again"
blender -b --python-exit-code 1 --python /project/tests/real_blender/smoke.py -- use /out/real

step "render from the command line"
blender -b /out/real/box.blend -E LUMENRAY -o /out/real/line_ -F OPEN_EXR -f 1
blender -b --python-exit-code 1 --python /project/tests/real_blender/smoke.py -- read /out/real

step "the same with the bpy wheel"
"$VENV/bin/python" "$here/smoke.py" use "$LUMENRAY_OUT/wheel"

step "comparison"
"$VENV/bin/python" "$here/compare.py" "$LUMENRAY_OUT"/{real,wheel}/smoke.json

step "luminaires dropped in a window"
LUMENRAY_INSTALLED=1 "$here/run_drop.sh"

step "the rendered view in a window"
LUMENRAY_INSTALLED=1 "$here/run_viewport.sh" look close
