"""Scattering files of other programs: how much light there is, and what is told where it is too much."""

import numpy as np
import pytest
import scattering_files
from scattering_files import (
    SHARES,
    anisotropic,
    bsdf180,
    coated,
    handed,
    mdl,
    reflectance,
    scattering,
    simple,
    zemax,
)
from scattering_models import towards
from scattering_readings import assert_same, front_of, pairs, read_back, told

from lumenray.engine.scattering.data.evaluation import total
from lumenray.engine.scattering.data.table import (
    albedo_of,
    direct_share,
    direction_of,
    evaluate_table,
)
from lumenray.engine.scattering.readers.reader import Wish, parse_scattering


def test_zemax_blocks_are_scaled_to_their_totals():
    file = read_back(zemax(totals=(0.1, 0.2, 0.3)))
    table = file.sides["front_reflection"]
    shares = [albedo_of(table, np.radians(s))[0] for s in (0, 30, 60)]
    np.testing.assert_allclose(shares, [0.1, 0.2, 0.3], rtol=1e-5)
    np.testing.assert_allclose(file.stated["front_reflection"], [0.1, 0.2, 0.3])
    assert "were scaled" in told(file)


def test_zemax_keeps_the_luminous_value_of_colours():
    file = read_back(zemax(content="XYZ"))
    assert "colour is left out" in told(file)
    assert_same(file.sides["front_reflection"], handed, (0, 30, 60), 0.02)


def test_values_that_send_away_more_light_than_comes_are_told():
    file = read_back(zemax(lambda wi, wo: np.ones(len(wi)), totals=(0, 0, 0)))
    assert "sends away 3.14 times the light" in told(file)
    assert "divide by pi" in told(read_back(mdl(lambda wi, wo: np.ones(len(wi)))))


def test_negative_values_are_taken_as_nothing_and_told():
    file = read_back(zemax(lambda wi, wo: np.where(wo[:, 0] > 0.8, -1.0, 0.1), totals=(0, 0, 0)))
    assert file.sides["front_reflection"].values.min() == 0.0
    assert "are negative" in told(file)


def test_speos_spectrum_is_the_total_in_its_own_direction():
    file = read_back(anisotropic())
    table = file.sides["front_reflection"]
    np.testing.assert_allclose(total(table, np.radians(30.0)), [0.5, 0.25], rtol=3e-3)
    # In other directions values are as many times larger as the file has them.
    ratio = reflectance(handed, 60) / reflectance(handed, 30)
    assert total(table, np.radians(60.0))[0] == pytest.approx(0.5 * ratio, rel=5e-3)
    np.testing.assert_array_equal(file.stated["front_reflection"], [np.nan, 0.375, np.nan])


def test_missing_directions_are_told():
    assert "no values beyond 60 degrees" in told(read_back(anisotropic(thetas=range(0, 61, 6))))


def test_mixtures_have_the_shares_that_they_state():
    file = read_back(scattering())
    for side, part in (("front_reflection", 1.0), ("front_transmission", 0.1)):
        table = file.sides[side]
        for incidence, direct in ((0.0, 0.04), (60.0, 0.1)):
            wi = towards(np.array([incidence]), 0.0)
            assert direct_share(table, wi)[0, 0] == pytest.approx(part * direct, rel=1e-5)
            share = albedo_of(table, np.radians(incidence))[0]
            assert share == pytest.approx(part * 0.5, rel=5e-3)
    assert "taken as direct, Lambertian and Gaussian share" in told(file)


def test_simple_mixtures_share_what_is_not_absorbed():
    table = front_of(simple("20 30 60 20"))
    wi = towards(np.array([40.0]), 0.0)
    assert total(table, np.radians(40.0))[0] == pytest.approx(0.8, rel=5e-3)
    assert direct_share(table, wi)[0, 0] == pytest.approx(0.08, rel=1e-5)
    # Half of the lobe's top at half of its full width, in and across the plane of incidence.
    at, matt = np.array([0.0, 0.0, 0.0]), 0.8 * 0.3 / np.pi
    radial, azimuth = np.radians([0.0, 10.0, 10.0]), np.radians([0.0, 90.0, 180.0])
    wo = direction_of(at, radial, azimuth)
    top, side, ahead = evaluate_table(table, towards(np.zeros(3), 0.0), wo)[:, 0] - matt
    assert side / top == pytest.approx(0.5, rel=0.03)
    assert ahead / top == pytest.approx(0.5, rel=0.03)


def test_a_lambertian_mixture_has_the_same_value_everywhere():
    table = front_of(simple("0 100 0 5"))
    wi, wo = pairs((0.0, 40.0, 70.0))
    np.testing.assert_allclose(evaluate_table(table, wi, wo), 1.0 / np.pi, rtol=1e-5)
    assert list(read_back(simple(mode="Transmission")).sides) == ["front_transmission"]


def test_lobes_as_narrow_as_a_mirror_are_direct():
    wi = towards(np.array([30.0]), 0.0)
    assert direct_share(front_of(simple("0 40 60 0.1")), wi)[0, 0] == pytest.approx(0.6)


@pytest.mark.parametrize("data", [coated(), bsdf180()])
def test_coatings_are_direct_and_the_mean_of_both_polarisations(data):
    file = read_back(data)
    mean = 0.01 * SHARES.mean(axis=1)
    for k, kind in enumerate(("reflection", "transmission")):
        np.testing.assert_allclose(file.sides[f"front_{kind}"].direct[0], mean[..., k], atol=1e-6)
        assert not file.sides[f"front_{kind}"].values.any()
    if len(file.sides) > 2:
        np.testing.assert_allclose(
            file.sides["back_reflection"].direct[0], 0.5 * mean[..., 0], atol=1e-6
        )
    assert file.name.startswith("glass")


@pytest.mark.parametrize(
    "make", [scattering_files.lighttools, scattering_files.anisotropic, scattering_files.mdl]
)
def test_the_wanted_error_of_resampling_counts(make):
    coarse, fine = (
        next(iter(parse_scattering(make(), "x", Wish(e)).sides.values())) for e in (0.1, 0.01)
    )
    assert fine.error <= 0.01 < coarse.error <= 0.1
    assert fine.values.size > coarse.values.size
