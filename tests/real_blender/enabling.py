"""Enables the installed extension in a Blender that has not loaded it, and tells what that takes.

Prints a line of JSON: seconds of the processor and of the clock, how many modules were loaded, and how many of these are the
extension's own. Call it by run_enabling.sh.
"""

import json
import resource
import sys
import time

import bpy

INSTALLED = "bl_ext.user_default.lumenray"


def processor_seconds() -> float:
    """Return what this process has taken of processors. [s]"""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


before = set(sys.modules)
begin, taken = time.perf_counter(), processor_seconds()
done = bpy.ops.preferences.addon_enable(module=INSTALLED)
clock, taken = time.perf_counter() - begin, processor_seconds() - taken
if done != {"FINISHED"}:
    sys.exit(f"{INSTALLED} cannot be enabled: {done}")
new = set(sys.modules) - before
told = {
    "blender": bpy.app.version_string,
    "processor_seconds": taken,
    "clock_seconds": clock,
    "modules": len(new),
    "own_modules": sum(name.startswith(INSTALLED) for name in new),
}
print("enabling=" + json.dumps(told))
