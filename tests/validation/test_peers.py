"""Radiance and Cycles as instruments of the suite: closed forms on small scenes, where the programs are installed."""

import numpy as np
import pytest

from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.scene.light import CieSky, Luminaire, Output, PointLight, Quantity
from lumenray.engine.scene.material import Diffuse, Material, TabulatedPane, ThinGlass, Transparent
from lumenray.engine.scene.sensor import SensorKind
from lumenray.engine.scene.spectrum import Constant, Tabulated
from lumenray.validation.bench import Bench, CannotStateError
from lumenray.validation.peers.contents import sort_items
from lumenray.validation.peers.cycles import Cycles
from lumenray.validation.peers.radiance import Radiance
from lumenray.validation.peers.skies import luminance_scale, relative_luminance
from lumenray.validation.reference import FOLDER
from lumenray.validation.stage import BLACK, box, candela, frame, glowing, lumen, matt, mesh, quad

pytestmark = pytest.mark.validation

UP, ORIGIN = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)

OPENING = 1.2
"""Side of the square opening over the origin, and of the light. [m]"""

HEIGHT = 2.0
"""Of opening and light. [m]"""


@pytest.fixture(scope="module")
def radiance():
    """Radiance with few rays."""
    return Bench(_start(Radiance, rays=300_000))


@pytest.fixture(scope="module")
def cycles():
    """Cycles with few paths."""
    peer = _start(Cycles, paths=100_000)
    yield Bench(peer)
    peer.close()


@pytest.fixture(params=["radiance", "cycles"])
def bench(request):
    """Each of the two."""
    return request.getfixturevalue(request.param)


def _start(kind, **options):
    try:
        return kind(**options)
    except CannotStateError as error:
        pytest.skip(str(error))


def square_factor(side: float, height: float) -> float:
    """Configuration factor of an element under the middle of a parallel square."""
    ratio = 0.5 * side / height
    root = np.sqrt(1.0 + ratio**2)
    return 4.0 / np.pi * ratio / root * np.arctan(ratio / root)


def room(reflector: str = "black") -> list:
    """Black room under a roof with a square hole over the origin."""
    low, share = -2.0, (2.0 - 0.5 * OPENING) / 4.0
    hole = (share, 1.0 - share)
    return [
        BLACK,
        frame("roof", (low, low, HEIGHT), (0, 4, 0), (4, 0, 0), hole, hole, reflector),
        quad("floor", (low, low, 0), (4, 0, 0), (0, 4, 0), reflector),
        quad("south", (low, low, 0), (0, 0, HEIGHT), (4, 0, 0), reflector),
        quad("north", (low, 2, 0), (4, 0, 0), (0, 0, HEIGHT), reflector),
        quad("west", (low, low, 0), (0, 4, 0), (0, 0, HEIGHT), reflector),
        quad("east", (2, low, 0), (0, 0, HEIGHT), (0, 4, 0), reflector),
    ]


def pane(surface, key: str = "pane") -> list:
    """Square in the hole of the room."""
    corner = (-0.5 * OPENING, -0.5 * OPENING, HEIGHT)
    return [
        Material(key, key, surface),
        quad("glass", corner, (OPENING, 0, 0), (0, OPENING, 0), key),
    ]


def slab(cosine, ior: float, body: float):
    """Transmittance and reflectance of a pane whose body passes ``body`` straight through (Fresnel, all reflections)."""
    inner = np.sqrt(1.0 - (1.0 - cosine**2) / ior**2)
    weakened = body ** (1.0 / inner)
    transmittance = reflectance = 0.0
    for one, two in ((cosine, ior * inner), (ior * cosine, inner)):
        face = ((one - two) / (one + two)) ** 2
        passed = (1.0 - face) ** 2 * weakened / (1.0 - (face * weakened) ** 2)
        transmittance = transmittance + 0.5 * passed
        reflectance = reflectance + 0.5 * face * (1.0 + weakened * passed)
    return transmittance, reflectance


def test_point_light_follows_the_inverse_square(bench):
    points = [(0.0, 0.0, 0.0), (1.0, 2.0, 0.0), (0.0, 0.0, 6.0)]
    made = bench.measure([candela("lamp", (0, 0, 3), 1000.0)], points, [UP, UP, (0, 0, -1)], 1.0)
    expected = [1000.0 / 9.0, 3000.0 / 14.0**1.5, 1000.0 / 9.0]
    assert made.values == pytest.approx(expected, rel=2e-4)


def test_square_light_has_its_configuration_factor(bench):
    corner = (-0.5 * OPENING, -0.5 * OPENING, HEIGHT)
    light = quad("light", corner, (0, OPENING, 0), (OPENING, 0, 0), "glow")
    points = [(0, 0, 0), (0, 0, HEIGHT - 0.1), (0, 0, HEIGHT + 1)]
    made = bench.measure([glowing("glow", 1000.0), light], points, [UP, UP, (0, 0, -1)], 1.0)
    expected = [1000.0 * np.pi * square_factor(OPENING, h) for h in (HEIGHT, 0.1)]
    # Nothing is behind it.
    assert made.values == pytest.approx([*expected, 0.0], rel=3e-3)


def test_uniform_sky_through_an_opening(bench):
    sky = CieSky(5, np.array([0.0, 0.0, 1.0]), 1000.0)
    made = bench.measure([*room(), sky, *pane(Transparent())], [ORIGIN], [UP], 1.0)
    expected = 1000.0 * square_factor(OPENING, HEIGHT)
    assert made.errors[0] < 0.01 * expected
    assert made.values[0] == pytest.approx(expected, abs=4.0 * made.errors[0] + 1e-3 * expected)


