"""Texts of goniometers: every layout gives the scattering that it was made from, and says what it had to assume."""

import re

import numpy as np
import pytest
from folders import ROOT, WILD
from goniometer_files import COLOURS, about_mirror, about_normal, e1392, grid, in_plane, lobe, write
from scattering_models import towards

from lumenray.engine.errors import FileFormatError
from lumenray.engine.scattering.data.evaluation import albedo, evaluate
from lumenray.engine.scattering.data.table import check_table, direction_of
from lumenray.engine.scattering.measuring.raw_measurement import (
    is_raw_measurement,
    read_raw_measurement,
)
from lumenray.engine.scattering.readers.goniometer import is_goniometer, read_goniometer

REAL = WILD / "bsdf" / "brdf_2D_data.csv"

REFLECTION = "front_reflection"


def matt(wi, wo):
    return np.full(len(wi), 0.9 / np.pi)


def table_of(data: bytes, side=REFLECTION):
    assert is_goniometer(data)
    table = read_goniometer(data, "sample.txt").sides[side]
    check_table(table)
    return table


def told(data: bytes) -> str:
    return "; ".join(str(each) for each in read_goniometer(data, "sample.txt").remarks)


def pairs(incidences, seed=1, count=2000, lowest=0.15):
    """Light at some angles of incidence over +x, and directions above the horizon, half near the mirror direction."""
    rng = np.random.default_rng(seed)
    wi = towards(rng.choice(incidences, count), 0.0)
    z, turn = rng.uniform(lowest, 1.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    sine = np.sqrt(1.0 - z**2)
    wo = np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=1)
    near = wi * [-1.0, -1.0, 1.0] + 0.4 * (wo - wi * [-1.0, -1.0, 1.0])
    wo = np.where((np.arange(count) % 2 == 0)[:, None], near, wo)
    return wi, wo / np.linalg.norm(wo, axis=1, keepdims=True)


def off(table, f, incidences=(0, 20, 40, 60)):
    """Relative difference of a table and a function, root mean square."""
    wi, wo = pairs(incidences)
    true = f(wi, wo)[:, None] * COLOURS
    return float(np.sqrt((((evaluate(table, wi, wo) - true) / true) ** 2).mean()))


# ---- our own layout ----


def test_the_examples_of_the_documentation_are_read():
    text = (ROOT / "docs" / "goniometer_format.md").read_text(encoding="utf-8")
    examples = [part.encode() for part in re.findall(r"```text\n(.*?)```", text, re.DOTALL)]
    table = table_of(examples[0])
    mirrored = evaluate(table, towards([30.0], 0.0), towards([30.0], 180.0))
    np.testing.assert_allclose(mirrored, [[0.873, 0.881, 0.886]], rtol=0.02)
    assert is_raw_measurement(examples[1])
    raw = read_raw_measurement(examples[1], "raw.txt")
    np.testing.assert_array_equal(raw.wavelengths, [450.0, 550.0])
    assert raw.slices[0].sample[0, 0] == 20312.0
    assert raw.dark[0] == 52.0


def test_a_grid_about_the_mirror_direction_is_kept_as_it_is():
    data = about_mirror(lobe)
    table = table_of(data)
    rows = [line.split() for line in data.decode().splitlines() if line[0].isdigit()]
    values = np.array(rows, dtype=float)
    wi = towards(values[:, 0], 0.0)
    wo = direction_of(*np.radians(values[:, [0, 2, 3]].T))
    np.testing.assert_allclose(evaluate(table, wi, wo), values[:, 4:], rtol=1e-5)
    np.testing.assert_array_equal(table.wavelengths, [450.0, 550.0, 650.0])


def test_missing_directions_are_filled_from_their_neighbours():
    whole = off(table_of(about_mirror(lobe)), lobe)
    assert off(table_of(about_mirror(lobe, share=0.9)), lobe) < whole + 0.025


def test_a_grid_about_the_normal_is_resampled():
    order = np.random.default_rng(2).permutation(4 * 18 * 13)[: int(0.97 * 4 * 18 * 13)]
    assert off(table_of(about_normal(lobe)), lobe) < 0.03
    assert off(table_of(about_normal(lobe, order=order)), lobe) < 0.04


