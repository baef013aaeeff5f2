"""Scattering of scalar waves by a sphere; beside Mie's, it tells what the scalar model leaves out.

The field u and its slope du/dr are the same on both sides of the surface.

With x = k a in the binder and y = m x inside, partial waves scatter as

    a_l = -[j_l'(x) j_l(y) - m j_l(x) j_l'(y)] / [h_l'(x) j_l(y) - m h_l(x) j_l'(y)]
    Q_sca = 4 / x^2 sum (2 l + 1) |a_l|^2,   Q_ext = -4 / x^2 sum (2 l + 1) Re a_l,   f(0) = sum (2 l + 1) a_l / (i k)

References
----------
P. M. Morse, K. U. Ingard: Theoretical Acoustics, 1968, 8.2 (a fluid sphere of equal density).
"""

import numpy as np

MORE_ORDERS = 12


def partial_waves(parameter: float, ratio: complex) -> np.ndarray:
    """Amplitudes a_l of a sphere.

    Parameters
    ----------
    parameter : float    Size, k a in the binder.
    ratio : complex    Index over that of the binder.

    Returns
    -------
    (l,) complex128 array    From l = 0 on.
    """
    orders = int(parameter + 4.0 * np.cbrt(parameter)) + MORE_ORDERS
    inner = ratio * parameter
    outside, inside = _bessel(orders, parameter), _bessel(orders, inner)
    second = _neumann(orders, parameter)
    outer = outside + 1j * second
    slopes = [
        _slopes(values, place)
        for values, place in ((outside, parameter), (inside, inner), (outer, parameter))
    ]
    top = slopes[0] * inside[:-1] - ratio * outside[:-1] * slopes[1]
    bottom = slopes[2] * inside[:-1] - ratio * outer[:-1] * slopes[1]
    return -top / bottom


def scalar_efficiencies(parameter: float, ratio: complex) -> tuple[float, float]:
    """Efficiencies of extinction and of scattering."""
    waves = partial_waves(parameter, ratio)
    weights = 2.0 * np.arange(len(waves)) + 1.0
    scale = 4.0 / parameter**2
    return -scale * float(weights @ waves.real), scale * float(weights @ np.abs(waves) ** 2)


def forward_amplitude(radius: float, ratio: complex, wave_number: float) -> complex:
    """f(0), the wave far away being f exp(i k r) / r. [um], [-], [1/um] -> [um]"""
    waves = partial_waves(wave_number * radius, ratio)
    return complex((2.0 * np.arange(len(waves)) + 1.0) @ waves / (1j * wave_number))


def _bessel(orders: int, place) -> np.ndarray:
    """j_0 to j_orders, downwards from orders at which they vanish."""
    start = orders + int(abs(place)) + 16
    values = np.zeros(start + 2, np.complex128)
    values[start] = 1e-280
    for n in range(start, 0, -1):
        values[n - 1] = (2 * n + 1) / place * values[n] - values[n + 1]
        if abs(values[n - 1]) > 1e250:
            values[n - 1 :] *= 1e-250
    first = np.sin(place) / place
    second = first / place - np.cos(place) / place
    # By the larger of both: the other one may be 0 there.
    scale = first / values[0] if abs(first) >= abs(second) else second / values[1]
    return values[: orders + 1] * scale


def _neumann(orders: int, place: float) -> np.ndarray:
    values = np.empty(orders + 1)
    values[0] = -np.cos(place) / place
    values[1] = values[0] / place - np.sin(place) / place
    for n in range(1, orders):
        values[n + 1] = (2 * n + 1) / place * values[n] - values[n - 1]
    return values


def _slopes(values, place) -> np.ndarray:
    """Derivatives, of all but the last."""
    n = np.arange(len(values) - 1)
    return n / place * values[:-1] - values[1:]
