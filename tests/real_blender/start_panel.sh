#!/usr/bin/env bash
# Takes the guide's picture of the Start panel into docs/pictures: as Blender starts, with the room, after its bake, and when
# all its steps are done, side by side.
#
#   LUMENRAY_BLENDER            4.3 (default) or 5.2, as for blender.sh; it is in the picture's name
#   VENV, LUMENRAY_OUT          as for run_smoke.sh
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"

"$here/run_panels.sh" first_steps
# The panel is at the sidebar's top, and high while it has steps to show.
"$here/blender.sh" run bash -euc '
  cd panels
  convert sidebar_start{,_room,_baked,_done}.png -crop x480+0+0 +repage -bordercolor "#181818" -border 6 +append joined.png'
picture="$project/docs/pictures/start_panel_${LUMENRAY_BLENDER:-4.3}.png"
mv "$LUMENRAY_OUT/panels/joined.png" "$picture"
echo "$picture"