@pytest.mark.slow
def test_directions_on_no_grid_are_joined():
    rng = np.random.default_rng(7)
    count = 6000
    theta_i = rng.choice([0.0, 30.0, 60.0], count)
    theta_o, phi_o = (
        np.degrees(np.arccos(rng.uniform(0.05, 1.0, count))),
        rng.uniform(0, 360, count),
    )
    values = lobe(towards(theta_i, 0.0), towards(theta_o, phi_o))[:, None] * COLOURS
    names = "theta_i phi_i theta_o phi_o 450 550 650"
    data = write(
        ["# lumenray goniometer 1", "# quantity: brdf"],
        names,
        [theta_i, 0 * theta_i, theta_o, phi_o, values],
    )
    assert off(table_of(data), lobe, (0, 30, 60)) < 0.03


@pytest.mark.parametrize(
    ("quantity", "factor"),
    [
        ("brdf", 1.0),
        ("luminance factor", np.pi),
        ("Percent", 100.0 * np.pi),
        (None, 1.0),
        (None, np.pi),
        (None, 100.0 * np.pi),
    ],
)
def test_all_quantities_of_a_white_tile_become_its_brdf(quantity, factor):
    """A tile of 90 % reads 0.286, 0.9 or 90; without a word it is told by its sum, and that is said."""
    data = about_normal(matt, quantity=quantity, factor=factor)
    table = table_of(data)
    np.testing.assert_allclose(albedo(table, 0.5), 0.9 * COLOURS, rtol=1e-4)
    assert ("does not say what its values are" in told(data)) == (quantity is None)


def test_cosine_corrected_values_are_divided_by_the_cosine():
    def corrected(wi, wo):
        return matt(wi, wo) * wo[:, 2]

    polars = np.arange(0.0, 90.0, 3.0)
    data = about_normal(corrected, quantity="cosine-corrected BRDF", polars=polars)
    np.testing.assert_allclose(table_of(data).values[..., 0], 0.9 / np.pi, rtol=1e-3)
    assert "farther than 85° from the normal, left out" in told(data)


def test_the_mirror_direction_is_where_light_would_be_mirrored():
    def peak(wi, wo):
        return lobe(wi, wo, width=6.0)

    for make in (about_normal, about_mirror):
        table = table_of(make(peak, incidences=(40,), rotations=(70,)))
        # Isotropic, so it may be asked from another side.
        wi, wo = towards([40.0], 10.0), towards([40.0], 190.0)
        assert evaluate(table, wi, wo)[0, 0] == pytest.approx(0.6, rel=0.01)


@pytest.mark.parametrize("make", [about_normal, about_mirror])
def test_sides_of_the_plane_of_incidence_are_kept_apart(make):
    def handed(wi, wo):
        return 0.2 + 0.1 * (wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0])

    data = make(handed, azimuths=np.arange(0.0, 360.0, 15.0))
    assert off(table_of(data), handed) < 0.02


@pytest.mark.parametrize("make", [about_normal, about_mirror])
def test_several_rotations_make_it_anisotropic(make):
    def brushed(wi, wo):
        half = wi + wo
        return 0.2 + 0.1 * half[:, 0] ** 2 / (half**2).sum(axis=1)

    around = np.arange(0.0, 360.0, 20.0)
    half_turn = make(
        brushed, rotations=np.arange(0, 180, 20), azimuths=around, more=("# rotation period: 180",)
    )
    for data in (make(brushed, rotations=around, azimuths=around), half_turn):
        table = table_of(data)
        assert len(table.rotations) == 18
        rng = np.random.default_rng(3)
        wi = towards(rng.choice([0.0, 20, 40, 60], 1000), rng.uniform(0.0, 360.0, 1000))
        wo = towards(rng.uniform(0.0, 75.0, 1000), rng.uniform(0.0, 360.0, 1000))
        np.testing.assert_allclose(evaluate(table, wi, wo)[:, 0], brushed(wi, wo), rtol=0.05)


