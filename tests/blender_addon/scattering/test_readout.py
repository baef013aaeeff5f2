"""Colours of measured materials by illuminant."""

import numpy as np
import pytest
from blender_scattering import add_paint, matt

from lumenray.blender_addon.scattering import readout as scattering_readout
from lumenray.blender_addon.scattering.files import scattering_files

pytestmark = pytest.mark.usefixtures("extension")


def test_colour_is_that_under_the_chosen_illuminant(write_scattering):
    paint = add_paint(write_scattering(front_reflection=matt(0.1841865)))
    measured = paint.lumenray.measured
    reading = scattering_files.obtain(measured)
    told = dict(scattering_readout.describe_colour(reading, "A"))
    assert told["Y"] == "18.4 %"
    # CIE 15: the chromaticity of A; L* = 50 at Y = 18.42 %.
    assert told["x, y"] == "0.4476, 0.4074"
    assert told["L*, a*, b*"] == "50.0, 0.0, 0.0"
    for name in ("D65", "D50", "A", "LED-B3", "FL2", "FL11"):
        measured.illuminant = name
        # Grey is grey under any light.
        assert tuple(measured.swatch) == pytest.approx([0.1842] * 3, abs=2e-4)


def test_coloured_samples_change_with_the_light(write_scattering):
    steps = matt(np.where(np.arange(16) < 8, 0.05, 0.8), np.linspace(400.0, 700.0, 16))
    measured = add_paint(write_scattering(front_reflection=steps)).lumenray.measured
    reading = scattering_files.obtain(measured)
    values = {
        name: float(dict(scattering_readout.describe_colour(reading, name))["Y"].split()[0])
        for name in ("D65", "A")
    }
    # Red reflects more of lamp light.
    assert values["A"] > values["D65"] + 3.0
    assert measured.swatch[0] > 2.0 * measured.swatch[2]
