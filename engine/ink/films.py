"""What a homogeneous film reflects and lets pass, for both polarisations; the wave across the incidence is the scalar one.

References
----------
M. Born, E. Wolf: Principles of Optics, 7th edition, 1.6.4.
"""

import numpy as np


def film_shares(permittivity, thickness, sines, wavelength, above=1.0, below=1.0):
    """Shares of power that a film reflects and lets pass; arrays that fit together.

    Parameters
    ----------
    permittivity : array    Complex. [-]
    thickness, wavelength : array    [um]
    sines : array    Of the angle of incidence in the half-space above.
    above, below : float    Real indices of the half-spaces.

    Returns
    -------
    (2, ...), (2, ...) float64 arrays    Reflectance and transmittance, polarised across and within the plane of incidence.
    """
    inner = np.asarray(permittivity, np.complex128)
    square = (above * np.asarray(sines, np.float64)) ** 2
    k0 = 2.0 * np.pi / np.asarray(wavelength, np.float64)
    normals = [_root(each - square) for each in (above**2 + 0j, inner, below**2 + 0j)]
    reflectances, transmittances = [], []
    for is_across in (True, False):
        first, middle, last = (
            normal if is_across else normal / each
            for normal, each in zip(normals, (above**2, inner, below**2), strict=True)
        )
        upper = (first - middle) / (first + middle)
        lower = (middle - last) / (middle + last)
        through = np.exp(1j * normals[1] * k0 * thickness)
        loop = 1.0 + upper * lower * through**2
        back = (upper + lower * through**2) / loop
        # Fields tangential to the faces, of which flux is a constant times the admittance.
        forth = (1.0 + upper) * (1.0 + lower) * through / loop
        reflectances.append(np.abs(back) ** 2)
        # At grazing incidence nothing comes, and nothing passes.
        flux = np.maximum(first.real, 1e-300)
        transmittances.append(np.abs(forth) ** 2 * last.real / flux)
    return np.stack(reflectances), np.stack(transmittances)


def _root(square) -> np.ndarray:
    root = np.sqrt(square)
    return np.where(root.imag < 0.0, -root, root)
