"""Errors of illuminances hold what ray files leave open of the light that comes straight from their lamps."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake
from ray_lamps import BLACK, exact_disk, floor, lamp_at, lumels_of
from small_scenes import box, paint, quad, session_of

from lumenray.benchmarks.common.ray_sources import helix
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.plan import DECISIONS
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.sensor import SensorColour, SensorKind
from lumenray.engine.transport.sensors.file_errors import find_file_errors

pytestmark = pytest.mark.mitsuba

CENTRE = np.array([0.0, 0.0, 1.0])
PLACES = np.array([[0.0, 0.0, 0.0], [0.5, 0.2, 0.0], [-1.0, 0.7, 0.0], [0.1, 0.0, 0.8]])
"""Under the lamp, beside it, and nearer than five of its sizes."""

UP = np.tile([0.0, 0.0, 1.0], (len(PLACES), 1))
MUCH = np.full(len(PLACES), 1e9)


def known_within(lamp, error):
    return replace(lamp, rays=replace(lamp.rays, information_error=error))


LAMP = known_within(lamp_at(CENTRE), 0.03)


def errors_of(*items, found=MUCH, bends=False, places=PLACES, facing=UP, kind=SensorKind.PLANAR):
    scene = session_of(BLACK, floor(4.0), *items)._prepare("auto", False)
    return find_file_errors(scene, places, facing, kind, found, bends)


def test_the_error_is_a_share_of_the_light_that_comes_straight():
    found = errors_of(LAMP)
    exact = 0.03 * exact_disk(PLACES, CENTRE)
    # The distribution is that of few rays itself.
    np.testing.assert_allclose(found[:3], exact[:3], rtol=0.1)
    # Near by it is no less, and by no orders more.
    assert exact[3] < found[3] < 5.0 * exact[3]
    assert (errors_of(known_within(LAMP, 0.0)) == 0.0).all()
    assert (
        errors_of(PointLight("p", "p", Output(Quantity.LUMINOUS_FLUX, 9.0), CENTRE)) == 0.0
    ).all()


def test_it_is_never_more_than_if_all_light_were_the_lamps():
    """As in a shadow, where nothing but what others reflect arrives."""
    dim = np.array([1e-3, 1e9, 0.0, 1e-3])
    found = errors_of(LAMP, found=dim)
    np.testing.assert_allclose(found[[0, 2, 3]], 0.03 * dim[[0, 2, 3]])
    assert found[1] == errors_of(LAMP)[1]
    # Light over mirrors and glass may come from anywhere.
    lux = np.full(len(PLACES), 40.0)
    np.testing.assert_allclose(errors_of(LAMP, found=lux, bends=True), 0.03 * lux)
    from glass_scenes import MIRROR

    mirror = quad("mirror", (2.0, -2, 0), (0, 0, 3.0), (0, 4.0, 0), "mirror")
    np.testing.assert_allclose(errors_of(LAMP, MIRROR, mirror, found=lux), 0.03 * lux)


def test_lamps_of_one_set_add_up_and_those_of_others_as_squares():
    twin = replace(LAMP, id="twin", name="twin")
    other = replace(known_within(lamp_at(CENTRE, helix), 0.02), id="other", name="other")
    one, both = errors_of(LAMP), errors_of(LAMP, twin)
    np.testing.assert_allclose(both, 2.0 * one, rtol=1e-9)
    np.testing.assert_allclose(errors_of(LAMP, other), np.hypot(one, errors_of(other)), rtol=1e-9)
    off = replace(LAMP, output=replace(LAMP.output, value=0.0))
    assert (errors_of(off) == 0.0).all()


@pytest.mark.parametrize(
    ("kind", "share"),
    [
        (SensorKind.SPHERICAL, 0.25),
        (SensorKind.CYLINDRICAL, 0.0),
        (SensorKind.SEMICYLINDRICAL, 0.0),
    ],
)
def test_kinds_respond_by_direction(kind, share):
    """Straight below a lamp a ball gets a quarter of what a plane does, and an upright cylinder nothing."""
    facing = np.tile([1.0, 0.0, 0.0], (len(PLACES), 1))
    found, plane = errors_of(LAMP, facing=facing, kind=kind), errors_of(LAMP)
    assert found[0] == pytest.approx(share * plane[0], abs=1e-9 * plane[0])
    if kind is SensorKind.CYLINDRICAL:
        # The angle to the vertical is the same for all directions about it.
        cosine = 1.0 / np.sqrt(1.0 + 0.29)
        expected = plane[1] / cosine * np.sqrt(1.0 - cosine**2) / np.pi
        assert found[1] == pytest.approx(expected, rel=1e-6)
    if kind is SensorKind.SEMICYLINDRICAL:
        # It faces +x, and this place has the lamp behind it.
        assert found[1] < found[2]


def test_readings_and_maps_state_it():
    """Many samples leave nothing but what the file does; a note says so and what helps."""
    items = (paint(0.5), floor(2.0, material="paint"), LAMP)
    places = np.array([[0.0, 0.0, 0.0], [0.5, 0.2, 0.0]])
    exact = 0.03 * exact_disk(places, CENTRE)
    made = session_of(*items).measure(places, UP[:2], StopRule(samples=1 << 12))
    np.testing.assert_allclose(made.floors, exact, rtol=0.1)
    assert (made.standard_error >= made.floors).all()
    assert any("files of more rays do" in note for note in made.provenance.notes)
    assert any("errors of sensors and lux maps hold" in note for note in made.provenance.notes)
    assert made.has_common_errors
    # Also where nothing is simplified, and full paths are followed.
    full = Modelling(tuple((name, Switch.OFF) for name in DECISIONS))
    plain = session_of(*items, full).measure(places, UP[:2], StopRule(samples=256))
    assert plain.has_common_errors and (plain.floors > 0.0).all()
    result = bake(items, ("floor",), 256, density=10.0, margin=1)
    values, at = lumels_of(result, items[1])
    assert (values.standard_error > 0.85 * 0.03 * exact_disk(at, CENTRE)).all()
    # What is alike on neighbouring lumels does not cancel in the mean.
    (whole,) = result.maps
    assert whole.mean_standard_error > 0.02 * whole.mean


def test_samples_make_up_for_it_where_light_is_uneven():
    """Sensors near the lamp count by the square of their light: all of them together lack twice the file's share."""
    items = (paint(0.8), box(4.0, 4.0, 3.0), known_within(lamp_at((2.0, 2.0, 2.0)), 0.003))
    near, far = (np.linspace(2.0 - away, 2.0 + away, n) for away, n in ((0.1, 12), (1.7, 40)))
    places = np.array(
        [
            *([x, y, 1.3] for x in near for y in near),
            *([x, y, 0.01] for x in far for y in far),
        ]
    )
    facing = np.tile([0.0, 0.0, 1.0], (len(places), 1))
    for kind in (SensorColour.NONE, SensorColour.TRISTIMULUS):
        made = session_of(*items).measure(places, facing, StopRule(error=0.01), colour=kind)
        mean = made.illuminance.mean()
        assert np.sqrt((made.floors**2).mean()) > 0.005 * mean
        stated = np.sqrt((made.standard_error**2).mean()) / mean
        assert 0.009 < stated <= 0.0102


