"""Ray files: which format a file has, by its content, and its rays in pieces, checked.

Extensions are no help: ``.ray`` stands for four formats and ``.dat`` for three.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from ..errors import Cancelled, FileFormatError
from ..reading.remarks import Remark
from .asap import is_asap, read_asap
from .binary import Head
from .lighttools import is_lighttools, read_lighttools
from .record import RayFile, Rays
from .speos import is_speos, read_speos
from .text import Assumed, is_text, read_text
from .tm25 import is_tm25, read_tm25
from .zemax import is_zemax, read_zemax

MOST_BAD = 0.01
"""Share of rays that may be of no use. [-]"""

UNIT_TOLERANCE = 1e-3
"""Of the length of directions; beyond it, it is remarked that they are made unit vectors."""

SHORTEST_WAVELENGTH, LONGEST_WAVELENGTH = 100.0, 20_000.0
"""Of light and what is near it. [nm]"""

LARGEST = 1e4
"""Distance from the origin beyond which no ray of a source starts. [m]"""


def read_rayset(path, assumed: Assumed | None = None) -> RayFile:
    """Read the head of a ray file.

    Parameters
    ----------
    path : path
    assumed : Assumed or None    What is taken of texts that do not tell their units.

    Raises
    ------
    FileFormatError    It is of no known format, or breaks the rules of its own.
    """
    head = Head(path)
    if not head.data:
        raise FileFormatError(path, "is empty")
    for is_one, read in (
        (is_tm25, read_tm25),
        (is_lighttools, read_lighttools),
        (is_zemax, read_zemax),
        (is_asap, read_asap),
    ):
        if is_one(head):
            return read(path)
    if is_text(head.data):
        return read_text(path, assumed)
    if is_speos(head):
        return read_speos(path)
    raise FileFormatError(
        path,
        "is no ray file of a known format (IES TM-25, Zemax, LightTools, SPEOS, ASAP, or rows of numbers); "
        "export it as IES TM-25",
    )


@dataclass
class Faults:
    """What was found wrong with rays, counted.

    Parameters
    ----------
    rays : int    That were looked at.
    dark : int    Without flux: left out.
    lost : int    With numbers that are none, or without a direction: left out.
    skew : int    Whose direction was no unit vector: made one.
    """

    rays: int = 0
    dark: int = 0
    lost: int = 0
    skew: int = 0
    first_lost: int | None = field(default=None)

    def remarks(self) -> tuple[Remark, ...]:
        """What of it people should know."""
        made = []
        if self.dark:
            made.append(Remark(f"{self.dark} of {self.rays} rays carry no light and were left out"))
        if self.lost:
            made.append(
                Remark(
                    f"{self.lost} of {self.rays} rays, first number {self.first_lost + 1}, have numbers that are none "
                    "or no direction and were left out"
                )
            )
        if self.skew:
            made.append(
                Remark(
                    f"{self.skew} of {self.rays} directions were no unit vectors and were made so"
                )
            )
        return tuple(made)


def read_rays(
    file: RayFile,
    faults: Faults | None = None,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Iterator[Rays]:
    """Yield the rays of a file piece by piece, in SI but for their weights; those of no use are left out and counted.

    Parameters
    ----------
    file : RayFile
    faults : Faults or None    Takes note of what is wrong.
    progress : callable or None    Told the share of the file that has been read.
    cancelled : callable

    Raises
    ------
    FileFormatError    A ray has negative flux, or too many are of no use.
    Cancelled
    """
    faults = Faults() if faults is None else faults
    for rows in file.rows():
        if cancelled():
            raise Cancelled("cancelled")
        yield _check(file, rows, faults)
        if progress is not None:
            progress(min(faults.rays / max(file.count, 1), 1.0))
    if faults.lost > MOST_BAD * faults.rays:
        raise FileFormatError(
            file.path,
            f"{faults.lost} of {faults.rays} rays, first number {faults.first_lost + 1}, have numbers that are none or "
            f"no direction, expected at most {MOST_BAD:.0%}; it may be damaged, or of another format than {file.format}",
        )


def _check(file: RayFile, rows: np.ndarray, faults: Faults) -> Rays:
    columns, first = file.columns, faults.rays
    faults.rays += len(rows)
    weight = rows[:, columns.weight]
    with np.errstate(invalid="ignore", over="ignore"):
        direction = rows[:, columns.direction : columns.direction + 3].astype(np.float64)
        length = np.sqrt((direction**2).sum(axis=1))
        good = np.isfinite(weight) & np.isfinite(length) & (length > 0.0)
        if columns.position is None:
            position = np.zeros((len(rows), 3))
        else:
            position = rows[:, columns.position : columns.position + 3].astype(np.float64)
            position *= file.scale
            good &= np.isfinite(position).all(axis=1) & (np.abs(position) < LARGEST).all(axis=1)
        wavelength = None
        if columns.wavelength is not None:
            wavelength = rows[:, columns.wavelength].astype(np.float64) * file.wavelength_scale
            good &= (wavelength >= SHORTEST_WAVELENGTH) & (wavelength <= LONGEST_WAVELENGTH)
        spectrum = None
        if columns.spectrum is not None:
            number = rows[:, columns.spectrum]
            good &= (number >= 1.0) & (number <= len(file.spectra))
            spectrum = np.where(good, number, 1.0).astype(np.int32) - 1
        negative = good & (weight < 0.0)
    if negative.any():
        place = first + int(np.argmax(negative)) + 1
        raise FileFormatError(
            file.path, f"ray {place} has the flux {weight[negative][0]:g}, expected none below 0"
        )
    if not good.all():
        if faults.first_lost is None:
            faults.first_lost = first + int(np.argmin(good))
        faults.lost += int((~good).sum())
    dark = good & (weight == 0.0)
    faults.dark += int(dark.sum())
    kept = good & ~dark
    faults.skew += int((np.abs(length[kept] - 1.0) > UNIT_TOLERANCE).sum())
    unit = direction[kept] / length[kept, None]
    return Rays(
        position[kept].astype(np.float32),
        unit.astype(np.float32),
        weight[kept].astype(np.float32),
        None if wavelength is None else wavelength[kept].astype(np.float32),
        None if spectrum is None else spectrum[kept],
    )
