"""Data sheets of panes: transmittance and reflectance by the angle of incidence, from text files."""

import numpy as np

from ..errors import FileFormatError, SceneError
from ..reading.content import read_bytes
from ..reading.text_table import MAXIMUM_BYTES, parse_rows
from ..scene.material import TabulatedPane

_COLUMNS = "angle, transmittance and reflectance"


def read_data_sheet(path) -> TabulatedPane:
    """Read a pane's data sheet.

    Parameters
    ----------
    path : str or Path    Text or CSV with three columns: angle to the normal in degrees, transmittance and reflectance,
        both 0 to 1; rows as `parse_rows` takes them, in any order.

    Raises
    ------
    FileFormatError    The file cannot be read as a data sheet; the message says what was expected.
    """
    rows = parse_rows(path, read_bytes(path, MAXIMUM_BYTES), 3, _COLUMNS)
    if not rows:
        raise FileFormatError(path, f"expected rows of {_COLUMNS}, found none")
    columns = np.array(sorted(row[1:] for row in rows), dtype=np.float64).T
    pane = TabulatedPane(*(np.ascontiguousarray(column) for column in columns))
    try:
        pane.check()
    except SceneError as error:
        raise FileFormatError(path, str(error)) from None
    return pane
