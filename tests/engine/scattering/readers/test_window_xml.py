"""WINDOW XML with matrices of Klems: which way directions point, bases, bands and sides."""

import numpy as np
import pytest
from scattering_models import directions
from window_files import (
    HALF_TURN,
    KLEMS_FULL,
    MIRROR_X,
    NORMAL,
    SMALL,
    SMALL_BASIS,
    SMALL_COUNT,
    block,
    evaluate_window,
    klems,
    read_window,
    row_towards,
    shares_sent,
    tree,
    window_xml,
)

from lumenray.engine.scattering.data.patches import (
    albedos,
    centre,
    check_patches,
    patch_of,
    reciprocity_of,
    solid_angles,
)
from lumenray.engine.scattering.data.tree import check_tree
from lumenray.engine.scattering.readers.window_xml import SIDES


@pytest.mark.parametrize("kind", ["Transmission", "Reflection"])
@pytest.mark.parametrize("side", ["Front", "Back"])
def test_light_on_the_diagonal_goes_straight_on_or_as_from_a_mirror(kind, side):
    # Of both, what leaves has the x and y of the direction in which light came, which is against wi.
    matrix = read_window(klems(f"{kind} {side}", np.eye(145)), f"{side.lower()}_{kind.lower()}")
    wi = directions(500, 1, 0.0)
    assert np.all(evaluate_window(matrix, wi, wi * HALF_TURN) == 1.0)
    assert albedos(matrix) == pytest.approx(solid_angles(matrix.incoming)[:, None], rel=1e-6)


def test_up_stays_up_and_the_outdoor_side_sees_left_and_right_exchanged():
    # From the normal (patch 0) to the second ring (patches 1 to 8): azimuth 90 degrees is up, 0 is to the right of somebody
    # who stands indoors and looks at the pane.
    for patch, azimuth in ((3, 90.0), (7, 270.0), (1, 180.0), (5, 0.0)):
        values = np.zeros((145, 145))
        values[patch, 0] = 2.0
        for direction, side in SIDES.items():
            matrix = read_window(klems(direction, values), side)
            assert evaluate_window(matrix, NORMAL, row_towards(10.0, azimuth)) == 2.0


def test_light_that_travels_to_a_patch_comes_from_the_opposite_direction():
    values = np.zeros((145, 145))
    values[0, 2] = 2.0
    # It travels row_towards 45 degrees, so it comes from 225; and left is right.
    matrix = read_window(klems("Transmission Front", values), "front_transmission")
    assert evaluate_window(matrix, row_towards(10.0, 225.0) * MIRROR_X, NORMAL) == 2.0
    assert matrix.values.sum() == 2.0


@pytest.mark.parametrize("structure", ["Columns", "Rows"])
def test_rows_of_text_are_outgoing_where_columns_are_incident(structure):
    values = np.arange(145.0 * 145).reshape(145, 145)
    text = values if structure == "Columns" else values.T
    matrix = read_window(klems("Transmission Back", text, structure=structure), "back_transmission")
    # Both on the pole and in the outermost ring at azimuth 90, which no reversal of x moves.
    assert evaluate_window(matrix, NORMAL, row_towards(80.0, 90.0)) == values[133 + 3, 0]
    assert evaluate_window(matrix, row_towards(80.0, 270.0), NORMAL) == values[0, 133 + 3]


@pytest.mark.parametrize(("name", "count"), [("Full", 145), ("Half", 77), ("Quarter", 41)])
def test_bases_of_klems_that_a_file_need_not_define(name, count):
    # Counts and bounds as the Berkeley Lab's own calculation engine has them.
    values = np.full((count, count), 0.8 / np.pi)
    matrix = read_window(
        klems("Reflection Front", values, f"LBNL/Klems {name}"), "front_reflection"
    )
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
    file = read_window(data)
    matrix = file.sides["back_reflection"]
    assert matrix.incoming.counts.tolist() == [1, 4, 2]
    assert np.degrees(file.incidences) == pytest.approx([0.0, 45.0, 75.0])
    check_patches(matrix)


def test_different_bases_of_incident_and_outgoing_light():
    values = np.arange(41.0 * 145).reshape(41, 145)
    names = (KLEMS_FULL, "LBNL/Klems Quarter")
    matrix = read_window(
        window_xml("Columns", block("Reflection Back", values, names)), "back_reflection"
    )
    assert matrix.values.shape == (145, 41, 1)
    assert evaluate_window(matrix, NORMAL, row_towards(80.0, 90.0)) == values[33 + 2, 0]


