"""How many samples sensors get: by need where that saves many, alike where scatter is everywhere the same."""

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.decision import Asked
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import AreaLight, Output, PointLight, Quantity
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta

ALIKE = Modelling((("samples", Switch.OFF),))
UP = [0.0, 0.0, 1.0]


def decided(asked, *items):
    scene = Scene()
    scene.apply(SceneDelta(changed=(box(2, 2, 2), paint(0.5), *items)))
    plan = make_plan(scene, asked)
    return plan, next(each for each in plan.decisions if each.name == "samples")


def test_it_takes_an_asked_error_and_a_user_who_does_not_mind():
    plan, decision = decided(Asked(0.01))
    assert (plan.samples_evenly, decision.choice) == (False, "as many as each needs")
    assert decided(Asked())[1].choice == "as many for all"
    plan, decision = decided(Asked(0.01), ALIKE)
    assert (plan.samples_evenly, decision.choice) == (True, "as many for all")


def near_and_far():
    """Sensors on a floor under a panel: some at its edge, nearly all in its far penumbra, where there is little light."""
    frame = np.eye(4)
    frame[:3, 3] = 0.0, 0.0, 0.25
    panel = AreaLight("a", "a", Output(Quantity.LUMINOUS_FLUX, 2000.0), frame, 0.4, 0.4)
    screen = quad("screen", (-0.2, -0.2, 0.1), (0.4, 0, 0), (0, 0.2, 0), "paint")
    near = np.stack(np.meshgrid(np.linspace(-0.2, 0.2, 8), np.linspace(-0.1, 0.1, 8)), axis=-1)
    far = np.stack(np.meshgrid(np.linspace(2.0, 6.0, 24), np.linspace(-2.0, 2.0, 24)), axis=-1)
    places = np.concatenate([near.reshape(-1, 2), far.reshape(-1, 2)])
    return (paint(0.0), screen, panel), np.column_stack([places, np.zeros(len(places))])


@pytest.mark.mitsuba
def test_who_scatters_gets_more_and_all_are_right():
    items, places = near_and_far()
    normals, rule = np.tile(UP, (len(places), 1)), StopRule(error=0.002)
    by_need, alike = (
        session_of(*items, *more).measure(places, normals, rule, 5) for more in ((), (ALIKE,))
    )
    told = [note for note in by_need.provenance.notes if "as they need" in note]
    assert len(told) == 1
    assert not any("as they need" in note for note in alike.provenance.notes)
    assert by_need.provenance.samples < 0.5 * alike.provenance.samples
    for made in (by_need, alike):
        whole = np.sqrt((made.standard_error**2).mean()) / made.illuminance.mean()
        assert whole <= 0.002
    sure = session_of(*items, ALIKE).measure(places, normals, StopRule(error=0.0004), 77)
    apart = (by_need.illuminance - sure.illuminance) / np.hypot(
        by_need.standard_error, sure.standard_error
    )
    # Near ones scatter as is stated, and none is off by more than Student's t of 640 allows.
    assert np.sqrt((apart[:64] ** 2).mean()) < 1.4
    assert np.abs(apart).max() < 6.5


@pytest.mark.mitsuba
def test_rare_bright_samples_that_may_fall_anywhere_are_no_reason():
    """A small lamp just over the floor: what scatters most by chance would get the samples, and gain nothing."""
    lamp = PointLight(
        "l", "l", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([2.0, 2.0, 0.02]), 0.001
    )
    x, y = np.meshgrid(np.linspace(0.5, 3.5, 16), np.linspace(0.5, 3.5, 16))
    places = np.stack([x.ravel(), y.ravel(), np.full(256, 2.0)], axis=1)
    normals = np.tile([0.0, 0.0, -1.0], (256, 1))
    session = session_of(box(4, 4, 3), paint(0.6), lamp)
    made = session.measure(places, normals, StopRule(error=0.01), 1, method="paths")
    assert not any("as they need" in note for note in made.provenance.notes)


@pytest.mark.mitsuba
def test_the_same_seed_gives_the_same_samples():
    items, places = near_and_far()
    normals = np.tile(UP, (len(places), 1))
    first, second = (
        session_of(*items).measure(places, normals, StopRule(error=0.004), 9) for _ in range(2)
    )
    np.testing.assert_array_equal(first.illuminance, second.illuminance)
    assert first.provenance.samples == second.provenance.samples


@pytest.mark.mitsuba
def test_single_errors_are_met_without_more_samples_for_those_who_have_theirs():
    items, places = near_and_far()
    normals, rule = np.tile(UP, (len(places), 1)), StopRule(each=0.004, floor=1.0)
    by_need, alike = (
        session_of(*items, *more).measure(places, normals, rule, 5) for more in ((), (ALIKE,))
    )
    for made in (by_need, alike):
        assert (made.standard_error <= 0.004 * np.maximum(made.illuminance, 1.0)).all()
    assert by_need.provenance.samples < 0.7 * alike.provenance.samples
