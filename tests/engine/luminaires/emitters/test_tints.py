"""Colours of luminaires by direction: spectra of the nodes by upsampling one colour at a time, luminous shares by sums."""

import numpy as np
import pytest
from lumenray.engine.photometry.spectra import (
    GRID,
    illuminant,
    luminous_efficiency,
    upsample,
)
from lumenray.engine.scene.distribution import IntensityDistribution
from lumenray.engine.scene.spectrum import Rgb
from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba

AZIMUTH, POLAR = np.linspace(0.0, 2.0 * np.pi, 9), np.linspace(0.0, 1.2, 4)


def row_of(colours):
    from lumenray.engine.luminaires.emitters.palette import KINDS, Row
    from lumenray.engine.luminaires.emitters.tables import distribution_digest

    shown = IntensityDistribution(AZIMUTH, POLAR, np.ones((9, 4)), colours=colours)
    density = illuminant(GRID, "D65")
    density = density / (683.0 * (density * luminous_efficiency()).sum())
    one, none = np.eye(3), np.zeros(3)
    return Row(
        shown, distribution_digest(shown), one, KINDS["point"], one, none, none, 5.0, density
    )


def towards(azimuth, polar):
    return np.array(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), -np.cos(polar)]
    )


def test_light_of_a_direction_has_the_spectrum_of_its_colour_and_its_amount():
    import drjit as dr
    import mitsuba as mi
    from lumenray.engine.luminaires.emitters.palette import LuminairePalette

    backend.start(True)
    colours = np.random.default_rng(1).integers(0, 9, (9, 4, 3)) / 8.0 + 0.125
    coloured, plain = row_of(colours.astype(np.float32)), row_of(None)
    palette = LuminairePalette()
    palette.commit([plain, coloured])
    wavelengths = np.arange(402.0, 700.0, 7.0)
    at = mi.Spectrum(*(mi.Float(wavelengths),) * 4)
    for i, j in ((0, 1), (3, 2), (6, 3), (7, 1)):
        direction = mi.Vector3f(*map(float, towards(AZIMUTH[i], POLAR[j])))
        found, beside = (
            np.array(palette.spectrum(dr.opaque(mi.UInt32, n), at, mi.Bool(True), direction))[0]
            for n in (1, 0)
        )
        colour = colours[i, j] / colours[i, j].max()
        tint = upsample(Rgb(*colour), GRID)
        light = plain.density * luminous_efficiency()
        share = (tint * light).sum() / light.sum()
        wanted = 5.0 * np.interp(wavelengths, GRID, plain.density * tint / share)
        assert found == pytest.approx(wanted, rel=0.01)
        assert beside == pytest.approx(5.0 * np.interp(wavelengths, GRID, plain.density), rel=1e-3)


def test_photometric_light_and_grey_luminaires_have_no_colours():
    from lumenray.engine.luminaires.emitters.tints import Tints

    colours = np.ones((9, 4, 3), np.float32)
    backend.start(False)
    tints = Tints()
    assert tints.commit([row_of(colours)]) == [0]
    backend.start(True)
    tints = Tints()
    assert tints.commit([row_of(None), row_of(colours), row_of(colours)]) == [0, 1, 1]
    assert len(tints) == 1