def test_transmission_has_its_own_side():
    data = about_normal(lobe, more=("# kind: transmission", "# side: back", "# name: glass"))
    file = read_goniometer(data, "x")
    assert list(file.sides) == ["back_transmission"]
    assert file.name == "glass"
    assert off(file.sides["back_transmission"], lobe) < 0.03


@pytest.mark.parametrize(
    "names",
    [
        "theta_i,theta_o,phi_o,value",
        "theta_i;theta_o;phi_o;R;G;B",
        "theta_i\ttheta_o\tphi_o\tX\tY\tZ",
    ],
)
def test_separators_decimal_commas_and_colours(names):
    mark = next(mark for mark in ";\t," if mark in names)
    theta_i, theta_o, phi_o = grid((0, 50), np.arange(0, 81, 10), np.arange(0, 181, 30))
    bands = len(names.split(mark)) - 3
    # White of D65 in X, Y, Z.
    white = {1: [1.0], 3: [1.0] * 3}[bands] if "X" not in names else [0.95047, 1.0, 1.08883]
    values = np.full((len(theta_i), bands), 0.25) * white
    text = write(
        ["# quantity: brdf"], names.replace(mark, " "), [theta_i, theta_o, phi_o, values], mark=mark
    )
    if mark != ",":
        text = text.replace(b".", b",")
    np.testing.assert_allclose(table_of(text).values, 0.25, rtol=1e-3)


# ---- one plane ----


def test_a_round_lobe_is_known_from_one_plane():
    """Of a lobe that is round about the mirror direction, one plane tells all."""
    for mark in (",", ";"):
        data = in_plane(lobe, mark=mark, head=("# quantity: brdf",))
        table = table_of(data)
        assert off(table, lobe, (10, 30, 50, 70)) < 0.03
        assert "plane of incidence alone" in told(data)


def test_signs_that_count_the_other_way_are_turned():
    data = in_plane(lobe, sign=-1.0, head=("# quantity: brdf",))
    assert off(table_of(data), lobe, (10, 30, 50, 70)) < 0.03
    assert "signs were turned" in told(data)


def test_our_layout_may_hold_one_plane_too():
    azimuths = np.array([0.0, 180.0])
    assert (
        off(table_of(about_normal(lobe, azimuths=azimuths, polars=np.arange(0, 86, 2.5))), lobe)
        < 0.03
    )
    radials = np.append(np.arange(0.0, 30.0, 2.0), np.arange(30.0, 150.0, 4.0))
    assert off(table_of(about_mirror(lobe, azimuths=azimuths, radials=radials)), lobe) < 0.03


@pytest.mark.skipif(not REAL.is_file(), reason="needs ../shared/data/bsdf")
def test_a_real_measurement_of_a_white_tile():
    """Luminance factors of a glossy white tile: the rows come back over pi, and it reflects nearly everything."""
    data = REAL.read_bytes()
    table = table_of(data)
    for theta, signed, at_550 in (
        (25.0, 26.0, 66.6876),
        (40.0, -12.0, None),
        (60.0, 61.0, 177.5221),
    ):
        line = next(s for s in data.decode().splitlines() if s.startswith(f"{theta:g},{signed:g},"))
        values = np.array(line.split(","), dtype=float)[2:]
        assert at_550 is None or values[16] == at_550
        found = evaluate(table, towards([theta], 0.0), towards([signed], 180.0))[0]
        np.testing.assert_allclose(found, values / np.pi, rtol=1e-4)
    for angle in table.incidences[:-1]:
        assert 0.9 < albedo(table, angle).mean() < 1.0
    # Rows of zeros beside the light are filled: a white tile is not black there.
    retro = evaluate(table, towards([40.0], 0.0), towards([-40.0], 180.0))
    np.testing.assert_allclose(np.pi * retro, 0.94, atol=0.05)
    words = told(data)
    for part in (
        "26 rows of zeros",
        "luminance factors",
        "plane of incidence alone",
        "beyond 80 degrees",
    ):
        assert part in words


# ---- E1392 ----


