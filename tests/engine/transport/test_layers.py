"""Layers in one search tree, as graphics cards need them, show what layers in trees of their own show."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.material import Cauchy, Dielectric, Material, ThinGlass
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.transport import devices
from lumenray.engine.views import ViewSettings

SAMPLES = StopRule(samples=64)


def items():
    """A room with a pane, a block of glass, a screen that light does not meet and a panel that the camera sees otherwise."""
    lamp = PointLight(
        "lamp", "lamp", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.0, 1.5, 1.9]), 0.05
    )
    solid = box(1.0, 1.0, 1.0, "glass", inwards=False)
    screen = quad("screen", (0.8, 0.7, 0.2), (0.5, 0, 0), (0, 0, 0.5), "ink")
    return [
        paint(0.5),
        paint(0.1, "ink"),
        paint(0.1, "twofold", seen=paint(0.9, "bright")),
        Material("pane", "pane", ThinGlass()),
        Material("glass", "glass", Dielectric(Cauchy(1.5, 0.0))),
        box(2.0, 2.0, 2.0),
        replace(solid, id="ball", vertices=0.3 * solid.vertices + [1.4, 0.5, 0.3]),
        quad("window", (0.2, 1.0, 0.1), (1.5, 0, 0), (0, 0, 1.5), "pane"),
        replace(screen, meets_light=False),
        quad("panel", (0.1, 1.6, 0.1), (0.9, 0, 0), (0, 0, 0.9), "twofold"),
        lamp,
    ]


PLACES = np.array([[1.0, 0.5, 0.3], [1.0, 1.8, 0.5], [0.4, 1.3, 1.0]])
UP = np.tile([0.0, 0.0, 1.0], (3, 1))

FRAME = np.array([[1, 0, 0, 1.0], [0, 0, -1, 0.05], [0, 1, 0, 1.0], [0, 0, 0, 1]], float)
CAMERA = Camera(FRAME, Projection.PERSPECTIVE, 32, 24)


def answers(session):
    """Illuminances and a picture."""
    seen = session.render(CAMERA, ViewSettings(SAMPLES, 1, shares=False)).tristimulus[..., 1]
    return session.measure(PLACES, UP, SAMPLES, 1).illuminance, seen


def answer_both(monkeypatch, ask):
    """What layers in trees of their own answer, and layers in one tree."""
    made = []
    for many in (True, False):
        device = replace(devices.DEVICES["cpu"], traces_many=many)
        monkeypatch.setitem(devices.DEVICES, "cpu", device)
        made.append(ask())
    return made


def assert_same(own, one):
    """Rounding may send a path elsewhere, no more."""
    np.testing.assert_allclose(one[0], own[0], rtol=2e-3)
    differing = np.abs(one[1] - own[1]) > 1e-3 * own[1].mean()
    assert differing.mean() < 0.02
    assert one[1].mean() == pytest.approx(own[1].mean(), rel=2e-3)


def test_one_tree_shows_what_several_show(monkeypatch):
    own, one = answer_both(monkeypatch, lambda: answers(session_of(*items())))
    assert own[1].std() > 0.1 * own[1].mean()
    assert_same(own, one)


@pytest.mark.slow
def test_one_tree_follows_edits(monkeypatch):
    def edit():
        session = session_of(*items())
        answers(session)
        panel = quad("panel", (0.6, 1.4, 0.1), (0.9, 0, 0), (0, 0, 0.9), "paint")
        session.apply(SceneDelta(changed=(panel,), removed=("screen", "ball")))
        return answers(session)

    own, one = answer_both(monkeypatch, edit)
    assert_same(own, one)


def test_one_tree_traces_one_scene_in_a_kernel(monkeypatch):
    """Of a second one OptiX would find nothing."""
    traced = []

    def follow(real):
        def trace(self, *rest):
            traced.append(id(self))
            return real(self, *rest)

        return trace

    device = replace(devices.DEVICES["cpu"], traces_many=False)
    monkeypatch.setitem(devices.DEVICES, "cpu", device)
    session = session_of(*items())
    answers(session)
    import mitsuba as mi

    for name in ("ray_test", "ray_intersect", "ray_intersect_preliminary"):
        monkeypatch.setattr(mi.Scene, name, follow(getattr(mi.Scene, name)))
    session.render(CAMERA, ViewSettings(SAMPLES, 2, shares=False))
    assert len(set(traced)) == 1
