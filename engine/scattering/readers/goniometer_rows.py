"""Rows of a goniometer's text as directions and values in SI units, and without what is no data."""

from dataclasses import dataclass, field

import numpy as np

from ...photometry.colour import scene_linear
from ...reading.columns import Columns
from ...reading.remarks import Remark
from ..data.table import direction_of
from .checks import tell_missing, tell_negative
from .colour import spectra_of_rgb
from .goniometer_text import ABOUT_MIRROR, ABOUT_NORMAL
from .in_plane import SHADOW

QUANTITIES = {
    "brdf": "brdf", "btdf": "brdf", "bsdf": "brdf",
    "luminance factor": "factor", "radiance factor": "factor", "reflectance factor": "factor", "factor": "factor",
    "percent": "percent", "per cent": "percent", "%": "percent", "luminance factor in percent": "percent",
    "cosine-corrected brdf": "cosine", "cosine corrected brdf": "cosine", "ccbrdf": "cosine", "ars": "cosine",
}  # fmt: skip
"""Words for quantities, and what is meant."""

STEEPEST = np.radians(85.0)
"""Directions farther from the normal are left out where values have to be divided by their cosine."""

LARGEST = 1e9
"""Measured value."""

SINGLE = 550.0
"""Wavelength of values that are for all. [nm]"""


@dataclass(eq=False)
class Measured:
    """Rows of a measurement.

    Parameters
    ----------
    is_specular : bool    Whether directions are told about the mirror direction, else about the normal.
    is_in_plane : bool    Whether all lie in the plane of incidence; ``azimuth`` is 0 or pi.
    incidence, rotation : (n,) arrays    Of light. [rad]
    radial, azimuth : (n,) arrays    From the axis and about it, 0 towards the horizon or where light comes from. [rad]
    wavelengths : (w,) array    [nm]
    values : (n, w) array    nan where nothing was measured.
    remarks : list of Remark
    """

    is_specular: bool
    is_in_plane: bool
    incidence: np.ndarray
    rotation: np.ndarray
    radial: np.ndarray
    azimuth: np.ndarray
    wavelengths: np.ndarray
    values: np.ndarray
    remarks: list[Remark] = field(default_factory=list)

    def keep(self, rows: np.ndarray) -> None:
        """Leave out the other rows; in place."""
        for name in ("incidence", "rotation", "radial", "azimuth", "values"):
            setattr(self, name, getattr(self, name)[rows])

    def cosine(self) -> np.ndarray:
        """Cosine of the outgoing directions to the normal. (n,)"""
        if not self.is_specular:
            return np.cos(self.radial)
        return direction_of(self.incidence, self.radial, self.azimuth)[:, 2]

    def direction(self) -> np.ndarray:
        """Outgoing directions, light coming over +x. (n, 3)"""
        if self.is_specular:
            return direction_of(self.incidence, self.radial, self.azimuth)
        sine = np.sin(self.radial)
        parts = sine * np.cos(self.azimuth), sine * np.sin(self.azimuth), np.cos(self.radial)
        return np.stack(parts, axis=1)


# ---- what stands in the columns ----


def take_angles(columns: Columns, layout: str) -> Measured:
    """Angles of all rows, checked."""
    told = columns.head.get("angles", "normal").lower()
    if told not in {"normal", "specular"}:
        columns.fail(f"states 'angles: {told[:40]}', expected normal or specular")
    is_specular = told == "specular" or ("sigma" in columns.names and "theta" in columns.names)
    sets = ABOUT_MIRROR if is_specular else ABOUT_NORMAL
    incidence, rotation, radial, azimuth = (columns.find(*names) for names in sets)
    if incidence is None or radial is None:
        wanted = "sigma and theta" if is_specular else "theta_i and theta_o"
        columns.fail(f"has no columns {wanted} of angles")
    is_plane = azimuth is None
    rotation = np.zeros(len(incidence)) if rotation is None else rotation
    azimuth = np.zeros(len(incidence)) if is_plane else azimuth
    angles = np.stack([incidence, rotation, radial, azimuth], axis=1)
    for row in np.flatnonzero(~np.isfinite(angles).all(axis=1))[:1]:
        columns.fail("lacks an angle", row)
    angles = angles if _is_in_radians(columns, layout, angles) else np.radians(angles)
    _check_angles(columns, angles, is_specular, is_plane)
    incidence, rotation, radial, azimuth = angles.T
    if is_plane:
        # A signed angle in the plane; which side is the mirror direction's is found out later.
        azimuth = np.where(radial >= 0.0, np.pi, 0.0)
        radial = np.abs(radial)
    elif not is_specular:
        azimuth = azimuth - rotation
    across = np.abs(np.sin(azimuth)) * np.sin(radial)
    plane = is_plane or bool((across < 1e-4).all())
    if plane and not is_plane:
        azimuth = np.where(np.cos(azimuth) >= 0.0, 0.0, np.pi)
    return Measured(
        is_specular,
        plane,
        np.clip(incidence, 0.0, 0.5 * np.pi),
        rotation % (2.0 * np.pi),
        np.clip(radial, 0.0, np.pi if is_specular else 0.5 * np.pi),
        azimuth,
        np.zeros(0),
        np.zeros((0, 0)),
    )


def _is_in_radians(columns: Columns, layout: str, angles) -> bool:
    unit = columns.head.get("unit", "").lower()
    if unit.startswith(("deg", "rad")):
        return unit.startswith("rad")
    # E1392 has radians; no angle to the normal is beyond 1.6 of them.
    return layout.startswith("ASTM") and np.abs(angles[:, [0, 2]]).max() <= 1.6


