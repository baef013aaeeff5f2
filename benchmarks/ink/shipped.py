"""Colours of the layers that ship, as drafts; one that cannot be solved is told of by its reason."""

from ...engine.errors import SceneError
from ...engine.ink.computed import compute
from ...engine.ink.plan import make_plan, memory_of
from ...engine.ink.reader import read_ink
from ...libraries import inks


def measure_presets(say) -> list[dict]:
    """Solve all presets as drafts."""
    rows = []
    for path in inks.presets().values():
        ink = read_ink(path)
        plan = make_plan(ink, draft=True)
        say(ink.name)
        row = {"name": ink.name, "memory_bytes": memory_of(ink, plan), "problem": ""}
        try:
            made = compute(ink, plan)
        except SceneError as error:
            rows.append(row | {"problem": str(error)})
            continue
        rows.append(
            row
            | {
                "lab": made.lab.tolist(),
                "lab_error": made.lab_error,
                "wavelengths_nm": made.printed.wavelengths.tolist(),
                "reflectance": made.readings.tolist(),
                "grid_error": made.grid_error,
                "iterations": made.iterations,
            }
        )
    return rows
