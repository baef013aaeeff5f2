"""Scattering files of other programs: the direction that each value is for."""

import numpy as np
import pytest
from scattering_files import (
    alike,
    anisotropic,
    anisotropic_binary,
    brdf_text,
    handed,
    lighttools,
    mdl,
    reflectance,
    zemax,
)
from scattering_models import towards
from scattering_readings import assert_same, front_of, read_back, told

from lumenray.engine.scattering.data.evaluation import total
from lumenray.engine.scattering.data.table import albedo_of, evaluate_table


def test_zemax_values_are_for_the_directions_that_its_formula_states():
    assert_same(front_of(zemax()), handed, (0, 30, 60), 0.02)


def test_zemax_tables_of_one_side_are_mirrored():
    half = zemax(alike, azimuths=tuple(range(0, 181, 15)), symmetry="PlaneSymmetrical")
    table = front_of(half)
    assert table.azimuths[-1] == pytest.approx(np.pi)
    assert_same(table, alike, (0, 30, 60), 0.02)


def test_a_zemax_table_may_leave_out_the_last_line_of_azimuths():
    open_ended = front_of(zemax(azimuths=tuple(range(0, 360, 15))))
    np.testing.assert_allclose(open_ended.values, front_of(zemax()).values, atol=1e-5)


def test_zemax_keeps_odd_azimuths():
    # None of these lies at 180 degrees, where our azimuth begins.
    assert_same(front_of(zemax(azimuths=(0, *range(7, 360, 8), 360))), handed, (0, 30, 60), 0.02)


def test_zemax_rotations_are_those_of_the_normal_of_the_plane_of_incidence():
    turns = (0, 90, 180, 270)
    lines = zemax(symmetry="ASymmetrical4D", rotations=turns, totals=(0, 0, 0)).decode().split("\n")
    # Only light of the second block of rotations is scattered.
    blocks = [k for k, line in enumerate(lines) if line.startswith("TIS")]
    for number, start in enumerate(blocks):
        if number // 3 != 1:
            end = blocks[number + 1] if number + 1 < len(blocks) else len(lines) - 1
            for k in range(start + 1, end):
                lines[k] = " ".join(["0"] * 31)
    file = read_back("\n".join(lines).encode())
    table = file.sides["front_reflection"]
    assert "normal of the plane of incidence" in told(file)
    # The normal at 90 degrees: the plane is along x, and light comes from a right angle ahead.
    wi, wo = (
        towards(np.full(4, 30.0), np.array([0.0, 90.0, 180.0, 270.0])),
        towards(np.full(4, 5.0), 0.0),
    )
    np.testing.assert_array_equal(evaluate_table(table, wi, wo)[:, 0] > 0.0, [0, 0, 1, 0])


def test_zemax_btdf_is_transmission_about_the_straight_direction():
    file = read_back(zemax(kind="BTDF"))
    assert list(file.sides) == ["front_transmission"]
    assert_same(file.sides["front_transmission"], handed, (0, 30, 60), 0.02)


def test_zemax_values_hold_where_its_zeros_are_below_the_horizon():
    # Light at 60 degrees: the mirror's neighbours on the side of the horizon have no data beyond 90 degrees.
    wo = towards(np.array([86.0]), 180.0)
    wi = towards(np.array([60.0]), 0.0)
    flat = front_of(zemax(lambda wi, wo: np.full(len(wo), 0.2)))
    assert evaluate_table(flat, wi, wo)[0, 0] == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize("light", [90.0, 0.0, 270.0])
def test_lighttools_values_are_for_their_directions_wherever_light_comes_from(light):
    file = read_back(lighttools(light=light))
    assert ("brightest" in told(file)) == (light != 90.0)
    assert_same(file.sides["front_reflection"], handed, (0, 30, 60), 0.06)


def test_lighttools_planes_of_incidence_become_rotations():
    file = read_back(lighttools(incidences=(0, 45), planes=(0, 120, 240)))
    table = file.sides["front_reflection"]
    np.testing.assert_allclose(np.degrees(table.rotations), [90.0, 210.0, 330.0])
    assert_same(table, handed, (0, 45), 0.08, rotations=(90.0, 210.0, 330.0))