def _check_angles(columns: Columns, angles, is_specular: bool, is_plane: bool) -> None:
    low = -0.5 * np.pi if is_plane else 0.0
    bounds = (
        ("angle of incidence", 0.0, 0.5 * np.pi),
        ("azimuth of incidence", -2.0 * np.pi, 2.0 * np.pi),
        ("outgoing angle", low, np.pi if is_specular else 0.5 * np.pi),
        ("outgoing azimuth", -2.0 * np.pi, 2.0 * np.pi),
    )
    for column, (name, least, most) in enumerate(bounds):
        off = (angles[:, column] < least - 1e-4) | (angles[:, column] > most + 1e-4)
        for row in np.flatnonzero(off)[:1]:
            found, start, end = np.degrees([angles[row, column], least, most])
            columns.fail(f"has the {name} {found:g}°, expected {start:g}° to {end:g}°", row)


def take_values(columns: Columns, measured: Measured) -> None:
    """Bands of all rows; in place."""
    spectral = columns.wavelengths()
    if len(spectral):
        order = sorted(spectral, key=lambda name: spectral[name])
        wavelengths = np.array([spectral[name] for name in order])
        if np.any(np.diff(wavelengths) <= 0.0):
            columns.fail("has two columns of one wavelength")
        values = np.stack([columns.find(name) for name in order], axis=1)
    else:
        wavelengths, values = _take_colours(columns, measured)
    off = np.abs(np.nan_to_num(values)).max(axis=1) > LARGEST
    for row in np.flatnonzero(off)[:1]:
        columns.fail(f"has a value beyond {LARGEST:g}", row)
    measured.wavelengths, measured.values = wavelengths, values


def _take_colours(columns: Columns, measured: Measured):
    """Values of files without wavelengths: colours, or one value for all."""
    for names, is_xyz in ((("r", "g", "b"), False), (("red", "green", "blue"), False), (("x", "y", "z"), True)):  # fmt: skip
        if all(name in columns.names for name in names):
            values = np.stack([columns.find(name) for name in names], axis=1)
            if is_xyz:
                values = np.asarray(scene_linear(values, 1.0), dtype=np.float64)
            what = "tristimulus values of D65" if is_xyz else "linear Rec. 709 colours"
            measured.remarks.append(Remark(f"holds no spectra; taken as {what}"))
            good = np.isfinite(values).all(axis=1)
            wavelengths, made = spectra_of_rgb(np.where(good[:, None], values, 0.0))
            return wavelengths, np.where(good[:, None], made, np.nan)
    angles = {name for names in (*ABOUT_NORMAL, *ABOUT_MIRROR) for name in names}
    left = [name for name in columns.names if name not in angles]
    if len(left) != 1:
        columns.fail("has no columns of wavelengths, such as 450 or 450nm, nor one of values")
    return np.array([SINGLE]), columns.find(left[0])[:, None]


def stated_quantity(columns: Columns) -> str | None:
    """What the file says that its values are, of the values of `QUANTITIES`; None where it does not."""
    told = columns.head.get("quantity")
    if told is None:
        return None
    known = QUANTITIES.get(" ".join(told.lower().replace("_", " ").split()))
    if known is None:
        columns.fail(
            f"states the quantity '{told[:40]}', expected brdf, luminance factor, percent or "
            "cosine-corrected brdf"
        )
    return known


def stated_side(columns: Columns) -> str:
    """Of `record.SIDES`."""
    kind = columns.head.get("kind", "reflection").lower()
    side = columns.head.get("side", "front").lower()
    if kind not in {"reflection", "transmission"} or side not in {"front", "back"}:
        columns.fail(
            f"states 'kind: {kind[:40]}' and 'side: {side[:40]}', expected reflection or transmission, "
            "front or back"
        )
    return f"{side}_{kind}"


# ---- cleaning ----


def clean_rows(columns: Columns, measured: Measured, quantity: str | None, side: str) -> None:
    """Leave out what is no data, and divide by the cosine where that was multiplied; in place."""
    values = measured.values
    with np.errstate(invalid="ignore"):
        low = values < 0.0
        measured.remarks += tell_negative(side, int(low.sum()), values.size)
        values = np.where(low, 0.0, values)
        dark = (np.nan_to_num(values) == 0.0).all(axis=1)
    cosine = measured.cosine()
    good = np.isfinite(values).any(axis=1)
    if measured.is_in_plane and "reflection" in side:
        source = np.stack([np.sin(measured.incidence), 0.0 * cosine, np.cos(measured.incidence)], 1)
        near = (measured.direction() * source).sum(axis=1) > np.cos(SHADOW)
        shadowed = dark & near & good
        if shadowed.any():
            measured.remarks.append(
                Remark(
                    f"has {shadowed.sum()} rows of zeros beside the direction of the light, where the "
                    "detector is in its way; they are filled from their neighbours"
                )
            )
        good &= ~shadowed
    above = cosine > 1e-6
    if quantity == "cosine":
        above = cosine > np.cos(STEEPEST) - 1e-9
        values = values / np.maximum(cosine, np.cos(STEEPEST))[:, None]
    if np.any(good & ~above):
        what = "below the horizon"
        if quantity == "cosine":
            what = f"farther than {np.degrees(STEEPEST):.0f}° from the normal"
        measured.remarks.append(Remark(f"has {np.sum(good & ~above)} rows {what}, left out"))
    measured.values = values
    good &= above
    if not good.any():
        columns.fail("has no row with a value above the horizon")
    empty = ~np.isfinite(values[good]).any(axis=0)
    if empty.any():
        columns.fail(f"has no value at {measured.wavelengths[empty][0]:g} nm")
    measured.keep(good)
    measured.remarks += tell_missing(side, float(np.arccos(cosine[good].min())))
