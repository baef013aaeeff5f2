"""Thin films on glass, paint and metals: reflectance by angle and wavelength with all light between both faces.

Of a film of the index n and the thickness d on a base of the complex index m, in air, an amplitude comes back as

    r = (r_1 + r_2 e^(i phi)) / (1 + r_1 r_2 e^(i phi)),    phi = 4 pi n d cos_n / lambda

with Fresnel's amplitudes r_1 of air on film and r_2 of film on base at the cosine cos_n inside. Unpolarised light has the
mean of |r|^2 over both polarisations. Light that passes into a clear base is the rest, whichever way it goes. Where light
of both faces is apart by more than `LONGEST`, colours that eyes and sensors see have forgotten phi, and its mean is taken.

Kernels read tables: even in the root of the cosine and in the wave number, as fine as phi needs it.

References
----------
M. Born, E. Wolf: Principles of Optics, 7th edition, 1.6.4 and 14.4.
O. Gulbrandsen: Artist Friendly Metallic Fresnel, Journal of Computer Graphics Techniques 3 (4), 2014.
"""

from functools import lru_cache

import numpy as np

from ..photometry.units import MAXIMUM_WAVELENGTH, MINIMUM_WAVELENGTH
from ..scene.film import Film
from .facets import POINTS, seen_facets, seen_of_glass

LONGEST = 12_000.0
"""Difference of the ways 2 n d up to which light of both faces interferes. [nm]"""

STEP = 0.1
"""Largest step of phi from entry to entry. [rad]"""

FEWEST_COSINES = 128
"""Entries over the cosine where phi needs fewer."""

FEWEST_WAVELENGTHS = 256
"""Entries over the wave number where phi needs fewer."""

BRIGHTEST = 0.999
"""Reflectance of a metal along its normal up to which it has an index. [-]"""


def reflectance(film: Film, base, cosine, wavelengths) -> np.ndarray:
    """Reflectance of a film on a base in air, unpolarised.

    Parameters
    ----------
    film : Film
    base : complex or array    Refractive index of the base, n + i k. [-]
    cosine : float or array    To the normal, outside. [-]
    wavelengths : float or array    [nm]

    Returns
    -------
    array    Of the shape that the last three have together. [-]
    """
    cosine, base = np.asarray(cosine, np.float64), np.asarray(base, np.complex128)
    squared = 1.0 - cosine**2
    inside = np.sqrt(1.0 - squared / film.ior**2)
    below = np.sqrt(1.0 - squared / base**2)
    path = 2.0 * film.ior * film.thickness
    turn = np.exp(2j * np.pi * path * inside / np.asarray(wavelengths, np.float64))
    total = 0.0
    for first, second in (
        (_amplitude(cosine, film.ior * inside), _amplitude(film.ior * inside, base * below)),
        (_amplitude(film.ior * cosine, inside), _amplitude(base * inside, film.ior * below)),
    ):
        if path > LONGEST:
            lower, upper = np.abs(second) ** 2, first**2
            share = upper + (1.0 - upper) ** 2 * lower / np.maximum(1.0 - upper * lower, 1e-12)
            total = total + 0.5 * share
        else:
            total = total + 0.5 * np.abs(_sum(first, second * turn)) ** 2
    return np.clip(total, 0.0, 1.0)


def _amplitude(one, other):
    return (one - other) / np.where(one + other == 0.0, 1e-12, one + other)


def _sum(first, second):
    """All light that goes to and fro between both faces."""
    below = 1.0 + first * second
    # Grazing light of films that are no boundary to it: all of it comes back.
    return np.where(
        np.abs(below) < 1e-9, -1.0, (first + second) / np.where(below == 0.0, 1.0, below)
    )


def metal_index(normal, edge, real=None) -> np.ndarray:
    """Complex refractive index of a metal by what it reflects.

    Parameters
    ----------
    normal : (n,) array    Reflectance along the normal. [-]
    edge : (n,) array    Reflectance at 82 degrees, which Gulbrandsen's measure of an edge follows, as in Cycles. [-]
    real : (n,) array or None    Real part of the index if it is known. [-]

    Returns
    -------
    (n,) complex array    Its reflectance along the normal is ``normal``. [-]
    """
    normal = np.clip(normal, 0.0, BRIGHTEST)
    if real is None:
        root, edge = np.sqrt(normal), np.clip(edge, 0.0, 1.0)
        most, least = (1.0 + root) / (1.0 - root), (1.0 - normal) / (1.0 + normal)
        real = most * (1.0 - edge) + least * edge
    squared = (normal * (real + 1.0) ** 2 - (real - 1.0) ** 2) / (1.0 - normal)
    return real + 1j * np.sqrt(np.maximum(squared, 0.0))


