"""WINDOW XML: what is read of its patches and trees, which way its directions point, what is refused, and its integrals."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.scattering.data.patches import (
    albedo_of_patches,
    albedos,
    centre,
    check_patches,
    evaluate_patches,
    patch_of,
    reciprocity_of,
    solid_angles,
    transposed,
)
from lumenray.engine.scattering.data.tree import (
    albedo_of_tree,
    albedos_of_tree,
    check_tree,
    disk_of,
    evaluate_tree,
    levels_of,
    raster_of,
    square_of,
)
from lumenray.engine.scattering.readers.window_xml import SIDES, is_window_xml, read_window_xml
from lumenray.engine.scene.scattering import PatchMatrix
from window_files import (
    KLEMS_FULL,
    SMALL,
    SMALL_BASIS,
    SMALL_COUNT,
    basis,
    block,
    klems,
    tree,
    window_xml,
)

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "bsdf" / "lbnl_xml"

NORMAL = np.array([[0.0, 0.0, 1.0]])

MIRROR_X, HALF_TURN = np.array([-1.0, 1.0, 1.0]), np.array([-1.0, -1.0, 1.0])


def read(data: bytes, side: str | None = None):
    file = read_window_xml(data, "pane.xml")
    return file if side is None else file.sides[side]


def evaluate(scatter, wi, wo):
    found = evaluate_patches if isinstance(scatter, PatchMatrix) else evaluate_tree
    return found(scatter, wi, wo)[:, 0]


def shares(scatter, wi):
    if isinstance(scatter, PatchMatrix):
        return albedos(scatter)[patch_of(scatter.incoming, wi), 0]
    return albedos_of_tree(scatter, wi)[:, 0]


def directions(count: int, seed: int) -> np.ndarray:
    """Even over the hemisphere."""
    found = np.random.default_rng(seed).normal(size=(count, 3))
    found[:, 2] = np.abs(found[:, 2])
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def towards(polar, azimuth) -> np.ndarray:
    polar, azimuth = np.radians(polar), np.radians(azimuth)
    sine = np.sin(polar)
    return np.array([[sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(polar)]])


# ---- directions and order, by Klems ----


@pytest.mark.parametrize("kind", ["Transmission", "Reflection"])
@pytest.mark.parametrize("side", ["Front", "Back"])
def test_light_on_the_diagonal_goes_straight_on_or_as_from_a_mirror(kind, side):
    # Of both, what leaves has the x and y of the direction in which light came, which is against wi.
    matrix = read(klems(f"{kind} {side}", np.eye(145)), f"{side.lower()}_{kind.lower()}")
    wi = directions(500, 1)
    assert np.all(evaluate(matrix, wi, wi * HALF_TURN) == 1.0)
    assert albedos(matrix) == pytest.approx(solid_angles(matrix.incoming)[:, None], rel=1e-6)


def test_up_stays_up_and_the_outdoor_side_sees_left_and_right_exchanged():
    # From the normal (patch 0) to the second ring (patches 1 to 8): azimuth 90 degrees is up, 0 is to the right of somebody
    # who stands indoors and looks at the pane.
    for patch, azimuth in ((3, 90.0), (7, 270.0), (1, 180.0), (5, 0.0)):
        values = np.zeros((145, 145))
        values[patch, 0] = 2.0
        for direction, side in SIDES.items():
            matrix = read(klems(direction, values), side)
            assert evaluate(matrix, NORMAL, towards(10.0, azimuth)) == 2.0


def test_light_that_travels_to_a_patch_comes_from_the_opposite_direction():
    values = np.zeros((145, 145))
    values[0, 2] = 2.0
    # It travels towards 45 degrees, so it comes from 225; and left is right.
    matrix = read(klems("Transmission Front", values), "front_transmission")
    assert evaluate(matrix, towards(10.0, 225.0) * MIRROR_X, NORMAL) == 2.0
    assert matrix.values.sum() == 2.0


@pytest.mark.parametrize("structure", ["Columns", "Rows"])
def test_rows_of_text_are_outgoing_where_columns_are_incident(structure):
    values = np.arange(145.0 * 145).reshape(145, 145)
    text = values if structure == "Columns" else values.T
    matrix = read(klems("Transmission Back", text, structure=structure), "back_transmission")
    # Both on the pole and in the outermost ring at azimuth 90, which no reversal of x moves.
    assert evaluate(matrix, NORMAL, towards(80.0, 90.0)) == values[133 + 3, 0]
    assert evaluate(matrix, towards(80.0, 270.0), NORMAL) == values[0, 133 + 3]


@pytest.mark.parametrize(("name", "count"), [("Full", 145), ("Half", 77), ("Quarter", 41)])
def test_bases_of_klems_that_a_file_need_not_define(name, count):
    # Counts and bounds as the Berkeley Lab's own calculation engine has them.
    values = np.full((count, count), 0.8 / np.pi)
    matrix = read(klems("Reflection Front", values, f"LBNL/Klems {name}"), "front_reflection")
    assert len(solid_angles(matrix.incoming)) == count
    assert solid_angles(matrix.incoming).sum() == pytest.approx(np.pi)
    assert albedos(matrix) == pytest.approx(0.8, rel=1e-6)
    limits = {"Full": 5.0, "Half": 6.5, "Quarter": 9.0}
    assert np.degrees(matrix.incoming.bounds[1]) == pytest.approx(limits[name])
    assert patch_of(matrix.incoming, centre(matrix.incoming)).tolist() == list(range(count))


def test_a_basis_that_the_file_defines():
    data = window_xml(
        "Columns",
        block("Reflection Back", np.full((SMALL_COUNT, SMALL_COUNT), 0.1), (SMALL, SMALL)),
        bases=SMALL_BASIS,
    )
    file = read(data)
    matrix = file.sides["back_reflection"]
    assert matrix.incoming.counts.tolist() == [1, 4, 2]
    assert np.degrees(file.incidences) == pytest.approx([0.0, 45.0, 75.0])
    check_patches(matrix)


def test_different_bases_of_incident_and_outgoing_light():
    values = np.arange(41.0 * 145).reshape(41, 145)
    names = (KLEMS_FULL, "LBNL/Klems Quarter")
    matrix = read(window_xml("Columns", block("Reflection Back", values, names)), "back_reflection")
    assert matrix.values.shape == (145, 41, 1)
    assert evaluate(matrix, NORMAL, towards(80.0, 90.0)) == values[33 + 2, 0]


def test_numbers_stand_between_blanks_and_commas():
    values = np.random.default_rng(1).random((145, 145)).round(4)
    texts = (
        "\n".join("\t".join(map(str, row)) for row in values),
        ",\n".join(", ".join(map(str, row)) for row in values) + ",",
        " ".join(f"{value:.4e}," for value in values.ravel()),
    )
    found = [read(klems("Reflection Front", text), "front_reflection").values for text in texts]
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])


# ---- trees ----

GRID = " ".join(f"{k}" for k in range(16))
"""Of one halving; the last coordinate is the fastest."""

NESTED = " ".join(f"{{ {(k & 1) << 3 | (k & 2) << 1 | (k & 4) >> 1 | k >> 3} }}" for k in range(16))
"""The same with braces: there the first coordinate is the lowest bit of a branch's number."""


