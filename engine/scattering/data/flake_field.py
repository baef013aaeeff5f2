"""The random field of a surface's flakes: how they are laid out, and its variance in closed form.

Flakes are points of a Poisson process over place and slope; their slopes are Gaussian, their areas log-normal. At a place x,
for light that needs flakes of the slope m to get to the eye, the field is

    X = sum_j b_j G(x - x_j) K(m - m_j) / (n (D * K)(m)),    mean of all b_j = 1,  integral of G = 1,

with n flakes by area, D the density of their slopes, G what a pixel covers of the surface and K how far a flake blurs what
it mirrors. Its mean is 1 everywhere, whatever G is, and its variance

    Var X = <b^2> integral(G^2) (D * K^2)(m) / (n (D * K)(m)^2),

the inverse of the number of flakes that are lit where G and K are flat and all flakes alike. Both kernels are
(1 - r^2)^2 within their radius, which has a standard deviation of radius / sqrt(8) per axis. D * K is taken as the Gaussian
of the summed variances; with radii up to `WIDEST` slopes it is off by less than 0.1 %.
"""

import math
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from ...errors import SceneError
from ...scene.scattering import Scatter, ScatterTable, Sparkle

RADIUS = math.sqrt(8.0)
"""Radius of a kernel over its standard deviation per axis. [-]"""

WIDEST, NARROWEST = 0.75, 0.02
"""Largest and least radius of the blur of one flake, over the standard deviation of the slopes. [-]"""

OCCUPANCY = 1.5
"""Mean number of flakes of a cell of place and slope."""

MOST_FLAKES = 10
"""Flakes of a cell that count; more are there once in five million."""

AREAS = 64
"""Sizes that flakes have."""

FACING = math.sqrt(3.0)
"""Largest area of a surface over that of its projection along the nearest axis. [-]"""

SQUARED_KERNEL = 0.6
"""Integral of the square of a kernel over that of the kernel: (pi / 5) / (pi / 3). [-]"""


@dataclass(frozen=True, eq=False)
class FlakeLayout:
    """Cells of place and slope that flakes lie in, for one `Sparkle`.

    Parameters
    ----------
    density : float    Flakes by area. [1/m2]
    slope : float    Standard deviation of their slopes. [-]
    radius : float    Of the kernel over slopes. [-]
    cell : float    Side of cells on the surface. [m]
    slope_cells : int
        Cells across the slopes' distribution, even in its cumulative shares; a kernel never reaches into more than two.
    areas : (`AREAS`,) float64 array    Of the flakes over their mean, all as frequent. [-]
    index : float    Refractive index around the flakes. [-]
    """

    density: float
    slope: float
    radius: float
    cell: float
    slope_cells: int
    areas: np.ndarray
    index: float

    @property
    def moment(self) -> float:
        """Mean square of the areas over the square of their mean. [-]"""
        return float(np.mean(np.square(self.areas)))

    @property
    def smooth_variance(self) -> float:
        """Variance per axis of slopes, with what a flake blurs. [-]"""
        return self.slope**2 + self.radius**2 / 8.0

    @property
    def squared_variance(self) -> float:
        """The same of the square of the kernel. [-]"""
        return self.slope**2 + self.radius**2 / 12.0

    def chance(self, slope) -> np.ndarray:
        """Share of the flakes that are lit at slopes, the integral of D K. [-]"""
        variance = self.smooth_variance
        return math.pi / 3.0 * self.radius**2 * _gauss(slope, variance)

    def variance(self, slope, radius: float) -> np.ndarray:
        """Variance of the field.

        Parameters
        ----------
        slope : (...) array    Length of the slope that light needs. [-]
        radius : float    Of the kernel over the surface, a disk. [m]
        """
        area = math.pi / 3.0 * radius**2 / SQUARED_KERNEL
        squared = math.pi / 5.0 * self.radius**2 * _gauss(slope, self.squared_variance)
        return self.moment * squared / (self.density * area * self.chance(slope) ** 2)


def _gauss(slope, variance: float):
    return np.exp(-0.5 * np.square(slope) / variance) / (2.0 * math.pi * variance)


def lay_out(sparkle: Sparkle) -> FlakeLayout:
    """Lay out the cells of flakes.

    Raises
    ------
    SceneError    A number is out of its range.
    """
    limits = {
        "density": (1.0, 1e16),
        "slope": (1e-4, 2.0),
        "blur": (0.0, 2.0),
        "log_spread": (0.0, 2.0),
        "index": (1.0, 4.0),
    }
    for name, (low, high) in limits.items():
        value = getattr(sparkle, name)
        if not low <= value <= high:
            raise SceneError(
                f"sparkling flakes have the {name} {value:g}, expected {low:g} to {high:g}"
            )
    radius = min(max(RADIUS * sparkle.blur, NARROWEST * sparkle.slope), WIDEST * sparkle.slope)
    cells = max(int(1.0 / math.erf(radius / (sparkle.slope * math.sqrt(2.0)))), 1)
    return FlakeLayout(
        sparkle.density,
        sparkle.slope,
        radius,
        cells * math.sqrt(OCCUPANCY / (FACING * sparkle.density)),
        cells,
        areas_of(sparkle.log_spread),
        sparkle.index,
    )


def counts_of_cells() -> list[float]:
    """Chances that a cell has up to 0, 1, ... flakes, `MOST_FLAKES` of them."""
    shares = [OCCUPANCY**n / math.factorial(n) for n in range(MOST_FLAKES)]
    return (np.cumsum(shares) * math.exp(-OCCUPANCY)).tolist()


def areas_of(log_spread: float) -> np.ndarray:
    """Means of as many equal parts of log-normal areas, of the mean 1. (`AREAS`,) [-]

    ``log_spread``: standard deviation of the logarithm of the diameters; of areas it is twice as much.
    """
    normal = NormalDist()
    edges = [normal.inv_cdf(number / AREAS) for number in range(1, AREAS)]
    # Of the areas' sum below a deviate e is Phi(e - sigma).
    below = [normal.cdf(edge - 2.0 * log_spread) for edge in edges]
    return np.diff(below, prepend=0.0, append=1.0) * AREAS


def check_sparkle(sparkle: Sparkle, reflection: Scatter | None) -> None:
    """Refuse flakes that are no part of a surface's reflection.

    Raises
    ------
    SceneError    Says what is wrong with them.
    """
    lay_out(sparkle)
    part = sparkle.first_order
    if not isinstance(reflection, ScatterTable):
        raise SceneError("sparkling flakes are a part of a table, and the surface reflects by none")
    axes = ("rotations", "incidences", "radials", "azimuths", "wavelengths")
    if not all(np.array_equal(getattr(part, name), getattr(reflection, name)) for name in axes):
        raise SceneError("the table of sparkling flakes has other axes than that of their surface")
    if not np.isfinite(part.values).all() or part.values.min(initial=0.0) < 0.0:
        raise SceneError(
            "the table of sparkling flakes has a value that is negative or no finite number"
        )


def parts_of(sparkles: tuple[Sparkle, ...], reflection: ScatterTable) -> list[ScatterTable]:
    """Return what flakes mirror once as tables that together nowhere exceed what the surface reflects."""
    whole = sum(each.first_order.values.astype(np.float64) for each in sparkles)
    share = np.minimum(reflection.values / np.maximum(whole, 1e-30), 1.0).astype(np.float32)
    return [
        replace(each.first_order, values=each.first_order.values * share, direct=None)
        for each in sparkles
    ]
