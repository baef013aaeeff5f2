"""Guides of filters of noise: means over the pixel of what is seen, through panes and in mirrors."""

import numpy as np
import pytest
from live_scenes import camera_at
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import AreaLight, Output, Quantity
from lumenray.engine.scene.material import Coated, Diffuse, Glossy, Material, ThinGlass
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

RED = (0.7, 0.2, 0.1)

FLOOR = quad("floor", (-5, -5, 0), (10, 0, 0), (0, 10, 0), "floor")
LAMP = AreaLight(
    "l", "l", Output(Quantity.LUMINOUS_FLUX, 100.0), camera_at(-4, 4, 9).frame, 0.5, 0.5
)


def render(*items, camera, transport="spectral", guides=True):
    """Picture of few samples of a scene that is looked at from above."""
    settings = ViewSettings(StopRule(samples=2), transport=transport, guides=guides)
    return session_of(*items, LAMP).render(camera, settings)


def test_a_matt_floor_shows_its_colour_its_normal_and_how_far_it_is():
    floor = Material("floor", "floor", Diffuse(Rgb(*RED)))
    made = render(FLOOR, floor, camera=camera_at(0, 0, 2.0))
    # At one wavelength each: enough to tell surfaces apart.
    np.testing.assert_allclose(made.denoising_albedo.mean(axis=(0, 1)), RED, atol=0.15)
    np.testing.assert_allclose(made.denoising_normal, (0, 0, 1) * np.ones((36, 48, 3)), atol=1e-5)
    assert made.denoising_depth[18, 24] == pytest.approx(2.0, rel=2e-3)
    # Along the ray, not the axis of view.
    assert made.denoising_depth[0, 0] > 2.1


def test_they_are_there_only_when_asked_for():
    made = render(FLOOR, paint(0.3, "floor"), camera=camera_at(0, 0, 2.0), guides=False)
    assert made.denoising_albedo is made.denoising_normal is made.denoising_depth is None


def test_edges_are_means_and_nothing_is_seen_beside():
    half = quad("floor", (-5, -5, 0), (5, 0, 0), (0, 10, 0), "floor")
    made = render(half, paint(0.3, "floor"), camera=camera_at(0, 0, 2.0, 49, 36), transport="mono")
    np.testing.assert_allclose(made.denoising_albedo[:, :24], 0.3, atol=1e-5)
    assert (made.denoising_albedo[:, 26:] == 1.0).all()
    assert (made.denoising_normal[:, 26:] == 0.0).all()
    assert (made.denoising_depth[:, 26:] == 0.0).all()
    # The middle column is halved by the edge; the picture's own normal is that of its pixels' centres.
    assert made.denoising_albedo[:, 24].mean() == pytest.approx(0.65, abs=0.05)
    assert set(np.unique(made.normal[:, 24, 2])) <= {0.0, 1.0}


@pytest.mark.parametrize("transport", ["mono", pytest.param("spectral", marks=pytest.mark.slow)])
def test_panes_and_mirrors_show_what_is_seen_in_them(transport):
    glass = Material("glass", "glass", ThinGlass(1.5))
    pane = quad("pane", (-5, -5, 1), (5, 0, 0), (0, 10, 0), "glass")
    mirror = Material("mirror", "mirror", Glossy(Constant(0.9), roughness=0.0))
    board = quad("board", (0, -5, 1), (5, 0, 0), (0, 10, 0), "mirror")
    ceiling = quad("ceiling", (-5, -5, 3), (0, 10, 0), (10, 0, 0), "ceiling")
    made = render(
        FLOOR, pane, board, ceiling, paint(0.3, "floor"), paint(0.8, "ceiling"), glass, mirror,
        camera=camera_at(0, 0, 2.0, 48, 36), transport=transport,
    )  # fmt: skip
    # Through the pane the floor.
    albedo = made.denoising_albedo
    np.testing.assert_allclose(albedo[:, :22], 0.3, atol=0.03)
    np.testing.assert_allclose(made.denoising_normal[:, :22, 2], 1.0, atol=1e-5)
    np.testing.assert_allclose(albedo[:, 26:], 0.9 * 0.8, atol=0.02)
    np.testing.assert_allclose(made.denoising_normal[:, 26:, 2], -1.0, atol=1e-5)
    assert made.denoising_depth[18, 26] == pytest.approx(1.0 + 2.0, rel=0.01)


def test_varnish_shows_the_colour_below_and_a_lamp_is_white():
    varnish = Material("floor", "floor", Coated(Rgb(*RED), roughness=0.3))
    upwards = camera_at(0, 0, 1.0).frame @ np.diag([1.0, -1.0, -1.0, 1.0])
    lamp = AreaLight("seen", "seen", Output(Quantity.LUMINOUS_FLUX, 100.0), upwards, 0.3, 0.3)
    made = render(FLOOR, varnish, lamp, camera=camera_at(0, 0, 2.0))
    np.testing.assert_allclose(made.denoising_albedo[2, 2], RED, atol=0.15)
    np.testing.assert_allclose(made.denoising_albedo[18, 24], 1.0, atol=1e-5)
