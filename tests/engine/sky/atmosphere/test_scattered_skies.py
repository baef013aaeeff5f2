"""Skies computed by scattering: closed forms of thin air, of no air, and of what the sun's disk gives."""

import numpy as np
import pytest

from lumenray.engine.sky.atmosphere import multiple_scattering, single_scattering
from lumenray.engine.sky.atmosphere.directions import angle_to, onto_sphere, towards, wrap
from lumenray.engine.sky.atmosphere.scattered_sky import (
    MULTIPLE,
    NISHITA,
    SINGLE,
    ScatteredSky,
    find_colours,
)
from lumenray.libraries import skies, spectra

THIN = 1e-4
"""Density of air that takes nothing from light that passes it. [-]"""

FAINT = 5e-3
"""The same, within a few parts of a thousand, and enough for single precision. [-]"""

ZENITH = np.array([0.0, 0.0, 1.0])


def luminance(colours):
    return colours @ (0.2126, 0.7152, 0.0722)


def sky_of(model, elevation=0.7, **settings):
    given = {"rotation": 0.4, "altitude": 1.0, "air": 1.0, "dust": 1.0, "ozone": 1.0}
    return ScatteredSky(model, elevation, **(given | settings))


def at_zenith(table):
    """Light of the uppermost row, which is 0.7 degrees from the zenith at most, averaged round it."""
    return table[-1].astype(np.float64).mean(axis=0)


def test_thin_air_scatters_what_its_column_holds():
    """Every metre of air scatters by itself: the density's integral, the phase function and the sun's spectrum."""
    elevation = 0.7
    table = single_scattering.make_table(elevation, 1.0, THIN, 0.0, 0.0)
    _, irradiance, rayleigh, _ = skies.atmosphere().T
    steps = (np.arange(single_scattering.STEPS) + 0.5) * 60_000.0 / single_scattering.STEPS
    column = np.exp(-steps / 8000.0).sum() * 60_000.0 / single_scattering.STEPS
    assert column == pytest.approx(8000.0 * (1.0 - np.exp(-7.5)), rel=3e-3)
    phase = 3.0 / (16.0 * np.pi) * (1.0 + np.sin(elevation) ** 2)
    observer = spectra.observer()[1][20:421:20]
    expected = THIN * column * phase * (irradiance * rayleigh) @ observer * 20.0
    np.testing.assert_allclose(at_zenith(table), expected, rtol=3e-3)


def test_thin_air_scatters_once_and_what_is_fitted_to_come_after():
    elevation = 0.7
    table = multiple_scattering.make_table(elevation, 1.0, FAINT, 0.0, 0.0)
    steps = (np.arange(64) + 0.5) * 100.0 / 64
    density = np.exp(-0.07771971 * steps**1.16364243)
    cosine = np.sin(elevation)
    seen = 2.0 * np.pi * (1.0 - np.sqrt(1.0 - (6371.0 / (6371.0 + steps)) ** 2))
    ground = 0.3 / np.pi / (4.0 * np.pi) * seen * cosine
    fit = 0.02 * np.array([0.217, 0.347, 0.594, 1.0]) / (1.0 + 5.0 * np.exp(-17.92 * cosine))
    phase = 3.0 / (16.0 * np.pi) * (1.0 + cosine**2)
    places = phase + ground[:, None] + fit
    light = (density[:, None] * places).sum(axis=0) * 100.0 / 64
    light *= FAINT * multiple_scattering.AIR * multiple_scattering.IRRADIANCE
    np.testing.assert_allclose(
        at_zenith(table), light @ multiple_scattering.TO_XYZ, rtol=5e-3, atol=0.0
    )


@pytest.mark.parametrize("model", [NISHITA, SINGLE, MULTIPLE])
def test_without_air_there_is_a_sun_in_the_dark(model):
    sky = sky_of(model, air=0.0, dust=0.0, ozone=0.0, sun_size=0.01, sun_intensity=1.0)
    above = onto_sphere(np.random.default_rng(1).normal(size=(200, 3)) * (0.3, 0.3, 0.0) + ZENITH)
    assert find_colours(sky, above).max() == 0.0
    sun = find_colours(sky, sky.towards_sun[None], True)[0]
    if model == MULTIPLE:
        outside = multiple_scattering.IRRADIANCE @ multiple_scattering.TO_XYZ
    else:
        outside = skies.atmosphere()[:, 1] @ spectra.observer()[1][20:421:20] * 20.0
    assert luminance(sun) == pytest.approx(outside[1] / (np.pi * 0.005**2), rel=4e-3)


