"""How reflected light is found: left to jobs, or as the user wants it."""

import numpy as np
import pytest
from small_scenes import box, paint, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.material import Glossy, Material
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Constant


def wish(switch):
    return Modelling((("estimator", switch),))


def plan_of(*items):
    scene = Scene()
    scene.apply(SceneDelta(changed=(box(2, 2, 2), *items)))
    plan = make_plan(scene)
    return plan, next(each for each in plan.decisions if each.name == "estimator")


def test_jobs_choose_where_nobody_else_does():
    plan, decision = plan_of(paint(0.5))
    assert (plan.method, decision.bound, decision.saving) == ("auto", 0.0, 0.0)
    assert [plan.method_of(own) for own in ("auto", "paths", "cells")] == ["auto", "paths", "cells"]


def test_a_switch_says_how_and_a_job_that_is_told_itself_has_the_last_word():
    off, forced = (
        plan_of(paint(0.5), wish(Switch.OFF))[0],
        plan_of(paint(0.5), wish(Switch.FORCE))[0],
    )
    assert (off.method_of("auto"), off.method_of("cells")) == ("paths", "cells")
    assert (forced.method_of("auto"), forced.method_of("paths")) == ("cells", "paths")


def test_where_nothing_is_matt_there_are_no_cells_even_if_they_are_forced():
    metal = Material("paint", "paint", Glossy(Constant(0.8), 0.3))
    plan, decision = plan_of(metal, wish(Switch.FORCE))
    assert (plan.method, decision.choice, decision.saving) == ("auto", "full paths", 0.0)


@pytest.mark.mitsuba
def test_sensors_go_by_the_switch():
    output = Output(Quantity.LUMINOUS_FLUX, 1000.0)
    lamp = PointLight("lamp", "lamp", output, np.array([1.0, 1.0, 1.0]))
    session = session_of(box(2, 2, 2), paint(0.5), lamp, wish(Switch.OFF))
    made = session.measure([[1.0, 1.0, 0.1]], [[0.0, 0.0, 1.0]], StopRule(samples=16))
    assert "full paths are asked for" in made.provenance.decisions
