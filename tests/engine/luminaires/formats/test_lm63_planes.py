"""Planes of LM-63 files: symmetries, photometric types, seams and poles."""

import math

import numpy as np
import pytest
from lm63_files import FIRST_LINES, HORIZONTAL, VERTICAL, candela, made, parsed, table_ab, words

from lumenray.engine.luminaires.distribution import intensity


def lobe(azimuth):
    """Intensity at 45 degrees that tells all azimuths apart, and not linear."""
    return 300 + azimuth + azimuth**2 / 100


def lobed(azimuths):
    return tuple(f"500 {lobe(azimuth):.9g} 0" for azimuth in azimuths)


@pytest.mark.parametrize(
    ("year", "stored", "symmetry", "image"),
    [
        (2002, [0], "rotational", lambda _: 0),
        (2002, [0, 45, 90], "quadrant", lambda c: min(c % 180, 180 - c % 180)),
        (2002, [0, 90, 180], "C0-C180", lambda c: min(c, 360 - c)),
        (1995, [90, 180, 270], "C90-C270", lambda c: c if 90 <= c <= 270 else (180 - c) % 360),
        (2002, [0, 90, 180, 270, 360], "none", lambda c: c),
    ],
)
def test_symmetric_planes_are_expanded_all_around(year, stored, symmetry, image):
    planes = lobed([0 if c == 360 else c for c in stored])
    horizontal = " ".join(map(str, stored))
    file = parsed(made(FIRST_LINES[year], lamps="2 2000 1", horizontal=horizontal, candela=planes))
    assert file.remarks == ()
    assert file.symmetry == symmetry
    for azimuth in range(0, 360, 45):
        expected = np.interp(image(azimuth), stored, [lobe(c % 360) for c in stored])
        if symmetry == "none" and azimuth > 270:
            expected = (lobe(270) + lobe(0)) / 2
        assert candela(file, 45, azimuth) == pytest.approx(expected), azimuth
    around = file.distribution.azimuth
    assert len(around) == 1 or (around[0] == 0.0 and around[-1] == pytest.approx(2 * math.pi))


@pytest.mark.parametrize(
    ("stored", "symmetry", "remark"),
    [
        ([0, 120, 240], "none", "0 to 240; the 120 degrees"),
        ([0, 90, 180, 270], "none", "0 to 270; the 90 degrees"),
        ([-90, 0, 90], "C90-C270", "-90 to 90, which LM-63-2002 does not know"),
        ([90, 180, 270], "C90-C270", "90 to 270, which LM-63-2002 does not know"),
        ([180, 270, 360], "C0-C180", "180 to 360"),
        ([-180, -90, 0, 90, 180], "none", "-180 to 180"),
        ([60, 180, 300], "none", "60 to 300; the 120 degrees"),
        ([45], "rotational", "a single plane at 45"),
    ],
)
def test_unusual_planes_are_taken_with_a_remark(stored, symmetry, remark):
    text = made(horizontal=" ".join(map(str, stored)), candela=lobed(stored))
    file = parsed(text)
    assert file.symmetry == symmetry
    assert remark in words(file)
    assert "line 10:" in words(file)
    for azimuth in stored[:-1]:
        assert candela(file, 45, azimuth) == pytest.approx(lobe(azimuth))
    if symmetry != "rotational":
        # The planes go all around, from 0 on, and close.
        assert file.distribution.azimuth[[0, -1]].tolist() == [0.0, 2.0 * math.pi]
        assert np.array_equal(file.distribution.intensity[0], file.distribution.intensity[-1])
    if stored[0] == 60:
        assert candela(file, 45, 0) == pytest.approx((lobe(60) + lobe(300)) / 2)


def test_planes_that_differ_at_the_pole_meet_in_their_mean_by_width():
    file = parsed(
        made(horizontal="0 90 180 270 360", candela=["100 0 0"] * 2 + ["140 0 0"] * 2 + ["100 0 0"])
    )
    assert candela(file, 0) == pytest.approx(120.0)
    assert "at a pole the planes differ by up to 16.7%" in words(file)
    uneven = parsed(made(horizontal="0 30 90", candela=("60 0 0", "60 0 0", "120 0 0")))
    # Between 30 and 90 degrees the mean is 90, over two thirds of the quarter.
    assert candela(uneven, 0) == pytest.approx(80.0)


