"""Light that a mirror ball throws on a floor beside it, by the closed form of an exact sphere, and how places know of it."""

import numpy as np
import pytest
from glass_scenes import BLACK, CANDELA, MIRROR, ball, slab
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import PointLight

RADIUS, CENTRE, LAMP = 0.1, 0.13, 0.7
"""Of the ball, and heights of its middle and of the lamp above the floor. [m]"""

INTENSITY, REFLECTANCE = 100.0, 0.9

PLACES = np.linspace(0.16, 0.5, 60)
"""Distances from the axis, outside the ball's shadow. [m]"""


def illuminance_beside_a_ball(distances):
    """Of a point straight above, and of what the ball reflects. (n,) [m -> lx]"""
    rim = np.arcsin(RADIUS / (LAMP - CENTRE))
    theta = np.linspace(1e-4, rim * (1.0 - 1e-7), 400_001)
    incident = np.arcsin((LAMP - CENTRE) * np.sin(theta) / RADIUS)
    # From straight up: where the ray meets the ball, and where it goes then.
    meets, leaves = incident - theta, 2.0 * incident - theta
    height = CENTRE + RADIUS * np.cos(meets)
    down = leaves > 0.5 * np.pi + 1e-3
    lands = RADIUS * np.sin(meets[down]) + height[down] * np.tan(np.pi - leaves[down])
    theta = theta[down]
    amount = INTENSITY * REFLECTANCE * np.sin(theta) / np.abs(np.gradient(lands, theta)) / lands
    order = np.argsort(lands)
    straight = INTENSITY * LAMP / (LAMP**2 + distances**2) ** 1.5
    return straight + np.interp(distances, lands[order], amount[order])