def test_grids_and_branches_are_told_apart():
    trees = [
        read(tree("Reflection Back", f"{{ {text} }}"), "back_reflection") for text in (GRID, NESTED)
    ]
    wi, wo = directions(2000, 3), directions(2000, 4)
    assert np.array_equal(evaluate(trees[0], wi, wo), evaluate(trees[1], wi, wo))
    # In the file's frame, a half turn about y away: in x and y of where light travels to, then out x and y.
    x, y, u, v = -wi[:, 0] * -1, -wi[:, 1], -wo[:, 0], wo[:, 1]
    number = sum((value > 0.0) * bit for value, bit in ((x, 8), (y, 4), (u, 2), (v, 1)))
    assert np.array_equal(evaluate(trees[0], wi, wo), number)


@pytest.mark.parametrize("rank", [3, 4])
def test_fine_grids_are_their_cells(rank):
    size = 4
    values = np.random.default_rng(5).random((size,) * rank).astype(np.float32)
    text = "{" + ", ".join(f"{value:.9g}" for value in values.ravel()) + "}"
    found = read(tree("Transmission Front", text, rank), "front_transmission")
    check_tree(found)
    assert len(levels_of(found)) == 2
    # In x and out x are turned round against the file, in x and in y once more.
    turned = (1, 2) if rank == 4 else (2,)
    assert np.array_equal(raster_of(found, 2)[..., 0], np.flip(values, turned))
    assert raster_of(found, 1)[(0,) * rank][0] == pytest.approx(
        np.flip(values, turned)[(slice(2),) * rank].mean(), rel=1e-6
    )


