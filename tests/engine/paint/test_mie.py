"""Spheres after Mie, against the tables that programs for them are checked with, and against miepython's values."""

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.paint.composition import Diameters
from lumenray.engine.paint.mie import scatter_spheres


def efficiencies(index, size):
    """[extinction, scattering, asymmetry] of a sphere in vacuum with a size parameter."""
    diameter = size / np.pi
    made = scatter_spheres(np.array([index + 0j]), Diameters(diameter), np.ones(1), [1000.0])
    scale = diameter / 1.5
    return [made.extinction[0] * scale, made.scattering[0] * scale, made.asymmetry[0]]


@pytest.mark.parametrize(
    ("index", "size", "want"),
    [  # A12: Bohren and Huffman's sample, miepython's, Wiscombe's
        (1.55, 5.21282, [3.1054247418196654, 3.1054247418196654, 0.6331366986241304]),
        (1.5 + 1j, 1.0, [2.336320984672381, 0.6634537615162462, 0.19213639589188627]),
        (1.5, 10.0, [2.881998952075896, 2.881998952075896, 0.742912898568678]),
        (1.33 + 1e-5j, 100.0, [2.1013207058578036, 2.0965935063939676, 0.8689592720021941]),
        (
            1.0 / 1.557,
            4.4467816014902795,
            [1.8473258651944993, 1.8473258651944993, 0.8282914268971742],
        ),
    ],
)
def test_single_spheres(index, size, want):
    assert efficiencies(index, size) == pytest.approx(want, rel=1e-5)


@pytest.mark.parametrize(
    ("index", "diameter", "extinction", "asymmetry"),
    [  # A12, by 1 % of volume
        (2.7, 0.25, 0.23906113495266126, 0.5419154351235195),
        (1.75 + 0.44j, 0.03, 0.09349338952191862, 0.010526539884757302),
        (1.6 + 0.2j, 0.15, 0.04648935414353687, 0.28508212196508115),
    ],
)
def test_pigments(index, diameter, extinction, asymmetry):
    made = scatter_spheres(np.array([index + 0j]), Diameters(diameter), np.array([1.45]), [550.0])
    assert 0.01 * made.extinction[0] == pytest.approx(extinction, rel=1e-5)
    assert made.asymmetry[0] == pytest.approx(asymmetry, rel=1e-5)


def test_phase_functions_are_positive_and_normal():
    wavelengths = np.array([400.0, 700.0])
    made = scatter_spheres(np.full(2, 2.6 + 0j), Diameters(0.4, 0.3), np.full(2, 1.5), wavelengths)
    cosines = np.linspace(-1, 1, 91)
    terms = np.arange(made.series.shape[1])
    phase = np.polynomial.legendre.legval(cosines, (made.series * (2 * terms + 1)).T)
    assert made.series[:, 0] == pytest.approx(np.ones(2), abs=1e-12)
    assert phase.min() > 0.0


def test_large_grains_are_refused():
    with pytest.raises(SceneError, match="too large for Mie"):
        scatter_spheres(np.array([1.6 + 0j]), Diameters(200.0), np.array([1.5]), [400.0])
