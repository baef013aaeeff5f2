"""Which wavelengths paths carry: by lamps and eye, evenly where a user wants it, and the same light either way."""

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.decision import Asked
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.material import Diffuse, Material
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Illuminant, Rgb, Tabulated

EVENLY = Modelling((("wavelengths", Switch.OFF),))


def plan_of(*items, transport="auto", asked=None):
    scene = Scene()
    scene.apply(SceneDelta(changed=items))
    return make_plan(scene, asked, transport)


def decision_of(plan):
    return next(each for each in plan.decisions if each.name == "wavelengths")


def lamp(name, spectrum, place, intensity=100.0):
    output = Output(Quantity.LUMINOUS_INTENSITY, intensity, spectrum)
    return PointLight(name, name, output, np.array(place, float))


LAMP = lamp("lamp", Illuminant("FL11"), (1.0, 1.0, 1.0))
RED = Material("paint", "paint", Diffuse(Rgb(0.6, 0.1, 0.05)))


def test_light_without_wavelengths_has_none_to_choose():
    plan = plan_of(box(2, 2, 2), paint(0.5), LAMP)
    assert (decision_of(plan).choice, decision_of(plan).saving) == ("none", 0.0)
    # The user wants light that has them: then they are chosen.
    made = plan_of(box(2, 2, 2), paint(0.5), LAMP, transport="spectral")
    assert decision_of(made).choice == "by lamps and eye"
    assert decision_of(plan_of(box(2, 2, 2), RED, LAMP, transport="mono")).choice == "none"


def test_a_switch_draws_them_evenly():
    assert not plan_of(box(2, 2, 2), RED, LAMP).draws_evenly
    plan = plan_of(box(2, 2, 2), RED, LAMP, EVENLY)
    assert plan.draws_evenly
    assert (decision_of(plan).choice, decision_of(plan).bound) == ("evenly from all", 0.0)
    assert "colour matching functions" in decision_of(plan_of(box(2, 2, 2), RED, LAMP)).reason
    photometric = Asked(0.01, has_colour=False)
    assert "the eye sees" in decision_of(plan_of(box(2, 2, 2), RED, LAMP, asked=photometric)).reason


@pytest.mark.mitsuba
def test_a_faint_lamp_of_other_wavelengths_is_not_missed():
    """The strong lamp, whose light says what wavelengths count, is hidden from the sensor: I / d^2 of the other is left."""
    green, red = (
        Tabulated(np.array([360.0, at - 6, at, at + 6, 830.0]), np.array([0.0, 0.0, 1.0, 0.0, 0.0]))
        for at in (540.0, 650.0)
    )
    items = (
        quad("screen", (-1.0, -1.0, 2.0), (2.0, 0, 0), (0, 2.0, 0), "black"),
        paint(0.0, "black"),
        lamp("strong", green, (0.0, 0.0, 3.0), 1e4),
        lamp("faint", red, (0.0, 0.0, 1.0), 1.0),
    )
    made = session_of(*items).measure(
        [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], StopRule(samples=1 << 14), 3, "spectral"
    )
    assert made.illuminance[0] == pytest.approx(1.0, abs=4.0 * made.standard_error[0] + 1e-3)
    assert made.standard_error[0] < 0.2


@pytest.mark.mitsuba
def test_lamps_and_eye_say_what_counts():
    """Light of one lamp has the same weight at all wavelengths that are drawn by it; at those drawn evenly it varies."""
    errors = {}
    for name, more in (("guided", ()), ("even", (EVENLY,))):
        made = session_of(LAMP, *more).measure(
            [[1.0, 1.0, 0.0]], [[0.0, 0.0, 1.0]], StopRule(samples=1 << 10), 3, "spectral"
        )
        errors[name] = made.standard_error[0]
        assert made.illuminance[0] == pytest.approx(100.0, abs=4.0 * errors[name] + 0.05)
    assert errors["guided"] < 0.5 * errors["even"]
