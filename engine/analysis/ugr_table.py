"""The table of unified glare ratings that makers print for a luminaire. (CIE 190:2010)"""

from dataclasses import dataclass

import numpy as np

from ...libraries.glare import position_index
from ..errors import SceneError
from ..luminaires.coordinates import directions
from ..luminaires.distribution import flux, intensity
from ..luminaires.formats.record import LUMINOUS, LuminaireFile
from ..luminaires.openings import projected_area

HEIGHT = 2.0
"""Of the luminaires above the eye, the H that rooms are measured in. [m]"""

ROOMS = tuple(
    (x, y)
    for x, lengths in ((2, (2, 3, 4, 6, 8, 12)), (4, (2, 3, 4, 6, 8, 12)), (8, (4, 6, 8, 12)), (12, (4, 6, 8)))
    for y in lengths
)  # fmt: skip
"""Width X across and length Y along the line of sight of each room. [H]"""

REFLECTANCES = ((0.7, 0.5, 0.2), (0.7, 0.3, 0.2), (0.5, 0.5, 0.2), (0.5, 0.3, 0.2), (0.3, 0.3, 0.2))
"""Of ceiling, walls and the plane at the eye's height, by column. [-]"""

VIEWS = ("crosswise", "endwise")
"""How the lamps lie to the line of sight: their axis (C90) across it, or along it."""

SPACING = 0.25
"""Between the centres of luminaires, as makers' tables have it. [H]"""

LEAST_SPACING = 0.05
"""Smallest spacing: 48 thousand luminaires in the largest room. [H]"""

FARTHEST_ASIDE, STEEPEST = 3.0, np.deg2rad(85.0)
"""T/R and gamma beyond which luminaires do not count. (CIE 117:1995, 4.5)"""

_STEPS = 360
"""Points of the midpoint rule in azimuth and polar angle for the flux on the plane."""


@dataclass(frozen=True, eq=False)
class UgrTable:
    """Ratings of a luminaire in the rooms of CIE 190.

    Parameters
    ----------
    spacing : float    [H]
    values : (19, 2, 5) float64 array
        By `ROOMS`, `VIEWS` and `REFLECTANCES`; NaN where no luminaire that shines is seen. [-]
    backgrounds : (19, 2, 5) float64 array    Background luminances. [cd/m2]
    """

    spacing: float
    values: np.ndarray
    backgrounds: np.ndarray


def find_ugr_table(file: LuminaireFile, spacing: float = SPACING) -> UgrTable:
    """Rate the glare of a luminaire in the rooms of CIE 190.

    Parameters
    ----------
    file : LuminaireFile    Its flux is that of the file.
    spacing : float    Between luminaires, which must divide H. [H]

    Returns
    -------
    UgrTable

    Raises
    ------
    SceneError    The file has no luminous opening, no candelas or no light, or the spacing does not divide H.

    Notes
    -----
    Luminaires lie `HEIGHT` above the eye on a square grid whose first rows are half a spacing from the walls; the observer
    sits at the middle of a wall and looks level at the opposite one. The background luminance is the mean indirect
    illuminance of the walls between eye and luminaires over pi, by interreflection between them, the ceiling and the plane
    at the eye's height, each evenly lit; direct flux reaches the plane as from luminaires spread evenly over the ceiling.
    CIE 190 has the same by tabulated multipliers; for the luminaire whose table it prints the values agree within 0.2.
    """
    _check(file, spacing)
    values = np.full((len(ROOMS), len(VIEWS), len(REFLECTANCES)), np.nan)
    backgrounds = np.zeros_like(values)
    beams = _Beams(file)
    for i, room in enumerate(ROOMS):
        sides = np.array(room) * HEIGHT
        for j, view in enumerate(VIEWS):
            seen = _seen_sum(file, sides, spacing, view)
            backgrounds[i, j] = _backgrounds(beams, sides, spacing, view)
            if seen > 0.0:
                values[i, j] = 8.0 * np.log10(0.25 * seen / backgrounds[i, j])
    return UgrTable(spacing, values, backgrounds)


def tabulated_position_index(aside, above) -> np.ndarray:
    """Position index of CIE 117:1995, table 4.1, linear between its values.

    Parameters
    ----------
    aside, above : array    T/R and H/R of sources, at least 0. [-]

    Returns
    -------
    float64 array    NaN outside the table, where sources do not count. [-]
    """
    rows, columns, table = position_index()
    aside, above = np.broadcast_arrays(np.asarray(aside, float), np.asarray(above, float))
    i = np.clip(np.searchsorted(rows, aside, side="right") - 1, 0, len(rows) - 2)
    j = np.clip(np.searchsorted(columns, above, side="right") - 1, 0, len(columns) - 2)
    u = (aside - rows[i]) / (rows[i + 1] - rows[i])
    v = (above - columns[j]) / (columns[j + 1] - columns[j])
    low = table[i, j] * (1.0 - v) + table[i, j + 1] * v
    high = table[i + 1, j] * (1.0 - v) + table[i + 1, j + 1] * v
    # On a line of the table its neighbours beyond do not count.
    found = np.where(u == 0.0, np.where(v == 0.0, table[i, j], low), low * (1.0 - u) + high * u)
    inside = (aside <= rows[-1]) & (above <= columns[-1]) & (aside >= 0.0) & (above >= 0.0)
    return np.where(inside, found, np.nan)


