"""Tables of glare ratings against the one that CIE 190 prints, and against what follows from the formula."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from folders import WILD
from lm63_files import made as lm63
from lm63_files import parsed

from lumenray.engine.analysis.glare import guth_position_index
from lumenray.engine.analysis.ugr_table import (
    REFLECTANCES,
    ROOMS,
    find_ugr_table,
    tabulated_position_index,
)
from lumenray.engine.errors import SceneError
from lumenray.engine.luminaires.distribution import scaled
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.scene.distribution import Opening

TABLES = WILD / "ugr"


def printed(name):
    """Table of a program or a standard: (19, 10), NaN where it only says that a value is below 10."""
    with (TABLES / name).open() as file:
        rows = [
            [np.nan if "<" in cell else float(cell) for cell in row]
            for row in csv.reader(file)
            if row
        ]
    return np.array(rows)


@pytest.fixture
def face():
    """Lambertian face of 1000 cd, 0.5 m x 1 m."""
    gamma = np.arange(0, 91, 5)
    values = " ".join(f"{1000.0 * np.cos(np.deg2rad(each)):.4f}" for each in gamma)
    angles = " ".join(map(str, gamma))
    return parsed(lm63(vertical=angles, candela=(values,), size="0.5 1 0"))


@pytest.mark.skipif(not TABLES.is_dir(), reason="needs the tables of CIE 190")
def test_the_table_of_the_standards_example_is_met():
    made = find_ugr_table(read_luminaire(TABLES / "sample_11.ldt"), spacing=1.0)
    apart = made.values.reshape(19, 10) - printed("ugr_table_11_cie190.csv")
    # The standard's own worksheet reckons with zones of 10 degrees and prints one decimal.
    assert np.abs(apart).max() < 0.2
    assert abs(apart.mean()) < 0.05


@pytest.mark.skipif(not TABLES.is_dir(), reason="needs tables of other programs")
@pytest.mark.parametrize("number", ["01", "02", "03", "04", "05"])
def test_tables_of_another_program_are_met(number):
    made = find_ugr_table(read_luminaire(TABLES / f"sample_{number}.ldt"))
    apart = made.values.reshape(19, 10) - printed(f"ugr_table_{number}_Relux.csv")
    assert np.nanmax(np.abs(apart)) < 0.3


def test_a_round_luminaire_is_rated_alike_across_and_along(face):
    square = replace(face, opening=Opening("rectangle", (0.5, 0.5, 0.0), "z"))
    values = find_ugr_table(square).values
    assert np.allclose(values[:, 0], values[:, 1], atol=1e-9)


def test_ten_times_the_flux_adds_eight(face):
    brighter = replace(face, distribution=scaled(face.distribution, 10.0))
    apart = find_ugr_table(brighter).values - find_ugr_table(face).values
    assert np.allclose(apart, 8.0, atol=1e-9)


def test_half_the_opening_adds_what_twice_the_luminance_does(face):
    half = replace(face, opening=Opening("rectangle", (0.5, 0.5, 0.0), "z"))
    whole = replace(face, opening=Opening("rectangle", (0.5, 1.0, 0.0), "z"))
    apart = find_ugr_table(half).values - find_ugr_table(whole).values
    assert np.allclose(apart, 8.0 * np.log10(2.0), atol=1e-9)


def test_interreflection_has_the_factors_that_the_standard_tabulates(face):
    """In 4H x 8H at 70/50/20, of light on plane and walls 0.115 and 0.211 return to the walls. (CIE 190, table 5)"""
    room = ROOMS.index((4, 8))
    found = find_ugr_table(face, spacing=1.0).backgrounds[
        room, :, REFLECTANCES.index((0.7, 0.5, 0.2))
    ]
    lumens = np.pi * 1000.0
    walls = 2.0 * 2.0 * (8.0 + 16.0)
    between = np.array([0.115, 0.211]) * 32.0 * lumens / walls / np.pi
    # Light of the face divides between the two.
    assert (found > between.min()).all()
    assert (found < between.max()).all()


def test_the_table_of_indices_is_that_of_the_formula_within_what_that_promises():
    aside, above = np.meshgrid(np.linspace(0.0, 2.0, 9), np.linspace(0.1, 1.5, 8))
    eccentricity = np.degrees(np.arctan(np.hypot(aside, above)))
    by_formula = guth_position_index(np.degrees(np.arctan2(aside, above)), eccentricity)
    assert np.abs(tabulated_position_index(aside, above) / by_formula - 1.0).max() < 0.13


def test_sources_outside_the_table_do_not_count():
    assert np.isnan(tabulated_position_index([3.1, 0.0, 0.0], [0.5, 2.0, 1.85])).all()
    # The last columns of the table have values from some rows on.
    assert tabulated_position_index(0.9, 1.9) == pytest.approx(16.0)


@pytest.mark.parametrize("spacing", [0.3, 0.01, 2.0])
def test_spacings_that_do_not_divide_the_height_are_refused(face, spacing):
    with pytest.raises(SceneError, match="part of H"):
        find_ugr_table(face, spacing)


def test_points_have_no_table(face):
    with pytest.raises(SceneError, match="no luminous opening"):
        find_ugr_table(replace(face, opening=Opening("point", (0.0, 0.0, 0.0), "z")))
