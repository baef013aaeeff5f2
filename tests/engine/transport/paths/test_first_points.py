"""What the first surfaces do with paths of the camera is drawn evenly, and without bias."""

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.material import Dielectric, Emission, Material
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

LUMINANCE, SAMPLES, Z = 100.0, 64, 4.0


@pytest.fixture(scope="module")
def slab():
    """Slab of glass below the camera, a luminous sheet behind that, and nothing under the glass."""
    block: Mesh = box(2.0, 2.0, 0.2, "glass", inwards=False)
    sheet = quad("sheet", (-4.0, -4.0, 3.0), (0.0, 10.0, 0.0), (10.0, 0.0, 0.0), "bright")
    bright = paint(0.0, "bright", emission=Emission(Constant(1.0), LUMINANCE))
    session = session_of(block, sheet, Material("glass", "glass", Dielectric()), bright)
    frame = np.eye(4)
    frame[:3, 3] = 1.0, 1.0, 2.0
    camera = Camera(frame, Projection.PERSPECTIVE, 40, 30, 0.04, 0.03)
    return session.render(camera, ViewSettings(StopRule(samples=SAMPLES), 3, method="paths"))


def mirrored_share():
    """What a slab reflects at normal incidence with all that goes to and fro in it (E. Hecht, Optics, ch. 9)."""
    single = ((1.5 - 1.0) / (1.5 + 1.0)) ** 2
    return 2.0 * single / (1.0 + single)


def test_light_that_a_slab_reflects_is_that_of_its_closed_form(slab):
    found = slab.tristimulus[..., 1].astype(float) / LUMINANCE
    error = found.std(ddof=1) / np.sqrt(found.size)
    assert abs(found.mean() - mirrored_share()) < Z * error


def test_pixels_scatter_less_than_by_chances_of_their_own(slab):
    share = mirrored_share()
    by_chance = np.sqrt(share * (1.0 - share) / SAMPLES)
    assert (slab.tristimulus[..., 1] / LUMINANCE).std() < 0.7 * by_chance
