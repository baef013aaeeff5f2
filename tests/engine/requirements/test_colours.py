"""Whether light needs wavelengths: the bound of doing without, and scenes that must not."""

import numpy as np
import pytest
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.photometry.spectra import (
    GRID,
    evaluate_emission,
    evaluate_reflectance,
    luminous_efficiency,
)
from lumenray.engine.requirements import colours
from lumenray.engine.requirements.decision import Asked
from lumenray.engine.requirements.facts import Facts
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import ImageWorld, Output, PointLight, Quantity
from lumenray.engine.scene.material import Cauchy, Coated, Dielectric, Diffuse, Material, Mix
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Illuminant, Rgb, Tabulated
from lumenray.engine.scene.texture import ImageTexture
from small_scenes import box, paint, session_of

PERCENT = Asked(0.01, has_colour=False)


def lamp(spectrum="D65", name="lamp", place=(1.0, 1.0, 1.0)):
    output = Output(Quantity.LUMINOUS_INTENSITY, 100.0, Illuminant(spectrum))
    return PointLight(name, name, output, np.array(place))


def coloured(surface, name="paint"):
    return Material(name, name, surface)


def scene_of(*items):
    scene = Scene()
    scene.apply(SceneDelta(changed=(box(2, 2, 2), *items)))
    return scene


def bound_of(*items):
    return colours.find_bound(Facts(scene_of(*items)))


def test_lamps_of_any_spectra_light_neutral_surfaces_without_wavelengths():
    scene = scene_of(paint(0.7), lamp("A", "a"), lamp("FL11", "b"))
    plan = make_plan(scene, PERCENT)
    assert (plan.spectral, plan.spent) == (False, 0.0)
    assert "neutral" in plan.reasons[0]
    # Colours are another matter.
    assert make_plan(scene, Asked(0.01)).spectral


@pytest.mark.parametrize("name", ["D65", "A", "FL11"])
@pytest.mark.parametrize("walls", [(0.8, 0.79, 0.77), (0.5, 0.48, 0.5), (0.7, 0.4, 0.3)])
def test_the_bound_holds_in_an_integrating_sphere(name, walls):
    """Closed form: light from walls of reflectance r is r / (1 - r) of the direct light, by wavelength."""
    values = evaluate_reflectance(Rgb(*walls), GRID)
    weights = evaluate_emission(Illuminant(name), GRID) * luminous_efficiency()
    weights /= weights.sum()
    mean = weights @ values
    exact, approximate = weights @ (values / (1.0 - values)), mean / (1.0 - mean)
    error = abs(approximate / exact - 1.0)
    bound = bound_of(coloured(Diffuse(Rgb(*walls))), lamp(name))
    assert error < bound
    # And it is no excuse for never doing it.
    assert bound < max(20.0 * error, 1e-5) or walls == (0.7, 0.4, 0.3)


@pytest.mark.mitsuba
def test_stated_errors_hold_what_is_left_out():
    """Sensors in a room of off-white paint, with and without wavelengths."""
    items = box(2, 2, 2), coloured(Coated(Rgb(0.80, 0.79, 0.77))), lamp("A")
    places, up = [[0.5, 0.5, 0.1], [1.5, 1.0, 0.1]], [[0, 0, 1.0]] * 2
    session = session_of(*items)
    made = session.measure(places, up, StopRule(error=0.02), seed=2)
    full = session_of(*items).measure(places, up, StopRule(samples=1 << 15), 3, "spectral")
    assert "alike" in made.provenance.decisions[0]
    assert not made.provenance.variant.startswith("llvm_ad_spectral")
    spent = make_plan(session.scene, Asked(0.02, has_colour=False)).spent
    assert 0.0 < spent <= 0.02 / 3.0
    assert (made.standard_error > spent * made.illuminance).all()
    error = np.hypot(made.standard_error, full.standard_error)
    assert (np.abs(made.illuminance - full.illuminance) < 3.5 * error).all()


def test_of_no_error_nothing_is_spent_and_switches_decide():
    scene = scene_of(coloured(Diffuse(Rgb(0.8, 0.79, 0.77))), lamp())
    assert make_plan(scene, Asked(None, False)).spectral
    plan = make_plan(scene, PERCENT)
    assert not plan.spectral
    assert plan.spent == plan.decisions[0].bound <= plan.allowed
    scene.apply(SceneDelta(changed=(Modelling((("colours", Switch.OFF),)),)))
    assert make_plan(scene, PERCENT).spectral
    scene.apply(SceneDelta(changed=(Modelling((("colours", Switch.FORCE),)),)))
    forced = make_plan(scene, Asked(1e-6, False))
    assert not forced.spectral
    assert forced.spent > forced.allowed
    assert "simplifications: at most" in forced.reasons[-1]


RED, GREEN = Rgb(0.7, 0.1, 0.1), Rgb(0.1, 0.7, 0.1)

LINES = Tabulated(
    np.array([500.0, 540.0, 541.0, 600.0, 601.0, 640.0]), np.array([0.3, 0.3, 0.7, 0.7, 0.3, 0.3])
)


@pytest.mark.parametrize(
    "items",
    [
        # Light between red and green walls is nearly nothing, whatever each reflects by itself.
        (coloured(Mix(Diffuse(RED), Diffuse(GREEN), 0.5)), lamp()),
        (coloured(Diffuse(Rgb(0.5, 0.3, 0.2))), lamp()),
        # The reflectance under each lamp is another, and none is that of their mean.
        (coloured(Diffuse(LINES)), lamp("FL11", "a"), lamp("A", "b")),
        # Glass that sends colours into other directions.
        (coloured(Dielectric(Cauchy(1.5, 0.01))), lamp()),
        # Light whose colour goes with its direction, on coloured walls.
        (
            coloured(Diffuse(Rgb(0.8, 0.79, 0.77))),
            ImageWorld(
                ImageTexture(np.full((4, 8, 3), 1.0, np.float32) * np.float32([1, 0.5, 0.2])), 1e2
            ),
        ),
        # What a picture holds is not bounded.
        (
            coloured(Diffuse(ImageTexture(np.full((2, 2, 3), (0.8, 0.79, 0.77), np.float32)))),
            lamp(),
        ),
    ],
)
def test_scenes_that_need_wavelengths_get_them(items):
    assert make_plan(scene_of(*items), PERCENT).spectral


def test_paths_of_many_reflections_widen_the_bound():
    """White walls that are hardly coloured make light very yellow in the end."""
    dark, bright = (bound_of(coloured(Diffuse(Rgb(x, x, x - 0.02))), lamp()) for x in (0.3, 0.95))
    assert bright > 5.0 * dark
    assert bound_of(coloured(Diffuse(Rgb(0.99, 0.99, 0.9))), lamp()) > 0.01
