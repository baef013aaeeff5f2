"""What a reader of one format of spectra hands over: the rows of the spectrum that was asked for."""

from dataclasses import dataclass

from ..errors import FileFormatError
from ..reading.remarks import Remark


@dataclass(frozen=True)
class SpectrumRows:
    """One of the spectra of a file.

    Parameters
    ----------
    format : str    For people.
    rows : list of (int, float, float)    Line of the file, wavelength [nm], value; in the order of the file.
    names : tuple of str    Of the spectra; empty where the file does not tell.
    count : int    How many spectra there are.
    spectra : str    What they are called, for messages.
    remarks : tuple of Remark
    """

    format: str
    rows: list[tuple[int, float, float]]
    names: tuple[str, ...] = ()
    count: int = 1
    spectra: str = "columns of values"
    remarks: tuple[Remark, ...] = ()


def check_column(path, column: int | None, count: int, spectra: str = SpectrumRows.spectra) -> None:
    """Refuse a column (from 1; None: the first) that a file does not have. Raises `FileFormatError`."""
    if column is not None and not 1 <= column <= count:
        raise FileFormatError(
            path, f"has {count} {spectra}, expected a column from 1 to {count}, not {column}"
        )