def test_mixed_depths_and_a_single_value():
    inner = "{ " + " ".join(["{ 0.5 }"] * 8) + " }"
    text = "{" + inner + "{ 1 2 3 4 5 6 7 8 }" + "{ 3 }" * 6 + "}"
    found = read(tree("Reflection Back", text, 3), "back_reflection")
    check_tree(found)
    assert len(levels_of(found)) == 2
    plain = read(tree("Reflection Back", "{ 0.25 }", 3), "back_reflection")
    assert albedo_of_tree(plain, 0.3)[0] == pytest.approx(0.25 * np.pi)


def test_isotropic_trees_do_not_change_when_both_directions_turn():
    values = np.random.default_rng(6).random(512)
    text = "{" + " ".join(f"{value:.6f}" for value in values) + "}"
    found = read(tree("Reflection Front", text, 3), "front_reflection")
    wi, wo = directions(500, 7), directions(500, 8)
    angle = 1.1
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    alike = evaluate(found, wi, wo) == evaluate(found, wi @ turn.T, wo @ turn.T)
    # Rounding moves hardly any across an edge.
    assert alike.mean() > 0.995


# ---- several bands and sides ----


def test_of_the_bands_only_the_visible_is_read():
    names = (KLEMS_FULL, KLEMS_FULL)
    bands = (("Solar", 0.1), ("Visible", 0.2), ("CIE-X", 0.3), ("CIE-Z", 0.4))
    data = window_xml(
        "Columns",
        *(block("Reflection Back", np.full((145, 145), v), names, band) for band, v in bands),
    )
    file = read(data)
    assert np.all(file.sides["back_reflection"].values == np.float32(0.2))
    told = " ".join(str(remark) for remark in file.remarks)
    assert "colour is left out" in told
    assert "'Solar' are left out" in told
    assert (file.name, file.source) == ("Pane one", "Works")


def test_solar_stands_in_where_nothing_is_visible():
    names = (KLEMS_FULL, KLEMS_FULL)
    data = window_xml("Columns", block("Reflection Back", np.full((145, 145), 0.1), names, "Solar"))
    file = read(data)
    assert "Solar is taken" in str(file.remarks[0])
    assert np.all(file.sides["back_reflection"].values == np.float32(0.1))


def test_a_missing_transmission_follows_by_reciprocity():
    values = np.random.default_rng(2).random((145, 145)) * 0.2
    file = read(klems("Transmission Back", values))
    assert set(file.sides) == {"back_transmission", "front_transmission"}
    assert "reciprocity" in str(file.remarks[0])
    wi, wo = directions(1000, 9), directions(1000, 10)
    front, back = file.sides["front_transmission"], file.sides["back_transmission"]
    assert np.array_equal(evaluate(front, wi, wo), evaluate(back, wo, wi))
    assert reciprocity_of(front, back) == 0.0
    assert reciprocity_of(front) > 0.1


@pytest.mark.parametrize("rank", [3, 4])
def test_the_transpose_of_a_tree_lets_as_much_light_pass(rank):
    size = 8 if rank == 3 else 4
    values = np.random.default_rng(3).random(size**rank)
    text = "{" + " ".join(f"{value:.6f}" for value in values) + "}"
    file = read(tree("Transmission Back", text, rank))
    front, back = file.sides["front_transmission"], file.sides["back_transmission"]
    check_tree(front)
    # Bi-hemispherical transmittance, light that is even over the projected solid angle.
    sine = np.sqrt((np.arange(400) + 0.5) / 400)
    azimuth = 2.399963 * np.arange(400)
    wi = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.sqrt(1 - sine**2)], axis=1)
    assert shares(front, wi).mean() == pytest.approx(shares(back, wi).mean(), rel=0.01)
    a, b = directions(2000, 11), directions(2000, 12)
    there, again = evaluate(front, a, b), evaluate(back, b, a)
    if rank == 4:
        assert np.array_equal(there, again)
    else:
        # Constant in cells on the way there, so not on the way back: on a grid.
        assert np.abs(there - again).mean() < 0.4 * np.abs(again - again.mean()).mean()


