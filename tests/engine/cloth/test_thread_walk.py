"""Light inside one thread, against closed forms and other programs' walks."""

import numpy as np
import pytest

pytest.importorskip("mitsuba")

import mitsuba as mi

from lumenray.engine.cloth.boundary import reflect_share
from lumenray.engine.cloth.thread_walk import ThreadOptics, walk_inside
from lumenray.engine.paint.fresnel import face_reflectance
from lumenray.engine.transport import backend

pytestmark = [pytest.mark.mitsuba, pytest.mark.validation]

INDEX = 1.557


@pytest.fixture(autouse=True)
def variant():
    backend.start(spectral=False)


def forward(g: float) -> np.ndarray:
    """Cosines of scattering after Henyey and Greenstein, at even chances."""
    u = np.linspace(0.0, 1.0, 1025)
    if g == 0.0:
        return 2.0 * u - 1.0
    s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u)
    return (1.0 + g * g - s * s) / (2.0 * g)


def lambert(count: int):
    """Ways into a thread of light from all around it: along, and offset from the axis."""
    u, v = np.random.default_rng(3).random((2, count))
    axial, around = np.sqrt(u) * np.cos(2 * np.pi * v), np.sqrt(u) * np.sin(2 * np.pi * v)
    return axial, around / np.sqrt(1.0 - axial**2), np.sqrt(1.0 - u)


def walk(axial, offset, *optics):
    made = walk_inside(ThreadOptics(*optics), mi.Float(axial), mi.Float(offset), 1)
    assert not np.array(made.lost).any()
    return made


@pytest.mark.parametrize(
    "index, optical_radius, g, roughness",
    [(1.0, 0.5, 0.0, 0.0), (INDEX, 20.0, 0.8, 0.0), (INDEX, 5.0, 0.0, 0.3)],
)
def test_mean_way_is_that_of_any_body(index, optical_radius, g, roughness):
    """2 n^2 R whatever scatters, and however rough the surface is (Blanco and Fournier; B2)."""
    axial, offset, cosine = lambert(30_000)
    made = walk(axial, offset, index, optical_radius, forward(g), roughness)
    grid = np.linspace(0.0, 1.0, 301)
    enters = 1.0 - np.interp(cosine, grid, reflect_share(grid, index, roughness))
    ways = enters * np.array(made.length)
    error = ways.std() / np.sqrt(len(ways))
    assert ways.mean() == pytest.approx(2.0 * index**2, abs=4.0 * error)
    assert error < 0.01 * ways.mean()


@pytest.mark.parametrize("depth, share", [(0.25, 0.6796327547), (2.0, 0.0729358911)])
def test_uncollided_light_is_what_struve_says(depth, share):
    """1 + pi / 2 (L1 - I1)(2 t) of a beam across a thread without a surface (B1)."""
    count = 20_000
    offset = 2.0 * np.random.default_rng(4).random(count) - 1.0
    made = walk(np.zeros(count), offset, 1.0, depth, forward(0.0))
    went = (np.abs(np.array(made.axial)) < 1e-6).mean()
    assert went == pytest.approx(share, abs=4.0 * np.sqrt(share * (1.0 - share) / count))


@pytest.mark.parametrize("absorbed, straight", [(0.0, 0.8599798), (0.5, 0.3390209)])
def test_clear_thread_has_the_lobes_of_hair(absorbed, straight):
    """TT and TRT of a clear cylinder, also with a dye (B3)."""
    count = 60_000
    offset = (np.arange(count) + 0.5) / count
    made = walk(np.zeros(count), offset, INDEX, 0.0, forward(0.0))
    way = np.array(made.length)
    crossings = np.rint(way / (2.0 * np.sqrt(1.0 - (offset / INDEX) ** 2)))
    enters = 1.0 - face_reflectance(offset, 1.0, INDEX)
    kept = enters * np.exp(-absorbed * way)
    assert 1.0 - enters.mean() == pytest.approx(0.0759352, abs=1e-4)
    assert kept[crossings == 1].sum() / count == pytest.approx(straight, abs=2e-3)
    if not absorbed:
        assert kept[crossings == 2].sum() / count == pytest.approx(0.0563859, abs=2e-3)


def test_thick_thread_returns_what_another_walk_found():
    """Pencil on the middle of a thread, mu_s R = 30, a hundredth of it absorbed (B4: 0.5703)."""
    count = 4_000
    made = walk(np.zeros(count), np.zeros(count), INDEX, 30.0, forward(0.0))
    enters = 1.0 - face_reflectance(0.0, 1.0, INDEX)
    kept = enters * np.exp(-0.3 * np.array(made.length))
    error = np.hypot(kept.std() / np.sqrt(count), 0.0016)
    assert kept.mean() == pytest.approx(0.57026, abs=4.0 * error)


@pytest.mark.parametrize(
    "roughness, shares", [(0.2, (0.94766, 0.92440, 0.85777)), (0.5, (0.68785, 0.68277, 0.76137))]
)
def test_facets_lose_what_a_quadrature_says(roughness, shares):
    """Albedo of mirrors as facets at 0, 45 and 75 degrees (B5)."""
    made = reflect_share(np.cos(np.radians([0.0, 45.0, 75.0])), np.inf, roughness)
    assert made == pytest.approx(shares, abs=1e-3)