def test_a_seam_that_does_not_close_is_remarked_on():
    file = parsed(made(horizontal="0 180 360", candela=("300 200 0", "300 100 0", "300 150 0")))
    assert "first and the last plane differ by up to 16.7%" in words(file)
    assert candela(file, 45, 0.0) == candela(file, 45, 360.0) == pytest.approx(200.0)


FORWARD, RIGHT, UP = np.array([0.0, 0, -1]), np.array([1.0, 0, 0]), np.array([0.0, 1, 0])


def type_b(vertical, horizontal):
    """IES formula of type B: out of the vertical plane by H, about the horizontal axis by V. [degree]"""
    v, h = math.radians(vertical), math.radians(horizontal)
    return (
        math.cos(h) * math.cos(v) * FORWARD + math.sin(h) * RIGHT + math.cos(h) * math.sin(v) * UP
    )


def type_a(vertical, horizontal):
    """IES formula of type A: up by V, to the right by H. [degree]"""
    v, h = math.radians(vertical), math.radians(horizontal)
    return (
        math.cos(v) * math.cos(h) * FORWARD + math.cos(v) * math.sin(h) * RIGHT + math.sin(v) * UP
    )


@pytest.mark.parametrize(("kind", "letter", "direction"), [(3, "A", type_a), (2, "B", type_b)])
def test_types_a_and_b_point_where_their_formulas_say(kind, letter, direction):
    rows = table_ab(kind)
    file = parsed(
        made(
            kind=kind,
            size=".2 .5 0",
            vertical=" ".join(map(str, VERTICAL)),
            horizontal=" ".join(map(str, HORIZONTAL)),
            candela=rows,
        )
    )
    assert (file.photometric_type, file.symmetry) == (letter, "none")
    assert not any("angles" in str(remark) for remark in file.remarks)
    for h, row in zip(HORIZONTAL, rows, strict=True):
        for v, value in zip(VERTICAL, row.split(), strict=True):
            found = float(intensity(file.distribution, direction(v, h)))
            assert found == pytest.approx(float(value)), (v, h)
    # Behind the luminaire nothing was measured.
    assert intensity(file.distribution, np.array([0.1, 0.1, 1.0])) == 0.0
    # Width lies across the beam, along x.
    assert file.opening.size == (0.2, 0.5, 0.0)


def test_a_half_given_type_b_is_mirrored_to_the_left():
    file = parsed(
        made(
            FIRST_LINES[1995],
            lamps="1 10000 1",
            kind=2,
            vertical="-90 0 90",
            horizontal="0 90",
            candela=("0 5000 0", "0 0 0"),
        )
    )
    assert file.symmetry == "C90-C270"
    value = [
        float(intensity(file.distribution, type_b(*angles)))
        for angles in ((0, 0), (0, 45), (0, -45), (45, 0), (-45, 45), (89.9, 0))
    ]
    assert value == pytest.approx([5000, 2500, 2500, 2500, 1250, 5000 / 900], rel=1e-9)


@pytest.mark.parametrize(("kind", "direction"), [(3, type_a), (2, type_b)])
def test_vertical_angles_from_0_are_mirrored_with_a_remark(kind, direction):
    file = parsed(
        made(
            kind=kind, vertical="0 30 60", horizontal="0 40 80", candela=["9 8 7", "6 5 4", "3 2 1"]
        )
    )
    assert file.symmetry == "quadrant"
    assert "the lower half mirrors the upper one" in words(file)
    assert "vertical angles from 0 to 60 instead of -90 or 0 to 90" in words(file)
    for v, h in ((30, 40), (-30, 40), (30, -40), (-30, -40)):
        assert intensity(file.distribution, direction(v, h)) == pytest.approx(5.0)
    assert intensity(file.distribution, direction(61, 0)) == 0.0
    assert intensity(file.distribution, direction(0, 81)) == 0.0


def test_vertical_angles_that_stop_early_leave_darkness():
    file = parsed(made(vertical="0 40 80"))
    assert "line 9: vertical angles from 0 to 80 instead of 0 or 90 to 90 or 180" in words(file)
    assert candela(file, 80) == pytest.approx(100.0)
    assert candela(file, 80.1) == 0.0
