"""EULUMDAT files as they are read: every symmetry, what describes the luminaire, and files of makers."""

import numpy as np
import pytest
from eulumdat_files import (
    DIRECTIONS,
    EIGHT,
    NAMES,
    SAMPLES,
    changed,
    parsed,
    plane_values,
    remarks_of,
    small,
)
from folders import WILD

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.direct_ratios import ROOM_INDICES, direct_ratios
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.eulumdat.lamps import colour_temperature
from lumenray.engine.luminaires.formats.eulumdat.reader import parse_eulumdat
from lumenray.engine.luminaires.formats.eulumdat.writer import write_eulumdat
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.luminaires.formats.record import LampSet
from lumenray.engine.scene.distribution import IntensityDistribution, Opening

DATA = WILD / "ldt"


@pytest.mark.parametrize("isym", SAMPLES)
def test_stored_planes_stand_for_the_whole_turn(isym):
    rows, expected = SAMPLES[isym]
    file = parsed(small(isym, rows))
    assert np.allclose(plane_values(file, EIGHT), expected)
    assert file.symmetry == NAMES[isym]
    assert not remarks_of(file)


def test_absolute_data_are_scaled_by_the_flux_too():
    file = parsed(small(2, SAMPLES[2][0], lamps=(-1, "LED", 2500)))
    assert np.allclose(plane_values(file, EIGHT), 2.5 * np.array(SAMPLES[2][1]))
    assert file.is_absolute
    assert file.stated_flux == 2500.0
    assert file.lamps[0].count == 1


def test_c0_points_along_x_c90_along_y_and_polar_angles_count_from_below():
    rows = [[0, 10, 0], [0, 20, 0], [0, 30, 0], [0, 40, 0]]
    file = parsed(small(0, rows, planes=[0, 90, 180, 270]))
    axes = np.array([[1, 0, -1], [0, 1, -1], [-1, 0, -1], [0, -1, -1]])
    assert np.allclose(intensity(file.distribution, axes), [10, 20, 30, 40])


def test_a_uniform_distribution_has_the_flux_of_its_sphere():
    file = parsed(small(1, [[100, 100, 100]], polars=(0, 90, 180), lamps=(2, "T8", 3000)))
    assert flux(file.distribution) == pytest.approx(4 * np.pi * 300)


def test_the_conversion_factor_counts_and_the_light_output_ratio_does_not():
    lines = changed(24, "0,5", isym=1, rows=[[100, 80, 0]])
    lines[22] = "40 %"
    assert plane_values(parsed(lines), [0]) == pytest.approx(40.0)


def test_light_that_goes_only_up_stays_up():
    file = parsed(small(1, [[50, 50, 50]], polars=(90, 135, 180)))
    assert flux(file.distribution) == pytest.approx(2 * np.pi * 50)
    assert intensity(file.distribution, [[0, 0, -1], [1, 0, -0.01]]) == pytest.approx([0, 0])


@pytest.mark.parametrize(
    ("length", "width", "heights", "opening"),
    [
        (0, 0, (0, 0, 0, 0), Opening()),
        (1150, 250, (0, 0, 0, 0), Opening("rectangle", (0.25, 1.15, 0.0), "z")),
        (1150, 250, (40, 40, 40, 40), Opening("box", (0.25, 1.15, 0.04), "z")),
        (300, 0, (0, 0, 0, 0), Opening("ellipse", (0.3, 0.3, 0.0), "z")),
        (300, 0, (50, 50, 50, 50), Opening("cylinder", (0.3, 0.3, 0.05), "z")),
    ],
)
def test_the_luminous_area_becomes_a_body_with_its_length_along_y(length, width, heights, opening):
    lines = small()
    lines[15:21] = [length, width, *heights]
    file = parsed(lines)
    assert file.opening == opening
    assert file.housing == (0.3, 1.2, 0.06)


def test_uneven_heights_are_averaged_with_a_remark():
    lines = small()
    lines[17:21] = [11, 12, 13, 14]
    file = parsed(lines)
    assert file.opening.size[2] == pytest.approx(0.0125)
    assert [(r.line, "mean of 12.5 mm" in r.text) for r in remarks_of(file)] == [(18, True)]


def test_a_round_housing_has_a_width_of_0():
    assert parsed(changed(14, 0)).housing == (1.2, 0.0, 0.06)


def test_what_describes_the_luminaire_is_kept():
    lines = small(lamps=(2, "T16 54 W", 8100))
    lines[0], lines[8] = "Größe & Co", "Lüster"
    lines[21:23] = [100, 40.3]
    lines[24] = 15
    for encoding in ("latin-1", "utf-8", "utf-8-sig"):
        file = parsed(lines, encoding=encoding)
        assert file.metadata == {
            "MANUFAC": "Größe & Co",
            "TEST": "R1",
            "LUMINAIRE": "Lüster",
            "LUMCAT": "L-1",
            "_FILE": "lamp.ldt",
            "ISSUEDATE": "2024-05-06/us",
            "_MEASUREMENT_TILT": "15",
        }
    assert file.lamps == (LampSet(2, 8100.0, 12.5, 4000.0, "T16 54 W", "4000 K", "80"),)
    assert file.light_output_ratio == pytest.approx(0.403)
    assert (file.watts, file.downward_fraction) == (12.5, 1.0)
    assert "tilt of 15 degrees" in str(file.remarks)


