"""Narrow lines, spiky lamps and metameric paints, against sums over 1 nm with tables of another program."""

import warnings

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.photometry.colour import chromaticity, cie_lab, colour_difference
from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight
from lumenray.engine.scene.material import Diffuse, Material
from lumenray.engine.scene.spectrum import Constant, Illuminant, Lines, Tabulated

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    colour = pytest.importorskip("colour")

NM = np.arange(360.0, 831.0)
"""The 1 nm steps of the sums. [nm]"""

EFFICACY = 683.002
"""Lumens per watt at the maximum of V. [lm/W]"""

SIDE = 4.0
"""Of the closed rooms, with the lamp in the middle. [m]"""


def matching_functions():
    """x-bar, y-bar, z-bar of the 1931 observer, (471, 3)."""
    table = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    return table.copy().align(colour.SpectralShape(360, 830, 1)).values


def at_line(nm, table):
    """Value of a 1 nm table at a line, linear between."""
    return np.array([np.interp(nm, NM, column) for column in np.atleast_2d(table.T)])


def orange(nm):
    """Reflectance of a paint that rises steeply about the lines of sodium. [-]"""
    return 0.1 + 0.75 / (1.0 + np.exp((588.0 - nm) / 4.0))


def tabulated(values):
    return Tabulated(NM, values)


def sodium():
    return Lines(np.array([589.3]), np.array([1.0]))


def triphosphor():
    """Five bands of 2 nm to 6 nm full width on a faint ground, as fluorescent lamps with three phosphors have."""
    power = np.full(len(NM), 0.004)
    for middle, width, height in (
        (435.8, 2.0, 0.5), (487.5, 6.0, 0.15), (543.6, 4.0, 1.0), (587.6, 5.0, 0.2), (611.3, 3.0, 1.3),
    ):  # fmt: skip
        power += height * np.exp(-4.0 * np.log(2.0) * ((NM - middle) / width) ** 2)
    return power


def room_with(lamp_spectrum, reflectance):
    """Closed cube of a paint around an isotropic lamp of 1 W, its lower corner at the origin."""
    output = Output(Quantity.RADIANT_FLUX, 1.0, lamp_spectrum)
    wall = Material("paint", "paint", Diffuse(reflectance))
    lamp = PointLight("lamp", "lamp", output, np.full(3, 0.5 * SIDE))
    return session_of(box(SIDE, SIDE, SIDE), wall, lamp)


def mean_over_the_floor(session, samples, **more):
    """X, Y, Z, mean over the floor and by symmetry over all walls, with errors. [lx]"""
    node, weight = np.polynomial.legendre.leggauss(4)
    # A quarter of the floor stands for all of it.
    place, share = 0.25 * SIDE * (1.0 + node), 0.5 * weight
    x, y = np.meshgrid(place, place)
    positions = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    normals = np.tile([0.0, 0.0, 1.0], (len(positions), 1))
    weights = np.outer(share, share).ravel()
    made = session.measure(positions, normals, StopRule(samples=samples), colour=True, **more)
    return weights @ made.tristimulus, np.sqrt(weights**2 @ made.tristimulus_error**2)


def test_a_sodium_line_between_steep_walls_is_right_to_half_a_percent():
    # The truth at the line itself: that light and paint are computed at full nanometres is part of the error.
    light = 1.0 / (1.0 - orange(589.3)) / (6.0 * SIDE**2)
    expected = EFFICACY * light * at_line(589.3, matching_functions())
    session = room_with(sodium(), tabulated(orange(NM)))
    found, errors = mean_over_the_floor(session, 1 << 14)
    assert (errors[:2] < 5e-3 / 3.0 * expected[:2]).all()
    assert np.allclose(found[:2], expected[:2], rtol=5e-3)