def grid(film: Film) -> tuple[np.ndarray, np.ndarray]:
    """Return cosines and wavelengths of a film's table, as many as it needs. (n,) [-], (m,) [nm]"""
    path = 2.0 * film.ior * film.thickness
    turns = 0.0 if path > LONGEST else 2.0 * np.pi * path
    root = np.linspace(0.0, 1.0, 1025)
    inside = np.sqrt(1.0 - (1.0 - root**4) / film.ior**2)
    steepest = np.abs(np.gradient(inside, root)).max() * turns / MINIMUM_WAVELENGTH
    n = max(FEWEST_COSINES, int(np.ceil(steepest / STEP)) + 1)
    numbers = 1.0 / MINIMUM_WAVELENGTH, 1.0 / MAXIMUM_WAVELENGTH
    m = max(FEWEST_WAVELENGTHS, int(np.ceil(turns * (numbers[0] - numbers[1]) / STEP)) + 1)
    return np.linspace(0.0, 1.0, n) ** 2, 1.0 / np.linspace(*numbers, m)


def mean_over_hemisphere(values: np.ndarray) -> np.ndarray:
    """Mean 2 * integral of R cos of a table over the root of the cosine, for its linear interpolant. (n, m) -> (m,)"""
    root = np.linspace(0.0, 1.0, len(values))
    nodes, weights = np.polynomial.legendre.leggauss(3)
    share = 0.5 * (nodes + 1.0)
    places = root[:-1, None] + share * root[1]
    amount = 2.0 * root[1] * weights * places**3
    shares = np.zeros(len(values))
    shares[:-1] += (amount * (1.0 - share)).sum(axis=1)
    shares[1:] += (amount * share).sum(axis=1)
    return shares @ values


@lru_cache(maxsize=64)
def facet_shares(alpha: float, count: int) -> np.ndarray:
    """Weights of a table over the root of the cosine in what facets reflect once. (64, ``count``)

    By cosines as `facets.directional_reflectance`, which they give for a boundary of the same reflectance from all sides.
    """
    dot, weight = seen_facets(alpha)
    return _spread(dot, weight, count)


