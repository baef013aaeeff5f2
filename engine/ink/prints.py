"""From the description of a pigment layer to its surface."""

from collections.abc import Callable
from pathlib import Path

from ..scene.material import Measured
from .computed import compute
from .ensemble import Progress, key_of
from .plan import make_plan
from .reader import parse_ink
from .surface import PrintedSurface


def print_surface(
    content: dict,
    *,
    draft: bool = False,
    folder: Path | None = None,
    processes: int = 1,
    report: Callable[[Progress], None] = lambda progress: None,
) -> PrintedSurface:
    """Compute what a pigment layer scatters.

    Parameters
    ----------
    content : dict    Description, as `reader.parse_ink` takes it.
    draft : bool    As of `plan.make_plan`.
    folder, processes, report    As of `ensemble.solve_ensemble`.

    Raises
    ------
    FileFormatError    The description breaks the schema or names what there is not; or the folder cannot be written.
    SceneError    The layer cannot be solved, or takes too much memory.
    EngineLost    A process ended by itself.
    """
    ink = parse_ink(content)
    plan = make_plan(ink, draft=draft)
    made = compute(ink, plan, folder, processes, report)
    table = made.table()
    return PrintedSurface(
        Measured(table, table),
        made.printed.wavelengths,
        made.readings,
        made.standard_errors,
        made.lab,
        made.lab_error,
        made.grid_error,
        plan.realisations,
        plan.seed,
        key_of(ink, plan),
        tuple(made.notes()),
    )
