"""Rays that are aimed: how bins are drawn, what density is stated, and that nothing but the scatter changes."""

import numpy as np
import pytest
from baking_rooms import furnished_room, lamp
from scipy import stats
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import Cancelled
from lumenray.engine.scene.material import Emission
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.session import Session

pytestmark = pytest.mark.mitsuba

SAMPLES = 1 << 18


@pytest.fixture(autouse=True)
def kernels():
    from lumenray.engine.transport import backend

    backend.start(spectral=False)


def densities_of(squares):
    from lumenray.engine.transport.lux_maps.path_guiding import find_densities

    return find_densities(np.asarray(squares, dtype=float))


def two_tiles():
    """Densities of a tile with a bright spot and of one of chance."""
    spot = np.full(256, 1e-4)
    spot[[40, 41, 56]] = 25.0
    return densities_of([spot, np.random.default_rng(3).exponential(size=256) ** 4])


def aims_of(densities, tile):
    import mitsuba as mi

    from lumenray.engine.transport.lux_maps.path_guiding import Aims

    return Aims(densities).of_tile(mi.UInt32(tile))


def test_densities_keep_a_share_for_all_bins_and_rise_with_the_root():
    squares = np.zeros((3, 256))
    squares[1, 100] = 1.0
    squares[2, 100], squares[2, 200] = 16.0, 1.0
    made = densities_of(squares).astype(float)
    np.testing.assert_allclose(made.mean(axis=1), 1.0, rtol=2e-3)
    # Where nothing was found rays go everywhere alike.
    np.testing.assert_array_equal(made[0], 1.0)
    assert made.min() == pytest.approx(0.3, rel=1e-3)
    assert (made[2, 100] - 0.3) / (made[2, 200] - 0.3) == pytest.approx(4.0, rel=0.01)
    assert made[1].argmax() == 100
    assert made[1, 101] > made[1, 102]


@pytest.mark.parametrize("tile", [0, 1])
def test_bins_are_drawn_as_often_as_their_densities_say(tile):
    import mitsuba as mi

    densities = two_tiles()
    rng = np.random.default_rng(5)
    x, y = rng.random((2, SAMPLES), dtype=np.float32)
    place, factor = aims_of(densities, tile).warp(mi.Point2f(x, y))
    u, v = np.array(place.x), np.array(place.y)
    assert ((u >= 0.0) & (u < 1.0) & (v >= 0.0) & (v < 1.0)).all()
    number = (u * 16).astype(int) * 16 + (v * 16).astype(int)
    own = densities[tile].astype(float)
    own /= own.mean()
    np.testing.assert_allclose(np.array(factor), own[number], rtol=1e-5)
    found = np.bincount(number, minlength=256)
    assert stats.chisquare(found, own / own.sum() * SAMPLES).pvalue > 1e-4
    # Evenly within a bin, too.
    inside = (u * 16 % 1.0)[number == own.argmax()]
    assert stats.kstest(inside, "uniform").pvalue > 1e-4


def test_the_density_of_directions_is_that_with_which_they_are_drawn():
    import drjit as dr
    import mitsuba as mi

    aim = aims_of(two_tiles(), 1)
    rng = np.random.default_rng(6)
    local, density = aim.sample(mi.Point2f(*rng.random((2, SAMPLES), dtype=np.float32)))
    stated = np.array(aim.density(local))
    # At the borders of bins rounding may find the neighbour.
    agree = np.isclose(stated, np.array(density), rtol=1e-4)
    assert agree.mean() > 0.999
    even = mi.warp.square_to_uniform_hemisphere(
        mi.Point2f(*rng.random((2, SAMPLES), dtype=np.float32))
    )
    whole = np.array(aim.density(even)) * 2.0 * np.pi
    assert whole.mean() == pytest.approx(1.0, abs=5.0 * whole.std() / np.sqrt(SAMPLES))
    assert not np.any(np.array(aim.density(mi.Vector3f(even.x, even.y, -even.z)))[1:])
    dr.sync_thread()


def bake_aimed(session, is_aimed, seed):
    from lumenray.engine.transport.lux_maps.job import Options

    order = BakeOrder(
        ("room", "block"), StopRule(samples=192), density=12.0, seed=seed, method="cells"
    )
    return session.bake_objects(order, options=Options(aimed=is_aimed))


@pytest.mark.slow
def test_aimed_rays_find_the_same_light_with_less_scatter():
    # The lamp faces the ceiling, so that a bright patch there lights the room.
    glow = paint(0.1, name="glow", emission=Emission(Constant(1.0), 5000.0))
    uplight = quad("uplight", (0.5, 0.6, 1.4), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), "glow")
    session = session_of(*furnished_room(), paint(0.7), glow, uplight)
    plain, aimed = (bake_aimed(session, is_aimed, 3) for is_aimed in (False, True))
    for left, right in zip(plain.maps, aimed.maps, strict=True):
        gap = (left.mean - left.bias) - (right.mean - right.bias)
        errors = (
            left.mean_standard_error,
            right.mean_standard_error,
            left.bias_error,
            right.bias_error,
        )
        assert abs(gap) < 4.5 * np.sqrt(sum(error**2 for error in errors))
    assert aimed.relative_standard_error < 0.95 * plain.relative_standard_error


@pytest.mark.slow
def test_a_bake_with_aimed_rays_that_is_cancelled_goes_on_to_the_same_map(tmp_path, monkeypatch):
    from lumenray.engine.transport.lux_maps import lumel_places, pilot

    monkeypatch.setattr(lumel_places, "SPAN_PLACES", 1 << 12)
    monkeypatch.setattr(pilot, "LEARNING", 1.0)
    # Whatever the trials say.
    monkeypatch.setattr(
        pilot.Pilot, "_try_ways", lambda _self, _levels, guide, aims: -len(aims) - (guide is None)
    )
    used = []
    real = lumel_places.Aims
    monkeypatch.setattr(lumel_places, "Aims", lambda table: used.append(len(table)) or real(table))

    def run(checkpoint=None, last=None):
        turns = [0]

        def turn():
            turns[0] += 1
            if turns[0] == last:
                session.cancel()

        session = Session(turn)
        session.apply(SceneDelta(changed=(*furnished_room(), paint(0.7), lamp((0.6, 0.7, 1.5)))))
        order = BakeOrder(
            ("room", "block"),
            StopRule(samples=64),
            density=6.0,
            seed=1,
            method="cells",
            checkpoint=checkpoint,
        )
        return session.bake_objects(order), turns[0]

    path = tmp_path / "state"
    whole, turns = run()
    with pytest.raises(Cancelled):
        run(str(path), int(0.93 * turns))
    assert path.exists()
    used.clear()
    again, more = run(str(path))
    assert used and more < turns
    for one, other in zip(whole.pages, again.pages, strict=True):
        np.testing.assert_array_equal(one.illuminance, other.illuminance)
        np.testing.assert_array_equal(one.standard_error, other.standard_error)
