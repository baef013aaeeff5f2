"""IES LM-63: the photometric files of North America, editions of 1986, 1991, 1995, 2002 and 2019.

Departures from the standard are read as what is evidently meant, each with a remark. Nothing that decides about light is
guessed: such files are refused with the line and what was expected.

References
----------
ANSI/IES LM-63-19 and its earlier editions.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ....reading.content import read_bytes
from ....reading.remarks import Remark
from ....reading.text import decode
from ....scene.distribution import IntensityDistribution
from ...coordinates import FRAMES
from ...distribution import flux
from ..radiant import settle_unit
from ..record import LampSet, LuminaireFile, TiltTable
from ..symmetry import POLE_TOLERANCE, average_poles, expand_planes
from .angles import mirror_half
from .data import Data, read_content, read_tilt
from .header import GENERATION_TYPE, Header, read_header
from .numbers import Numbers
from .opening import read_opening

FLUX_RATIO = (0.2, 1.05)
"""Between which the flux of the luminaire should lie, of that of its lamps."""

SEAM_TOLERANCE = 0.02
"""How far the planes at 0 and 360 degrees may differ, of the peak, before it is remarked on."""


def parse_lm63(data: bytes, path, folder: Path | None = None) -> LuminaireFile:
    """Read the content of a file.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages only.
    folder : Path or None    Where a TILT file may lie; nothing outside of it is read.

    Returns
    -------
    LuminaireFile    Of type B the stored azimuths are the vertical angles, of types A and C the horizontal ones.

    Raises
    ------
    FileFormatError    It cannot be read safely: with the line, what was found and what was expected.
    """
    lines = decode(path, data).split("\n")
    remarks: list[Remark] = []
    header = read_header(path, lines, remarks)
    content = read_content(path, header, lines[header.tilt_line :], remarks)
    tilt = content.tilt
    if header.tilt not in {"NONE", "INCLUDE"}:
        tilt = _read_tilt_file(header, folder, remarks)
    kind, is_b = content.photometric_type, content.photometric_type == "B"
    opening = read_opening(header.year, content.size, kind, content.size_line, remarks)
    distribution = _distribution_c(content, remarks) if kind == "C" else _distribution_ab(content)
    distribution = _with_single_poles(distribution, content, remarks)
    stated = content.lamps * content.lumens if content.lumens > 0.0 and content.lamps else None
    if stated:
        _compare_flux(flux(distribution), stated, remarks)
    watts = content.watts or None
    metadata = dict(header.metadata)
    if content.generation:
        metadata[GENERATION_TYPE] = content.generation
    name = metadata.get("LAMP") or metadata.get("LAMPCAT") or ""
    file = LuminaireFile(
        format=f"LM-63-{header.year}",
        photometric_type=kind,
        symmetry=content.symmetry,
        distribution=distribution,
        opening=opening,
        stored_azimuths=content.vertical if is_b else content.horizontal,
        stored_polars=content.horizontal if is_b else content.vertical,
        is_absolute=content.lumens <= 0.0,
        stated_flux=stated,
        watts=watts,
        lamps=(LampSet(content.lamps, stated, watts, name=name),),
        tilt=tilt,
        metadata=metadata,
        remarks=tuple(remarks),
    )
    return settle_unit(path, file)


def _distribution_c(content: Data, remarks) -> IntensityDistribution:
    stored, candela = content.horizontal, content.candela
    if stored[-1] - stored[0] > 359.999:
        differences = np.abs(candela[-1] - candela[0])
        share = float(differences.max() / candela.max())
        if share > SEAM_TOLERANCE:
            text = (
                f"the first and the last plane differ by up to {share:.1%} of the peak; the first one"
                " is used for both"
            )
            remarks.append(Remark(text, content.angle_line))
    azimuth, intensity = expand_planes(stored, candela, content.symmetry)
    return IntensityDistribution(np.radians(azimuth), np.radians(content.vertical), intensity)


def _distribution_ab(content: Data) -> IntensityDistribution:
    """Of types A and B: the angle about the polar axis is the azimuth, the other one counts from the pole."""
    vertical, horizontal, candela = content.vertical, content.horizontal, content.candela
    if content.symmetry in {"C90-C270", "quadrant"}:
        horizontal, candela = mirror_half(horizontal, candela)
    candela = candela.T
    if content.symmetry in {"C0-C180", "quadrant"}:
        vertical, candela = mirror_half(vertical, candela)
    around, across = vertical, horizontal
    if content.photometric_type == "A":
        around, across, candela = horizontal, vertical, candela.T
    return IntensityDistribution(
        np.radians(around),
        np.radians(90.0 + across),
        np.ascontiguousarray(candela),
        FRAMES[content.photometric_type],
    )


def _with_single_poles(distribution, content, remarks) -> IntensityDistribution:
    intensity, worst = average_poles(
        np.degrees(distribution.azimuth), np.degrees(distribution.polar), distribution.intensity
    )
    if worst > POLE_TOLERANCE:
        text = (
            f"at a pole the planes differ by up to {worst:.1%} of their mean, which is used there"
        )
        remarks.append(Remark(text, content.angle_line))
    return replace(distribution, intensity=intensity)


def _compare_flux(computed, stated, remarks):
    low, high = FLUX_RATIO
    if not low * stated <= computed <= high * stated:
        text = (
            f"intensities and lamps do not fit: {computed:.4g} lm by the intensities, {stated:.4g} lm"
            " stated"
        )
        remarks.append(Remark(text))


def _read_tilt_file(header: Header, folder, remarks) -> TiltTable | None:
    """Read the file that the TILT line names, if it lies in the folder; without it there are no factors."""
    name, line = header.tilt, header.tilt_line
    if header.year >= 2019:
        remarks.append(Remark("a TILT file, which LM-63-2019 does not know", line))
    path = _inside(folder, name)
    if path is None:
        text = f"the TILT file '{name[:40]}' is not beside the file; no factors for tilt"
        remarks.append(Remark(text, line))
        return None
    return read_tilt(Numbers(path, decode(path, read_bytes(path)).split("\n")))


def _inside(folder, name) -> Path | None:
    """Path of a file in the folder or below; None if there is none, or only elsewhere."""
    if folder is None:
        return None
    try:
        path = (Path(folder) / name).resolve()
        return path if path.is_relative_to(Path(folder).resolve()) and path.is_file() else None
    except (OSError, ValueError):
        # No name that this system could have written, so there is no such file.
        return None
