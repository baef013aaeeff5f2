"""From the description of a pigment layer to its surface, in the engine's process."""

import os
from collections.abc import Callable

from ..scene.material import Measured
from .computed import compute
from .ensemble import Progress
from .reader import parse_ink
from .surface import InkSurface

MOST_PROCESSES = 8


def ink_surface(
    content: dict, report: Callable[[float, float], None] = lambda share, seconds: None
) -> InkSurface:
    """Compute what a composition scatters, in as many processes as there are processors but one.

    Parameters
    ----------
    content : dict    Description, as `reader.parse_ink` takes it.
    report : callable    Told from time to time which share of the work is done, and the forecast of what is left [s]; what
        it raises ends it, and what was solved is kept.

    Raises
    ------
    FileFormatError    The description breaks the schema, or the folder of solved films cannot be written.
    SceneError    It cannot be solved.
    EngineLost    A process ended by itself.
    """

    def tell(progress: Progress) -> None:
        report(0.95 * progress.done / progress.total, progress.left)

    processes = min(max((os.cpu_count() or 2) - 1, 1), MOST_PROCESSES)
    made = compute(parse_ink(content), processes=processes, report=tell)
    table = made.table()
    return InkSurface(
        Measured(table, table),
        made.printed.wavelengths,
        made.readings,
        made.standard_errors,
        made.lab,
        made.lab_error,
        made.grid_error,
        made.plan.realisations,
        made.plan.seed,
        tuple(made.notes()),
    )