@pytest.mark.parametrize("in_degrees", [False, True])
def test_texts_like_those_of_e1392(in_degrees):
    data = e1392(lambda wi, wo: lobe(wi, wo, width=40.0), in_degrees)
    file = read_goniometer(data, "x")
    assert file.format == "ASTM E1392 text"
    assert file.name == "test"
    np.testing.assert_allclose(np.degrees(file.incidences), [10.0, 50.0], rtol=1e-6)
    assert off(file.sides[REFLECTION], lambda wi, wo: lobe(wi, wo, width=40.0), (10, 50)) < 0.03


# ---- what is wrong ----

HEAD = "# lumenray goniometer 1\n"
NAMES = "theta_i phi_i theta_o phi_o 450 550\n"
ROW = "30 0 20 180 0.3 0.3\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# lumenray goniometer 2\n" + NAMES + ROW, "line 1: is of version 2"),
        (HEAD, "no line that names its columns"),
        (HEAD + NAMES, "no rows of numbers"),
        (HEAD + NAMES + "30 0 20 180 0.3\n", "line 3: has 5 columns, expected 6"),
        (HEAD + NAMES + ROW + "30 0 20 abc 0.3 0.3\n", "line 4: has 'abc', expected a number"),
        (HEAD + NAMES + "30 0 - 180 0.3 0.3\n", "line 3: lacks an angle"),
        (HEAD + NAMES + "95 0 20 180 0.3 0.3\n", "line 3: has the angle of incidence 95°, expected 0° to 90°"),
        (HEAD + NAMES + "30 0 -20 180 0.3 0.3\n", "line 3: has the outgoing angle -20°"),
        (HEAD + NAMES + "30 0 20 1800 0.3 0.3\n", "outgoing azimuth 1800°"),
        (HEAD + NAMES + "30 0 20 180 1e20 0.3\n", "line 3: has a value beyond"),
        (HEAD + NAMES + "30 0 20 180 - -\n", "no row with a value above the horizon"),
        (HEAD + NAMES + "30 0 20 180 0.3 -\n", "no value at 550 nm"),
        (HEAD + "# quantity: candela\n" + NAMES + ROW, "states the quantity 'candela', expected brdf"),
        (HEAD + "# kind: emission\n" + NAMES + ROW, "expected reflection or transmission"),
        (HEAD + "# angles: both\n" + NAMES + ROW, "expected normal or specular"),
        (HEAD + "theta_i theta_i theta_o phi_o 450 550\n" + ROW, "two columns named 'theta_i'"),
        (HEAD + "theta_i phi_i theta_o phi_o 450 450nm\n" + ROW, "two columns of one wavelength"),
        (HEAD + "theta_i phi_i theta_o phi_o one two\n" + ROW, "no columns of wavelengths"),
        (HEAD + NAMES + "30 0 30 180 0.3 0.3\n", "single outgoing direction"),
        (HEAD + NAMES + ROW + "40 90 20 180 0.3 0.3\n", "lacks the incidence 40° at the rotation 0°"),
        (HEAD + "# rotation period: 100\n" + NAMES + ROW + ROW.replace("30 0", "30 45"), "rotation period 100"),
        (HEAD + NAMES + "30 0 20 180 1e6 1e6\n30 0 20 90 1e6 1e6\n", "state '# quantity"),
        (e1392(lobe, stated=3).decode(), "states 3 points, but holds 216"),
        ("# lumenray raw measurement 1\nsigma theta phi\n", "process them into a table first"),
        ("x" * 100, "no line that names its columns"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_one_sentence(text, message):
    with pytest.raises(FileFormatError, match=message) as caught:
        read_goniometer(text.encode(), "sample.txt")
    assert str(caught.value).startswith("sample.txt")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x89PNG\r\n\x1a\n" + bytes(50),
        b"AngleOfIncidence 2\n0 10\n",
        b"AOI 10\nPOI 0\nSide Front\n",
        b"450 0.5\n460 0.6\n",
    ],
)
def test_other_files_are_none_of_these(data):
    assert not is_goniometer(data)