@pytest.mark.parametrize(
    ("item", "share"),
    [("mirror ball", 1.0), ("glass ball", 1.0), ("mirror wall", 1.0), (None, 0.0)],
)
def test_maps_know_what_sends_light_of_lamps_on(item, share):
    """A sheet that faces away from the lamp gets its light from mirrors and glass alone, so all of it counts."""
    from glass_scenes import GLASS, MIRROR, ball

    material = {"mirror": MIRROR, "glass": GLASS}[item.split()[0]] if item else None
    bodies = []
    if item:
        wall = quad("wall", (2.0, -2, 0), (0, 4.0, 0), (0, 0, 3.0), "mirror")
        bodies = [
            wall if "wall" in item else ball("ball", 0.2, (0.5, 0.0, 0.5), material.id, rings=12)
        ]
    # Seen from below, its front is turned away.
    sheet = quad("sheet", (-0.5, -0.5, 0.4), (0, 1.0, 0), (1.0, 0, 0), "paint")
    white = quad("white", (-1, -1, 0.0), (2.0, 0, 0), (0, 2.0, 0), "paint")
    items = (paint(0.5), sheet, white, *([material] if item else []), *bodies)
    # The same seed, so that what the lamp's own error adds is all that differs.
    pages = []
    for lamp in (LAMP, known_within(LAMP, 0.0)):
        result = bake((*items, lamp), ("sheet",), 64, density=6.0, margin=1, witness=False)
        pages.append(result.lumels(result.maps[0].number))
    page, exact = pages
    known = page.illuminance > 0.0
    np.testing.assert_array_equal(page.illuminance, exact.illuminance)
    added = np.sqrt((page.standard_error**2 - exact.standard_error**2)[known])
    np.testing.assert_allclose(added / page.illuminance[known], 0.03 * share, atol=3e-4)


def test_the_stated_error_holds_the_true_one_near_a_disk():
    """By the file's own error, of four files of one source: nine tenths of the sensors are within two errors."""
    from ray_lamps import rays_of

    grid = np.array([[x, y, 0.0] for x in (-0.2, 0.0, 0.2) for y in (-0.2, 0.0, 0.2)])
    centre = np.array([0.0, 0.0, 0.3])
    within = []
    for seed in range(4):
        lamp = lamp_of(rays_of, seed, centre)
        made = session_of(BLACK, floor(1.0), lamp).measure(
            grid, np.tile([0.0, 0.0, 1.0], (9, 1)), StopRule(error=0.005)
        )
        within.append(
            np.abs(made.illuminance - exact_disk(grid, centre)) < 2.0 * made.standard_error
        )
    assert np.mean(within) >= 0.9


def lamp_of(rays_of, seed, centre):
    """The lamp of a file of 4000 rays, made ready as a file is."""
    import tempfile
    from pathlib import Path

    from ray_files import zemax
    from ray_lamps import FLUX

    from lumenray.benchmarks.common.ray_sources import disk
    from lumenray.engine.raysets.emission import prepare_light
    from lumenray.engine.scene.light import Luminaire

    rays = rays_of(disk, 4000, seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "lamp.dat"
        path.write_bytes(zemax(np.column_stack([1e3 * rays.position, rays.direction, rays.weight])))
        made = prepare_light(path)
    frame = np.eye(4)
    frame[:3, 3] = centre
    output = Output(Quantity.LUMINOUS_FLUX, FLUX)
    return Luminaire("led", "led", output, frame, made.distribution, rays=made.emission)