@pytest.mark.mitsuba
def test_light_of_a_mirror_ball_is_found_beside_it_with_few_samples():
    """A lamp of 2 cm: its image in the ball fills 1e-5 of what a sensor sees."""
    lamp = PointLight("lamp", "lamp", CANDELA, np.array([0.0, 0.0, LAMP]), 0.01)
    floor = slab((-0.8, -0.8, -0.1), (0.8, 0.8, 0.0), "black", "floor")
    items = (BLACK, MIRROR, ball("ball", RADIUS, (0, 0, CENTRE), "mirror", 192), lamp, floor)
    turns = 0.3 + np.arange(len(PLACES))
    places = np.stack([PLACES * np.cos(turns), PLACES * np.sin(turns), 0.0 * PLACES], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
    made = session_of(*items).measure(places, up, StopRule(samples=256), 1)
    expected = illuminance_beside_a_ball(PLACES)
    error = np.linalg.norm(made.standard_error) / np.linalg.norm(expected)
    assert error < 0.03
    # Facets of the ball turn the light of single places by some per cent.
    assert made.illuminance.mean() == pytest.approx(expected.mean(), rel=0.01)
    assert np.abs(made.illuminance - expected).max() < 0.1 * expected.max()


@pytest.fixture(scope="module")
def cones():
    """Cones of one part: a narrow bundle with nine tenths of the light, a wide one, and a line of another light."""
    from lumenray.engine.transport.light_tracing.known_places import CONES, _make_cones

    rng = np.random.default_rng(1)
    direction = np.array([0.0, 0.0, -1.0]) + 0.001 * rng.normal(size=(60, 3))
    direction[50:] += 0.4 * rng.normal(size=(10, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    light = np.zeros(60, dtype=np.int64)
    light[-1] = 1
    flux = np.where(np.arange(60) < 50, 1.0, 0.5)
    # All seem to come from one place, about.
    start, way = np.array([0.0, 0.0, 5.0]) + 0.01 * rng.normal(size=(60, 3)), np.full(60, 5.0)
    lines = {"direction": direction, "start": start, "way": way, "light": light, "flux": flux}
    return lines, _make_cones(lines, [np.arange(60)]).reshape(CONES, -1)


def test_cones_hold_all_lines_of_their_light(cones):
    from lumenray.engine.transport.light_tracing.known_places import DIRECTIONS

    lines, rows = cones
    rows = rows[-DIRECTIONS:]
    height = 1.0 + lines["direction"] @ rows[:, :3].T
    inside = (height <= rows[:, 4] * 1.0001) & (lines["light"][:, None] == rows[:, 3])
    assert inside.any(axis=1).all()
    # And no more than they need: the wide ones have no share of the narrow one's light.
    narrow = inside[:50].any(axis=0)
    assert rows[narrow, 5].sum() > 0.75 * rows[:, 5].sum()


def test_cones_about_places_hold_what_seems_to_be_there(cones):
    """Seen from where they land, lines from about one place are in the cone about it, though their directions differ."""
    from lumenray.engine.transport.light_tracing.known_places import IMAGES

    lines, rows = cones
    rows = rows[:IMAGES][rows[:IMAGES, 3] == 0.0]
    main = rows[rows[:, 5].argmax()]
    assert main[8] == 1.0
    np.testing.assert_allclose(main[:3], [0.0, 0.0, 5.0], atol=0.1)
    landed = lines["start"] + 5.0 * lines["direction"]
    axis = main[:3] - landed
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    height = 1.0 + (axis * lines["direction"]).sum(axis=1)
    assert (height <= main[4]).sum() >= 50


def test_cones_are_drawn_by_their_shares(cones):
    """Walker's tables give back the shares that they were made of."""
    _, rows = cones
    chance = np.zeros(len(rows))
    for number, (threshold, other) in enumerate(rows[:, 6:8]):
        chance[number] += threshold / len(rows)
        chance[int(other)] += (1.0 - threshold) / len(rows)
    assert rows[:, 5].sum() == pytest.approx(1.0)
    np.testing.assert_allclose(chance, rows[:, 5], atol=1e-12)


def test_places_in_one_plane_are_parted_along_it():
    """Most light lands on a floor: the median of its height is the floor's own, which parts nothing."""
    from lumenray.engine.transport.light_tracing.known_places import FEWEST, _part

    rng = np.random.default_rng(2)
    where = rng.uniform(-1.0, 1.0, (4000, 3))
    where[:3000, 2] = -5.0
    _, parts = _part(where)
    assert sorted(np.concatenate(parts)) == list(range(4000))
    sizes = np.array([len(part) for part in parts])
    assert sizes.min() >= FEWEST
    assert sizes.max() < 4 * FEWEST


@pytest.mark.mitsuba
def test_density_is_that_of_what_is_drawn(cones):
    """Directions drawn from the cones of a part, counted in bins, against their density."""
    import drjit as dr
    import mitsuba as mi
    from scipy.stats import chi2

    from lumenray.engine.arrays import upload
    from lumenray.engine.transport.light_tracing.known_places import SHARES, Directions, KnownPlaces
    from lumenray.engine.transport.paths.sampler import random_stream

    _, rows = cones
    places = object.__new__(KnownPlaces)
    places.rows = upload(mi.Float, rows.astype(np.float32))
    places.bent = type("Bent", (), {"aim_of": staticmethod(lambda light: light)})
    count, cosines, turns = 1 << 18, 24, 8
    stream = random_stream(dr.arange(mi.UInt32, count), mi.UInt32(7))
    known = Directions(places, mi.UInt32(0), mi.Point3f(0.0, 0.0, 0.0))
    # What the aims would give lies beyond all bins.
    nowhere = mi.UInt32(2), mi.Vector3f(0.0, 0.0, -1.0)
    light, drawn = known.draw(stream, *nowhere)
    own = np.array(light) == 0
    drawn = np.stack([np.array(drawn[k]) for k in range(3)], axis=1)[own]
    # By the sine, as cosines of small angles have no digits left.
    edges = np.geomspace(1e-4, 1.0, cosines + 1)
    band = np.searchsorted(edges, np.hypot(drawn[:, 0], drawn[:, 1])) - 1
    turn = ((np.arctan2(drawn[:, 1], drawn[:, 0]) / (2.0 * np.pi)) % 1.0 * turns).astype(int)
    kept = (band >= 0) & (band < cosines) & (drawn[:, 2] > 0.0)
    seen = np.bincount(
        band[kept] * turns + np.minimum(turn[kept], turns - 1), minlength=cosines * turns
    )
    # The density in many places of every bin.
    rng, inner = np.random.default_rng(3), 4000
    u, v = rng.random((2, cosines * turns, inner))
    low, high = (np.repeat(each, turns)[:, None] for each in (edges[:-1], edges[1:]))
    sine = np.sqrt(low**2 + (high**2 - low**2) * u)
    phi = 2.0 * np.pi * (np.tile(np.arange(turns), cosines)[:, None] + v) / turns
    rise = np.sqrt(1.0 - sine**2)
    where = mi.Vector3f(*(each.ravel() for each in (sine * np.cos(phi), sine * np.sin(phi), rise)))
    density = np.array(known.density(mi.Float(0.0), mi.UInt32(0), where)).reshape(sine.shape)
    # Places of a bin are even over its shadow, so that they count by 1 / cos.
    density, solid = density / rise, (high**2 - low**2)[:, 0] * np.pi / turns
    expected = density.mean(axis=1) * solid * count
    doubt = density.std(axis=1) / np.sqrt(inner) * solid * count
    counts = expected > 20.0
    square = ((seen - expected) ** 2 / (expected + doubt**2))[counts].sum()
    assert square < chi2.ppf(0.999, counts.sum())
    assert 0.5 < expected[counts].sum() / count < sum(SHARES)
