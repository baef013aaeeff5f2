"""When roulette begins for paths of sensors: the share that pays, and the same light as ever."""

import numpy as np
import pytest
from small_scenes import box, paint, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.fading import (
    COST,
    FIRST,
    LEAST,
    SURE,
    find_saving,
    find_share,
    own_variance,
)
from lumenray.engine.scene.light import AreaLight, Output, Quantity
from lumenray.engine.scene.modelling import Modelling, Switch

EARLY = Modelling((("roulette", Switch.OFF),))


def simulated(reflectance, share, count=400_000):
    """Relative variance at a sensor in a room that glows evenly, of paths that play roulette below a share."""
    draw = np.random.default_rng(1)
    found, weight = np.full(count, 1.0 - reflectance), np.ones(count)
    for vertex in range(1, 3000):
        # What a surface sends on of the lamps' light, and what is left after it.
        weight = weight * reflectance
        found += weight * (1.0 - reflectance)
        if vertex >= 2:
            survival = np.minimum(weight / share, 1.0)
            goes_on = draw.random(count) < survival
            weight = np.where(goes_on, weight / np.maximum(survival, 1e-30), 0.0)
        if not weight.any():
            break
    assert found.mean() == pytest.approx(1.0, abs=5.0 * found.std() / np.sqrt(count))
    return found.var()


@pytest.mark.parametrize("reflectance", [0.5, 0.8, 0.9])
def test_the_variance_by_roulette_is_about_that_of_paths(reflectance):
    """In closed form rho^4 (1 + rho - rho^2) where all glows; lamps that face sensors leave less to reflections."""
    found = simulated(reflectance, 1.0)
    assert found == pytest.approx(reflectance**4 * (1.0 + reflectance - reflectance**2), rel=0.03)
    assert 0.35 * found < own_variance(reflectance) < found


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_late_roulette_is_as_much_quieter_as_the_square_of_its_share(share):
    assert simulated(0.9, share) / simulated(0.9, 1.0) == pytest.approx(share**2, rel=0.3)


@pytest.mark.parametrize("reflectance", [0.45, 0.6, 0.9])
@pytest.mark.parametrize("variance", [None, 0.01, 0.1, 2.0])
def test_the_share_makes_time_and_variance_multiply_to_the_least(reflectance, variance):
    share = find_share(reflectance, variance, 0.4)
    shares = np.geomspace(LEAST, 1.0, 4000)
    own = own_variance(reflectance)
    rest = FIRST if variance is None else max(variance - 0.16 * own, SURE * variance)
    worth = (rest + own * shares**2) * (COST - np.log(shares))
    assert share == pytest.approx(shares[worth.argmin()], rel=5e-3)


def test_where_nothing_is_reflected_or_all_is_noise_roulette_begins_at_once():
    assert find_share(0.0) == 1.0
    assert find_share(0.0, 0.5) == 1.0
    assert find_share(0.3, 5.0) == pytest.approx(1.0)


def test_what_is_saved_grows_with_what_surfaces_reflect():
    savings = [find_saving(reflectance) for reflectance in (0.0, 0.2, 0.5, 0.8, 0.9)]
    assert savings[0] == 0.0
    assert (np.diff(savings) >= 0.0).all()
    # Mean squares of errors times seconds, by hand, in rooms of one reflectance under panels: 2.8 and 8.8 times less.
    assert 0.2 < savings[2] < 1.0 - 1.0 / 2.8
    assert 0.7 < savings[3] < 1.0 - 1.0 / 8.8


def white_room(*more):
    """Closed box of 4 x 3 x 2.5 m, white all over, with a lamp at its ceiling."""
    frame = np.array([[1.0, 0, 0, 2.0], [0, 1, 0, 1.5], [0, 0, 1, 2.49], [0, 0, 0, 1]])
    lamp = AreaLight("a", "a", Output(Quantity.LUMINOUS_FLUX, 3000.0), frame, 1.0, 1.0)
    return session_of(box(4, 3, 2.5), paint(0.8), lamp, *more)


@pytest.mark.mitsuba
def test_late_roulette_finds_the_same_light_with_less_noise():
    x, y = np.meshgrid(np.linspace(0.5, 3.5, 8), np.linspace(0.5, 2.5, 8))
    places = np.stack([x.ravel(), y.ravel(), np.full(64, 0.8)], axis=1)
    rule, normals = StopRule(samples=1 << 12), np.tile([0.0, 0.0, 1.0], (64, 1))
    made = [
        white_room(*more).measure(places, normals, rule, 3, transport="mono")
        for more in ((), (EARLY,))
    ]
    late, early = ((m.illuminance, m.standard_error) for m in made)
    apart = (late[0] - early[0]) / np.hypot(late[1], early[1])
    # Sixteen groups: Student's t; the mean of all is the sharper test.
    assert np.abs(apart).max() < 5.0
    error = np.sqrt((late[1] ** 2).sum() + (early[1] ** 2).sum()) / 64
    assert abs(late[0].mean() - early[0].mean()) < 3.5 * error
    assert (late[1] ** 2).mean() < 0.5 * (early[1] ** 2).mean()
