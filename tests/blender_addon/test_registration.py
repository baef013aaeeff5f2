"""Registration always succeeds; what is missing is said with its remedy."""

import os
import subprocess
import sys

PROBE = """
import sys
sys.modules["mitsuba"] = None
sys.modules["drjit"] = None
import bpy, lumenray
lumenray.register()
assert bpy.types.Scene.lumenray
assert "LUMENRAY" in {e.bl_idname for e in bpy.types.RenderEngine.__subclasses__() if hasattr(e, "bl_idname")}
from lumenray.engine.transport import backend
print("status:", backend.status().cause, "|", backend.status().remedy)
lumenray.unregister()
assert not hasattr(bpy.types.Scene, "lumenray")
lumenray.register()
"""

MISSING_LLVM = """
from lumenray.engine.transport import backend
print("status:", backend.status().cause, "|", backend.status().remedy)
"""


def run(script, **environment):
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return next(line for line in done.stdout.splitlines() if line.startswith("status:"))


def test_a_missing_engine_does_not_stop_registration():
    told = run(PROBE)
    assert "cannot be loaded" in told
    assert "reinstall Lumenray" in told


def test_a_wrong_llvm_is_named_with_the_remedy():
    told = run(MISSING_LLVM, DRJIT_LIBLLVM_PATH="/nowhere/libLLVM.so")
    assert "/nowhere/libLLVM.so" in told
    assert "DRJIT_LIBLLVM_PATH to the library" in told