def test_a_lamp_of_narrow_bands_in_a_coloured_room_is_right_to_half_a_percent():
    power = triphosphor()
    light = power / power.sum() / (1.0 - orange(NM)) / (6.0 * SIDE**2)
    expected = EFFICACY * light @ matching_functions()
    session = room_with(tabulated(power), tabulated(orange(NM)))
    found, errors = mean_over_the_floor(session, 1 << 15)
    assert (errors < 5e-3 / 3.0 * expected).all()
    assert np.allclose(found, expected, rtol=5e-3)
    assert np.allclose(chromaticity(found), chromaticity(expected), atol=1e-3)
    # One reflectance for all of the light would be off by far more.
    mean = (power * orange(NM)) @ matching_functions()[:, 1]
    mean /= power @ matching_functions()[:, 1]
    one = EFFICACY * power @ matching_functions()[:, 1] / power.sum() / (6.0 * SIDE**2 * (1 - mean))
    assert abs(one / expected[1] - 1.0) > 0.1


def test_walls_that_reflect_within_three_nanometres_only_are_not_smeared():
    # A notch about the line: 1 nm beside it the paint is nearly black.
    notch = np.where(np.abs(NM - 589.0) <= 1.0, 0.8, 0.05)
    lamp = Lines(np.array([589.0]), np.array([1.0]))
    expected = EFFICACY * matching_functions()[229] / (0.2 * 6.0 * SIDE**2)
    found, _ = mean_over_the_floor(room_with(lamp, tabulated(notch)), 1 << 13)
    assert np.allclose(found[:2], expected[:2], rtol=5e-3)


@pytest.mark.parametrize("nm", [405.0, 450.0, 546.1, 589.3, 632.8, 700.0])
def test_lines_are_neither_missed_nor_doubled_by_drawn_wavelengths(nm):
    # Owed: 0.1 % of Y, though nothing but the drawing of wavelengths is at work.
    output = Output(Quantity.RADIANT_FLUX, 100.0, Lines(np.array([nm]), np.array([1.0])))
    lamp = PointLight("lamp", "lamp", output, np.array([0.0, 0.0, 3.0]))
    made = session_of(lamp).measure(
        [[0, 0, 0]], [[0, 0, 1]], StopRule(samples=1 << 14), transport="spectral", colour=True
    )
    expected = EFFICACY * at_line(nm, matching_functions()) * 100.0 / (4.0 * np.pi * 9.0)
    assert made.tristimulus[0, 1] == pytest.approx(expected[1], rel=1e-3)
    assert np.allclose(chromaticity(made.tristimulus[0]), chromaticity(expected), atol=5e-4)


def test_a_faint_line_beside_a_bright_one_keeps_its_light():
    # A ten-thousandth of the power where the eye is 240 times as sensitive: 2 % of the light; owed: 0.1 %.
    powers = np.array([1.0, 1e-4])
    centres = np.array([700.0, 555.0])
    output = Output(Quantity.RADIANT_FLUX, 1.0, Lines(centres, powers))
    lamp = PointLight("lamp", "lamp", output, np.array([0.0, 0.0, 1.0]))
    made = session_of(lamp).measure(
        [[0, 0, 0]], [[0, 0, 1]], StopRule(samples=1 << 14), transport="spectral"
    )
    efficiency = at_line(centres, matching_functions()[:, 1])[0]
    expected = EFFICACY * (powers @ efficiency) / powers.sum() / (4.0 * np.pi)
    assert made.illuminance[0] == pytest.approx(expected, rel=1e-3)


def metamers(illuminant):
    """Reflectances of two paints that look alike under an illuminant, (471,) each."""
    first = 0.12 + 0.5 / (1.0 + np.exp((580.0 - NM) / 15.0))
    bumps = np.exp(-(((NM[:, None] - np.arange(420.0, 690.0, 45.0)) / 16.0) ** 2))
    seen = (illuminant[:, None] * matching_functions()).T @ bumps
    _, _, rows = np.linalg.svd(seen)
    change = bumps @ rows[3:].T @ rows[3:] @ np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    return first, first + 0.1 * change / np.abs(change).max()


