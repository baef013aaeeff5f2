"""Numbers of photometric files: fluxes, flux codes, beams and luminances."""

import numpy as np
import pytest
from luminaires import rotational

from lumenray.engine.luminaires.coordinates import FRAMES, directions
from lumenray.engine.luminaires.distribution import flux, intensity, mirrored, turned
from lumenray.engine.luminaires.formats.record import LuminaireFile
from lumenray.engine.luminaires.summary import summarise
from lumenray.engine.luminaires.zones import flux_within
from lumenray.engine.scene.distribution import IntensityDistribution, Opening


def file_of(distribution, photometric_type="C", **more):
    return LuminaireFile(
        format="made here",
        photometric_type=photometric_type,
        symmetry="none",
        distribution=distribution,
        opening=more.pop("opening", Opening()),
        stored_azimuths=np.rad2deg(distribution.azimuth),
        stored_polars=np.rad2deg(distribution.polar),
        is_absolute=more.pop("is_absolute", True),
        **more,
    )


def of_type(photometric_type, values, step=2.5):
    """Distribution of a function of the direction on a grid of another photometric type, over the half towards the beam."""
    azimuth = np.deg2rad(np.linspace(-90.0, 90.0, round(180.0 / step) + 1))
    polar = np.deg2rad(np.linspace(0.0, 180.0, round(180.0 / step) + 1))
    frame = FRAMES[photometric_type]
    towards = directions(azimuth[:, None], polar[None, :], frame)
    return IntensityDistribution(azimuth, polar, values(towards), frame)


def planes(table):
    """Distribution of planes C0, C90, C180, C270 [cd] at gamma 0, 20, 40, 60, 90 degrees."""
    azimuth, polar = np.deg2rad([0, 90, 180, 270, 360]), np.deg2rad([0.0, 20, 40, 60, 90])
    table = np.array(table, dtype=float)
    return IntensityDistribution(azimuth, polar, np.vstack([table, table[0]]))


def test_a_lambertian_face_has_the_numbers_of_the_textbook():
    made = summarise(file_of(rotational(lambda g: 100.0 * np.cos(g))))
    assert made.total_flux == pytest.approx(100.0 * np.pi, rel=1e-4)
    assert made.upward_flux == 0.0
    assert made.downward_fraction == 1.0
    # Flux in a cone: I0 pi sin^2; the cones are those of pi/2, pi, 3 pi/2 sr.
    assert made.flux_codes == pytest.approx([7 / 16, 3 / 4, 15 / 16, 1.0, 1.0], abs=1e-4)
    assert made.beam_angles == pytest.approx((120.0, 120.0), abs=1e-3)
    assert made.field_angles == pytest.approx([2 * np.rad2deg(np.arccos(0.1))] * 2, abs=1e-3)
    edges = np.deg2rad(np.arange(0, 100, 10))
    assert made.zonal_flux[:9] == pytest.approx(100 * np.pi * np.diff(np.sin(edges) ** 2), rel=1e-4)
    assert not made.zonal_flux[9:].any()


@pytest.mark.parametrize("power", [3.0, 20.0, 400.0])
def test_powers_of_the_cosine_have_their_beam_and_codes(power):
    made = summarise(file_of(rotational(lambda g: np.maximum(np.cos(g), 0.0) ** power, 0.1)))
    expected = 2.0 * np.rad2deg(np.arccos(0.5 ** (1.0 / power)))
    assert made.beam_angles == pytest.approx((expected, expected), rel=1e-4)
    codes = [1.0 - c ** (power + 1.0) for c in (0.75, 0.5, 0.25)]
    assert made.flux_codes[:3] == pytest.approx(codes, abs=1e-5)


def test_a_globe_shines_alike_into_equal_solid_angles():
    made = summarise(file_of(rotational(lambda g: np.full_like(g, 10.0), 5.0)))
    assert made.total_flux == pytest.approx(40.0 * np.pi, rel=1e-12)
    assert made.flux_codes == pytest.approx([0.25, 0.5, 0.75, 0.5, 1.0], rel=1e-12)
    assert made.beam_angles == pytest.approx((360.0, 360.0))


def test_an_uplight_has_no_downward_code():
    made = summarise(file_of(rotational(lambda g: -np.cos(g))))
    assert made.flux_codes == pytest.approx([0.0, 0.0, 0.0, 0.0, 1.0])
    assert made.downward_fraction == 0.0
    assert made.beam_angles == pytest.approx((120.0, 120.0), abs=1e-3)
    assert made.peak_direction == (0.0, 180.0)


def test_darkness_has_no_ratios():
    made = summarise(file_of(rotational(lambda g: 0.0 * g)))
    assert made.total_flux == 0.0
    assert made.downward_fraction is None
    assert made.beam_angles == (None, None)