def test_numbers_stand_between_blanks_and_commas():
    values = np.random.default_rng(1).random((145, 145)).round(4)
    texts = (
        "\n".join("\t".join(map(str, row)) for row in values),
        ",\n".join(", ".join(map(str, row)) for row in values) + ",",
        " ".join(f"{value:.4e}," for value in values.ravel()),
    )
    found = [
        read_window(klems("Reflection Front", text), "front_reflection").values for text in texts
    ]
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])


def test_of_the_bands_only_the_visible_is_read():
    names = (KLEMS_FULL, KLEMS_FULL)
    bands = (("Solar", 0.1), ("Visible", 0.2), ("CIE-X", 0.3), ("CIE-Z", 0.4))
    data = window_xml(
        "Columns",
        *(block("Reflection Back", np.full((145, 145), v), names, band) for band, v in bands),
    )
    file = read_window(data)
    assert np.all(file.sides["back_reflection"].values == np.float32(0.2))
    told = " ".join(str(remark) for remark in file.remarks)
    assert "colour is left out" in told
    assert "'Solar' are left out" in told
    assert (file.name, file.source) == ("Pane one", "Works")


def test_solar_stands_in_where_nothing_is_visible():
    names = (KLEMS_FULL, KLEMS_FULL)
    data = window_xml("Columns", block("Reflection Back", np.full((145, 145), 0.1), names, "Solar"))
    file = read_window(data)
    assert "Solar is taken" in str(file.remarks[0])
    assert np.all(file.sides["back_reflection"].values == np.float32(0.1))


def test_a_missing_transmission_follows_by_reciprocity():
    values = np.random.default_rng(2).random((145, 145)) * 0.2
    file = read_window(klems("Transmission Back", values))
    assert set(file.sides) == {"back_transmission", "front_transmission"}
    assert "reciprocity" in str(file.remarks[0])
    wi, wo = directions(1000, 9, 0.0), directions(1000, 10, 0.0)
    front, back = file.sides["front_transmission"], file.sides["back_transmission"]
    assert np.array_equal(evaluate_window(front, wi, wo), evaluate_window(back, wo, wi))
    assert reciprocity_of(front, back) == 0.0
    assert reciprocity_of(front) > 0.1


@pytest.mark.parametrize("rank", [3, 4])
def test_the_transpose_of_a_tree_lets_as_much_light_pass(rank):
    size = 8 if rank == 3 else 4
    values = np.random.default_rng(3).random(size**rank)
    text = "{" + " ".join(f"{value:.6f}" for value in values) + "}"
    file = read_window(tree("Transmission Back", text, rank))
    front, back = file.sides["front_transmission"], file.sides["back_transmission"]
    check_tree(front)
    # Bi-hemispherical transmittance, light that is even over the projected solid angle.
    sine = np.sqrt((np.arange(400) + 0.5) / 400)
    azimuth = 2.399963 * np.arange(400)
    wi = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.sqrt(1 - sine**2)], axis=1)
    assert shares_sent(front, wi).mean() == pytest.approx(shares_sent(back, wi).mean(), rel=0.01)
    a, b = directions(2000, 11, 0.0), directions(2000, 12, 0.0)
    there, again = evaluate_window(front, a, b), evaluate_window(back, b, a)
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
    file = read_window(data)
    assert not file.sides["back_transmission"].values.any()
    assert "not reciprocal" in str(file.remarks[0])


def test_more_light_than_arrives_is_remarked_with_its_angle():
    values = np.full((145, 145), 0.9 / np.pi)
    values[:, 0] = 1.5 / np.pi
    told = [str(remark) for remark in read_window(klems("Reflection Back", values)).remarks]
    assert told == [
        "the back sends on 1.5 of the light that arrives at 0 degrees, more than there is"
    ]


def test_negative_values_become_zero_and_are_counted():
    values = np.full((145, 145), 0.1)
    values[3, :5] = -1e-4
    file = read_window(klems("Reflection Back", values))
    assert str(file.remarks[0]).endswith("5 values of Reflection Back are negative; taken as 0")
    assert file.sides["back_reflection"].values.min() == 0.0