def _check(file: LuminaireFile, spacing: float) -> None:
    if file.quantity != LUMINOUS:
        raise SceneError("the file states W/sr, but glare is rated of candelas")
    if file.opening.shape == "point":
        raise SceneError("the file states no luminous opening, so its luminance is not known")
    if not flux(file.distribution) > 0.0:
        raise SceneError("the luminaire gives no light, so there is no glare to rate")
    count = 1.0 / spacing if spacing >= LEAST_SPACING else 0.5
    if abs(count - round(count)) > 1e-6 * count:
        raise SceneError(
            f"the spacing is {spacing:g} H, expected a part of H such as 1, 0.5 or 0.25, at least {LEAST_SPACING:g}"
        )


def _seen_sum(file: LuminaireFile, sides, spacing: float, view: str) -> float:
    """Sum of L^2 omega / p^2 over the luminaires of a room that count. [cd2/m4 sr]"""
    across, along = (
        (np.arange(round(side / (spacing * HEIGHT))) + 0.5) * spacing * HEIGHT for side in sides
    )
    aside, ahead = (grid.ravel() for grid in np.meshgrid(across - 0.5 * sides[0], along))
    index = tabulated_position_index(np.abs(aside) / ahead, HEIGHT / ahead)
    counts = np.isfinite(index) & (np.abs(aside) <= FARTHEST_ASIDE * ahead)
    counts &= np.hypot(aside, ahead) <= np.tan(STEEPEST) * HEIGHT
    aside, ahead, index = aside[counts], ahead[counts], index[counts]
    # The lamps' axis is the luminaire's y.
    plan = (-ahead, -aside) if view == "crosswise" else (-aside, -ahead)
    towards = np.stack([*plan, np.full(len(aside), -HEIGHT)], axis=-1)
    area = projected_area(file.opening, towards)
    candelas = intensity(file.distribution, towards)
    squared = np.divide(candelas**2, area, out=np.zeros_like(area), where=area > 0.0)
    return float(np.sum(squared / (np.einsum("ij,ij->i", towards, towards) * index**2)))


class _Beams:
    """Flux of a luminaire by direction, and what of it meets the plane at the eye's height."""

    def __init__(self, file: LuminaireFile):
        azimuth = (np.arange(_STEPS) + 0.5) * 2.0 * np.pi / _STEPS
        polar = (np.arange(_STEPS) + 0.5) * 0.5 * np.pi / _STEPS
        direction = directions(azimuth[:, None], polar)
        solid = np.sin(polar) * (2.0 * np.pi / _STEPS) * (0.5 * np.pi / _STEPS)
        self._flux = intensity(file.distribution, direction) * solid
        self._reach = [HEIGHT * np.abs(direction[..., i] / direction[..., 2]) for i in (0, 1)]
        self._down = float(self._flux.sum())
        self._total = max(flux(file.distribution), self._down)

    def on_surfaces(self, width: float, length: float) -> np.ndarray:
        """Flux on the plane, the walls and the ceiling of a room, sides along the luminaire's x and y. (3,) [lm]"""
        shares = [
            np.maximum(1.0 - reach / side, 0.0)
            for reach, side in zip(self._reach, (width, length), strict=True)
        ]
        plane = float((self._flux * shares[0] * shares[1]).sum())
        return np.array([plane, self._down - plane, self._total - self._down])


def _backgrounds(beams: _Beams, sides, spacing: float, view: str) -> np.ndarray:
    """Background luminance of a room by reflectances. (5,) [cd/m2]"""
    x, y = sides
    plan = (y, x) if view == "crosswise" else (x, y)
    count = round(x / (spacing * HEIGHT)) * round(y / (spacing * HEIGHT))
    areas = np.array([x * y, 2.0 * HEIGHT * (x + y), x * y])
    direct = beams.on_surfaces(*plan) * count / areas
    opposite = _facing_rectangles(x, y, HEIGHT)
    aside = 1.0 - opposite
    back = aside * areas[0] / areas[1]
    # Share of what each surface (row) sees that is plane, walls, ceiling.
    factors = np.array(
        [[0.0, aside, opposite], [back, 1.0 - 2.0 * back, back], [opposite, aside, 0.0]]
    )
    found = []
    for ceiling, walls, plane in REFLECTANCES:
        seen = np.linalg.solve(np.eye(3) - factors * np.array([plane, walls, ceiling]), direct)
        found.append((seen[1] - direct[1]) / np.pi)
    return np.array(found)


def _facing_rectangles(x: float, y: float, apart: float) -> float:
    """Form factor between equal rectangles that face each other. [m -> -]"""
    a, b = x / apart, y / apart
    p, q = np.hypot(1.0, a), np.hypot(1.0, b)
    edges = (
        a * q * np.arctan(a / q) + b * p * np.arctan(b / p) - a * np.arctan(a) - b * np.arctan(b)
    )
    return float(2.0 / (np.pi * a * b) * (np.log(p * q / np.sqrt(1.0 + a * a + b * b)) + edges))