def test_sphere_of_light_fills_what_it_fills(bench):
    output = Output(Quantity.LUMINANCE, 100.0)
    sphere = PointLight("ball", "ball", output, np.array([0.0, 0.0, 3.0]), 1.0)
    made = bench.measure([sphere], [ORIGIN], [UP], 1.0)
    assert made.values[0] == pytest.approx(100.0 * np.pi / 9.0, rel=5e-3)


def test_closed_cube_multiplies_light(bench):
    cube = box("cube", (-1, -1, -1), (1, 1, 1), "paint", inwards=True)
    grid = (np.arange(4) + 0.5) / 2.0 - 1.0
    points = [(x, y, -1.0) for x in grid for y in grid]
    lamp = lumen("lamp", (0, 0, 0), 1000.0)
    made = bench.measure([matt("paint", 0.5), cube, lamp], points, [UP] * 16, 1.0)
    first = bench.measure([matt("paint", 0.5), cube, lamp], points, [UP] * 16, 1.0, reflections=0)
    # Direct light is exact; the mean of all is that of the enclosure but for the coarse grid.
    expected = [1000.0 / (4.0 * np.pi * (1.0 + x * x + y * y) ** 1.5) for x, y, _ in points]
    assert first.values == pytest.approx(expected, rel=1e-3)
    assert (made.values - first.values).mean() == pytest.approx(1000.0 / 24.0, rel=0.03)


@pytest.mark.parametrize("kind", ["glass", "data sheet"])
def test_pane_takes_its_share(bench, kind):
    degrees = np.linspace(0.0, 90.0, 181)
    transmittance, reflectance = slab(np.cos(np.radians(degrees)), 1.52, 0.9)
    if kind == "glass":
        surface = ThinGlass(1.52, Constant(0.9))
    else:
        surface = TabulatedPane(degrees, transmittance, reflectance)
    sky = CieSky(5, np.array([0.0, 0.0, 1.0]), 1000.0)
    made = bench.measure([*room(), sky, *pane(surface)], [(0.5, 0.0, 0.0)], [UP], 1.0)
    # E = integral of L T(theta) cos^2(theta) / d^2 over the opening, by midpoints.
    grid = ((np.arange(100) + 0.5) / 100.0 - 0.5) * OPENING
    x, y = np.meshgrid(grid - 0.5, grid)
    square = x**2 + y**2 + HEIGHT**2
    cosine = HEIGHT / np.sqrt(square)
    share = slab(cosine, 1.52, 0.9)[0] * cosine**2 / square
    expected = 1000.0 / np.pi * share.mean() * OPENING**2
    assert made.values[0] == pytest.approx(expected, abs=4.0 * made.errors[0] + 1e-3 * expected)
    assert made.errors[0] < 0.01 * expected


def test_what_a_peer_lacks_is_said(bench):
    lamp = candela("lamp", (0, 0, 3), 1000.0)
    with pytest.raises(CannotStateError, match="spherical"):
        bench.measure([lamp], [ORIGIN], [UP], 1.0, kind=SensorKind.SPHERICAL)
    with pytest.raises(CannotStateError, match="spectra"):
        bench.measure([lamp], [ORIGIN], [UP], 1.0, colour=True)
    with pytest.raises(CannotStateError, match="reflections"):
        bench.measure([lamp], [ORIGIN], [UP], 1.0, reflections=2)
    red = Diffuse(Tabulated(np.array([400.0, 700.0]), np.array([0.1, 0.9])))
    with pytest.raises(CannotStateError, match="spectra of surfaces"):
        bench.measure([lamp, *pane(red)], [ORIGIN], [UP], 1.0)


def test_radiance_refuses_type_a(radiance):
    file = read_luminaire(FOLDER / "ies" / "C04_typeA.ies")
    output = Output(Quantity.LUMINOUS_FLUX, 1000.0)
    lamp = Luminaire("lamp", "lamp", output, np.eye(4), file.distribution)
    with pytest.raises(CannotStateError, match="type A"):
        radiance.measure([lamp], [(0, 0, -3)], [UP], 1.0)


def test_a_peer_that_takes_too_long_is_told_of_without_its_command(radiance, monkeypatch):
    """Reports are published: what `subprocess` says is the whole command, with the machine's paths."""
    monkeypatch.setattr("lumenray.validation.peers.radiance.PATIENCE", 1e-9)
    with pytest.raises(CannotStateError) as told:
        radiance.measure([candela("lamp", (0, 0, 3), 1000.0)], [ORIGIN], [UP], 1.0)
    assert str(told.value).endswith("takes longer than 1e-09 s")


def test_overcast_sky_has_the_luminance_of_its_zenith():
    sky = CieSky(16, np.array([0.0, 0.0, 1.0]), 7.0 * np.pi / 9.0)
    assert luminance_scale(sky) == pytest.approx(1.0, rel=1e-5)
    low = relative_luminance(sky, np.array([1.0, 0.0, 0.0]))
    assert low == pytest.approx(1.0 / 3.0)


def test_triangles_of_a_quad_are_one_face():
    faces = sort_items([BLACK, quad("q", ORIGIN, (2, 0, 0), (0, 3, 0), "black")]).parts[0].faces()
    assert [len(face.corners) for face in faces] == [4]
    assert faces[0].area == pytest.approx(6.0)
    assert faces[0].normal == pytest.approx(UP)
    bent = mesh("m", [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]], [[0, 1, 2], [0, 2, 3]], "black")
    faces = sort_items([BLACK, bent]).parts[0].faces()
    assert [len(face.corners) for face in faces] == [3, 3]
