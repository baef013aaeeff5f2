"""Pigments of paint: how strongly they absorb and scatter, and the reflectance of a thick layer of their mixture.

The bands have the shape of their kind of pigment and are drawn by hand, not measured: edges as of iron oxides, dips as of
phthalocyanines. Amounts count in units of titanium dioxide that scatters as 1 at 550 nm.

References
----------
P. Kubelka, F. Munk: Ein Beitrag zur Optik der Farbanstriche, Zeitschrift für technische Physik 12, 1931.
"""

import numpy as np

from .colour import WAVELENGTHS


def edge(place: float, width: float) -> np.ndarray:
    """1 at wavelengths below a place, 0 above. (w,)"""
    return 1.0 / (1.0 + np.exp((WAVELENGTHS - place) / width))


def band(place: float, width: float) -> np.ndarray:
    """A bell of a standard deviation. (w,)"""
    return np.exp(-0.5 * ((WAVELENGTHS - place) / width) ** 2)


def _flat(value: float) -> np.ndarray:
    return np.full(len(WAVELENGTHS), value)


PIGMENTS = {
    # Rutile absorbs violet light: paints that are white to the eye are black below 380 nm.
    "titanium white": (0.0018 + 6.0 * edge(388.0, 5.5), WAVELENGTHS**-0.8 * 550.0**0.8),
    "chalk": (0.004 + 0.004 * edge(470.0, 60.0), _flat(0.12)),
    "carbon black": (60.0 * (550.0 / WAVELENGTHS) ** 0.6, _flat(0.05)),
    "red iron oxide": (0.25 + 11.0 * edge(578.0, 13.0) + 0.5 * edge(690.0, 30.0), _flat(0.6)),
    "yellow iron oxide": (0.06 + 7.0 * edge(498.0, 14.0) + 0.8 * edge(570.0, 25.0), _flat(0.5)),
    "brown iron oxide": (0.9 + 9.0 * edge(560.0, 40.0), _flat(0.5)),
    "phthalo blue": (
        0.05 + 18.0 * band(600.0, 44.0) + 15.0 * band(690.0, 40.0) + 3.0 * band(360.0, 30.0),
        _flat(0.15),
    ),
    "phthalo green": (
        0.05
        + 18.0 * band(650.0, 42.0)
        + 14.0 * band(735.0, 30.0)
        + 15.0 * band(400.0, 38.0)
        + 4.0 * band(585.0, 35.0),
        _flat(0.15),
    ),
    "diketopyrrole red": (0.05 + 16.0 * edge(586.0, 7.0), _flat(0.5)),
    "bismuth yellow": (0.008 + 9.0 * edge(490.0, 9.0), _flat(0.9)),
}
"""Absorption and scattering of the unit amount on `WAVELENGTHS`, relative to each other."""


def mixture(parts: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Absorption and scattering of a mixture by the names of `PIGMENTS`. (w,), (w,)"""
    absorption = sum(amount * PIGMENTS[name][0] for name, amount in parts.items())
    scattering = sum(amount * PIGMENTS[name][1] for name, amount in parts.items())
    return absorption, scattering


def thick_reflectance(absorption, scattering) -> np.ndarray:
    """Reflectance of a layer that hides what lies below, for even light inside of it (Kubelka and Munk). [-]"""
    ratio = absorption / scattering
    return 1.0 + ratio - np.sqrt(ratio * (ratio + 2.0))


def layer(absorption, scattering) -> tuple[np.ndarray, np.ndarray]:
    """Reflectance and transmittance of a layer before nothing, for even light inside of it (Kubelka and Munk).

    Parameters
    ----------
    absorption, scattering : arrays    Coefficients times the thickness. [-]
    """
    k, s = np.asarray(absorption, dtype=np.float64), np.asarray(scattering, dtype=np.float64)
    # Without absorption the hyperbolic functions are 0 / 0.
    k = np.maximum(k, 1e-7 * s)
    a = 1.0 + k / s
    b = np.sqrt(a * a - 1.0)
    x = b * s
    # Divided by cosh, which would overflow for thick layers.
    tanh = np.tanh(x)
    below = a * tanh + b
    return tanh / below, b / (below * np.cosh(np.minimum(x, 300.0)))