def test_a_side_that_breaks_reciprocity_is_remarked():
    names = (KLEMS_FULL, KLEMS_FULL)
    data = window_xml(
        "Columns",
        block("Transmission Front", np.full((145, 145), 0.1), names),
        block("Transmission Back", np.zeros((145, 145)), names),
    )
    file = read(data)
    assert not file.sides["back_transmission"].values.any()
    assert "not reciprocal" in str(file.remarks[0])


def test_more_light_than_arrives_is_remarked_with_its_angle():
    values = np.full((145, 145), 0.9 / np.pi)
    values[:, 0] = 1.5 / np.pi
    told = [str(remark) for remark in read(klems("Reflection Back", values)).remarks]
    assert told == [
        "the back sends on 1.5 of the light that arrives at 0 degrees, more than there is"
    ]


def test_negative_values_become_zero_and_are_counted():
    values = np.full((145, 145), 0.1)
    values[3, :5] = -1e-4
    file = read(klems("Reflection Back", values))
    assert str(file.remarks[0]).endswith("5 values of Reflection Back are negative; taken as 0")
    assert file.sides["back_reflection"].values.min() == 0.0


# ---- refusals ----


def test_other_files_are_told_apart():
    assert is_window_xml(klems("Reflection Back", "0"))
    assert is_window_xml(klems("Reflection Back", "0").decode().encode("utf-16"))
    for other in (b"<IESTM33-22></IESTM33-22>", b"IESNA:LM-63-2002", b"", b"<WindowElements>"):
        assert not is_window_xml(other)


FULL = (KLEMS_FULL, KLEMS_FULL)

BAD = {
    "begins with the element 'Window'": (b"<Window/>", 1),
    "no Optical/Layer": (b"<WindowElement/>", 1),
    "template without data": (window_xml("Columns"), 3),
    "IncidentDataStructure 'pyramids'": (window_xml("Pyramids", block("Reflection Back", "1")), 5),
    "'NIR', expected Visible or Solar": (
        window_xml("Columns", block("Reflection Back", "1", FULL, "NIR")),
        3,
    ),
    "'Reflection Back' twice": (
        window_xml("Columns", *[block("Reflection Back", "1", FULL)] * 2),
        13,
    ),
    "neither Transmission nor Reflection": (klems("Absorption Front", "1"), 3),
    "has no ScatteringData for Reflection Back": (klems("Reflection Back", " "), 7),
    "has 2 values of Reflection Back, expected 145 rows of 145": (
        klems("Reflection Back", "0 1"),
        9,
    ),
    "has more values of": (klems("Reflection Back", "0 " * 21026), 9),
    "has 'n' among ScatteringData": (klems("Reflection Back", "0 1\n0 nan"), 11),
    "has '1e99'": (klems("Reflection Back", "0 1\n1e99 " + "0 " * 21022), 11),
    "has '1.2.3'": (klems("Reflection Back", "1.2.3 " + "0 " * 21024), 10),
    "ColumnAngleBasis 'Tregenza', which it does not define": (
        klems("Reflection Back", "0", "Tregenza"),
        8,
    ),
    "a ring with 5 patches": (
        window_xml(
            "Columns",
            block("Reflection Back", "0 " * 36, ("Odd", "Odd")),
            bases=basis("Odd", ((0, 45, 1), (45, 90, 5))),
        ),
        None,
    ),
    "a ring from 31 to 60 degrees": (
        window_xml(
            "Columns",
            block("Reflection Back", "0", FULL),
            bases=basis("Gap", ((0, 30, 1), (31, 60, 4), (60, 90, 4))),
        ),
        7,
    ),
    "rings end at 80 degrees": (
        window_xml(
            "Columns",
            block("Reflection Back", "0", FULL),
            bases=basis("Short", ((0, 30, 1), (30, 80, 4))),
        ),
        5,
    ),
    "has the nPhis 4e+09": (
        window_xml(
            "Columns",
            block("Reflection Back", "0", FULL),
            bases=basis("Huge", ((0, 30, 1), (30, 90, 4_000_000_000))),
        ),
        7,
    ),
    "has the nPhis '1_0', expected a number": (
        window_xml(
            "Columns",
            block("Reflection Back", "0", FULL),
            bases=SMALL_BASIS.replace("<nPhis>4<", "<nPhis>1_0<"),
        ),
        7,
    ),
    "expected LBNL/Shirley-Chiu": (
        tree("Reflection Back", "{ 1 }").replace(b"Shirley-Chiu", b"Square"),
        7,
    ),
    "3 values in braces, expected a power of 16": (tree("Reflection Back", "{ 1 2 3 }"), 10),
    "2 branches in braces, expected 16": (tree("Reflection Back", "{ { 1 } { 2 } }"), 10),
    "0 branches in braces": (tree("Reflection Back", "{ }"), 10),
    "braces do not close": (tree("Reflection Back", "{ { 1 }"), 9),
    "a closing brace without": (tree("Reflection Back", "} { 1 }"), 10),
    "something after the last brace": (tree("Reflection Back", "{ 1 }\n{ 2 }"), 11),
    "numbers beside braces": (tree("Reflection Back", "{ { 1 }\n 2 }"), None),
    "nested deeper than 16 levels": (tree("Reflection Back", "{" * 100_000), 10),
    "DOCTYPE": (b"<!DOCTYPE w [<!ENTITY a 'b'>]><WindowElement>&a;</WindowElement>", 1),
}