@pytest.mark.parametrize("photometric_type", ["A", "B"])
def test_types_a_and_b_have_the_fluxes_of_the_same_light_in_type_c(photometric_type):
    def lobe(towards):
        axis = np.array([np.sin(0.4), 0.2, -np.cos(0.4)])
        return 1000.0 * np.maximum(towards @ axis / np.linalg.norm(axis), 0.0) ** 12

    made = summarise(file_of(of_type(photometric_type, lobe, 0.5), photometric_type))
    azimuth, polar = np.deg2rad(np.arange(0, 361, 1.0)), np.deg2rad(np.arange(0, 180.1, 0.5))
    same = IntensityDistribution(azimuth, polar, lobe(directions(azimuth[:, None], polar[None, :])))
    wanted = summarise(file_of(same))
    assert made.total_flux == pytest.approx(wanted.total_flux, rel=2e-4)
    assert made.flux_codes == pytest.approx(wanted.flux_codes, abs=2e-4)
    assert made.zonal_flux == pytest.approx(wanted.zonal_flux, abs=3e-4 * made.total_flux)
    assert made.beam_angles == pytest.approx(wanted.beam_angles, abs=0.05)


@pytest.mark.parametrize("photometric_type", ["A", "B"])
def test_flux_in_cones_about_another_axis_is_the_integral_of_the_interpolant(photometric_type):
    made = of_type(photometric_type, lambda d: np.maximum(-d[..., 2], 0.0) ** 200 + 0.01, 5.0)
    cones = np.deg2rad([3.0, 12.0, 41.0, 90.0, 130.0, 180.0])
    gamma = (np.arange(3600) + 0.5) * np.pi / 3600
    around = (np.arange(720) + 0.5) * np.pi / 360
    rings = intensity(made, directions(around[None, :], gamma[:, None])).mean(1) * np.sin(gamma)
    sums = np.concatenate([[0.0], np.cumsum(rings) * 2.0 * np.pi**2 / 3600])
    wanted = np.interp(cones, np.linspace(0.0, np.pi, 3601), sums)
    assert flux_within(made, cones) == pytest.approx(wanted, rel=1e-4)
    assert flux_within(made, np.pi) == pytest.approx(flux(made), rel=1e-12)


def test_turning_and_mirroring_about_the_vertical_leaves_the_zones():
    made = planes([[5, 4, 3, 2, 1], [5, 9, 9, 4, 1], [5, 4, 0, 2, 1], [5, 4, 3, 7, 1]])
    cones = np.deg2rad([10.0, 41.4, 80.0])
    wanted = flux_within(made, cones)
    for moved in (turned(made, 0.7), mirrored(made)):
        assert flux_within(moved, cones) == pytest.approx(wanted, rel=1e-12)
    over = IntensityDistribution(made.azimuth, made.polar, made.intensity, np.diag([1.0, -1, -1]))
    assert flux_within(over, np.pi - cones) == pytest.approx(flux(made) - wanted, rel=1e-12)


@pytest.mark.parametrize("photometric_type", ["A", "B"])
def test_the_peak_of_types_a_and_b_is_told_in_both_ways(photometric_type):
    h, v = np.deg2rad([20.0, -35.0])
    # LM-75: beam -z, up +y, right +x.
    towards = {
        "A": np.array([np.cos(v) * np.sin(h), np.sin(v), -np.cos(v) * np.cos(h)]),
        "B": np.array([np.sin(h), np.cos(h) * np.sin(v), -np.cos(h) * np.cos(v)]),
    }[photometric_type]
    made = summarise(
        file_of(of_type(photometric_type, lambda d: d @ towards + 1.0), photometric_type)
    )
    assert made.peak_angles == pytest.approx((20.0, -35.0))
    c = np.rad2deg(np.arctan2(towards[1], towards[0])) % 360.0
    assert made.peak_direction == pytest.approx((c, np.rad2deg(np.arccos(-towards[2]))))


def test_the_peak_of_a_plane_beyond_180_keeps_its_c():
    made = planes([[5, 4, 3, 2, 1], [5, 4, 3, 2, 1], [5, 4, 3, 2, 1], [5, 4, 30, 2, 1]])
    summary = summarise(file_of(made))
    assert summary.peak == 30.0
    assert summary.peak_direction == pytest.approx((270.0, 40.0))
    assert summary.peak_angles is None


def test_both_wings_of_a_batwing_are_one_beam():
    wings = [100, 400, 1000, 400, 0]
    made = summarise(file_of(planes([wings] * 4)))
    # 500 cd between 40 and 60 degrees, 100 cd between 60 and 90 degrees, linear.
    assert made.beam_angles == pytest.approx([2 * (40 + 20 * 500 / 600)] * 2)
    assert made.field_angles == pytest.approx([2 * (60 + 30 * 300 / 400)] * 2)


