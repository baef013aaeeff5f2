#!/usr/bin/env bash
# Writes the Blender files that ship with the real Blender, an older one than the bpy wheel's, so that all supported versions
# can open them: the assets of a library (luminaires or materials), or the bundled scenes.
#
#   write_library.sh luminaires|materials|scenes
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE=smoke-profile
library="$1"
made="$LUMENRAY_OUT/libraries/$library"

rm -rf "$made"
[ -n "${LUMENRAY_INSTALLED:-}" ] || "$here/install.sh"
"$here/blender.sh" run blender -b --python-exit-code 1 --python /project/tests/real_blender/library.py -- \
  "/out/libraries/$library" "$library"
cp "$made"/*.blend "$project/libraries/$library/"
[ "$library" = scenes ] || cp "$made/blender_assets.cats.txt" "$project/libraries/$library/"