@pytest.mark.parametrize("told", BAD)
def test_refusals_name_the_place_and_what_was_expected(told):
    data, line = BAD[told]
    with pytest.raises(FileFormatError) as caught:
        read(data)
    message = str(caught.value)
    assert told in message
    assert "\n" not in message
    assert line is None or caught.value.line == line


def test_text_that_is_no_xml_is_refused():
    with pytest.raises(FileFormatError, match="not well-formed"):
        read(b"Pane of glass")


def test_too_deep_trees_of_branches_and_grids_are_refused():
    rest = " { 0 }" * 7
    deep = "{ 1 2 3 4 5 6 7 8 }"
    for _ in range(16):
        deep = "{" + deep + rest + "}"
    with pytest.raises(FileFormatError, match="deeper than 16"):
        read(tree("Reflection Back", deep, 3))


# ---- integrals, in closed form and by quadrature ----


def test_the_map_of_disk_and_square_keeps_areas_and_goes_both_ways():
    u, v = np.random.default_rng(4).random((2, 5000))
    x, y = disk_of(u, v)
    assert (x * x + y * y).max() <= 1.0
    back = square_of(x, y)
    assert np.allclose(back, (u, v), atol=1e-12)
    # The square's cells have equal shares of the disk: that within the radius r is r^2 of all.
    grid = (np.arange(1000) + 0.5) / 1000
    x, y = disk_of(*np.meshgrid(grid, grid))
    for radius in (0.2, 0.5, 0.9):
        assert (x * x + y * y < radius**2).mean() == pytest.approx(radius**2, abs=2e-3)
    # Shirley and Chiu: (1, 1/2) of [-1, 1]^2 lies at the azimuth pi / 8, the corner at pi / 4.
    assert np.allclose(disk_of(1.0, 0.75), (np.cos(np.pi / 8), np.sin(np.pi / 8)))
    assert np.allclose(disk_of(0.0, 0.0), (-np.sqrt(0.5), -np.sqrt(0.5)))
    assert np.allclose(disk_of(0.5, 0.5), 0.0)


