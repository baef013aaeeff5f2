"""From the description of a paint to its surface."""

from collections.abc import Callable

import numpy as np

from ..scene.material import Measured
from .composition import Paint
from .reader import parse_paint
from .readings import ASPECULAR, lab_of, reflectances
from .sparkle import find_sparkles
from .surface import PaintedSurface
from .tabulation import Tabulated, compute

TABULATED = 0.8
"""Share of the work that is done when there is a table. [-]"""


def paint_surface(
    content: dict, report: Callable[[float], None] = lambda share: None
) -> PaintedSurface:
    """Compute what a composition scatters.

    Parameters
    ----------
    content : dict    Description of a paint, as `reader.parse_paint` takes it.
    report : callable    Told from time to time which share of the work is done; what it raises ends it.

    Raises
    ------
    FileFormatError    The description breaks the schema or names what there is not.
    SceneError    The paint cannot be solved.
    """
    paint = parse_paint(content)
    report(0.0)
    made = compute(paint, report=lambda share: report(TABULATED * share))
    report(TABULATED)
    table, wavelengths = made.table, made.solution.wavelengths
    values = reflectances(made.solution)
    return PaintedSurface(
        Measured(table, table, sparkles=find_sparkles(made.solution, table)),
        np.array(ASPECULAR),
        wavelengths,
        values,
        lab_of(values, wavelengths),
        made.convergence,
        tuple(_notes(paint, made)),
    )


def _notes(paint: Paint, made: Tabulated):
    """Say what the surface leaves out or assumes."""
    for remark in made.file().remarks:
        yield remark.text
    for layer in paint.layers:
        for flakes in layer.flakes:
            if flakes.diameters is None:
                name = flakes.name or "flakes"
                yield f"{name}: no diameter is stated, so the camera does not see them one by one"
    if any(flakes.diameters for layer in paint.layers for flakes in layer.flakes):
        yield (
            "flakes are seen one by one where the camera looks straight at them; mirrors, and light that is traced through "
            "bending glass, show their mean"
        )
