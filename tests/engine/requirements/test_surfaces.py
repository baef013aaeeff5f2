"""Surfaces that are simpler ones: exact, and left alone where something in them is seen."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import box, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.light_layers import split_lights
from lumenray.engine.photometry.spectra import GRID, evaluate_reflectance
from lumenray.engine.requirements.decision import Asked
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.requirements.surfaces import simplify
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.material import (
    BLEND_STEPS,
    Black,
    Blend,
    Coated,
    Diffuse,
    Emission,
    Glossy,
    Holdout,
    Material,
    Mix,
    Sheen,
    Transparent,
    Varnish,
)
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.scene.texture import ImageTexture

EVEN = ImageTexture(np.full((2, 2, 1), 0.5, np.float32))

PICTURE = ImageTexture(np.array([[[0.5], [0.5]], [[0.5], [0.501]]], np.float32))

DARK, LIGHT = Diffuse(Constant(0.2)), Diffuse(Constant(0.6))


def blend(first, second, weights):
    return Blend(
        first, second, np.broadcast_to(np.reshape(weights, (1, 2, 1)), (2, 2, BLEND_STEPS))
    )


@pytest.mark.parametrize(
    ("stated", "same"),
    [
        (Mix(DARK, LIGHT, 0.25), Diffuse(Constant(0.3))),
        (Mix(DARK, Glossy(), 0.0), DARK),
        (Mix(Mix(DARK, LIGHT, 0.5), Glossy(), 0.3), Mix(Diffuse(Constant(0.4)), Glossy(), 0.3)),
        (Mix(LIGHT, Black(), 0.5), Diffuse(Constant(0.3))),
        (
            Mix(LIGHT, Diffuse(Constant(0.2), Constant(0.4)), 0.5),
            Diffuse(Constant(0.4), Constant(0.2)),
        ),
        (Mix(Coated(Constant(0.2)), Coated(Constant(0.6)), 0.5), Coated(Constant(0.4))),
        (Varnish(Sheen(DARK, 0.0), 0.0), DARK),
        (blend(DARK, LIGHT, (0.75, 0.25)), Diffuse(Constant(0.3))),
        (Diffuse(EVEN), Diffuse(Constant(0.5))),
        (Mix(DARK, LIGHT, EVEN), Diffuse(Constant(0.4))),
    ],
)
def test_what_says_the_same_is_simpler(stated, same):
    found = simplify(stated)
    if isinstance(found, Diffuse | Coated):
        assert found.reflectance.value == pytest.approx(same.reflectance.value, abs=1e-12)
        found = replace(found, reflectance=same.reflectance)
    if isinstance(found, Mix):
        assert found.first.reflectance.value == pytest.approx(0.4, abs=1e-12)
        found = replace(found, first=same.first)
    if isinstance(found, Diffuse) and found.transmittance is not None:
        assert found.transmittance.value == pytest.approx(0.2, abs=1e-12)
        found = replace(found, transmittance=same.transmittance)
    assert found == same


def test_spectra_of_mixed_paints_lie_between_theirs():
    red, green = Rgb(0.8, 0.1, 0.1), Rgb(0.1, 0.7, 0.1)
    mixed = simplify(Mix(Diffuse(red), Diffuse(green), 0.3)).reflectance
    expected = 0.7 * evaluate_reflectance(red, GRID) + 0.3 * evaluate_reflectance(green, GRID)
    assert np.allclose(evaluate_reflectance(mixed, GRID), expected, atol=1e-12)


@pytest.mark.parametrize(
    "stated",
    [
        # What they add is a thousandth of the light, all of which may go to one place.
        Mix(DARK, Glossy(Constant(0.9), 0.1), 0.001),
        Varnish(DARK, 0.001),
        Sheen(DARK, 0.001),
        Coated(Constant(0.5), 1.5, 1.0, 0.001),
        # A hole of a thousandth lights the room behind it alone.
        Mix(DARK, Transparent(), 0.001),
        Mix(DARK, LIGHT, PICTURE),
        Diffuse(PICTURE),
        # One pixel that is no number counts as black.
        Diffuse(ImageTexture(np.array([[[0.5], [np.nan]]], np.float32))),
        Varnish(DARK, PICTURE),
        Mix(Diffuse(PICTURE), LIGHT, 0.5),
        # Each of these has a law of its own.
        Mix(Coated(Constant(0.2), 1.5), Coated(Constant(0.6), 1.6), 0.5),
        Mix(Diffuse(Constant(0.2), roughness=0.5), LIGHT, 0.5),
        Mix(DARK, Holdout(), 0.5),
        blend(DARK, Glossy(), (0.5, 0.25)),
    ],
)
def test_what_adds_something_stays(stated):
    assert simplify(stated) is stated


def test_weights_that_differ_by_angle_stay():
    weights = np.stack([np.linspace(0, 1, BLEND_STEPS), np.linspace(1, 0, BLEND_STEPS)])
    stated = Blend(DARK, LIGHT, np.stack([weights, weights]))
    assert simplify(stated) is stated


def items_of(surface):
    output = Output(Quantity.LUMINOUS_FLUX, 1000.0)
    lamp = PointLight("lamp", "lamp", output, np.array([1.0, 1.0, 1.5]))
    return box(2, 2, 2), Material("paint", "paint", surface), lamp


def test_the_plan_changes_the_materials_and_the_switch_stops_it():
    scene = Scene()
    scene.apply(SceneDelta(changed=items_of(Mix(DARK, LIGHT, 0.5))))
    plan = make_plan(scene, Asked())
    assert (plan.spent, list(plan.changes)) == (0.0, ["paint"])
    assert plan.simplify(scene).materials["paint"].surface == Diffuse(Constant(0.4))
    scene.apply(SceneDelta(changed=(Modelling((("surfaces", Switch.OFF),)),)))
    assert not make_plan(scene, Asked()).changes


def test_an_even_picture_is_the_colour_of_its_pixels():
    pixels = np.full((4, 4, 3), (0.8, 0.4, 1.2), np.float32)
    found = simplify(Glossy(ImageTexture(pixels, extension="extend"), 0.3)).reflectance
    assert (found.red, found.green, found.blue) == pytest.approx((0.8, 0.4, 1.0), abs=1e-7)


@pytest.mark.mitsuba
def test_the_light_is_the_same():
    picture = ImageTexture(np.full((4, 4, 3), (0.7, 0.3, 0.2), np.float32))
    items = items_of(Mix(Coated(picture), Coated(Rgb(0.2, 0.5, 0.6)), 0.4))
    off = Modelling((("surfaces", Switch.OFF),))
    places, up, rule = [[0.5, 0.7, 0.0]], [[0, 0, 1.0]], StopRule(samples=1 << 14)
    less, full = (
        session_of(*items, *more).measure(places, up, rule, 1, "spectral") for more in ((), (off,))
    )
    noise = np.hypot(less.standard_error, full.standard_error)
    assert noise[0] < 0.02 * full.illuminance[0]
    assert abs(less.illuminance - full.illuminance)[0] < 3.0 * noise[0]


@pytest.mark.mitsuba
def test_light_groups_of_a_bake_have_no_others_light():
    """A group's scene is the same without the light of others, also where their surfaces are simplified."""
    room, panel, lamp = items_of(DARK)
    glowing = replace(panel, surface=Mix(DARK, LIGHT, 0.5), emission=Emission(Constant(1.0), 100.0))
    session = session_of(room, glowing, lamp)
    scenes = dict(split_lights(session.scene, (LightGroup("lamp", ("lamp",)),)))
    with session._engine("mono") as compiled:
        assert compiled.requirements.changes
        sources = {
            name: [name for name, _ in session._compile_aside(scene, compiled).named_sources()]
            for name, scene in scenes.items()
        }
    assert sources == {"lamp": ["lamp"], "rest": ["box"]}