@pytest.mark.parametrize("rank", [0, 3, 4])
def test_totals_are_the_integral_of_the_value_times_the_cosine(rank):
    rng = np.random.default_rng(7)
    if rank:
        text = "{" + " ".join(f"{v:.6f}" for v in rng.random(2 ** (2 * rank)) * 0.3) + "}"
        scatter = read(tree("Reflection Front", text, rank), "front_reflection")
    else:
        scatter = read(klems("Reflection Front", rng.random((145, 145)) * 0.3), "front_reflection")
    # Even over the projected solid angle: the mean of f times pi.
    n = 1000
    square, azimuth = (np.arange(n) + 0.5) / n, 2 * np.pi * (np.arange(n) + 0.5) / n
    square, azimuth = (m.ravel() for m in np.meshgrid(square, azimuth))
    sine = np.sqrt(square)
    wo = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.sqrt(1 - square)], axis=1)
    for incidence, rotation in ((0.02, 0.4), (0.8, 2.0), (1.4, 4.0)):
        wi = towards(np.degrees(incidence), np.degrees(rotation))
        expected = np.pi * evaluate(scatter, np.broadcast_to(wi, wo.shape), wo).mean()
        total = albedo_of_tree if rank else albedo_of_patches
        assert total(scatter, incidence, rotation)[0] == pytest.approx(expected, rel=2e-3)


def test_nothing_is_scattered_below_the_horizon():
    for scatter in (
        read(klems("Reflection Front", np.ones((145, 145))), "front_reflection"),
        read(tree("Reflection Front", "{ 1 }"), "front_reflection"),
    ):
        below = np.array([[0.0, 0.6, -0.8]])
        assert evaluate(scatter, NORMAL, below) == 0.0
        assert evaluate(scatter, below, NORMAL) == 0.0


def test_reciprocity_is_measured():
    values = np.random.default_rng(8).random((145, 145, 1)).astype(np.float32)
    matrix = read(klems("Reflection Back", np.eye(145)), "back_reflection")
    alike = replace(matrix, values=values + values.transpose(1, 0, 2))
    assert reciprocity_of(alike) < 1e-6
    one_way = replace(matrix, values=np.triu(values[..., 0], 1)[..., None])
    assert reciprocity_of(one_way) == pytest.approx(2.0)
    assert reciprocity_of(one_way, transposed(one_way)) == 0.0
    # The mean f is 1 with deviations of 10 % in each of two opposite directions: sqrt(2) times that.
    noisy = replace(matrix, values=1.0 + 0.1 * np.sqrt(12.0) * (values - 0.5))
    assert reciprocity_of(noisy) == pytest.approx(0.1 * np.sqrt(2.0), rel=0.05)


def test_matrices_and_trees_that_break_their_rules_are_refused():
    matrix = read(klems("Reflection Front", np.ones((145, 145))), "front_reflection")
    rings = matrix.incoming
    for change, told in (
        ({"values": matrix.values[:-1]}, "shape"),
        ({"values": -matrix.values}, "negative"),
        ({"wavelengths": np.zeros(0)}, "no wavelength"),
        ({"incoming": replace(rings, bounds=rings.bounds[::-1])}, "ascend"),
        ({"incoming": replace(rings, bounds=rings.bounds * 0.9)}, "horizon"),
        ({"incoming": replace(rings, counts=rings.counts * 0)}, "without patches"),
        ({"incoming": replace(rings, counts=rings.counts[1:])}, "one polar angle more"),
    ):
        with pytest.raises(SceneError, match=told):
            check_patches(replace(matrix, **change))
    found = read(tree("Reflection Front", f"{{ {GRID} }}"), "front_reflection")
    for change, told in (
        ({"rank": 5}, "rank 5"),
        ({"rank": 3}, "8 children"),
        ({"values": found.values[:3]}, "does not have"),
        ({"values": -found.values}, "negative"),
        ({"children": np.zeros_like(found.children)}, "hangs"),
        ({"wavelengths": np.array([np.nan])}, "no number"),
    ):
        with pytest.raises(SceneError, match=told):
            check_tree(replace(found, **change))


# ---- real files, and Radiance ----

RADIANCE = """
import json, sys
import pyradiance.bsdf as bsdf
kept, found = [], []
for path, pairs, incidents in json.load(sys.stdin):
    # Radiance ends the process where one of several is given back.
    data = bsdf.load_file(path)
    kept.append(data)
    values = [float(bsdf.query(data, *pair)[1]) for pair in pairs]
    # Diffuse and other, reflected or transmitted.
    totals = [bsdf.direct_hemi(data, *way, flags) for *way, flags in incidents]
    found.append([values, totals])
json.dump(found, sys.stdout)
"""
"""Values and hemispherical totals; angles in degrees, of wi and wo."""


