"""Pictures of scattering in panels."""

import numpy as np
import pytest
from blender_scattering import add_paint, matt

from lumenray.blender_addon.scattering import preview as scattering_pictures
from lumenray.blender_addon.scattering.files import scattering_files

pytestmark = pytest.mark.usefixtures("extension")


def test_pictures_of_a_file_of_the_back_show_the_back(write_scattering):
    reading = scattering_files.obtain(
        add_paint(write_scattering(back_reflection=matt(0.5))).lumenray.measured
    )
    for kind in scattering_pictures.DRAWN:
        dark = scattering_pictures.draw_scattering(reading, 256, True, kind)
        assert dark.shape == (256, 256, 4)
        assert np.median(dark[..., :3]) < 0.3
        light = scattering_pictures.draw_scattering(reading, 256, False, kind)
        assert np.median(light[..., :3]) > 0.9
        # Blue is the curve's: paper and grid have none.
        assert (np.ptp(light[..., :3], axis=2) > 0.3).sum() > 100
