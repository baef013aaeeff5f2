"""Spectra of many colours at once: sums of three smooth spectra, so that interpolating values and colours is the same."""

import numpy as np

ANY_WAVELENGTH = 550.0
"""Of tables that are the same at all wavelengths. [nm]"""

WAVELENGTHS = np.arange(400.0, 641.0, 20.0)
"""Of `PRIMARIES`; beyond them the ends hold. [nm]"""

PRIMARIES = np.array(
    [
        [0.055163, 0.000000, 0.944837],
        [0.051731, 0.000000, 0.948269],
        [0.029101, 0.000000, 0.970899],
        [0.006272, 0.000000, 0.993728],
        [0.000000, 0.263407, 0.736593],
        [0.000000, 0.741991, 0.258009],
        [0.000000, 1.000000, 0.000000],
        [0.000000, 1.000000, 0.000000],
        [0.000000, 1.000000, 0.000000],
        [0.138651, 0.788863, 0.072486],
        [0.793079, 0.205252, 0.001669],
        [1.000000, 0.000000, 0.000000],
        [1.000000, 0.000000, 0.000000],
    ]
)
"""Reflectances of Rec. 709 red, green and blue, (w, 3). [-]

Of all that are nowhere negative, sum up to 1 at every wavelength, and look under D65 to the 1931 observer exactly like the
primaries, these have the smallest sum of squared steps (a quadratic programme, rounded to six digits).
"""


def spectra_of_rgb(values) -> tuple[np.ndarray, np.ndarray]:
    """Smooth spectra of linear Rec. 709 / D65 values of reflectance, on any scale.

    Greys are the same at all wavelengths; colours outside the gamut come back less saturated, as spectra are nowhere
    negative.

    Parameters
    ----------
    values : (n, 3) array    Red, green, blue. [x]

    Returns
    -------
    wavelengths : (w,) float64 array    Linear in between, the ends hold beyond. [nm]
    spectra : (n, w) float64 array    [x]
    """
    values = np.asarray(values, dtype=np.float64)
    # Greys go beside the sum, which would round them.
    grey = values.min(axis=1, keepdims=True)
    return WAVELENGTHS.copy(), np.maximum(grey + (values - grey) @ PRIMARIES.T, 0.0)
