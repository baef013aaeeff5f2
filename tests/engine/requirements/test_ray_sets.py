"""From where on ray sets are points: within the budget, nowhere where a point is not known to be right enough."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import paint, quad

from lumenray.engine.requirements.decision import Asked, boxes_of
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.requirements.ray_sets import find_limit
from lumenray.engine.scene.distribution import IntensityDistribution
from lumenray.engine.scene.light import Luminaire, Output, Quantity
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.ray_emission import (
    EVERYWHERE,
    GROUP,
    PLANE,
    DirectionWeight,
    RayBody,
    RayEmission,
)
from lumenray.engine.scene.scene import Scene, SceneDelta

FAR = np.array([1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0])
DOWN, ZERO = np.array([0.0, 0.0, -1.0]), np.zeros(3)


def emission(errors, size=0.1, fluctuation=0.3):
    """A few rays of a source of a size, with the errors of a point at distances of so many sizes."""
    body = RayBody(PLANE, ZERO, DOWN, True, 0.0, np.zeros((0, 5), np.float32))
    return RayEmission(
        np.zeros((GROUP, 3), np.float32),
        np.tile(DOWN, (GROUP, 1)).astype(np.float32),
        fluctuation * np.eye(6, dtype=np.float32)[None],
        np.ones(GROUP, np.float32),
        np.zeros(GROUP, np.uint32),
        None,
        body,
        None,
        DirectionWeight.even(),
        size,
        np.full(3, 0.5 * size),
        5.0 * size,
        0.03,
        size * FAR,
        np.asarray(errors, float),
    )


SHARP = emission(0.2499 / FAR**2)
"""A point is wrong by 1 % at five sizes, and by less than 0.33 % from nearly nine sizes on."""


def lamp(rays, name="lamp"):
    angles = np.array([0.0, np.pi / 2.0])
    shape = IntensityDistribution(np.array([0.0]), angles, np.array([[1.0, 0.0]]))
    output = Output(Quantity.LUMINOUS_FLUX, 100.0)
    return Luminaire(name, name, output, np.eye(4), shape, rays=rays)


def plan_of(asked, *items, switch=Switch.AUTO):
    scene = Scene()
    scene.apply(SceneDelta(changed=(*items, Modelling((("ray sets", switch),)))))
    plan = make_plan(scene, asked)
    return plan, next(each for each in plan.decisions if each.name == "ray sets")


def test_a_smaller_error_needs_rays_farther_out():
    found = [find_limit(SHARP, most) for most in (0.02, 0.01, 0.0025, 0.0001, 1e-6, 0.0)]
    assert found[0] == found[1] == SHARP.near
    assert found[2] == pytest.approx(0.1 * 10.0, rel=0.03)
    assert found[3] == pytest.approx(0.1 * 50.0, rel=0.03)
    assert found[4:] == [EVERYWHERE, EVERYWHERE]


def test_the_bound_fits_into_the_budget():
    for error in (0.03, 0.01, 0.001):
        plan, decision = plan_of(Asked(error, False), lamp(SHARP))
        assert 0.0 < decision.bound <= plan.allowed
        near = plan.changes.get("lamp", lamp(SHARP)).rays.near
        assert SHARP.point_errors(near) <= decision.bound
    exact, decision = plan_of(Asked(1e-6, False), lamp(SHARP))
    assert (decision.bound, decision.choice) == (0.0, "rays everywhere")
    assert exact.changes["lamp"].rays.near == EVERYWHERE


def test_without_an_asked_error_what_the_set_puts_up_with_is_told():
    plan, decision = plan_of(Asked(), lamp(SHARP))
    assert (plan.changes, decision.bound) == ({}, pytest.approx(0.01, rel=1e-3))


def test_lux_maps_trace_what_the_budget_does_not_spare():
    plan, decision = plan_of(Asked(0.01, False, frozenset({"floor"})), lamp(SHARP))
    assert plan.changes["lamp"].rays.spared == pytest.approx(0.01 / 3.0)
    assert decision.bound <= plan.allowed
    off, decision = plan_of(Asked(0.01), lamp(SHARP), switch=Switch.OFF)
    assert (off.changes["lamp"].rays.spared, decision.bound) == (0.0, 0.0)


def test_what_lies_closer_than_the_source_is_large_is_no_place_for_a_point():
    """Forced points are made where how wrong they are is known, and nowhere else."""
    paper = (
        quad("floor", (-1.0, -1.0, -2.0), (2.0, 0, 0), (0, 2.0, 0), "paper"),
        paint(0.5, "paper"),
    )
    asked = Asked(0.01, False, places=boxes_of([[0.3, 0.0, -1.9]]))
    plan, decision = plan_of(asked, *paper, lamp(SHARP), switch=Switch.FORCE)
    assert plan.changes["lamp"].rays is None
    assert decision.bound == pytest.approx(0.25 / (np.hypot(0.3, 1.9) / 0.1) ** 2, rel=0.02)
    sheet = replace(paper[0], vertices=paper[0].vertices + np.array([0.0, 0.0, 1.95]))
    plan, decision = plan_of(asked, sheet, paper[1], lamp(SHARP), switch=Switch.FORCE)
    assert (decision.choice, "lamp" in plan.changes) == ("rays near, a point far", False)
    anywhere = replace(asked, places=None)
    assert (
        plan_of(anywhere, *paper, lamp(SHARP), switch=Switch.FORCE)[1].choice
        != "a point everywhere"
    )


def test_other_lights_and_rays_that_hardly_fluctuate_are_none_of_it():
    narrow = lamp(emission(0.25 / FAR**2, fluctuation=1e-4))
    for light in (narrow, replace(lamp(SHARP), rays=None)):
        plan, decision = plan_of(Asked(0.01), light)
        assert (plan.changes, decision.choice, decision.bound) == ({}, "none", 0.0)
