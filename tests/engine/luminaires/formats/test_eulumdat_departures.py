"""EULUMDAT files that depart from the format: read as meant with a remark, or refused with their line."""

import numpy as np
import pytest
from eulumdat_files import (
    EIGHT,
    NAMES,
    SAMPLES,
    as_bytes,
    changed,
    parsed,
    plane_values,
    remarks_of,
    small,
)

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.eulumdat.reader import parse_eulumdat

RATIOS = 32
"""Place of the first direct ratio in the lines of a file with one lamp set, from 0."""


def refused(lines, **kinds):
    with pytest.raises(FileFormatError) as caught:
        parsed(lines, **kinds)
    assert str(caught.value).startswith("a.ldt")
    return caught.value


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