def test_light_of_a_single_wavelength_fades_by_the_air_in_its_way():
    """At the zenith the sun's way is the column of air: 8 km of it and 1.2 km of dust."""
    made = single_scattering.sun_light(0.5 * np.pi, 1.0, 1.0, 1.0)
    _, irradiance, rayleigh, _ = skies.atmosphere().T
    depth = 8000.0 * (1.0 - np.exp(-7.5)) * rayleigh + 1200.0 * 1.11 * 2e-5
    observer = spectra.observer()[1][20:421:20]
    np.testing.assert_allclose(made, (irradiance * np.exp(-depth)) @ observer * 20.0, rtol=3e-3)


@pytest.mark.parametrize("model", [NISHITA, SINGLE, MULTIPLE])
def test_skies_are_even_about_the_suns_meridian(model):
    sky = sky_of(model)
    offset, height = np.linspace(0.1, 3.0, 30), np.linspace(-1.2, 1.4, 27)[:, None]
    sides = [
        onto_sphere(
            np.stack(
                np.broadcast_arrays(
                    np.cos(height) * np.sin(sky.rotation + side * offset),
                    np.cos(height) * np.cos(sky.rotation + side * offset),
                    np.sin(height),
                ),
                axis=-1,
            )
        )
        for side in (-1.0, 1.0)
    ]
    left, right = (find_colours(sky, side) for side in sides)
    np.testing.assert_allclose(left, right, rtol=1e-6, atol=1e-6)


def test_a_sun_past_the_zenith_stands_on_the_other_side():
    assert wrap(2.0, 0.3) == pytest.approx((np.pi - 2.0, np.pi + 0.3))
    for elevation, rotation in [(2.0, 0.3), (-4.0, 9.0), (7.0, -1.0), (0.2, 0.1)]:
        np.testing.assert_allclose(
            towards(*wrap(elevation, rotation)), towards(elevation, rotation), atol=1e-12
        )


def test_angles_next_to_the_sun_keep_their_digits():
    for angle in (1e-9, 1e-6, 1e-3, 1.0, np.pi - 1e-6):
        near = towards(0.3 + angle, 0.0)
        assert angle_to(near, towards(0.3, 0.0)) == pytest.approx(angle, rel=1e-6)


def test_vectors_of_any_length_count_by_their_height():
    made = onto_sphere(np.array([(3.0, 0.0, 0.5), (0.0, -2.0, 4.0), (0.0, 0.0, 0.0)]))
    expected = [(np.sqrt(0.75), 0.0, 0.5), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)]
    np.testing.assert_allclose(made, expected, atol=1e-12)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("model", [NISHITA, SINGLE, MULTIPLE])
@pytest.mark.parametrize(("elevation", "altitude"), [(-1.5, 0.0), (0.0, 100_000.0)])
def test_all_that_blender_lets_people_set_gives_numbers(model, elevation, altitude):
    around = onto_sphere(np.random.default_rng(2).uniform(-1.0, 1.0, (500, 3)))
    for amount in (0.0, 1000.0):
        given = {"air": amount, "dust": amount, "ozone": amount, "altitude": altitude}
        sky = sky_of(model, elevation, sun_size=1.57, sun_intensity=1000.0, **given)
        made = find_colours(sky, around, True)
        assert np.all(np.isfinite(made))
        assert made.min() >= 0.0


def test_before_version_5_the_disk_is_cut_at_the_level_and_since_then_at_the_horizon():
    low = np.stack([towards(-0.002, 0.4), towards(0.002, 0.4)])
    lit = {
        model: luminance(
            find_colours(
                sky_of(model, 0.0, altitude=100.0, sun_size=0.02, sun_intensity=1.0), low, True
            )
        )
        > 1000.0
        for model in (NISHITA, SINGLE, MULTIPLE)
    }
    assert lit[NISHITA].tolist() == [False, True]
    assert lit[SINGLE].tolist() == lit[MULTIPLE].tolist() == [True, True]
