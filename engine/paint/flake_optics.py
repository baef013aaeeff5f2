"""What a flake reflects and lets pass, by the angle to its normal and wavelength: waves in sheets between two binders.

Of sheets j of the index n_j and the thickness d_j, with the cosine c_j inside, the phase delta = 2 pi n d c / lambda and the
admittance eta = n c for the polarisation across the plane of incidence (s), n / c for that within it (p), the product of

    [ cos delta            -i sin(delta) / eta ]
    [ -i eta sin(delta)     cos delta          ]

times (1, eta_0) is (B, C), and r = (eta_0 B - C) / (eta_0 B + C) the amplitude that comes back of the tangential field.

All depends smoothly on the cosine in the binder, since only even functions of the other cosines occur: Chebyshev polynomials
of it hold a flake's curve, which makes everything that is linear in the reflectance a product of matrices. Towards grazing
sheets reflect nearly all of the light across the plane of incidence, and fringes get narrower than the spread of tilts by
which they are averaged; there the series holds their means. What single flakes reflect is read off the curve itself.

References
----------
H. A. Macleod: Thin-Film Optical Filters, 4th edition, 2.6. M. Born, E. Wolf: Principles of Optics, 7th edition, 1.6.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..errors import SceneError
from .composition import Flakes, Mirror, Stack

TERMS = (1, 8, 16, 24, 32, 48, 64, 96, 128, 192, 256)
"""Polynomials that a flake's series may have."""

PRECISE = 5e-4
"""Mean error of a series, by the share of the light that meets flakes at a cosine. [-]"""

TILT_TERMS = 3.0
"""Polynomials beyond which a spread of tilts averages fringes out, times its slope. [-]"""

CHECKED = np.linspace(0.02, 1.0, 99)
"""Cosines at which series are checked."""

PLACES = 384
"""Cosines of which series are made."""

ANGLES = 641
"""Angles at which curves are kept, up to the largest at which light from outside is met."""

FINEST_FRINGE = 80.0
"""Difference of phases between light along the normal and at 45 degrees, up to which these are fine enough. [rad]"""

OPAQUE = 40.0
"""Imaginary phase from which a sheet lets nothing pass. [rad]"""

THICKNESSES = 7
"""Thicknesses of the core by which a spread is averaged."""


@dataclass(frozen=True, eq=False)
class FlakeCurves:
    """Shares of light at a flake by the angle to its normal in the binder.

    Parameters
    ----------
    step : float    From angle to angle of the curves. [rad]
    curves : (3, a, w) float64 array
        At angles from 0: reflectance of light polarised across the plane of incidence, of that within it, and the real
        part of the one amplitude times the other's conjugate, of tangential fields, which 45 degrees go by.
    reflected, passed : (w, q) float64 arrays
        Reflectance and transmittance of unpolarised light as Chebyshev series of 2 c - 1, c the cosine.
    """

    step: float
    curves: np.ndarray
    reflected: np.ndarray
    passed: np.ndarray

    @property
    def terms(self) -> int:
        """How many polynomials there are."""
        return self.reflected.shape[1]

    def read(self, cosines) -> np.ndarray:
        """The curves at cosines. (n,) -> (3, n, w)"""
        last = self.curves.shape[1] - 1
        place = np.minimum(np.arccos(np.clip(cosines, 0.0, 1.0)) / self.step, last)
        low = np.minimum(place.astype(np.int64), last - 1)
        share = (place - low)[:, None]
        return self.curves[:, low] * (1.0 - share) + self.curves[:, low + 1] * share


def polynomials(cosines, terms: int) -> np.ndarray:
    """Chebyshev polynomials of 2 c - 1. (...) -> (..., q)"""
    x = 2.0 * np.asarray(cosines, np.float64) - 1.0
    made = np.empty((*x.shape, terms))
    made[..., 0] = 1.0
    if terms > 1:
        made[..., 1] = x
    for k in range(2, terms):
        np.multiply(2.0 * x, made[..., k - 1], out=made[..., k])
        made[..., k] -= made[..., k - 2]
    return made


def find_curves(flakes: Flakes, binder_index, wavelengths) -> FlakeCurves:
    """Curves of flakes in a binder.

    Parameters
    ----------
    binder_index : (w,) array    Real. [-]
    wavelengths : (w,) array    [nm]

    Raises
    ------
    SceneError    The flake is so thick that its fringes are finer than what a curve is kept by.
    """
    if isinstance(flakes.optics, Mirror):
        share, passed = (
            each.at(wavelengths)
            for each in (flakes.optics.reflectance, flakes.optics.transmittance)
        )
        curves = np.broadcast_to(share, (3, 2, len(share)))
        return FlakeCurves(1.0, curves, share[:, None], passed[:, None])
    if _fringes(flakes.optics, binder_index, wavelengths) > FINEST_FRINGE:
        raise SceneError(
            f"flakes '{flakes.name}' of {flakes.thickness_nm:g} nm have too many interference orders, expected thinner ones"
        )
    angles = np.linspace(0.0, np.arcsin(1.0 / max(np.min(binder_index), 1.001)), ANGLES)
    read = np.maximum(np.cos(angles), 1e-6)
    shares = find_shares(
        flakes.optics, binder_index, wavelengths, np.concatenate([read, CHECKED, _nodes()[0]])
    )
    mean, passed = 0.5 * (shares[0] + shares[1]), shares[3]
    curves = np.stack([each[:, :ANGLES].T for each in shares[:3]])
    both = np.stack([mean, passed])[..., ANGLES:]
    true, values = both[..., : len(CHECKED)], both[..., len(CHECKED) :]
    series = values @ _nodes()[1]
    basis = polynomials(CHECKED, TERMS[-1]).T
    enough = TILT_TERMS / flakes.slope
    for terms in TERMS:
        error = np.abs(series[..., :terms] @ basis[:terms] - true) * CHECKED
        if error.mean(axis=-1).max() <= PRECISE or terms >= enough:
            break
    return FlakeCurves(angles[1], curves, *series[..., :terms])


