"""Equal materials share a surface, and what differs in anything that can be seen does not."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.decision import Asked
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.material import Diffuse, Emission, Glossy, Material, Mix
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Constant, Tabulated

OFF = Modelling((("equal materials", Switch.OFF),))


def gloss(name, value=0.6, **more):
    return Material(name, name, Glossy(Constant(value), 0.3), **more)


def panels(count):
    return [
        quad(f"o{k}", (0.2 + 0.4 * k, 0.2, 0.5), (0.3, 0, 0), (0, 1.0, 0), f"m{k}")
        for k in range(count)
    ]


def surfaces_of(*materials):
    scene = Scene()
    scene.apply(SceneDelta(changed=(*panels(len(materials)), *materials)))
    plan = make_plan(scene, Asked())
    assert plan.spent == 0.0
    return plan.simplify(scene).materials


def test_equal_ones_share_a_surface_and_stay_themselves():
    glow = Emission(Constant(1.0), 100.0)
    found = surfaces_of(
        gloss("m0"), gloss("m1", index=7), gloss("m2", emission=glow), gloss("m3", 0.61)
    )
    assert found["m0"].surface is found["m1"].surface is found["m2"].surface
    assert [found[key].index for key in ("m0", "m1")] == [0, 7]
    assert (found["m2"].id, found["m2"].emission) == ("m2", glow)
    assert found["m3"].surface is not found["m0"].surface


def test_what_differs_by_one_number_of_a_table_stays_apart():
    def tinted(name, last):
        table = Tabulated(np.array([400.0, 700.0]), np.array([0.5, last]))
        return Material(name, name, Mix(Glossy(table, 0.2), Diffuse(), 0.5))

    found = surfaces_of(tinted("m0", 0.5), tinted("m1", 0.5), tinted("m2", 0.5 + 1e-9))
    assert found["m0"].surface is found["m1"].surface
    assert found["m2"].surface is not found["m0"].surface


def test_rows_of_the_palette_are_left_alone():
    scene = Scene()
    scene.apply(SceneDelta(changed=(*panels(2), paint(0.5, "m0"), paint(0.5, "m1"))))
    assert not make_plan(scene, Asked()).changes


@pytest.mark.slow
@pytest.mark.mitsuba
def test_the_light_is_the_same_and_edits_reach_one_alone():
    lamp = PointLight(
        "lamp", "lamp", Output(Quantity.LUMINOUS_FLUX, 500.0), np.array([1.0, 1.0, 1.5])
    )
    items = [box(2, 2, 2), paint(0.5), lamp, *panels(2), gloss("m0"), gloss("m1")]
    places, up, rule = (
        [[0.4, 0.5, 0.1], [1.0, 1.5, 1.0]],
        [[0, 0, 1.0], [0, 0, -1.0]],
        StopRule(samples=1 << 12),
    )

    def measure(session):
        return session.measure(places, up, rule, 1, "mono").illuminance

    session, apart = session_of(*items), session_of(*items, OFF)
    palette = session_palette(session, measure)
    assert palette.plugin_number("m0") == palette.plugin_number("m1")
    assert np.allclose(measure(session), measure(apart), rtol=1e-5)
    for edit in (
        gloss("m1", 0.1),
        replace(gloss("m0"), surface=Diffuse(Constant(0.2))),
        gloss("m1"),
        gloss("m0"),
    ):
        for each in (session, apart):
            each.apply(SceneDelta(changed=(edit,)))
        assert np.allclose(measure(session), measure(apart), rtol=1e-5)
    palette = session_palette(session, measure)
    assert palette.plugin_number("m0") == palette.plugin_number("m1")


def session_palette(session, measure):
    """The materials at work of a session that has measured."""
    measure(session)
    return session._compiled._material_palette
