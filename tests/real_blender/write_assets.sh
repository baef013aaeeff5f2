#!/usr/bin/env bash
# Writes the assets of a library (luminaires, or the one that is named) with the real Blender, an older one than the bpy
# wheel's, so that all supported versions can open them.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE=smoke-profile
library="${1:-luminaires}"

"$here/install.sh"
"$here/blender.sh" run blender -b --python-exit-code 1 --python /project/tests/real_blender/assets.py -- \
  "/out/assets/$library" "$library"
cp "$LUMENRAY_OUT/assets/$library/$library.blend" "$LUMENRAY_OUT/assets/$library/blender_assets.cats.txt" \
  "$project/libraries/$library/"
