"""Colours of luminaires by direction: spectra of the nodes by upsampling one colour at a time, luminous shares by sums."""

import numpy as np
import pytest
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.luminaires.distribution import flux
from lumenray.engine.photometry.spectra import (
    GRID,
    illuminant,
    luminous_efficiency,
    upsample,
)
from lumenray.engine.scene.distribution import IntensityDistribution
from lumenray.engine.scene.light import Luminaire, Output, Quantity
from lumenray.engine.scene.spectrum import Illuminant, Rgb
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


def test_sensors_see_the_intensity_and_the_colour_of_their_direction():
    """Red to one side and blue to the other: lux by the inverse-square law, colours of the Rec. 709 primaries."""
    azimuth, polar = np.linspace(0.0, 2.0 * np.pi, 17), np.linspace(0.0, 1.2, 5)
    colours = np.zeros((17, 5, 3), np.float32)
    is_red = (azimuth > 0.5 * np.pi) & (azimuth < 1.5 * np.pi)
    colours[is_red, :, 0] = colours[~is_red, :, 2] = 1.0
    amounts = np.where(is_red, 3.0, 1.0)[:, None] * np.ones(5)
    shown = IntensityDistribution(azimuth, polar, amounts, colours=colours)
    light = Luminaire(
        "l", "l", Output(Quantity.LUMINOUS_FLUX, 900.0, Illuminant("D65")), np.eye(4), shown
    )
    places, up = [[-1.0, 0.0, -2.0], [1.0, 0.0, -2.0]], [[0.0, 0.0, 1.0]] * 2
    made = session_of(light).measure(places, up, StopRule(samples=4096), colour=True)
    candelas = 900.0 / flux(shown) * np.array([3.0, 1.0])
    expected = candelas * 2.0 / 5.0**1.5
    assert made.illuminance == pytest.approx(expected, rel=0.02)
    chromaticity = (made.tristimulus / made.tristimulus.sum(axis=1, keepdims=True))[:, :2]
    assert chromaticity[0] == pytest.approx([0.64, 0.33], abs=0.02)
    assert chromaticity[1] == pytest.approx([0.15, 0.06], abs=0.02)


def test_colours_that_are_not_one_for_each_intensity_are_refused():
    from lumenray.engine.luminaires.emitters.tints import Tints

    backend.start(True)
    with pytest.raises(SceneError, match="three channels"):
        Tints().commit([row_of(np.ones((9, 3, 3), np.float32))])


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
