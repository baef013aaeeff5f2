"""Scattering by spheres after Mie: efficiencies, and the phase function as a series of Legendre polynomials.

With the size parameter x = pi d n_b / lambda and the index m of the sphere relative to the binder's, n + i k, the amplitudes

    a_n = [(D_n / m + n / x) psi_n - psi_(n-1)] / [(D_n / m + n / x) xi_n - xi_(n-1)],    b_n with m D_n instead

of the logarithmic derivative D_n(m x) of psi_n, which is found downwards.

References
----------
C. F. Bohren, D. R. Huffman: Absorption and Scattering of Light by Small Particles, 1983, chapter 4 and appendix A.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .composition import Diameters

LARGEST = 400.0
"""Largest size parameter. [-]"""

SIZES = 12
"""Diameters by which a spread is averaged."""

MORE_ANGLES = 16
"""Angles beyond the orders, by which a phase function is integrated."""


@dataclass(frozen=True, eq=False)
class Spheres:
    """Mean scattering of spheres at wavelengths.

    Parameters
    ----------
    extinction, scattering : (w,) float64 arrays    Cross sections by volume of spheres. [1/um]
    series : (w, l) float64 array
        chi_l, l from 0, of the phase function p = sum (2 l + 1) chi_l P_l(cos) with the mean 1 over all directions.
    """

    extinction: np.ndarray
    scattering: np.ndarray
    series: np.ndarray

    @property
    def asymmetry(self) -> np.ndarray:
        """Mean cosine of the angle of scattering. (w,)"""
        return self.series[:, 1]


def scatter_spheres(index, diameters: Diameters, binder_index, wavelengths) -> Spheres:
    """Mean scattering of spheres.

    Parameters
    ----------
    index : (w,) complex array    Of the spheres, n + i k. [-]
    binder_index : (w,) array    Real. [-]
    wavelengths : (w,) array    [nm]

    Raises
    ------
    SceneError    Some are too large against the wavelength.
    """
    wavelengths = np.asarray(wavelengths, np.float64)
    places, weights = np.polynomial.hermite_e.hermegauss(SIZES if diameters.log_spread else 1)
    sizes = diameters.median_um * np.exp(places * diameters.log_spread)
    ratio = (np.asarray(index, np.complex128) / binder_index)[:, None]
    parameter = np.pi * sizes * (binder_index / (wavelengths * 1e-3))[:, None]
    if parameter.max() > LARGEST:
        raise SceneError(
            f"grains of {sizes.max():.3g} um are too large for Mie's series, expected size parameters up to {LARGEST:g}"
        )
    first, second, scattered, extinct = _amplitudes(
        np.broadcast_to(ratio, parameter.shape), parameter
    )
    face = 0.25 * np.pi * sizes**2 * weights
    volume = (np.pi / 6.0 * sizes**3 * weights).sum()
    cosines, quadrature = np.polynomial.legendre.leggauss(2 * first.shape[-1] + MORE_ANGLES)
    strength = _strengths(first, second, cosines)  # (w, d, a), of any scale
    strength /= 0.5 * (strength @ quadrature)[..., None]
    share = face * scattered
    phase = np.einsum("wd,wda->wa", share / share.sum(axis=1, keepdims=True), strength)
    # Products with P_l up to the series' own degree, which is twice that of the amplitudes.
    legendre = np.polynomial.legendre.legvander(cosines, 2 * first.shape[-1])
    series = 0.5 * (phase * quadrature) @ legendre
    return Spheres((face * extinct).sum(axis=1) / volume, share.sum(axis=1) / volume, series)


def _amplitudes(ratio, parameter):
    """a_n and b_n (w, d, n), and efficiencies of scattering and extinction (w, d)."""
    orders = int(np.ceil((parameter + 4.0 * np.cbrt(parameter) + 2.0).max()))
    inner = ratio * parameter
    most = max(orders, float(np.abs(inner).max()))
    start = int(most + 8.0 * np.cbrt(most)) + 16
    derivative = np.zeros((orders + 1, *parameter.shape), np.complex128)
    last = np.zeros_like(inner)
    for n in range(start, 0, -1):
        last = n / inner - 1.0 / (last + n / inner)
        if n - 1 <= orders:
            derivative[n - 1] = last
    # psi_n downwards and scaled, since upwards it is lost where n is beyond x; chi_n upwards.
    ratios = np.zeros((orders + 2, *parameter.shape))
    falling = np.zeros_like(parameter)
    for n in range(start + 16, 0, -1):
        falling = 1.0 / ((2.0 * n + 1.0) / parameter - falling)  # psi_n / psi_(n-1)
        if n <= orders:
            ratios[n] = falling
    psi_before = np.sin(parameter)
    chi_before, chi_older = np.cos(parameter), -np.sin(parameter)
    first, second = [], []
    scattered, extinct = np.zeros_like(parameter), np.zeros_like(parameter)
    for n in range(1, orders + 1):
        psi = ratios[n] * psi_before
        chi = (2.0 * n - 1.0) / parameter * chi_before - chi_older
        wave, wave_before = psi - 1j * chi, psi_before - 1j * chi_before
        a = derivative[n] / ratio + n / parameter
        b = derivative[n] * ratio + n / parameter
        # Orders of which a small sphere has none overflow.
        with np.errstate(over="ignore", invalid="ignore"):
            a = (a * psi - psi_before) / (a * wave - wave_before)
            b = (b * psi - psi_before) / (b * wave - wave_before)
        a, b = (np.where(np.isfinite(each), each, 0.0) for each in (a, b))
        first.append(a)
        second.append(b)
        scattered += (2 * n + 1) * (np.abs(a) ** 2 + np.abs(b) ** 2)
        extinct += (2 * n + 1) * (a + b).real
        psi_before, chi_older, chi_before = psi, chi_before, chi
    scale = 2.0 / parameter**2
    return np.stack(first, -1), np.stack(second, -1), scale * scattered, scale * extinct


def _strengths(first, second, cosines) -> np.ndarray:
    """Intensity of unpolarised light by the angle, of any scale. (w, d, n) -> (w, d, a)"""
    orders = first.shape[-1]
    pi_older, pi = np.zeros_like(cosines), np.ones_like(cosines)
    pies, taus = [], []
    for n in range(1, orders + 1):
        pies.append(pi)
        taus.append(n * cosines * pi - (n + 1) * pi_older)
        pi_older, pi = pi, ((2 * n + 1) * cosines * pi - (n + 1) * pi_older) / n
    weight = np.array([(2 * n + 1) / (n * (n + 1)) for n in range(1, orders + 1)])
    pies, taus = np.array(pies) * weight[:, None], np.array(taus) * weight[:, None]
    return np.abs(first @ pies + second @ taus) ** 2 + np.abs(first @ taus + second @ pies) ** 2
