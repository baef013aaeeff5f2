"""Clear skies' spectrum beside Mitsuba's own spectral sky, and what is beyond it."""

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.photometry.colour_temperature import colour_temperature
from lumenray.engine.photometry.spectra import GRID, evaluate_emission, luminous_weight, observer
from lumenray.engine.sky.clear_sky import (
    find_illuminance,
    find_irradiance,
    find_spectrum,
    mix_spectra,
)
from lumenray.libraries import skies

DRAWN = [
    (5.3, 2.4, 0.15),
    (12.0, 1.2, 0.9),
    (27.7, 3.0, 0.2),
    (41.0, 5.6, 0.0),
    (63.2, 8.3, 0.5),
    (88.0, 10.0, 1.0),
]
"""Elevation of the sun, turbidity and albedo."""


def mitsubas_sky(elevation, turbidity, albedo, rows=120, columns=240):
    """Directions, and spectral radiance at the model's wavelengths, by the plug-in alone. (n, 3), (11, n) [W/(m2 sr nm)]"""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport import backend

    backend.start(True)
    sine = (np.arange(rows) + 0.5) / rows
    turn = 2.0 * np.pi * (np.arange(columns) + 0.5) / columns
    plan = np.sqrt(1.0 - sine**2)[:, None]
    directions = np.stack(
        np.broadcast_arrays(plan * np.cos(turn), plan * np.sin(turn), sine[:, None]), axis=-1
    ).reshape(-1, 3)
    height = np.radians(elevation)
    sky = mi.load_dict(
        {
            "type": "sunsky", "sun_direction": [np.cos(height), 0.0, np.sin(height)],
            "turbidity": turbidity, "albedo": albedo, "sun_scale": 0.0,
        }
    )  # fmt: skip
    si = dr.zeros(mi.SurfaceInteraction3f, len(directions))
    si.wi = mi.Vector3f(*(mi.Float(np.float32(column)) for column in -directions.T))
    made = []
    for first in (0, 4, 8):
        part = [*skies.WAVELENGTHS, 720][first : first + 4]
        si.wavelengths = mi.Spectrum(*(mi.Float(float(each)) for each in part))
        made.append(np.array(sky.eval(si)))
    return directions, np.concatenate(made)[:11]


@pytest.mark.mitsuba
@pytest.mark.parametrize(("elevation", "turbidity", "albedo"), DRAWN)
def test_spectrum_and_illuminance_are_those_of_mitsubas_sky(elevation, turbidity, albedo):
    directions, radiance = mitsubas_sky(elevation, turbidity, albedo)
    irradiance = (radiance * directions[:, 2]).sum(axis=1) * 2.0 * np.pi / len(directions)
    found = find_irradiance(elevation, turbidity, albedo)
    np.testing.assert_allclose(found, irradiance, rtol=2e-3)
    # V(lambda) of the CIE 1931 observer at the model's wavelengths, from tables, over 40 nm each: a coarse sum.
    efficiency = np.array([0, 0, 0.000396, 0.023, 0.13902, 0.71, 0.995, 0.631, 0.175, 0.017, 0.001])
    coarse = 683.0 * 40.0 * float(irradiance @ efficiency)
    assert find_illuminance(elevation, turbidity, albedo) == pytest.approx(coarse, rel=0.03)


def test_the_illuminance_is_that_of_clear_skies():
    """By the usual clear sky of the IES, 0.8 + 15.5 sin^1/2 klx, within a factor of 1.5 as single skies are."""
    for elevation in (10.0, 30.0, 60.0):
        usual = 800.0 + 15500.0 * np.sqrt(np.sin(np.radians(elevation)))
        assert 0.67 < find_illuminance(elevation, 3.0, 0.2) / usual < 1.5


def test_cleaner_air_is_bluer_and_darker():
    clean, hazy = (
        colour_temperature(
            evaluate_emission(find_spectrum(40.0, turbidity, 0.2), GRID) @ observer()
        )[0]
        for turbidity in (2.0, 8.0)
    )
    assert clean > 1.3 * hazy
    assert hazy > 6000.0
    assert find_illuminance(40.0, 2.0, 0.2) < find_illuminance(40.0, 8.0, 0.2)


def test_mixtures_have_the_asked_share_of_the_light():
    one, other = find_spectrum(40.0, 2.0), find_spectrum(10.0, 9.0)
    mixed = mix_spectra(one, other, 0.25)
    shares = [find_share(spectrum) for spectrum in (one, other, mixed)]
    assert shares[2] == pytest.approx(0.75 * shares[0] + 0.25 * shares[1], rel=1e-4)


def find_share(spectrum):
    """Power at 440 nm for each lumen, up to a factor."""
    return float(evaluate_emission(spectrum, 440.0)) / luminous_weight(spectrum)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ((-3.0, 3.0, 0.2), "a sun -3.0 degrees high"),
        ((0.0, 3.0, 0.2), "a sun 0.0 degrees high"),
        ((30.0, 0.9, 0.2), "turbidity 0.9, expected 1 to 10"),
        ((30.0, 11.0, 0.2), "turbidity 11, expected 1 to 10"),
        ((30.0, 3.0, 1.1), "albedo of the ground is 1.1"),
        ((30.0, float("nan"), 0.2), "turbidity nan"),
    ],
)
def test_beyond_what_the_model_knows_is_refused(asked, words):
    for find in (find_irradiance, find_illuminance, find_spectrum):
        with pytest.raises(SceneError, match=words):
            find(*asked)