def _fringes(stack: Stack, binder_index, wavelengths) -> float:
    """Difference of phases between light along the normal and at 45 degrees. [rad]"""
    total = 0.0
    for film, count in ((stack.core, 1.0), *((each, 2.0) for each in stack.coatings)):
        index = np.abs(film.index.at(wavelengths))
        path = index - np.sqrt(np.maximum(index**2 - 0.5 * np.asarray(binder_index) ** 2, 0.0))
        # Of metals only what light comes through counts.
        through = np.exp(
            -2.0 * np.pi * np.imag(film.index.at(wavelengths)) * film.thickness_nm / wavelengths
        )
        total = total + count * 4.0 * np.pi * film.thickness_nm * path / wavelengths * through
    return float(np.max(total))


@lru_cache
def _nodes() -> tuple[np.ndarray, np.ndarray]:
    """Cosines at which a curve is taken, and what makes of its values there the coefficients."""
    angle = (np.arange(PLACES) + 0.5) * np.pi / PLACES
    transform = np.cos(np.outer(angle, np.arange(TERMS[-1]))) * (2.0 / PLACES)
    transform[:, 0] *= 0.5
    return 0.5 * (1.0 + np.cos(angle)), transform


def find_shares(stack: Stack, binder_index, wavelengths, cosines) -> tuple[np.ndarray, ...]:
    """Shares of light at a stack, averaged over its spread of thickness.

    Parameters
    ----------
    binder_index : (w,) array    Real. [-]
    wavelengths : (w,) array    [nm]
    cosines : (c,) array    In the binder, above 0.

    Returns
    -------
    tuple of four (w, c) float64 arrays    Reflectance across and within the plane of incidence, what 45 degrees go by, and
        the transmittance of unpolarised light, as of `FlakeCurves`.
    """
    films = [*reversed(stack.coatings), stack.core, *stack.coatings]
    indices = [each.index.at(wavelengths).astype(np.complex128)[:, None] for each in films]
    thicknesses = [each.thickness_nm for each in films]
    if not stack.thickness_spread:
        return _shares(binder_index, indices, thicknesses, wavelengths, cosines)
    places, weights = np.polynomial.hermite_e.hermegauss(THICKNESSES)
    total, core = 0.0, len(stack.coatings)
    for place, weight in zip(places, weights / weights.sum(), strict=True):
        thicknesses[core] = stack.core.thickness_nm * max(1.0 + place * stack.thickness_spread, 0.0)
        shares = _shares(binder_index, indices, thicknesses, wavelengths, cosines)
        total = total + weight * np.stack(shares)
    return tuple(total)


def _shares(binder_index, indices, thicknesses, wavelengths, cosines) -> tuple[np.ndarray, ...]:
    outer = np.asarray(binder_index, np.float64)[:, None]
    wavelengths = np.asarray(wavelengths, np.float64)[:, None]
    cosines = np.asarray(cosines, np.float64)[None]
    tangential = (outer * np.sqrt(1.0 - cosines**2)) ** 2
    turns = []
    for index, thickness in zip(indices, thicknesses, strict=True):
        normal = np.sqrt(index**2 - tangential)  # n cos
        phase = 2.0 * np.pi * thickness / wavelengths * normal
        phase = phase.real + 1j * np.minimum(phase.imag, OPAQUE)
        turns.append((index, normal, np.cos(phase), np.sin(phase)))
    amplitudes, passed = [], 0.0
    for is_across in (True, False):
        outside = outer * cosines if is_across else outer / cosines
        first, second = np.ones_like(outside, np.complex128), outside.astype(np.complex128)
        for index, normal, cosine, sine in reversed(turns):
            inside = normal if is_across else index**2 / normal
            first, second = (
                cosine * first - 1j * sine / inside * second,
                cosine * second - 1j * sine * inside * first,
            )
        below = outside * first + second
        amplitudes.append((outside * first - second) / below)
        passed = passed + 0.5 * np.abs(2.0 * outside / below) ** 2
    across, within = amplitudes
    return (
        np.abs(across) ** 2,
        np.abs(within) ** 2,
        (across * within.conj()).real,
        passed,
    )