def power_of(name):
    """Relative power of an illuminant in steps of 1 nm, linear in its table."""
    table = colour.SDS_ILLUMINANTS[name]
    return np.interp(NM, table.wavelengths, table.values, left=0.0, right=0.0)


@pytest.mark.parametrize("name", ["A", "FL2"])
def test_metameric_paints_match_and_part_as_colour_science_says(name):
    # Owed: 0.2 % of X, Y and Z, 0.1 of the colour difference.
    shape = colour.SpectralShape(360, 830, 1)
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    light = colour.SpectralDistribution(power_of(name), NM)
    pair = metamers(power_of("A"))
    expected = [
        colour.sd_to_XYZ(colour.SpectralDistribution(values, NM), cmfs, light, method="Integration")
        for values in pair
    ]
    white = colour.sd_to_XYZ(
        colour.SpectralDistribution(np.ones(len(NM)), NM), cmfs, light, method="Integration"
    )

    sun = SunLight(
        "sun", "sun", Output(Quantity.ILLUMINANCE, 100.0, Illuminant(name)), np.array([0, 0, -1.0])
    )
    found = []
    for values in pair:
        # Seen from close above, the ground fills the half space: its reflected light is all that arrives.
        ground = quad("ground", (-500, -500, 0), (1000, 0, 0), (0, 1000, 0), "paint")
        session = session_of(ground, Material("paint", "paint", Diffuse(tabulated(values))), sun)
        made = session.measure(
            [[0, 0, 0.1]], [[0, 0, -1]], StopRule(samples=1 << 16), seed=1, colour=True
        )
        found.append(made.tristimulus[0])
    assert np.allclose(found, expected, rtol=2e-3)
    difference = colour_difference(*cie_lab(found, white))
    owed = float(colour.delta_E(*(cie_lab(xyz, white) for xyz in expected), method="CIE 1976"))
    assert difference == pytest.approx(owed, abs=0.1)
    assert owed < 1e-6 if name == "A" else owed > 3.0


def test_a_neutral_room_keeps_the_colour_of_its_lamp():
    # Photometric transport is exact here, and X and Z come from the lamp.
    output = Output(Quantity.LUMINOUS_FLUX, 96.0, Illuminant("FL11"))
    lamp = PointLight("lamp", "lamp", output, np.full(3, 0.5 * SIDE))
    made = session_of(box(SIDE, SIDE, SIDE), paint(0.5), lamp).measure(
        [[1.0, 1.0, 0.0]], [[0, 0, 1]], StopRule(samples=1 << 10), colour=True
    )
    assert "spectral" not in made.provenance.variant
    expected = chromaticity(power_of("FL11") @ matching_functions())
    assert np.allclose(chromaticity(made.tristimulus[0]), expected, atol=1e-5)


def test_a_white_paint_among_coloured_ones_stays_white():
    # Spectral transport of a neutral surface: owed are 0.1 % of each of X, Y and Z.
    ground = quad("ground", (-500, -500, 0), (1000, 0, 0), (0, 1000, 0), "paint")
    aside = quad("aside", (0, 0, -9), (1, 0, 0), (0, 1, 0), "orange")
    sun = SunLight(
        "sun", "sun", Output(Quantity.ILLUMINANCE, 100.0, Illuminant("FL2")), np.array([0, 0, -1.0])
    )
    session = session_of(
        ground,
        aside,
        Material("paint", "paint", Diffuse(Constant(0.5))),
        Material("orange", "orange", Diffuse(tabulated(orange(NM)))),
        sun,
    )
    made = session.measure(
        [[0, 0, 0.1]], [[0, 0, -1]], StopRule(samples=1 << 14), seed=1, colour=True
    )
    assert "spectral" in made.provenance.variant
    light = power_of("FL2") @ matching_functions()
    assert np.allclose(made.tristimulus[0], 50.0 * light / light[1], rtol=1e-3)
