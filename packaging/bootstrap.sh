#!/usr/bin/env bash
# Sets up everything that Lumenray's development needs, and says in one line per step what it did:
# Python 3.11, the virtual environment, LLVM for Dr.Jit, the system libraries that Dr.Jit and bpy load.
# Run it as often as you like: what is there already is only looked at.
#
#   VENV     where the virtual environment lies (default: .venv in the repository)
#   PYTHON   the Python 3.11 to make it with (default: python3.11 on the PATH)
#   DRJIT_LIBLLVM_PATH   an LLVM library of your own, instead of the one that is found
#
# As root on Debian or Ubuntu, missing system packages are installed; otherwise the command that
# installs them is printed and the script ends with an error.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
venv="${VENV:-$root/.venv}"
lock="$root/requirements.lock"
apt_updated=""

say() { printf '  %-10s %s\n' "$1" "$2"; }
fail() { printf '\nsetup failed: %s\n' "$1" >&2; exit 1; }

# ---- system packages ------------------------------------------------------------------------

has_apt() { command -v apt-get >/dev/null; }

refresh_apt() {
  [ -n "$apt_updated" ] && return
  apt-get update -qq || fail "apt-get update does not work here"
  apt_updated=yes
}

# install_packages REASON PACKAGE...
install_packages() {
  local reason="$1"; shift
  if ! has_apt; then fail "$reason. On Debian these packages hold it: $*"; fi
  if [ "$(id -u)" -ne 0 ]; then fail "$reason. Remedy: sudo apt-get install $*"; fi
  refresh_apt
  local log
  log="$(DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" \
    2>&1 </dev/null)" || fail "$reason, and 'apt-get install $*' does not work here:
$(tail -5 <<<"$log")"
}

# first_available PACKAGE...: the first one that apt knows
first_available() {
  local package
  for package in "$@"; do
    if [ -n "$(apt-cache policy "$package" 2>/dev/null | sed -n 's/^  Candidate: \([0-9]\)/\1/p')" ]; then
      echo "$package"; return
    fi
  done
  return 1
}

# ---- steps ----------------------------------------------------------------------------------

is_python311() { "$1" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; }

find_python() {
  python="${PYTHON:-python3.11}"
  if [ -z "${PYTHON:-}" ] && ! is_python311 "$python" && is_python311 python3; then python=python3; fi
  if ! is_python311 "$python"; then
    fail "Python 3.11 is needed (the bpy wheel of Blender 5.0 is made for it) and '$python' is not one.
Debian 12: sudo apt-get install python3.11-venv. Elsewhere: 'uv python install 3.11' or
'pyenv install 3.11'; then run PYTHON=/path/to/python3.11 make setup"
  fi
  if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    install_packages "$python cannot make virtual environments (its venv module is missing)" \
      python3.11-venv
  fi
}

make_venv() {
  if [ -x "$venv/bin/python" ] && is_python311 "$venv/bin/python"; then
    say Python "$("$venv/bin/python" --version | cut -d' ' -f2) in $venv"
    return
  fi
  find_python
  "$python" -m venv "$venv"
  say Python "$("$venv/bin/python" --version | cut -d' ' -f2): made $venv"
}

install_python_packages() {
  local stamp="$venv/lumenray-setup.sha256" wanted
  wanted="$({ echo "$root"; cat "$lock" "$root/pyproject.toml"; } | sha256sum | cut -d' ' -f1)"
  if [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ]; then
    say packages "as in requirements.lock (nothing to do)"
    return
  fi
  say packages "installing requirements.lock (about 630 MB the first time) ..."
  local quiet=(--disable-pip-version-check --no-input -q)
  if [ -n "${CI:-}" ] || [ ! -t 1 ]; then quiet+=(--progress-bar off); fi
  "$venv/bin/python" -m pip install "${quiet[@]}" -r "$lock" \
    || fail "pip could not install requirements.lock"
  "$venv/bin/python" -m pip install "${quiet[@]}" --no-deps --no-build-isolation -e "$root" \
    || fail "pip could not install the project itself"
  # The bpy wheel carries a tag of another Python, which newer pips remark upon; all else counts.
  local misfits
  misfits="$("$venv/bin/python" -m pip check 2>&1 | grep -vE "^bpy .* is not supported|^No broken" || true)"
  [ -z "$misfits" ] || fail "the packages do not fit each other: $misfits"
  echo "$wanted" >"$stamp"
  say packages "installed $(grep -c == "$lock") packages and the project itself"
}

