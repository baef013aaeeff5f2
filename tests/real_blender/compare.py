"""Compare what a real Blender and the bpy wheel measured in the same scene (``smoke.json``).

The means of two independent estimates may differ by three standard errors of their difference; one
per cent is added for what may rightly differ between Blender versions, such as rounding in
the meshes. The same holds for the renders inside one record.
"""

import json
import math
import sys
from pathlib import Path

STANDARD_ERRORS = 3.0
"""Allowed difference, in combined standard errors."""

MARGIN = 0.01
"""Allowed difference beyond that, as a share of the mean."""

FLOOR_ILLUMINANCE = 1000.0 / (24.0 * (1.0 - 0.5))
"""What the floor of the closed box gets: a flux of 1000 lm from its middle, 24 m2, reflectance 0.5;
by symmetry each of the six faces gets the mean of all. [lx]"""


def differences(first, second):
    """Return a line for each quantity that two records share, and whether it agrees."""
    pairs = [
        # A render from the command line exists in the real Blender only.
        (name, value, second["measured"].get(name, second["measured"]["luminance"]))
        for name, value in first["measured"].items()
    ]
    balance = {"mean": FLOOR_ILLUMINANCE, "standard_error": 0.0}
    pairs.append(("illuminance by balance of flux", first["measured"]["illuminance"], balance))
    rows = []
    for name, value, expected in pairs:
        error = math.hypot(value["standard_error"], expected["standard_error"])
        allowed = STANDARD_ERRORS * error + MARGIN * abs(expected["mean"])
        difference = abs(value["mean"] - expected["mean"])
        text = f"{name}: {value['mean']:.6g} and {expected['mean']:.6g}, "
        text += f"difference {difference:.2g}, allowed {allowed:.2g}"
        rows.append((text, difference <= allowed))
    return rows


def main():
    """Compare two files; return the exit status."""
    first, second = (json.loads(Path(name).read_text(encoding="utf-8")) for name in sys.argv[1:])
    rows = differences(first, second)
    print(f"Blender {first['blender']} against {second['blender']} as a Python module")
    for text, agrees in rows:
        print(f"  {'agrees ' if agrees else 'DIFFERS'}  {text}")
    return 0 if all(agrees for _, agrees in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