@pytest.mark.parametrize(
    ("text", "kelvin"),
    [
        *[("4000 K", 4000), ("3000K", 3000), ("tw/6500", 6500), ("840", 4000), ("LED 930", 3000)],
        *[("3 000 K", 3000), ("2.700 K", 2700), ("827/830", 2700), ("5079", 5079)],
        *[("", None), ("0", None), ("warm white", None), ("100", None), ("40000", None)],
    ],
)
def test_the_colour_temperature_is_found_in_the_text(text, kelvin):
    assert colour_temperature(text) == kelvin


SETS = [(1, "Single", 500, "3000", "90", 15), (2, "Double", 1200, "2700", "", 30)]


def with_sets(order):
    lines = small(1, [[100, 80, 0]])
    lines[25] = 2
    if order == "set":
        lines[26:32] = [item for lamp in SETS for item in lamp]
    else:
        lines[26:32] = [lamp[item] for item in range(6) for lamp in SETS]
    return lines


@pytest.mark.parametrize("order", ["set", "column"])
def test_several_lamp_sets_are_read_and_the_first_counts(order):
    file = parsed(with_sets(order))
    assert [(lamp.count, lamp.name, lamp.luminous_flux) for lamp in file.lamps] == [
        (1, "Single", 500.0),
        (2, "Double", 1200.0),
    ]
    assert [lamp.watts for lamp in file.lamps] == [15.0, 30.0]
    assert plane_values(file, [0]) == pytest.approx(40.0)
    assert [r.line for r in remarks_of(file)] == ([] if order == "set" else [27])


def test_direct_ratios_of_a_lambertian_luminaire_are_those_of_two_facing_squares():
    polar = np.linspace(0.0, np.pi / 2, 181)
    lambertian = IntensityDistribution(np.zeros(1), polar, np.cos(polar)[None])
    a = 2.0 * np.array(ROOM_INDICES)
    root = np.sqrt(1 + a**2)
    # Configuration factor of parallel squares of side a at distance 1 (J. R. Howell, C-11).
    expected = (np.log((1 + a**2) / np.sqrt(1 + 2 * a**2)) + 2 * a * root * np.arctan(a / root)) * 2
    expected = (expected - 4 * a * np.arctan(a)) / (np.pi * a**2)
    assert direct_ratios(lambertian) == pytest.approx(expected, abs=3e-4)


def real(name):
    path = DATA / name
    if not path.exists():
        pytest.skip(f"{path} is absent")
    return path


@pytest.mark.parametrize(
    "name", ["eul_fluorescent_luminaire", "eul_projector", "eul_road_luminaire"]
)
def test_direct_ratios_agree_with_those_that_makers_state(name):
    path = real(f"{name}.ldt")
    stated = np.array([float(line) for line in path.read_text("latin-1").splitlines()[32:42]])
    assert direct_ratios(read_luminaire(path).distribution) == pytest.approx(stated, abs=0.013)


@pytest.mark.parametrize("path", sorted(DATA.glob("*.ldt")), ids=lambda path: path.stem)
def test_real_files_are_read_and_written_or_refused_at_a_line(path):
    if path.stem == "lux_synthetic_basic_broken":
        with pytest.raises(FileFormatError, match="several values on one line") as caught:
            read_luminaire(path)
        assert caught.value.line == 48
        return
    file = read_luminaire(path)
    back = parse_eulumdat(write_eulumdat(file)[0], "back.ldt")
    before, after = (intensity(f.distribution, DIRECTIONS) for f in (file, back))
    assert np.abs(after - before).max() < 1e-4 * before.max()


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [
        # Real makers' files: the flux of the intensities is the stated share of the lamps'.
        ("eul_FL_MAX_600W_SYM30", 0.002),
        ("eul_FL_MAX_1200W_SYM10", 0.002),
        ("eul_FL_MAX_1200W_ASYM", 0.002),
        ("eul_demo_two_lamp_sets", 0.01),
        ("eul_road_luminaire", 0.01),
        ("luxpy_Isym2", 0.002),
        ("luxpy_Isym4_43cef5d7", 0.002),
        ("luxpy_test_lid_file", 0.002),
    ],
)
def test_computed_light_output_ratios_are_the_stated_ones(name, tolerance):
    file = read_luminaire(real(f"{name}.ldt"))
    ratio = flux(file.distribution) / file.stated_flux
    assert ratio == pytest.approx(file.light_output_ratio, rel=tolerance)


def test_two_measurements_of_one_luminaire_with_and_without_symmetry_agree():
    whole, quarter = (read_luminaire(real(f"qs_sample_isym{i}.ldt")) for i in (0, 4))
    assert flux(whole.distribution) == pytest.approx(flux(quarter.distribution), rel=1e-4)
    signs = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]])
    before = np.mean([intensity(whole.distribution, DIRECTIONS * s) for s in signs], axis=0)
    after = intensity(quarter.distribution, DIRECTIONS)
    assert np.abs(after - before).max() < 1e-3 * before.max()