def real_files() -> list[Path]:
    if not DATA.is_dir():
        pytest.skip(f"no real files in {DATA}")
    return sorted(DATA.glob("*.xml"))


def test_real_files_are_read_or_refused():
    for path in real_files():
        data = path.read_bytes()
        assert is_window_xml(data)
        stated = set(re.findall(rb"<WavelengthDataDirection>(.*?)<", data))
        if not stated:
            with pytest.raises(FileFormatError, match="template without data"):
                read_window_xml(data, path)
            continue
        file = read_window_xml(data, path)
        sides = {SIDES[name.decode().lower()] for name in stated}
        for name in ("front_transmission", "back_transmission"):
            if name in sides:
                sides |= {"front_transmission", "back_transmission"}
        assert set(file.sides) == sides
        for side in file.sides.values():
            (check_patches if isinstance(side, PatchMatrix) else check_tree)(side)


def test_files_of_known_reflectance():
    real_files()
    for name, expected in (
        ("simple_tensor_refl", (0.8, 0.8)),
        ("simple_tensor_front_refl", (0.8, 0.0)),
    ):
        sides = read((DATA / f"{name}.xml").read_bytes()).sides
        for side, value in zip(("front_reflection", "back_reflection"), expected, strict=True):
            assert albedo_of_tree(sides[side], 0.5)[0] == pytest.approx(value, rel=1e-6)


def degrees_of(w) -> tuple[float, float]:
    return (
        float(np.degrees(np.arccos(np.clip(w[2], -1.0, 1.0)))),
        float(np.degrees(np.arctan2(w[1], w[0]))),
    )


def in_radiance(w, is_front: bool) -> tuple[float, float]:
    """Polar angle and azimuth of a direction that lies on our front or back, in Radiance's frame: its z points indoors."""
    return degrees_of((-w[0], w[1], -w[2] if is_front else w[2]))


def test_values_and_totals_are_those_of_radiance():
    """By its own evaluation of the same files: fronts, backs, incident and outgoing directions are where it has them."""
    pytest.importorskip("pyradiance")
    count, asked, ours = 150, [], []
    wi, wo = directions(count, 20), directions(count, 21)
    # Straight and mirrored light is met in a third of the pairs.
    near = wi[::3] * HALF_TURN + np.random.default_rng(22).normal(size=(50, 3)) * 0.02
    wo[::3] = near / np.linalg.norm(near, axis=1, keepdims=True) * np.sign(near[:, 2:])
    incidents = np.concatenate(
        [towards(*way) for way in ((3, 20), (38, 110), (62, 200), (80, 310))]
    )
    for path in real_files():
        if path.name == "WINDOW6BSDFt_template.xml":
            continue
        for name, scatter in read_window_xml(path.read_bytes(), path).sides.items():
            if not scatter.values.any():
                # Radiance takes what is not seen as not told, and tells it by reciprocity.
                continue
            side, kind = name.split("_")
            front, leaves = side == "front", (side == "front") == (kind == "reflection")
            pairs = [
                (*in_radiance(a, front), *in_radiance(b, leaves))
                for a, b in zip(wi, wo, strict=True)
            ]
            flags = 12 + (1 if kind == "reflection" else 2)
            asked.append((str(path), pairs, [(*in_radiance(w, front), flags) for w in incidents]))
            ours.append((path.name, name, scatter))
    found = subprocess.run(
        [sys.executable, "-c", RADIANCE],
        input=json.dumps(asked),
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    compared = 0
    for (file, name, scatter), (values, totals) in zip(ours, json.loads(found.stdout), strict=True):
        label = f"{file} {name}"
        # Radiance keeps the even part of a distribution apart, with a colour of four digits.
        assert evaluate(scatter, wi, wo) == pytest.approx(values, rel=1e-3, abs=1e-5), label
        assert shares(scatter, incidents) == pytest.approx(totals, rel=5e-3, abs=1e-6), label
        compared += np.count_nonzero(values)
    assert compared > 2000
