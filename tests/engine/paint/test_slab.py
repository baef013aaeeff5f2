"""Adding of layers: slabs of isotropic and of forward scattering against closed forms and tables."""

import numpy as np
import pytest

from lumenray.benchmarks.paint.slabs import make_slab, shares_of
from lumenray.engine.paint.slab import Rates, add_below, find_slab


@pytest.mark.parametrize(
    ("albedo", "depth", "asymmetry", "want"),
    [
        # A2, own solver of the reference with a start at an optical depth of 1e-7; van de Hulst's table where g is 0.75.
        (0.5, 1, 0, [0.09911916700934101, 0.4460583746228394, 0.13416514164660123, 0.3067088065785305]),
        (0.9, 1, 0, [0.2674101971537295, 0.591624965865979, 0.35271186374210467, 0.4747457098618748]),
        (0.99, 16, 0, [0.7512559072850038, 0.029596908829919142, 0.793415358976971, 0.023196824508840124]),
        (1.0, 8, 0, [0.8218002526250978, 0.17819477769073602, 0.8584679156802664, 0.1415278293335333]),
        (0.9, 2, 0.75, [0.09739, 0.66096, 0.19108998816388523, 0.5018158432080795]),
        (0.99, 8, 0.875, [0.25842316709068847, 0.6080770116215232, 0.38843055898051015, 0.46901477521846785]),
    ],
)  # fmt: skip
def test_matched_slabs(albedo, depth, asymmetry, want):
    assert shares_of(albedo, depth, asymmetry) == pytest.approx(want, abs=2e-4)


@pytest.mark.parametrize(
    ("albedo", "depth", "asymmetry", "index", "want"),
    [
        # A3
        (0.9, 1, 0, 1.45, [0.22226203436083106, 0.5165243365612889, 0.28053938763275654, 0.44966194894344325]),
        (0.99, 4, 0.75, 1.5, [0.32903885554606804, 0.5216488121919997, 0.38772490381489694, 0.46164133688857034]),
        (1.0, 2, 0, 1.45, [0.4879025099866729, 0.512095485616091, 0.5362351536131502, 0.4637944300242848]),
        (0.9, 4096, 0, 1.5, [0.25996, 0.0, 0.3079036747690301, 0.0]),  # Giovanelli: 0.2600
    ],
)  # fmt: skip
def test_slabs_with_faces(albedo, depth, asymmetry, index, want):
    assert shares_of(albedo, depth, asymmetry, index) == pytest.approx(want, abs=5e-4)


@pytest.mark.parametrize(
    ("albedo", "h"),
    [(0.5, 1.2512595633832222), (0.9, 1.8500985167698127), (0.99, 2.472792828397024)],
)
def test_half_spaces(albedo, h):
    """Chandrasekhar's H function (A1)."""
    directions, reflected, _ = make_slab(albedo, 1e5, count=300)
    root = np.sqrt(directions.weights)
    normal = directions.interpolation([0.0])[0]
    kernel = reflected / np.outer(root, root)
    assert normal @ kernel @ directions.weights == pytest.approx(
        1.0 - np.sqrt(1.0 - albedo) * h, abs=1e-5
    )
    assert normal @ kernel @ normal == pytest.approx(albedo / 8.0 * h**2, abs=1e-5)


@pytest.mark.parametrize(
    ("r", "t", "depth"),
    [(1.0, 0.0, 2.0), (0.5, 0.5, 2.0), (0.9, 0.0, 2.0), (0.9, 0.0, 1e6), (0.22, 0.78, 3.459)],
)
def test_parallel_flakes(r, t, depth):
    """Mirrors without any tilt turn every direction into its own: two streams, in closed form (A5)."""
    k = 1.0 - t
    mu = np.array([0.2, 1.0])
    rates = Rates(np.diag((k + r) * np.ones(2)), np.diag((k - r) * np.ones(2)))
    reflected, _ = find_slab(rates, depth)
    # By length along the normal all directions are alike: what flakes intercept goes with the cosine.
    if abs(k - r) < 1e-12:
        want = r * depth / (1.0 + r * depth)
    else:
        q = np.sqrt(k * k - r * r)
        want = (
            r / (k + q)
            if depth > 1e5
            else r * np.sinh(q * depth) / (q * np.cosh(q * depth) + k * np.sinh(q * depth))
        )
    assert np.diag(reflected) == pytest.approx(want * np.ones(len(mu)), abs=1e-9)


def test_slabs_add_to_themselves():
    """Two layers of half the thickness, one on the other, are the whole: what doubling rests upon."""
    _, half_r, half_t = make_slab(0.97, 1.5, 0.6, 1.45, 32)
    _, whole_r, _ = make_slab(0.97, 3.0, 0.6, 1.45, 32)
    assert add_below(half_r, half_t, half_r) == pytest.approx(whole_r, abs=1e-12)