# The LLVM library that the extension ships, where there is one for this system.
install_llvm() {
  [ "$(uname -sm)" = "Linux x86_64" ] || return 0
  local stamp="$venv/lumenray-llvm.txt" wheel
  wheel="$("$venv/bin/python" "$root/packaging/llvm_wheel.py" linux-x64)" || fail "there is no LLVM"
  [ "$(cat "$stamp" 2>/dev/null)" != "$wheel" ] || return 0
  "$venv/bin/python" -m pip install --disable-pip-version-check --no-input -q --no-deps \
    --force-reinstall "$wheel" || fail "pip could not install $wheel"
  echo "$wheel" >"$stamp"
}

# The engine's own check decides, by a small job.
check_engine() {
  local status
  status="$("$venv/bin/python" -c '
import sys
from lumenray.engine.transport import backend
found = backend.status()
print(found.cause if found.usable else f"{found.cause}; {found.remedy}")
sys.exit(not found.usable)' 2>&1)" || fail "$status"
  say engine "$status"
}

# package_of SONAME: the Debian package that holds it
package_of() {
  case "$1" in
    libEGL.so.1) echo libegl1 ;;
    libGL.so.1) echo libgl1 ;;
    libGLX.so.0) echo libglx0 ;;
    libGLdispatch.so.0) echo libglvnd0 ;;
    libICE.so.6) echo libice6 ;;
    libOpenGL.so.0) echo libopengl0 ;;
    libSM.so.6) echo libsm6 ;;
    libX11-xcb.so.1) echo libx11-xcb1 ;;
    libX11.so.6) echo libx11-6 ;;
    libXext.so.6) echo libxext6 ;;
    libXfixes.so.3) echo libxfixes3 ;;
    libXi.so.6) echo libxi6 ;;
    libXrandr.so.2) echo libxrandr2 ;;
    libXrender.so.1) echo libxrender1 ;;
    libXt.so.6) first_available libxt6 libxt6t64 ;;
    libXxf86vm.so.1) echo libxxf86vm1 ;;
    libatomic.so.1) echo libatomic1 ;;
    libdrm.so.2) echo libdrm2 ;;
    libgomp.so.1) echo libgomp1 ;;
    libstdc++.so.6) echo libstdc++6 ;;
    libuuid.so.1) echo libuuid1 ;;
    libwayland-client.so.0) echo libwayland-client0 ;;
    libxcb.so.1) echo libxcb1 ;;
    libxkbcommon.so.0) echo libxkbcommon0 ;;
    libz.so.1) echo zlib1g ;;
    *) return 1 ;;
  esac
}

# The names of the system libraries that no package brought, directly or not. Only the modules that
# Python loads are asked: each finds the libraries of its own wheel by itself.
missing_libraries() {
  local site="$venv/lib/python3.11/site-packages"
  ldd "$site"/drjit/_drjit_ext*.so "$site"/mitsuba/mitsuba_ext*.so "$site"/OpenEXR*.so \
    "$site"/xatlas*.so "$site"/PIL/_imaging.*.so "$site"/bpy/__init__.so \
    | sed -n 's/^[[:space:]]*\([^ ]*\) => not found.*/\1/p' | sort -u
}

check_libraries() {
  [ "$(uname -s)" = Linux ] || return 0
  local missing packages=() name package
  missing="$(missing_libraries)"
  if [ -z "$missing" ]; then
    say libraries "every system library that the packages need is there"
    return
  fi
  for name in $missing; do
    package="$(package_of "$name")" \
      || fail "the system library $name is missing, and this script knows no package that holds it"
    packages+=("$package")
  done
  install_packages "system libraries are missing ($(paste -sd ' ' <<<"$missing"))" "${packages[@]}"
  missing="$(missing_libraries)"
  [ -z "$missing" ] || fail "system libraries are still missing: $(paste -sd ' ' <<<"$missing")"
  say libraries "installed ${packages[*]}"
}

check_bpy() {
  local version
  version="$("$venv/bin/python" -c 'import bpy; print(bpy.app.version_string)' 2>&1 | tail -1)" \
    || fail "bpy cannot be imported: $version"
  say bpy "Blender $version as a Python module"
}

echo "Lumenray setup"
make_venv
install_python_packages
check_libraries
install_llvm
check_engine
check_bpy