def test_lighttools_rows_may_be_angles_to_the_normal():
    lines = lighttools(incidences=(30,)).decode().split("\n")
    start = next(k for k, line in enumerate(lines) if line.startswith("TIS")) + 1
    rows = np.array([line.split() for line in lines[start:]])
    turned = "\n".join(lines[:start] + [" ".join(row) for row in rows.T])
    np.testing.assert_array_equal(
        front_of(turned.encode()).values, front_of("\n".join(lines).encode()).values
    )


@pytest.mark.parametrize(("side", "kind", "name"), [
    ("Back", "BRDF", "back_reflection"), ("Front", "BTDF", "front_transmission"), ("Back", "BTDF", "back_transmission"),
])  # fmt: skip
def test_lighttools_sides(side, kind, name):
    assert list(read_back(lighttools(side=side, kind=kind)).sides) == [name]


def test_lighttools_wavelengths_become_spectra():
    table = front_of(lighttools(bands=(400, 500, 650)))
    share = [total(table, np.radians(30.0))[k] for k in (0, -1)]
    assert share[1] / share[0] == pytest.approx(650 / 400, rel=1e-3)
    assert table.wavelengths[[0, -1]] == pytest.approx([400, 650])


@pytest.mark.parametrize("mirror", [0.0, 180.0])
@pytest.mark.parametrize("is_intensity", [False, True])
def test_speos_values_are_for_their_directions(mirror, is_intensity):
    file = read_back(anisotropic(mirror=mirror, is_intensity=is_intensity))
    table = file.sides["front_reflection"]
    assert ("azimuth 180" in told(file)) == (mirror == 180.0)
    factor = 0.5 / reflectance(handed, 30)
    assert_same(table, handed, (0, 30, 60), 0.06, factor)


def test_speos_binary_and_text_hold_the_same():
    text = anisotropic(is_intensity=True, spectrum=((400, 50.0), (700, 50.0)))
    np.testing.assert_allclose(
        front_of(anisotropic_binary()).values, front_of(text).values, rtol=1e-4
    )


def test_speos_sample_angles_become_rotations_all_around():
    table = front_of(
        anisotropic(turns=(0, 45, 90), factors=(1.0, 2.0, 3.0), spectrum=((400, 10.0),))
    )
    np.testing.assert_allclose(np.degrees(table.rotations), np.arange(0, 360, 45))
    shares = [albedo_of(table, np.radians(30.0), p)[0] for p in table.rotations]
    np.testing.assert_allclose(shares, 0.1 * np.array([1, 2, 3, 2, 1, 2, 3, 2]), rtol=0.01)


def test_speos_sample_angles_with_the_same_values_are_one():
    file = read_back(anisotropic(turns=(0, 90, 180)))
    assert len(file.sides["front_reflection"].rotations) == 1
    assert "same values at all anisotropy angles" in told(file)


def test_speos_brdf_holds_both_sides_of_a_pane():
    file = read_back(brdf_text())
    for side, factor in (("front_reflection", 0.5), ("front_transmission", 0.125)):
        assert_same(file.sides[side], handed, (0, 30, 60), 0.06, factor)
        shares = total(file.sides[side], np.radians(30.0))
        np.testing.assert_allclose(
            shares, factor * reflectance(handed, 30) * np.array([1, 2]), rtol=2e-3
        )


def test_mdl_values_are_for_their_directions():
    def skewed(wi, wo):
        # Not reciprocal, so that the axes of both angles cannot be exchanged.
        return alike(wi, wo) * (1.0 + wi[:, 2])

    table = front_of(mdl(skewed))
    assert_same(table, skewed, (3.0, 33.0, 63.0), 0.06)


def test_mdl_holds_both_sides():
    file = read_back(
        mdl(lambda wi, wo: np.full(len(wi), 0.25 / np.pi), marks=("_REFLECTION", "_TRANSMISSION"))
    )
    assert list(file.sides) == ["front_reflection", "front_transmission"]
    for table in file.sides.values():
        assert total(table, np.radians(45.0))[0] == pytest.approx(0.25, rel=1e-3)
