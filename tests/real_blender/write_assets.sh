#!/usr/bin/env bash
# Writes libraries/luminaires/luminaires.blend with the real Blender, an older one than the bpy wheel's, so that all
# supported versions can open it.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE=smoke-profile

"$here/install.sh"
"$here/blender.sh" run blender -b --python-exit-code 1 --python /project/tests/real_blender/assets.py -- /out/assets
cp "$LUMENRAY_OUT/assets/luminaires.blend" "$LUMENRAY_OUT/assets/blender_assets.cats.txt" "$project/libraries/luminaires/"
