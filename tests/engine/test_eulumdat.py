"""EULUMDAT files: every symmetry, every departure that is tolerated, every one that is refused, and writing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lumenray.engine.errors import FileFormatError, LumenrayError
from lumenray.engine.luminaires.coordinates import FRAMES, directions
from lumenray.engine.luminaires.direct_ratios import ROOM_INDICES, direct_ratios
from lumenray.engine.luminaires.distribution import flux, intensity, mirrored, turned
from lumenray.engine.luminaires.formats.eulumdat.reader import (
    colour_temperature,
    parse_eulumdat,
    read_eulumdat,
)
from lumenray.engine.luminaires.formats.eulumdat.writer import write_eulumdat
from lumenray.engine.luminaires.formats.record import LampSet, LuminaireFile, TiltTable
from lumenray.engine.scene.distribution import IntensityDistribution, Opening

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "ldt"

EIGHT = [0, 45, 90, 135, 180, 225, 270, 315]
"""C-planes of the small samples; the polar angles are 0, 45, 90."""

RATIOS = 32
"""Place of the first direct ratio in the lines of a file with one lamp set, from 0."""


def small(isym=0, rows=None, planes=EIGHT, polars=(0, 45, 90), lamps=(1, "LED", 1000)):
    """Lines of a file that departs from nothing but has a computed flux that LORL and DFF do not state."""
    rows = [[100, 80, 0]] * len(planes) if rows is None else rows
    count, name, lumens = lamps
    steps = [np.diff(angles) for angles in (planes, polars)]
    dc, dg = (s[0] if len(s) and np.ptp(s) == 0 else 0 for s in steps)
    return [
        *("A & B", 1 if isym == 1 else 2, isym, len(planes), dc, len(polars), dg),
        *("R1", "Lamp", "L-1", "lamp.ldt", "2024-05-06/us"),
        *(1200, 300, 60, 1150, 250, 0, 0, 0, 0),
        *("", "", 1, 0, 1),
        *(count, name, lumens, "4000 K", "80", 12.5),
        *[0.5] * 10,
        *planes,
        *polars,
        *[value for row in rows for value in row],
    ]


def as_bytes(lines, end="\r\n", encoding="latin-1"):
    return end.join(map(str, lines)).encode(encoding)


def parsed(lines, **kinds):
    return parse_eulumdat(as_bytes(lines, **kinds), "a.ldt")


def changed(line, text, **kinds):
    """Lines with one replaced; ``line`` counts from 1."""
    lines = small(**kinds)
    lines[line - 1] = text
    return lines


def plane_values(file, azimuths, polar=45.0):
    direction = directions(np.deg2rad(np.asarray(azimuths, dtype=float)), np.deg2rad(polar))
    return intensity(file.distribution, direction)


def remarks_of(file):
    """Remarks but those on the two blank fractions of `small`."""
    return [r for r in file.remarks if "fraction DFF" not in r.text]


def refused(lines, **kinds):
    with pytest.raises(FileFormatError) as caught:
        parsed(lines, **kinds)
    assert str(caught.value).startswith("a.ldt")
    return caught.value


# The values at 45 degrees from C0 to C315 that the format's description demands.
SAMPLES = {
    4: ([[300, v, 0] for v in (200, 180, 160)], [200, 180, 160, 180, 200, 180, 160, 180]),
    3: ([[300, v, 0] for v in (70, 80, 90, 100, 110)], [90, 100, 110, 100, 90, 80, 70, 80]),
    2: ([[300, v, 0] for v in (10, 20, 30, 40, 50)], [10, 20, 30, 40, 50, 40, 30, 20]),
    1: ([[300, 77, 0]], [77] * 8),
    0: ([[300, v, 0] for v in range(1, 9)], [1, 2, 3, 4, 5, 6, 7, 8]),
}
NAMES = {4: "quadrant", 3: "C90-C270", 2: "C0-C180", 1: "rotational", 0: "none"}


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
    assert file.length_axis == "y"


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


TOLERATED = {
    "decimal commas": (lambda a: [str(x).replace(".", ",") for x in a], 5, "decimal comma"),
    "units": (lambda a: [*a[:12], "1200 mm", "30cm", *a[14:]], 13, "'mm'"),
    "thousands": (lambda a: [*a[:28], "1 000,0 lm", *a[29:]], 29, "1000"),
    "blank number": (lambda a: [*a[:23], "", *a[24:]], 24, "taken as 1"),
    "blank lengths": (
        lambda a: [*a[:12], "", "", *a[14:]],
        13,
        "length of the luminaire, the width",
    ),
    "no ratios": (lambda a: [*a[:RATIOS], *a[RATIOS + 10 :]], 33, "0 direct ratios"),
    "blank ratios": (lambda a: [*a[:RATIOS], *[""] * 10, *a[RATIOS + 10 :]], 43, "0 direct"),
    "a ratio more": (lambda a: [*a[:RATIOS], 0.4, *a[RATIOS:]], 33, "11 direct ratios"),
    "first plane 360": (lambda a: [*a[:42], 360, *a[43:]], 43, "begins with 360"),
    "wrong Dc": (lambda a: [*a[:4], 15, *a[5:]], 5, "step of 22.5"),
    "Dg of 0": (lambda a: [*a[:6], 0, *a[7:]], 7, "step of 45"),
    "a word behind": (lambda a: [*a, "", "end"], None, "behind the values"),
    "Ityp 1": (lambda a: [a[0], 1, *a[2:]], 3, "Isym 0 counts"),
    "a height of nonsense": (lambda a: [*a[:14], -1, *a[15:]], 15, "taken as 0"),
    "LORL of 0": (lambda a: [*a[:22], 0, *a[23:]], 23, "not stated"),
    "negative watts": (lambda a: [*a[:31], -5, *a[32:]], 32, "not stated"),
    "blank lamp count": (lambda a: [*a[:26], "", *a[27:]], 27, "unknown"),
}


@pytest.mark.parametrize("what", TOLERATED)
def test_departures_are_read_as_meant_with_a_remark_and_its_line(what):
    change, line, words = TOLERATED[what]
    planes = [22.5 * i for i in range(16)]
    rows = [[300, 10 + i, 0] for i in range(16)]
    lines = small(0, rows, planes)
    file = parsed(change(lines))
    assert np.allclose(plane_values(file, planes), 10 + np.arange(16))
    (remark,) = remarks_of(file)[:1]
    assert words in remark.text
    assert remark.line == (line or len(lines) + 2)


@pytest.mark.parametrize("end", ["\n", "\r", "\r\r\n", "\r\n\r\n"])
def test_any_end_of_line_is_taken(end):
    rows, expected = SAMPLES[4]
    file = parsed(small(4, rows), end=end)
    assert np.allclose(plane_values(file, EIGHT), expected)
    assert ("every other line" in str(file.remarks)) == (len(end) > 2)


def test_nothing_counts_behind_the_end_mark_of_old_programs():
    data = as_bytes(small()) + b"\r\n\x1a\r\n17\r\n"
    assert parse_eulumdat(data, "a.ldt").symmetry == "none"


def test_a_size_in_metres_is_not_taken_for_millimetres():
    file = parsed(changed(16, "1.15 m"))
    assert file.opening.size[1] == pytest.approx(1.15)


@pytest.mark.parametrize(("isym", "agrees"), [(4, True), (2, True), (3, False)])
def test_all_planes_may_be_stored_although_a_symmetry_is_stated(isym, agrees):
    values = [10, 20, 30, 20, 10, 20, 30, 20] if agrees else [1, 2, 3, 4, 5, 6, 7, 8]
    file = parsed(small(isym, [[100, v, 0] for v in values]))
    assert np.allclose(plane_values(file, EIGHT), values)
    assert file.symmetry == (NAMES[isym] if agrees else "none")
    (remark,) = remarks_of(file)
    assert remark.line == 54
    assert ("not symmetric" in remark.text) != agrees


@pytest.mark.parametrize(
    ("planes", "values"),
    [
        # The whole list, turned, and only the stored part of it.
        ([90, 135, 180, 225, 270, 315, 0, 45], [110, 100, 90, 80, 70]),
        ([90, 135, 180, 225, 270], [110, 100, 90, 80, 70]),
        ([270, 315, 0, 45, 90], [70, 80, 90, 100, 110]),
    ],
)
def test_planes_of_isym_3_are_taken_in_the_order_in_which_they_are_listed(planes, values):
    file = parsed(small(3, [[300, v, 0] for v in values], planes))
    assert np.allclose(plane_values(file, EIGHT), SAMPLES[3][1])
    assert any(f"begins at {planes[0]}" in r.text for r in file.remarks)


def test_only_the_stored_part_of_the_planes_may_be_listed():
    file = parsed(small(4, SAMPLES[4][0], planes=[0, 45, 90]))
    assert np.allclose(plane_values(file, EIGHT), SAMPLES[4][1])


def test_uneven_angles_are_interpolated_between_their_own_neighbours():
    planes, polars = [0, 10, 90, 180, 270], [0, 30, 90]
    rows = [[60, v, 0] for v in (0, 100, 20, 20, 20)]
    file = parsed(small(0, rows, planes, polars))
    assert plane_values(file, [5.0, 50.0], 30.0) == pytest.approx([50.0, 60.0])
    assert plane_values(file, [10.0], 60.0) == pytest.approx(50.0)
    assert not remarks_of(file)


def test_a_single_plane_of_isym_0_goes_all_around_with_a_remark():
    file = parsed(small(0, [[100, 80, 0]], planes=[0]))
    assert file.symmetry == "rotational"
    assert "single C-plane" in str(file.remarks)


def test_planes_that_differ_at_the_pole_get_their_mean():
    file = parsed(small(0, [[100 + 20 * (i % 2), 80, 0] for i in range(8)]))
    assert intensity(file.distribution, [[0.0, 0.0, -1.0]]) == pytest.approx(110.0)
    assert "at a pole" in str(file.remarks)


REFUSED = {
    "no file": ([], None, "empty"),
    "end in the head": (small()[:15], 15, "the file ends where the length of the luminous area"),
    "end in the lamps": (small()[:29], 29, "lamp sets of 6 lines are expected"),
    "end in the planes": (small()[:45], 45, "ends in the C-planes"),
    "end before the intensities": (small()[:53], 53, "ends in the polar angles or intensities"),
    "text broken into two": ([*small()[:1], "and more", *small()[1:]], 2, "broken into two lines"),
    "Isym 5": (changed(3, 5), 3, "0 to 4, found 5"),
    "blank Isym": (changed(3, ""), 3, "0 to 4, found a blank line"),
    "Mc 0": (changed(4, 0), 4, "1 to 3601, found 0"),
    "huge Mc": (changed(4, 99999999), 4, "found 1e+08"),
    "half a plane": (changed(4, 7.5), 4, "found 7.5"),
    "Ng 1": (changed(6, 1), 6, "2 to 1801"),
    "a size of words": (changed(13, "long"), 13, "length of the luminaire, a number in mm"),
    "a foreign unit": (changed(13, "12 ft"), 13, "in mm, found '12 ft'"),
    "thousands by commas": (changed(29, "1.234,5"), 29, "found '1.234,5'"),
    "factor 0": (changed(24, 0), 24, "conversion factor"),
    "factor NaN": (changed(24, "nan"), 24, "found 'nan'"),
    "no lamps": (changed(26, 0), 26, "no lamp set"),
    "many lamp sets": (changed(26, 21), 26, "0 to 20"),
    "flux of 0": (changed(29, 0), 29, "0 lm as flux of the lamps of lamp set 1"),
    "negative flux": (changed(29, -5), 29, "-5 lm"),
    "flux of words": (changed(29, "bright"), 29, "found 'bright'"),
    "half a lamp": (changed(27, 1.5), 27, "number of lamps of lamp set 1, found 1.5"),
    "planes descending": (changed(45, 20), 45, "20 as C-plane 3 of 8"),
    "plane beyond the turn": (changed(50, 400), 50, "400 as C-plane 8 of 8"),
    "polar angles descending": (changed(52, 0), 52, "0 as polar angle 2 of 3"),
    "polar angle beyond": (changed(53, 200), 53, "200 as polar angle 3"),
    "negative intensities": (changed(60, -3), 60, "1 negative intensities, the least -3"),
    "NaN": (changed(60, "NaN"), 60, "an angle or an intensity, a number, found 'NaN'"),
    "infinite": (changed(60, "1e999"), 60, "found '1e999'"),
    "several on a line": (changed(60, "1 2 3"), 60, "several values on one line ('1 2 3')"),
    "one too few": (small()[:-1], 76, "23 intensities, expected 24 (8 planes of 3 for Isym 0"),
    "one too many": ([*small(), 5], 78, "25 intensities, expected 24"),
    "all dark": (small(rows=[[0, 0, 0]] * 8), 54, "all intensities are 0"),
    "too bright": (changed(60, 1e13), 54, "outside 1e-12 to 1e+12 cd"),
    "hardly any flux": (
        [*changed(29, "1e-300")[:23], "1e-300", *changed(29, "1e-300")[24:]],
        54,
        "outside 1e-12",
    ),
    "a quarter without symmetry": (
        small(0, [[9, 8, 0]] * 3, planes=[0, 45, 90]),
        43,
        "span of 360; Isym 4 would fit",
    ),
    "a half without symmetry": (
        small(0, [[9, 8, 0]] * 5, planes=[0, 45, 90, 135, 180]),
        43,
        "Isym 2 or 3 would fit",
    ),
    "an eighth": (small(4, [[9, 8, 0]] * 2, planes=[0, 15]), 43, "span of 90"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_read_safely_is_refused_with_line_and_expectation(what):
    lines, line, words = REFUSED[what]
    error = refused(lines)
    assert words in str(error)
    assert error.line == line


@pytest.mark.parametrize(
    ("stored", "stated", "fitting"),
    [(8, 4, "Isym 0"), (5, 0, "Isym 2 or 3"), (3, 2, "Isym 4"), (1, 0, "Isym 1")],
)
def test_the_symmetry_that_would_fit_the_number_of_values_is_named(stored, stated, fitting):
    lines = small(stated, [[9, 8, 0]] * stored)
    if stored == 8:
        # All planes are tolerated, so one list more.
        lines = small(stated, [[9, 8, 0]] * 8 + [[9, 8, 0]])
        assert f"27 intensities, expected 9 (3 planes of 3 for Isym {stated}" in str(refused(lines))
    else:
        assert str(refused(lines)).endswith(f"their number fits {fitting}")


def test_a_wrong_light_output_ratio_and_downward_fraction_are_remarked_on():
    lines = small(1, [[100, 100, 100]], polars=(0, 90, 180))
    right = 100 * 4 * np.pi * 100 / 1000
    lines[21:23] = [50, f"{right:.1f}"]
    assert not parsed(lines).remarks
    lines[21:23] = [56, f"{0.94 * right:.1f}"]
    texts = {r.line: r.text for r in parsed(lines).remarks}
    assert "50.0 % of the flux goes downwards, but DFF says 56 %" in texts[22]
    assert "125.7 % of the lamps' 1000 lm, but LORL says 118.1 %" in texts[23]


def test_the_flux_of_an_empty_form_is_remarked_on():
    (remark,) = remarks_of(parsed(small(lamps=(1, "", 1))))
    assert (remark.line, "empty form" in remark.text) == (29, True)


# ---- writing ----


def random_file(seed):
    """A luminaire with a random grid and symmetry, absolute or relative."""
    rng = np.random.default_rng(seed)
    symmetry = list(NAMES.values())[seed % 5]
    inner = np.sort(rng.choice(np.arange(5, 90, 2.5), rng.integers(1, 6), replace=False))
    quarter = np.concatenate([[0.0], inner, [90.0]])
    table = {}
    for azimuth in np.unique(
        np.concatenate([quarter, 180 - quarter, 180 + quarter, 360 - quarter])
    ):
        key = {
            "rotational": lambda _: 0.0,
            "quadrant": lambda c: round(min(c % 180, -c % 180), 6),
            "C0-C180": lambda c: round(min(c % 360, -c % 360), 6),
            "C90-C270": lambda c: round(min((c - 90) % 360, (90 - c) % 360), 6),
            "none": lambda c: round(c % 360, 6),
        }[symmetry](azimuth)
        table.setdefault(key, []).append(azimuth)
    polar = np.unique([0.0, *rng.choice(np.arange(1, 180, 0.5), 12, replace=False), 180.0])
    rows = {}
    peak = 10.0 ** rng.uniform(1, 6)
    for azimuths in table.values():
        row = peak * rng.random(len(polar)) ** 3
        row[[0, -1]] = 0.5 * peak
        rows.update(dict.fromkeys(azimuths, row))
    azimuth = np.array(sorted(rows))
    values = np.array([rows[a] for a in azimuth])
    if symmetry == "rotational":
        azimuth, values = azimuth[:1], values[:1]
    distribution = IntensityDistribution(np.deg2rad(azimuth), np.deg2rad(polar), values)
    absolute = bool(rng.integers(2))
    total = flux(distribution)
    return LuminaireFile(
        "made",
        "C",
        symmetry,
        distribution,
        Opening("rectangle", (0.1, 1.5, 0.0), "z"),
        azimuth,
        polar,
        absolute,
        stated_flux=None if absolute else total * rng.uniform(0.3, 3.0),
        watts=30.0,
        lamps=(LampSet(2, None, 30.0, 3000.0, "LED", "", "90"),),
        housing=(0.12, 1.6, 0.05),
        length_axis="y",
        metadata={"MANUFAC": "Öst", "LUMINAIRE": "One\ntwo", "LUMCAT": "x" * 90},
    )


DIRECTIONS = directions(
    np.deg2rad(np.arange(0.0, 360.0, 3.7))[:, None], np.deg2rad(np.arange(0.0, 180.1, 1.3))
)


@pytest.mark.parametrize("seed", range(20))
def test_what_is_written_is_read_back(seed):
    file = random_file(seed)
    data, remarks = write_eulumdat(file)
    back = parse_eulumdat(data, "back.ldt")
    before, after = (intensity(f.distribution, DIRECTIONS) for f in (file, back))
    assert np.abs(after - before).max() < 1e-4 * before.max()
    assert back.symmetry == file.symmetry
    assert not back.remarks
    assert (back.opening, back.housing) == (file.opening, file.housing)
    assert back.is_absolute == file.is_absolute
    total = flux(file.distribution)
    assert back.stated_flux == pytest.approx(file.stated_flux or total, rel=1e-5)
    assert back.light_output_ratio == pytest.approx(total / (file.stated_flux or total), abs=1e-4)
    down = flux(file.distribution, 0.0, np.pi / 2) / total
    assert back.downward_fraction == pytest.approx(down, abs=1e-4)
    assert back.lamps[0].colour_temperature == 3000.0
    assert back.metadata["LUMINAIRE"] == "One two"
    assert [r.text for r in remarks] == [f"the text '{'x' * 20}...' is cut to 78 characters"]
    assert back.metadata["LUMCAT"] == "x" * 78


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    "change", [lambda d: turned(d, 0.7), mirrored, lambda d: turned(mirrored(d), -2.0)]
)
def test_a_turned_or_mirrored_luminaire_is_written_as_it_shines(seed, change):
    file = random_file(seed)
    file = replace(file, distribution=change(file.distribution))
    back = parse_eulumdat(write_eulumdat(file)[0], "back.ldt")
    before, after = (intensity(f.distribution, DIRECTIONS) for f in (file, back))
    assert np.abs(after - before).max() < 1e-4 * before.max()


@pytest.mark.parametrize("kind", ["A", "B"])
def test_other_coordinate_systems_are_brought_onto_c_planes_and_it_is_said(kind):
    azimuth = np.deg2rad(np.arange(-90.0, 91.0, 5.0))
    polar = np.deg2rad(np.arange(0.0, 181.0, 5.0))
    beam = directions(azimuth[:, None], polar, FRAMES[kind])
    values = 1000.0 * np.maximum(-beam[..., 2], 0.0) ** 2
    distribution = IntensityDistribution(azimuth, polar, values, FRAMES[kind])
    data, remarks = write_eulumdat(
        replace(random_file(0), distribution=distribution, photometric_type=kind)
    )
    back = parse_eulumdat(data, "back.ldt").distribution
    before, after = intensity(distribution, DIRECTIONS), intensity(back, DIRECTIONS)
    assert np.abs(after - before).max() < 0.006 * before.max()
    assert flux(back) == pytest.approx(flux(distribution), rel=2e-3)
    assert "brought onto C-planes every 5 and polar angles every 5 degrees" in remarks[0].text


def test_a_luminaire_without_light_is_not_written():
    file = random_file(0)
    dark = replace(file.distribution, intensity=0.0 * file.distribution.intensity)
    with pytest.raises(LumenrayError, match="emits nothing"):
        write_eulumdat(replace(file, distribution=dark))


@pytest.mark.parametrize(
    ("opening", "written"),
    [
        (Opening("ellipse", (0.3, 0.3, 0.0)), Opening("ellipse", (0.3, 0.3, 0.0))),
        (Opening("ellipsoid", (0.3, 0.3, 0.3)), Opening("cylinder", (0.3, 0.3, 0.3))),
        (Opening("cylinder", (1.2, 0.1, 0.1), "x"), Opening("box", (1.2, 0.1, 0.1))),
        (Opening("rectangle", (0.0, 0.4, 0.2), "x"), Opening("box", (0.001, 0.4, 0.2))),
        (Opening(), Opening()),
    ],
)
def test_openings_that_the_format_lacks_are_written_as_their_likes(opening, written):
    data, remarks = write_eulumdat(replace(random_file(0), opening=opening, metadata={}))
    assert parse_eulumdat(data, "back.ldt").opening == written
    assert bool(remarks) == (opening != written)


def test_what_has_no_place_in_the_format_is_named():
    tilt = TiltTable(3, np.array([0.0, 90.0]), np.array([1.0, 0.9]))
    spectrum = (np.array([400.0, 700.0]), np.array([1.0, 1.0]))
    file = replace(random_file(0), tilt=tilt, spectrum=spectrum, metadata={"MANUFAC": "日本"})
    texts = " ".join(r.text for r in write_eulumdat(file)[1])
    assert all(word in texts for word in ("tilt", "spectrum", "Latin-1"))


def test_direct_ratios_of_a_lambertian_luminaire_are_those_of_two_facing_squares():
    polar = np.linspace(0.0, np.pi / 2, 181)
    lambertian = IntensityDistribution(np.zeros(1), polar, np.cos(polar)[None])
    a = 2.0 * np.array(ROOM_INDICES)
    root = np.sqrt(1 + a**2)
    # Configuration factor of parallel squares of side a at distance 1 (J. R. Howell, C-11).
    expected = (np.log((1 + a**2) / np.sqrt(1 + 2 * a**2)) + 2 * a * root * np.arctan(a / root)) * 2
    expected = (expected - 4 * a * np.arctan(a)) / (np.pi * a**2)
    assert direct_ratios(lambertian) == pytest.approx(expected, abs=3e-4)


# ---- real files ----


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
    assert direct_ratios(read_eulumdat(path).distribution) == pytest.approx(stated, abs=0.013)


@pytest.mark.parametrize("path", sorted(DATA.glob("*.ldt")), ids=lambda path: path.stem)
def test_real_files_are_read_and_written_or_refused_at_a_line(path):
    if path.stem == "lux_synthetic_basic_broken":
        with pytest.raises(FileFormatError, match="several values on one line") as caught:
            read_eulumdat(path)
        assert caught.value.line == 48
        return
    file = read_eulumdat(path)
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
    file = read_eulumdat(real(f"{name}.ldt"))
    ratio = flux(file.distribution) / file.stated_flux
    assert ratio == pytest.approx(file.light_output_ratio, rel=tolerance)


def test_two_measurements_of_one_luminaire_with_and_without_symmetry_agree():
    whole, quarter = (read_eulumdat(real(f"qs_sample_isym{i}.ldt")) for i in (0, 4))
    assert flux(whole.distribution) == pytest.approx(flux(quarter.distribution), rel=1e-4)
    signs = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]])
    before = np.mean([intensity(whole.distribution, DIRECTIONS * s) for s in signs], axis=0)
    after = intensity(quarter.distribution, DIRECTIONS)
    assert np.abs(after - before).max() < 1e-3 * before.max()


@pytest.mark.parametrize("isym", SAMPLES)
@pytest.mark.parametrize("change", ["lost", "doubled"])
def test_a_lost_or_doubled_line_changes_no_light_and_is_noticed(isym, change):
    lines = small(isym, SAMPLES[isym][0])
    whole = parsed(lines)
    lines[21] = 100
    lines[22] = round(100 * flux(whole.distribution) / 1000, 3)
    assert not [r for r in parsed(lines).remarks if "pole" not in r.text]
    for at, line in enumerate(lines):
        damaged = [*lines[:at], *([line, line] if change == "doubled" else []), *lines[at + 1 :]]
        try:
            file = parsed(damaged)
        except FileFormatError:
            continue
        assert np.allclose(plane_values(file, EIGHT), plane_values(whole, EIGHT)), f"line {at + 1}"
        assert file.remarks, f"line {at + 1}"
