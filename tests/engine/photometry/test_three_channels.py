"""What spectra change of coloured light on coloured paint."""

import numpy as np
import pytest
from small_scenes import quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.photometry.three_channels import excess_over_channels
from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.material import Diffuse, Material
from lumenray.engine.scene.spectrum import Rgb

REC709 = np.array([0.2126, 0.7152, 0.0722])
WARM, RED = Rgb(1.0, 0.53, 0.2), Rgb(0.7, 0.3, 0.2)


@pytest.mark.parametrize(
    ("light", "paint"),
    [(WARM, Rgb(0.5, 0.5, 0.5)), (Rgb(1.0, 1.0, 1.0), RED), (Rgb(0.3, 0.3, 0.3), RED)],
)
def test_grey_light_and_grey_paint_are_the_same_in_both(light, paint):
    assert excess_over_channels(light, paint) == pytest.approx(0.0, abs=1e-3)


def test_it_is_of_the_first_order_in_both_saturations():
    """Halving either colour's distance from grey halves it, about."""
    whole = excess_over_channels(Rgb(0.6, 0.5, 0.4), Rgb(0.6, 0.5, 0.4))
    half = excess_over_channels(Rgb(0.55, 0.5, 0.45), Rgb(0.6, 0.5, 0.4))
    quarter = excess_over_channels(Rgb(0.55, 0.5, 0.45), Rgb(0.55, 0.5, 0.45))
    assert half / whole == pytest.approx(0.5, abs=0.15)
    assert quarter / whole == pytest.approx(0.25, abs=0.15)


@pytest.mark.mitsuba
def test_it_is_what_a_measured_reflection_differs_by():
    """Of a plane under an even world, by the transport's own wavelengths and textures."""
    material = Material("paint", "paint", Diffuse(RED))
    plane = quad("plane", (-50, -50, 0), (100, 0, 0), (0, 100, 0), "paint")
    session = session_of(material, plane, UniformWorld(100.0, WARM))
    found = session.measure([(0, 0, 0.1)], [(0, 0, -1)], StopRule(samples=1 << 14))
    light, paint = (np.array([c.red, c.green, c.blue]) for c in (WARM, RED))
    in_channels = REC709 @ (light * paint) / (REC709 @ light)
    ratio = found.illuminance[0] / (100.0 * np.pi * in_channels)
    error = found.standard_error[0] / found.illuminance[0]
    assert error < 5e-3
    assert ratio - 1.0 == pytest.approx(excess_over_channels(WARM, RED), abs=4 * error)
    assert ratio < 0.97
