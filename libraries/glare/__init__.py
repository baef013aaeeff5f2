"""Guth's position index as CIE 117:1995, table 4.1 tabulates it, by the place of a source in the field of view."""

import csv
from functools import lru_cache
from pathlib import Path

import numpy as np


@lru_cache
def position_index() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the ratios T/R (31,) and H/R (20,) of the table and its values (31, 20), NaN where it has none. [-]

    T is the distance of a source to the side, H that above the eye, R that along the line of sight.
    """
    with (Path(__file__).parent / "position_index.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    values = [[float(cell) if cell else np.nan for cell in row] for row in rows]
    table = np.array(values)
    return table[:, 0], np.array(header[1:], dtype=np.float64), table[:, 1:]