@lru_cache(maxsize=64)
def glass_shares(alpha: float, index: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The same of a boundary of glass, of light from outside and inside.

    ``index``: of the glass.

    Returns
    -------
    (2, 64) array, (2, 64, ``count``) array    The share that is kept is the first and the second times the table.
    """
    plain, shares = [], []
    for eta in (index, 1.0 / index):
        dot, reflected, refracted = seen_of_glass(alpha, eta)
        inner = 1.0 - (1.0 - dot.astype(np.float64) ** 2) / eta**2
        is_all = inner <= 0.0
        outside = dot if eta > 1.0 else np.sqrt(np.maximum(inner, 0.0))
        plain.append(np.where(is_all, reflected, refracted).mean(axis=1, dtype=np.float64))
        shares.append(_spread(outside, np.where(is_all, 0.0, reflected - refracted), count))
    return np.stack(plain), np.stack(shares)


def _spread(cosine, weight, count: int) -> np.ndarray:
    """Share weights out between the entries that lie beside the cosines. (64, ``count``)"""
    place = np.sqrt(np.clip(cosine, 0.0, 1.0)).astype(np.float64) * (count - 1)
    below = np.minimum(place.astype(np.int64), count - 2)
    share = place - below
    row = np.arange(len(place))[:, None] * count + below
    total = np.bincount(row.ravel(), (weight * (1.0 - share)).ravel(), len(place) * count)
    total += np.bincount((row + 1).ravel(), (weight * share).ravel(), len(place) * count)
    return total.reshape(len(place), count) / POINTS


class SpectralTable:
    """Values on the device by cosine and wavelength. ``values``: (n, m) or (r, n, m), even in root and wave number."""

    def __init__(self, values: np.ndarray):
        import drjit as dr
        import mitsuba as mi

        from ..arrays import upload

        self.is_even = values.shape[-1] == 1
        self._rows, self._columns = (dr.opaque(mi.UInt32, n) for n in values.shape[-2:])
        self._values = upload(mi.Float, values)
        dr.eval(self._values, self._rows, self._columns)

    def read(self, cosine, si, active, row=0):
        """Interpolate at a cosine and the wavelengths of a hit. ``row``: number of the part."""
        import drjit as dr
        import mitsuba as mi

        low, share = _place(dr.sqrt(dr.clip(cosine, 0.0, 1.0)), self._rows)
        low += row * self._rows
        value = mi.Spectrum(0.0)
        for k in range(len(value)):
            column, across = mi.UInt32(0), None
            if not self.is_even:
                column, across = _place(_wave_place(si.wavelengths[k]), self._columns)
            ends = (self._along(low + n, column, across, active) for n in (0, 1))
            value[k] = dr.lerp(*ends, share)
        return value

    def _along(self, row, column, share, active):
        import drjit as dr
        import mitsuba as mi

        index = row * self._columns + column
        first = dr.gather(mi.Float, self._values, index, active)
        if share is None:
            return first
        return dr.lerp(first, dr.gather(mi.Float, self._values, index + 1, active), share)


def _place(where, count):
    """Entry below a place from 0 to 1, and how far it is to the next."""
    import drjit as dr
    import mitsuba as mi

    place = where * (mi.Float(count) - 1.0)
    below = dr.minimum(mi.UInt32(place), count - 2)
    return below, place - mi.Float(below)


def _wave_place(wavelength):
    """Place of a wavelength among the wave numbers, 0 to 1."""
    import drjit as dr

    first, last = 1.0 / MINIMUM_WAVELENGTH, 1.0 / MAXIMUM_WAVELENGTH
    return dr.clip((1.0 / wavelength - first) / (last - first), 0.0, 1.0)


class FilmOnMetal:
    """What facets of a metal under a film reflect, and its mean. ``values``: (n, m)."""

    def __init__(self, values: np.ndarray):
        self._mirror = SpectralTable(values)
        mean = mean_over_hemisphere(values)
        self._mean = SpectralTable(np.stack([mean, mean]))

    def mirror(self, si, cosine, active):
        """Reflectance at a cosine to a facet."""
        return self._mirror.read(cosine, si, active)

    def mean(self, si, active):
        """Mean reflectance over the hemisphere."""
        import mitsuba as mi

        return self._mean.read(mi.Float(0.0), si, active)


class FilmOnPaint:
    """The same of a coat of paint, and what its facets reflect once.

    ``values``: (n, m); ``alpha``: width of the facets; ``scale``: on all that they reflect.
    """

    def __init__(self, values: np.ndarray, alpha: float, scale: float):
        once = np.clip(scale * (facet_shares(alpha, len(values)) @ values), 0.0, 1.0)
        mean = mean_over_hemisphere(once)
        self._mirror, self._once = SpectralTable(values), SpectralTable(once)
        self._mean = SpectralTable(np.stack([mean, mean]))

    def mirror(self, si, cosine, active):
        """Reflectance at a cosine to a facet."""
        return self._mirror.read(cosine, si, active)

    def once(self, si, cosine, active):
        """Share of light that facets reflect once, the scale included."""
        return self._once.read(cosine, si, active)

    def mean(self, si, active):
        """Mean of that over the hemisphere."""
        import mitsuba as mi

        return self._mean.read(mi.Float(0.0), si, active)


class FilmOnGlass:
    """Reflectance of a clear boundary under a film. ``values``: (n, m) by the cosine outside; ``index``: of the glass."""

    def __init__(self, values: np.ndarray, alpha: float | None = None, index: float = 1.5):
        self._mirror, self.index = SpectralTable(values), index
        if alpha is not None:
            plain, shares = glass_shares(alpha, index, len(values))
            self._kept = SpectralTable(plain[..., None] + shares @ values)

    def mirror(self, si, cosine, fresnel, active):
        """Reflectance at a cosine to a facet, negative inside. ``fresnel``: that without the film, as Mitsuba gives it."""
        import drjit as dr
        import mitsuba as mi

        plain, cos_t = fresnel[:2]
        outside = dr.abs(dr.select(cosine > 0.0, cosine, cos_t))
        value = self._mirror.read(outside, si, active)
        return mi.Spectrum(dr.select(plain < 1.0, value, 1.0))

    def kept(self, si, cosine, active):
        """Share of light from a direction, negative inside, that the first facet reflects or lets in."""
        import drjit as dr
        import mitsuba as mi

        side = dr.select(cosine > 0.0, mi.UInt32(0), mi.UInt32(1))
        return self._kept.read(dr.abs(cosine), si, active, side)
