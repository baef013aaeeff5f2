#!/usr/bin/env bash
# Installs what the viewer's test needs: Chromium and Node from Debian, and the pinned packages of package.json beside this
# file. Quick when all is there. Needs root where Debian's packages are missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

fail() { printf 'viewer: %s\n' "$1" >&2; exit 1; }

missing=()
command -v chromium >/dev/null || missing+=(chromium)
command -v node >/dev/null || missing+=(nodejs)
command -v npm >/dev/null || missing+=(npm)
if [ "${#missing[@]}" -gt 0 ]; then
  command -v apt-get >/dev/null || fail "these are needed: ${missing[*]}; install them"
  [ "$(id -u)" -eq 0 ] || fail "root is needed to install ${missing[*]}"
  echo "viewer: installing ${missing[*]}"
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
fi
# The lock's copy is there if its last version was installed to the end.
if ! cmp -s package-lock.json node_modules/.lumenray-lock; then
  npm ci --no-audit --no-fund --ignore-scripts --loglevel=error
  cp package-lock.json node_modules/.lumenray-lock
fi
echo "viewer: $(chromium --version 2>/dev/null | tail -1), node $(node --version)"
