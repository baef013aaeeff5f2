#!/usr/bin/env bash
# Builds the zips of the extension and of its cluster pack and installs them into a real Blender with fresh settings.
#
#   VENV, LUMENRAY_OUT, LUMENRAY_PROFILE   as for blender.sh and run_smoke.sh
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
project="$(cd "$here/../.." && pwd)"
export VENV="${VENV:-$project/.venv}"
export LUMENRAY_OUT="${LUMENRAY_OUT:-$project/out/real-blender}"
export LUMENRAY_PROFILE="${LUMENRAY_PROFILE:-profile}"

step() { printf '\n-- %s\n' "$1"; }
blender() { "$here/blender.sh" run blender "$@"; }

if [ "$(id -u)" -ne 0 ] || ! unshare --mount --pid --fork true; then
  echo "A real Blender runs in a system of its own, which takes root and the right to make namespaces
(unshare, mount, chroot). That is refused here, so what was asked for cannot be done, and counts as
failed. As an ordinary user, try sudo; in a container, give it the capability SYS_ADMIN." >&2
  exit 1
fi

step "a real Blender"
"$here/setup.sh"
mkdir -p "$LUMENRAY_OUT"
version='import sys; print("tag=cp%d%d" % sys.version_info[:2])'
tag="$(blender -b --factory-startup --python-expr "$version" 2>&1 | sed -n 's/^tag=//p')"
[ -n "$tag" ] || { echo "the real Blender does not tell its Python version" >&2; exit 1; }

step "the extension for its Python ($tag)"
rm -rf "${LUMENRAY_OUT:?}/$LUMENRAY_PROFILE" "$LUMENRAY_OUT/zip"
"$VENV/bin/python" "$project/packaging/build_extension.py" --platform linux-x64 --python "$tag" \
  --output "$LUMENRAY_OUT/zip"
"$VENV/bin/python" "$project/packaging/cluster_pack.py" --platform linux-x64 --python "$tag" \
  --output "$LUMENRAY_OUT/zip"

step "install and enable"
for zip in $(cd "$LUMENRAY_OUT/zip" && ls); do
  blender --command extension validate "/out/zip/$zip"
  blender -b --command extension install-file -r user_default --enable "/out/zip/$zip"
done
