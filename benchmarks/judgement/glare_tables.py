"""Tables of unified glare ratings beside that of CIE 190 and those of other programs."""

import csv
from pathlib import Path

import numpy as np

from ...engine.analysis.ugr_table import find_ugr_table
from ...engine.luminaires.formats.reader import read_luminaire

EXAMPLE, SPACING = "11", 1.0
"""Luminaire whose table CIE 190 prints, and its spacing. [H]"""

PROGRAMS = ("Dialux", "Relux")


def measure(folder: Path, say) -> dict:
    """Compare all luminaires of a folder with the tables beside them.

    Parameters
    ----------
    folder : Path    With ``sample_NN.ldt`` and ``ugr_table_NN_NAME.csv``.

    Returns
    -------
    dict    ``cie190`` and ``programs`` by luminaire and program, each with ``max`` and ``mean``; ``between``: of the
        programs among themselves.
    """
    made = {"programs": {}, "between": {}}
    for path in sorted(folder.glob("sample_*.ldt")):
        number = path.stem.removeprefix("sample_")
        file = read_luminaire(path)
        printed = folder / f"ugr_table_{number}_cie190.csv"
        if printed.exists():
            made["cie190"] = _apart(find_ugr_table(file, SPACING).values, _read(printed))
        ours = find_ugr_table(file).values
        tables = [_read(folder / f"ugr_table_{number}_{name}.csv") for name in PROGRAMS]
        made["programs"][number] = {
            name: _apart(ours, table) for name, table in zip(PROGRAMS, tables, strict=True)
        }
        made["between"][number] = _apart(tables[0].reshape(ours.shape), tables[1])
        say(f"judgement: glare table of sample {number}")
    return made


def _read(path: Path) -> np.ndarray:
    """Table of (19, 10) values, NaN where it only says that one is below 10."""
    with path.open(newline="") as file:
        rows = [row for row in csv.reader(file) if row]
    return np.array([[np.nan if "<" in cell else float(cell) for cell in row] for row in rows])


def _apart(ours: np.ndarray, theirs: np.ndarray) -> dict:
    apart = ours.reshape(theirs.shape) - theirs
    return {
        "max": float(np.nanmax(np.abs(apart))),
        "mean": float(np.nanmean(apart)),
        "values": int(np.isfinite(apart).sum()),
    }
