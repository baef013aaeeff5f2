#!/usr/bin/env bash
# Takes the guide's pictures of Blender's window into docs/pictures: the bundled office in a real Blender
# with the extension installed.
#
#   screenshots.sh [SECONDS [VIEW...]]   how long the window may take before the picture (default: 60), and which
#                                        pictures: light, luminaire, rayset, library, material, measured, world, sun_arc, render,
#                                        bake, bake_graph, baked, baked_lux, viewport, viewport_lux, first_hour_1,
#                                        first_hour_2, first_hour_3 (default: all); the baked ones want 300 seconds or
#                                        more
#   VENV, LUMENRAY_OUT                   as for run_smoke.sh
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
seconds="${1:-60}"
views=("${@:2}")
[ "${#views[@]}" -gt 0 ] || views=(light luminaire rayset library material measured world sun_arc render bake bake_graph baked baked_lux viewport viewport_lux first_hour_{1,2,3})
export LUMENRAY_PROFILE=screenshots-profile

"$here/install.sh"
for view in "${views[@]}"; do
  picture="window_$view.png"
  [[ "$view" != first_hour_* ]] || picture="$view.png"
  [ "$view" != luminaire ] || picture=luminaire_panel.png
  [ "$view" != sun_arc ] || picture=sun_arc.png
  [ "$view" != library ] || picture=luminaire_library.png
  "$here/blender.sh" shot "$seconds" "$project/docs/pictures/$picture" \
    --python-exit-code 1 --python /project/tests/real_blender/prepare_window.py -- "$view"
  grep -h "longest wait" "${LUMENRAY_OUT:-$project/out/real-blender}/shot.log" || true
done
