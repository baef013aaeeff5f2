#!/usr/bin/env bash
# Takes the guide's pictures of Blender's window: each bundled scene (make scenes), opened in a real
# Blender with the extension installed, the viewport rendered by Lumenray.
#
#   screenshots.sh [SECONDS]   how long the viewport may render before the picture (default: 60)
#   VENV, LUMENRAY_OUT         as for run_smoke.sh
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
seconds="${1:-60}"
export LUMENRAY_PROFILE=screenshots-profile

scenes=("$project"/libraries/scenes/*.blend)
[ -e "${scenes[0]}" ] || { echo "there are no bundled scenes yet: make scenes" >&2; exit 1; }

"$here/install.sh"
for scene in "${scenes[@]}"; do
  name="$(basename "$scene" .blend)"
  "$here/blender.sh" shot "$seconds" "$project/docs/pictures/window_$name.png" \
    "/project/libraries/scenes/$name.blend" --python-exit-code 1 \
    --python /project/tests/real_blender/prepare_window.py
done
