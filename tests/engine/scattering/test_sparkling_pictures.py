"""Pictures of surfaces that sparkle: their mean is the table from near and far, and lux maps know no flakes."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, Quantity, SunLight
from lumenray.engine.scene.material import Material, Measured
from lumenray.engine.scene.scattering import Sparkle
from lumenray.engine.views import ViewSettings

pytestmark = [pytest.mark.mitsuba, pytest.mark.slow]

INDEX, SLOPE = 1.45, np.radians(3.0)


def flakes(wi, wo):
    """A fifth of the light of mirrors with Gaussian slopes inside a body. (n, 3), (n, 3) -> (n, 1) [1/sr]"""

    def inside(w):
        level = w[:, :2] / INDEX
        return np.concatenate([level, np.sqrt(1.0 - (level**2).sum(axis=1, keepdims=True))], axis=1)

    half = inside(wi) + inside(wo)
    tangent = (half[:, 0] ** 2 + half[:, 1] ** 2) / half[:, 2] ** 2
    cosine = half[:, 2] / np.linalg.norm(half, axis=1)
    density = np.exp(-0.5 * tangent / SLOPE**2) / (2.0 * np.pi * SLOPE**2 * cosine**3)
    return 0.05 / INDEX**2 * density[:, None]


@pytest.fixture(scope="module")
def luminances():
    """Luminances of a plane as its table and with flakes, 100 x 100 pixels, by the width of a pixel. [cd/m2]"""
    first = resample(flakes, [550.0], tolerance=0.02)
    whole = replace(first, values=first.values + np.float32(0.05))
    sparkle = Sparkle(first, 3.279e9, SLOPE, np.radians(0.3), 0.0, INDEX)
    frame = np.eye(4)
    frame[2, 3] = 1.0
    away = -np.array([np.sin(np.radians(5.0)), 0.0, np.cos(np.radians(5.0))])
    sun = SunLight("sun", "Sun", Output(Quantity.ILLUMINANCE, 1000.0), away, np.radians(2.0))
    plane = quad("plane", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint")
    made = {}
    for number, surface in enumerate(
        (Measured(whole, whole), Measured(whole, whole, sparkles=(sparkle,)))
    ):
        session = session_of(Material("paint", "Paint", surface), plane, sun)
        for width in (1e-4, 3e-4, 2e-3):
            camera = Camera(frame, Projection.ORTHOGRAPHIC, 100, 100, 100 * width, 100 * width)
            picture = session.render(camera, ViewSettings(StopRule(samples=32)))
            made[number, width] = picture.tristimulus[..., 1].astype(float)
    return made


@pytest.mark.parametrize("width", [1e-4, 3e-4, 2e-3])
def test_the_mean_of_ten_thousand_pixels_is_the_tables(luminances, width):
    table, found = (luminances[number, width] for number in (0, 1))
    assert found.mean() == pytest.approx(table.mean(), rel=0.005)


def test_the_nearer_the_camera_the_more_it_glitters(luminances):
    scatter = [
        luminances[1, width].std() / luminances[1, width].mean() for width in (1e-4, 3e-4, 2e-3)
    ]
    assert scatter[0] > 2.0 * scatter[1] > 8.0 * scatter[2] > 0.0
    # Pixels have as many flakes as they are wide, squared: the scatter goes with the inverse of the width.
    assert scatter[0] / scatter[2] == pytest.approx(20.0, rel=0.25)
    # The sun alone lights no grain where flakes are not seen.
    assert luminances[0, 1e-4].std() < 1e-3 * luminances[0, 1e-4].mean()
