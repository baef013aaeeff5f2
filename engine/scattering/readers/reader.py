"""Scattering files: which format a file has, by its content.

Extensions are no help: ``.bsdf`` stands for three formats.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...errors import FileFormatError, SceneError
from ...reading.content import read_bytes
from ...reading.remarks import Remark
from ...scene.scattering import ScatterTable
from ..data.normal_incidence import add_normal_incidence
from ..data.record import ScatteringFile
from ..data.store import is_store, read_store
from ..file_names import MAXIMUM_SIZE
from .goniometer import read_goniometer
from .goniometer_text import is_goniometer
from .lighttools import is_lighttools, read_lighttools
from .mdl import is_mdl, read_mdl
from .merl import is_merl, read_merl
from .speos import is_speos, read_speos
from .tensor_file import is_tensor_file, read_tensor_file
from .window_xml import is_window_xml, read_window_xml
from .zemax import is_zemax, read_zemax

KNOWN = "Zemax and LightTools BSDF, WINDOW XML, RGL and MERL files, SPEOS, MDL, goniometer tables, or our own .lumbsdf"


@dataclass(frozen=True)
class Wish:
    """How a file is to be read.

    Parameters
    ----------
    tolerance : float    Error that is allowed where data have to be resampled, see `ScatterTable.error`. [-]
    is_strict : bool    Whether a file is refused that cannot be resampled so well; else that is a remark.
    """

    tolerance: float = 0.02
    is_strict: bool = False


def read_scattering(path, wish: Wish | None = None) -> ScatteringFile:
    """Read a scattering file.

    Raises
    ------
    FileFormatError    It cannot be opened, is of no known format, or breaks the rules of its own.
    """
    return parse_scattering(read_content(path), path, wish)


def read_content(path) -> bytes:
    """Return the content of a file.

    Raises
    ------
    FileFormatError    It cannot be opened or is too large.
    """
    return read_bytes(path, MAXIMUM_SIZE)


def parse_scattering(data: bytes, path, wish: Wish | None = None) -> ScatteringFile:
    """Read the content of a scattering file; ``path`` is for messages.

    Raises
    ------
    FileFormatError    It is of no known format, or breaks the rules of its own.
    """
    if not data:
        raise FileFormatError(path, "is empty")
    wish = wish or Wish()
    for is_one, read, is_resampled in _FORMATS:
        if is_one(data):
            try:
                made = read(data, path, wish.tolerance) if is_resampled else read(data, path)
                if read is read_store:
                    _refuse_stored(made, wish)
                    return made
                return _complete(_judge_errors(made, wish))
            except SceneError as error:
                raise FileFormatError(path, str(error)) from None
    raise FileFormatError(path, f"is no scattering file of a known format ({KNOWN})")


def _errors_above(file: ScatteringFile, tolerance: float) -> dict[str, float]:
    """Stated errors of the sides whose tables miss a tolerance."""
    return {
        side: scatter.error
        for side, scatter in file.sides.items()
        if isinstance(scatter, ScatterTable) and scatter.error > tolerance
    }


def _refuse_stored(file: ScatteringFile, wish: Wish) -> None:
    """Refuse a table that was made with a larger error than is wanted: no reading makes it better.

    Where no tolerance was asked for, the remarks of its making tell of it.
    """
    errors = _errors_above(file, wish.tolerance) if wish.is_strict else {}
    if errors:
        side = max(errors, key=errors.get)
        raise FileFormatError(
            file.path,
            f"states an error of {100 * errors[side]:.3g} % of its table of {side.replace('_', ' ')}, more than the "
            f"{100 * wish.tolerance:.3g} % that are allowed; make it anew from its source",
        )


def _judge_errors(file: ScatteringFile, wish: Wish) -> ScatteringFile:
    """Refuse a file whose tables miss the tolerance, or remark on it."""
    errors = _errors_above(file, wish.tolerance)
    if not errors:
        return file
    side = max(errors, key=errors.get)
    worst, values = errors[side], file.sides[side].values.size
    if wish.is_strict:
        raise FileFormatError(
            file.path,
            f"cannot be resampled with an error of {100 * wish.tolerance:.2g} %: {100 * worst:.2g} % was reached with "
            f"{values} values of {side.replace('_', ' ')}; the data may be noisier than that, so "
            f"allow {100 * worst:.2g} % or more",
        )
    told = tuple(
        Remark(
            f"{side.replace('_', ' ')} was resampled with an error of {100 * error:.2g} %, more than the "
            f"{100 * wish.tolerance:.2g} % that are allowed; the data may be noisier than that"
        )
        for side, error in errors.items()
    )
    return replace(file, remarks=(*file.remarks, *told))


def _complete(file: ScatteringFile) -> ScatteringFile:
    """Add light along the normal where isotropic tables lack it; sides that share a table still do."""
    made, told = {}, ()
    for scatter in file.sides.values():
        if isinstance(scatter, ScatterTable) and id(scatter) not in made:
            made[id(scatter)] = add_normal_incidence(scatter)
            if made[id(scatter)] is not None:
                lowest = f"{np.degrees(scatter.incidences[0]):.3g}"
                told = (Remark(f"light along the normal is extrapolated from {lowest} degrees on"),)
    if not told:
        return file
    sides = {side: made.get(id(scatter)) or scatter for side, scatter in file.sides.items()}
    incidences = file.incidences
    if not len(incidences):
        incidences = next(iter(file.sides.values())).incidences
    return replace(file, sides=sides, incidences=incidences, remarks=(*file.remarks, *told))


_FORMATS = (
    (is_store, read_store, False),
    (is_tensor_file, read_tensor_file, True),
    (is_merl, read_merl, True),
    (is_window_xml, read_window_xml, False),
    (is_mdl, read_mdl, True),
    (is_speos, read_speos, True),
    (is_lighttools, read_lighttools, True),
    (is_zemax, read_zemax, False),
    (is_goniometer, read_goniometer, True),
)
"""How formats are told, in the order in which they are tried, and whether their reader takes a tolerance."""
