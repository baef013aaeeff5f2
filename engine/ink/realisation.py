"""One layer with its own particles, solved for light of one wavelength at all angles of incidence.

Realisations 2 k and 2 k + 1 have the same thickness and other particles, so that what they differ by tells the error of
their mean; from pair to pair the thickness runs evenly over its spread (by the golden ratio, so that more may follow).
Azimuths of incidence are drawn, since the cell's own axes mean nothing.
"""

from functools import lru_cache

import numpy as np

from .composition import Ink
from .packing import Packing, pack
from .plan import Plan
from .relief import CREST, carve, random_heights
from .voxels import fill_shares
from .waves import Cell, Waves

GOLDEN = 0.6180339887498949

SIDES = ("above", "below")


def thickness_of(ink: Ink, realisation: int) -> float:
    """Thickness of a realisation. [um]"""
    place = (0.5 + GOLDEN * (realisation // 2)) % 1.0
    return ink.thickness * (1.0 + ink.thickness_spread * (2.0 * place - 1.0))


def pack_ink(ink: Ink, width: float, seed: int, realisation: int) -> Packing:
    """Particles of a realisation."""
    populations = [each.population for each in ink.particles]
    return pack(populations, width, thickness_of(ink, realisation), [seed, realisation])


def face_of(ink: Ink, plan: Plan, realisation: int) -> np.ndarray:
    """Heights of a realisation's upper face above its mean, (columns, columns); (0, 0) where it is smooth. [um]"""
    if not ink.relief:
        return np.zeros((0, 0))
    rng = np.random.default_rng([plan.seed, realisation, 2])
    return random_heights(ink.relief.height, ink.relief.length, plan.width, plan.columns, rng)


@lru_cache(maxsize=1)
def _structure(ink: Ink, plan: Plan, realisation: int) -> tuple[np.ndarray, float, np.ndarray]:
    """Shares of the particles on the grid, the grid's height, and the face's heights over its mean or nothing."""
    height = thickness_of(ink, realisation)
    crest = CREST * ink.relief.height if ink.relief else 0.0
    layers, columns = plan.layers, plan.columns
    whole = height + crest
    shares = np.zeros((len(ink.particles), layers, columns, columns))
    if ink.particles:
        packing = pack_ink(ink, plan.width, plan.seed, realisation)
        # Particles stand below the mean face; on a grid that begins at the highest crest.
        lowered = Packing(
            packing.centres + np.array([0.0, 0.0, crest]), packing.axes, packing.diameters, packing.kinds,
            packing.populations, packing.width, whole, packing.steps,
        )  # fmt: skip
        shares = fill_shares(lowered, (layers, columns)) * (height / whole if crest else 1.0)
    return shares, whole, face_of(ink, plan, realisation)


def cell_of(ink: Ink, plan: Plan, realisation: int, wavelength: float) -> Cell:
    """A realisation's cell for one wavelength. [nm]"""
    shares, whole, heights = _structure(ink, plan, realisation)
    matrix = ink.matrix(wavelength)
    permittivity = np.full((plan.layers, plan.columns, plan.columns), matrix)
    for each, share in zip(ink.particles, shares, strict=True):
        permittivity += share * (complex(each.index.at([wavelength])[0]) ** 2 - matrix)
    if heights.size:
        permittivity = carve(permittivity, heights, whole, CREST * ink.relief.height, 1.0)
    return Cell(permittivity, plan.width, whole, 1.0, ink.below)


def solve_unit(ink: Ink, plan: Plan, realisation: int, band: int) -> dict[str, np.ndarray]:
    """Solve one realisation in one band.

    Returns
    -------
    dict of arrays    For each side (``above``, ``below`` where it differs) and incidence k, ``SIDE.k.up`` and
        ``SIDE.k.down``: rows of the tangential direction (x along that of the incidence, y; in units of k0) and the share
        of power, mode 0 the first one. ``iterations`` of every solve.

    Raises
    ------
    SceneError    Particles do not come to rest, or waves do not settle.
    """
    wavelength = plan.wavelengths[band]
    cell = cell_of(ink, plan, realisation, wavelength)
    turns = np.random.default_rng([plan.seed, realisation, 1]).random((2, len(plan.sines)))
    made, iterations = {}, []
    sides = SIDES[:1] if ink.is_alike_from_both_sides else SIDES
    for number, side in enumerate(sides):
        seen = cell if side == "above" else cell.turned_over()
        for k, sine in enumerate(plan.sines):
            turn = 2.0 * np.pi * turns[number, k]
            axis = np.array([np.cos(turn), np.sin(turn)])
            k0 = 2.0 * np.pi / (wavelength * 1e-3)
            waves = Waves(seen, wavelength * 1e-3, sine * seen.above * k0 * axis)
            out = waves.scatter(tolerance=plan.tolerance)
            iterations.append(out.iterations)
            across = np.array([-axis[1], axis[0]])
            for name, powers, carrying in zip(
                ("up", "down"), (out.reflected, out.transmitted), waves.carrying, strict=True
            ):
                x, y = (np.where(carrying, each, 0.0)[carrying] / k0 for each in waves.modes)
                rows = np.stack(
                    [axis[0] * x + axis[1] * y, across[0] * x + across[1] * y, powers[carrying]],
                    axis=1,
                )
                if not carrying[0, 0]:
                    # Totally reflected: mode 0 carries nothing there.
                    rows = np.concatenate([[[sine * seen.above, 0.0, 0.0]], rows])
                made[f"{side}.{k}.{name}"] = rows
    return made | {"iterations": np.array(iterations)}
