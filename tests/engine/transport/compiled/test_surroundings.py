"""How samples of light from infinity are shared between the world and its suns, and what spectra that light has."""

import numpy as np
import pytest

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import ImageWorld, Output, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Illuminant
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.session import Session

GREY = np.full((4, 8, 3), 2.0, np.float32)


def sun(illuminance, spectrum):
    output = Output(Quantity.ILLUMINANCE, illuminance, Illuminant(spectrum))
    return SunLight("sun", "sun", output, np.array([0.0, 0.6, -0.8]), 0.01)


def scene_of(*items):
    scene = Scene()
    scene.apply(SceneDelta(changed=items))
    return scene


def test_a_grey_picture_and_a_sun_of_its_white_need_no_wavelengths():
    """Light that is taken out of a grey picture must not make all of a render spectral, and slow."""
    world = ImageWorld(ImageTexture(GREY), 100.0)
    assert not make_plan(scene_of(world, sun(1e4, "D65"))).spectral
    made = make_plan(scene_of(world, sun(1e4, "A")))
    assert made.spectral
    assert made.reasons[0] == "the lights have different spectra"
    red = ImageWorld(ImageTexture(GREY * np.float32([1.0, 0.5, 0.5])), 100.0)
    assert (
        make_plan(scene_of(red, sun(1e4, "D65"))).reasons[0]
        == "the picture of the surroundings has colours"
    )


@pytest.mark.mitsuba
def test_samples_are_shared_by_the_light_of_world_and_suns():
    from lumenray.engine.transport.compiled.surroundings import LEAST_SHARE, share_of_world

    assert share_of_world(1000.0, 4000.0 * np.pi) == pytest.approx(0.5)
    assert share_of_world(1000.0, 1e9) == LEAST_SHARE
    assert share_of_world(1000.0, 1e-9) == pytest.approx(1.0 - LEAST_SHARE)
    assert (share_of_world(1000.0, 0.0), share_of_world(None, 1000.0)) == (1.0, 0.0)


@pytest.mark.mitsuba
@pytest.mark.parametrize("illuminance", [100.0, 1e5])
def test_however_samples_are_shared_the_light_is_that_of_both(illuminance):
    """Closed form: pi L of an even world and E cos of the sun."""
    session = Session(witness=False)
    world = UniformWorld(500.0, Illuminant("D65"))
    session.apply(SceneDelta(changed=(world, sun(illuminance, "D65"))))
    made = session.measure(
        [[0, 0, 0]], [[0, 0, 1.0]], StopRule(samples=1 << 12), method="paths", seed=3
    )
    expected = np.pi * 500.0 + 0.8 * illuminance
    assert abs(made.illuminance[0] - expected) < 4.0 * made.standard_error[0] + 1e-3 * expected
