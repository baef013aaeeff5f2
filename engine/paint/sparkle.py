"""Flakes of a paint as the camera sees them one by one: what each kind reflects, how many there are, and how sharply.

Deeper flakes are dimmer. With the optical depth t of a layer there and back along its normal, flakes at depths that are even
from top to bottom are as uneven in brightness as

    n = (a H / <A>) / ((t / 2) coth(t / 2))

alike ones would be, a H / <A> being the flakes by area of the surface.
"""

import math
from dataclasses import replace

import numpy as np

from ..scattering.data.table import direction_of
from ..scene.scattering import ScatterTable, Sparkle
from .first_order import pairs_of, single_reflection
from .matter import FlakeMatter, LayerMatter
from .orientation import DIFFRACTION
from .solution import Solution

GREEN = 0.55
"""Wavelength at which diffraction is taken. [um]"""

LEAST_DEPTH = 1e-3
"""Optical depth below which all flakes of a layer are equally bright. [-]"""


def find_sparkles(solution: Solution, table: ScatterTable) -> tuple[Sparkle, ...]:
    """Find what the camera sees of single flakes in a paint.

    Flakes of unknown diameter are left out, as their number is not known.

    Parameters
    ----------
    solution : Solution
    table : ScatterTable    Made of it; isotropic.
    """
    axes = np.meshgrid(table.incidences, table.radials, table.azimuths, indexing="ij")
    incidence, radial, azimuth = (axis.ravel() for axis in axes)
    wi = np.stack([np.sin(incidence), np.zeros(len(incidence)), np.cos(incidence)], axis=1)
    wo = direction_of(incidence, radial, azimuth)
    above = wo[:, 2] > 0.0
    pairs = pairs_of(wi[above], wo[above])
    bands = [int(np.argmin(np.abs(solution.wavelengths - each))) for each in table.wavelengths]

    def extinction(number: int, sines) -> np.ndarray:
        return solution.directions.interpolation(sines) @ solution.extinctions[number].T

    made = []
    for number, layer in enumerate(solution.layers):
        for kind in layer.flakes:
            if kind.flakes.diameters is None:
                continue
            alone = tuple(
                replace(each, flakes=(kind,) if k == number else ())
                for k, each in enumerate(solution.layers)
            )
            values = np.zeros((len(wo), len(bands)), np.float32)
            found = single_reflection(alone, extinction, pairs, solution.is_polarised)
            values[above] = np.maximum(found[:, bands], 0.0)
            shape = (1, len(table.incidences), len(table.radials), len(table.azimuths), len(bands))
            part = replace(table, values=values.reshape(shape), direct=None)
            made.append(_sparkle(part, layer, kind))
    return tuple(made)


def _sparkle(part: ScatterTable, layer: LayerMatter, kind: FlakeMatter) -> Sparkle:
    diameters = kind.flakes.diameters
    depth = 2.0 * layer.thickness * float(layer.extinction(np.ones(1)).mean())
    dimming = 1.0 if depth < LEAST_DEPTH else 0.5 * depth / math.tanh(0.5 * depth)
    number = kind.area * layer.thickness / diameters.face_um2 / dimming
    # Of the light that flakes reflect most is that of large ones.
    diameter = diameters.moment_um(3.0) / diameters.moment_um(2.0)
    blur = DIFFRACTION * GREEN / (layer.mean_index * diameter)
    return Sparkle(
        part,
        number * 1e12,
        kind.flakes.slope,
        blur,
        diameters.log_spread,
        layer.mean_index,
    )