def test_a_beam_aside_counts_from_edge_to_edge_and_a_dark_plane_has_none():
    dark = [0, 0, 0, 0, 0]
    made = summarise(file_of(planes([dark, [0, 0, 1000, 0, 0], dark, dark])))
    assert made.beam_angles[0] is None
    assert made.beam_angles[1] == pytest.approx(20.0)
    assert made.field_angles[1] == pytest.approx(36.0)


def test_of_light_up_and_down_the_larger_side_gives_the_beam():
    up = rotational(lambda g: np.where(g < np.pi / 2, 100 * np.cos(g), -200 * np.cos(g) ** 3))
    wanted = 2.0 * np.rad2deg(np.arccos(0.5 ** (1 / 3)))
    assert summarise(file_of(up)).beam_angles[0] == pytest.approx(wanted, abs=1e-2)
    equal = rotational(lambda g: 100.0 * np.abs(np.cos(g)))
    assert summarise(file_of(equal)).beam_angles[0] == pytest.approx(120.0, abs=1e-2)


def test_a_beam_that_ends_with_the_grid_ends_there():
    polar = np.deg2rad([0.0, 35.0])
    made = IntensityDistribution(np.zeros(1), polar, np.full((1, 2), 50.0))
    assert summarise(file_of(made)).beam_angles == pytest.approx((70.0, 70.0), abs=1e-3)


def test_light_alike_below_and_above_the_horizontal_has_a_beam():
    # As large at the horizontal, which belongs to both sides, as above it.
    above = IntensityDistribution(
        np.zeros(1), np.deg2rad([90.0, 135.0, 180.0]), np.full((1, 3), 9.0)
    )
    assert summarise(file_of(above)).beam_angles == pytest.approx((180.0, 180.0), abs=1e-3)
    # A globe with its cap: half the light at 20 degrees by the straight line from 0 to 40.
    globe = rotational(lambda g: np.interp(g, np.deg2rad([0.0, 40.0]), [0.0, 7.0]))
    assert summarise(file_of(globe)).beam_angles == pytest.approx((320.0, 320.0), abs=0.02)


def test_every_light_has_a_beam_wherever_its_maxima_are():
    rng = np.random.default_rng(7)
    azimuth = np.deg2rad([0.0, 90.0, 180.0, 270.0, 360.0])
    polar = np.deg2rad(np.linspace(0.0, 180.0, 9))
    for _ in range(300):
        # Few levels, so that maxima are alike in many places; alike to the last bit, or but for rounding.
        values = rng.integers(0, 3, (5, 9)) * rng.choice([1.0, 1.0 + 1e-12], (5, 9)) * 30.0
        values[-1] = values[0]
        made = summarise(file_of(IntensityDistribution(azimuth, polar, values)))
        for angle in (*made.beam_angles, *made.field_angles):
            assert angle is None or 0.0 < angle <= 360.0


def test_a_stated_number_next_to_nothing_gives_no_ratio():
    light = rotational(lambda g: 1000.0 * np.cos(g))
    made = summarise(file_of(light, is_absolute=False, stated_flux=1e-320, watts=1e-320))
    assert made.light_output_ratio is None
    assert made.efficacy is None
    assert np.isfinite(made.flux_codes).all()


def test_ratios_need_what_they_are_ratios_of():
    light = rotational(lambda g: 1000.0 * np.cos(g))
    relative = summarise(file_of(light, is_absolute=False, stated_flux=4000.0, watts=40.0))
    assert relative.light_output_ratio == pytest.approx(np.pi / 4, rel=1e-4)
    assert relative.flux_codes[4] == pytest.approx(np.pi / 4, rel=1e-4)
    assert relative.efficacy == pytest.approx(25.0 * np.pi, rel=1e-4)
    absolute = summarise(file_of(light, watts=0.0))
    assert absolute.light_output_ratio is None
    assert absolute.efficacy is None


def test_luminance_of_a_lambertian_face_is_the_same_from_everywhere():
    light = rotational(lambda g: 100.0 * np.cos(g), 0.1)
    made = summarise(file_of(light, opening=Opening("rectangle", (1.0, 0.5, 0.0))))
    assert made.luminance == pytest.approx(np.full((2, 3), 200.0), rel=1e-4)
    assert summarise(file_of(light)).luminance is None


def test_an_opening_seen_edge_on_has_no_luminance():
    light = rotational(lambda g: np.full_like(g, 100.0))
    made = summarise(file_of(light, opening=Opening("rectangle", (0.0, 0.5, 0.2), "x")))
    sines = np.sin(np.deg2rad([65.0, 75.0, 85.0]))
    assert made.luminance[0] == pytest.approx(1000.0 / sines)
    assert np.isnan(made.luminance[1]).all()
