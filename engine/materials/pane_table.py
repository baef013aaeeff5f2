"""What a pane's table has to fulfil; known without Mitsuba, so that files can be checked where they are read."""

import numpy as np

from ..errors import SceneError
from ..scene.material import TabulatedPane

ROUNDING = 1e-6
"""By which values of a data sheet may exceed what energy allows. [-]"""


def check_table(pane: TabulatedPane) -> None:
    """Refuse a table that says nothing or that would make light.

    Raises
    ------
    SceneError    Says what is wrong with it.
    """
    columns = (pane.angles, pane.transmittance, pane.reflectance)
    angles, transmittance, reflectance = (np.asarray(c, dtype=np.float64) for c in columns)
    shapes = [column.shape for column in (angles, transmittance, reflectance)]
    if angles.ndim != 1 or angles.size == 0 or len(set(shapes)) > 1:
        raise SceneError(
            "a pane's table needs as many angles as transmittances and reflectances, and one at least; "
            f"found {', '.join(' x '.join(map(str, shape)) or 'a number' for shape in shapes)}"
        )
    for name, values in (
        ("angle", angles),
        ("transmittance", transmittance),
        ("reflectance", reflectance),
    ):
        if not np.isfinite(values).all():
            raise SceneError(f"a pane's table has a {name} that is not a finite number")
    if angles[0] < 0.0 or angles[-1] > 90.0 or np.any(np.diff(angles) <= 0.0):
        raise SceneError("a pane's angles must ascend strictly from 0 to 90 degrees at most")
    for name, values in (("transmittance", transmittance), ("reflectance", reflectance)):
        if values.min() < 0.0 or values.max() > 1.0:
            wrong = values[np.argmax(np.abs(values - 0.5))]
            raise SceneError(f"a pane's {name} is {wrong:g}, expected 0 to 1")
    total = transmittance + reflectance
    if total.max() > 1.0 + ROUNDING:
        place = int(np.argmax(total))
        raise SceneError(
            f"a pane transmits and reflects {total[place]:g} of the light at {angles[place]:g} degrees, more than all of it"
        )
