"""Scattering files of other programs: the direction that each value is for, how much light there is, and what is refused."""

import struct
from pathlib import Path

import numpy as np
import pytest
import scattering_files
from lumenray.engine.errors import FileFormatError
from lumenray.engine.photometry.colour import XYZ_TO_REC709
from lumenray.engine.photometry.spectra import GRID, illuminant, observer
from lumenray.engine.reading.blocks import unpack_lz4
from lumenray.engine.scattering.data.evaluation import total
from lumenray.engine.scattering.data.record import SIDES
from lumenray.engine.scattering.data.table import (
    albedo_of,
    check_table,
    direct_share,
    direction_of,
    evaluate_table,
)
from lumenray.engine.scattering.readers.colour import spectra_of_rgb
from lumenray.engine.scattering.readers.lighttools import is_lighttools, read_lighttools
from lumenray.engine.scattering.readers.mdl import is_mdl, read_mdl
from lumenray.engine.scattering.readers.reader import Wish, parse_scattering
from lumenray.engine.scattering.readers.speos import is_speos, read_speos
from lumenray.engine.scattering.readers.zemax import is_zemax, read_zemax
from scattering_files import (
    SHARES,
    alike,
    anisotropic,
    anisotropic_binary,
    brdf_text,
    bsdf180,
    coated,
    handed,
    lighttools,
    mdl,
    mdl_block,
    packed,
    polar,
    reflectance,
    scattering,
    simple,
    zemax,
)

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "bsdf"

needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="needs ../shared/data/bsdf")

READERS = (
    (is_zemax, read_zemax),
    (is_lighttools, read_lighttools),
    (is_speos, read_speos),
    (is_mdl, read_mdl),
)


def read(data: bytes):
    """Read by the one reader that takes the file for its own, and check what it makes."""
    mine = [reader for is_mine, reader in READERS if is_mine(data)]
    assert len(mine) == 1
    file = mine[0](data, Path("surface"))
    assert set(file.sides) <= set(SIDES)
    for table in file.sides.values():
        check_table(table)
    return file


def front(data: bytes):
    return read(data).sides["front_reflection"]


def told(file) -> str:
    return " | ".join(str(each) for each in file.remarks)


def pairs(incidences, rotations=None, count=4000):
    """Pairs of directions, light coming at angles of incidence [degree] and at any azimuth or some. [degree]"""
    rng = np.random.default_rng(5)
    theta = rng.choice(np.asarray(incidences, dtype=float), count)
    phi = rng.uniform(0.0, 360.0, count) if rotations is None else rng.choice(rotations, count)
    steep = np.degrees(np.arccos(np.sqrt(rng.uniform(np.cos(np.radians(75.0)) ** 2, 1.0, count))))
    return polar(theta, phi), polar(steep, rng.uniform(0.0, 360.0, count))


def assert_same(table, brdf, incidences, tolerance, factor=1.0, **more):
    """The values are those of a function, wherever light comes from and goes."""
    wi, wo = pairs(incidences, **more)
    wanted = factor * brdf(wi, wo)
    error = np.abs(evaluate_table(table, wi, wo)[:, 0] - wanted)
    assert error.max() < tolerance * wanted.max()


# ---- directions ----


def test_zemax_values_are_for_the_directions_that_its_formula_states():
    assert_same(front(zemax()), handed, (0, 30, 60), 0.02)


def test_zemax_tables_of_one_side_are_mirrored():
    half = zemax(alike, azimuths=tuple(range(0, 181, 15)), symmetry="PlaneSymmetrical")
    table = front(half)
    assert table.azimuths[-1] == pytest.approx(np.pi)
    assert_same(table, alike, (0, 30, 60), 0.02)


def test_a_zemax_table_may_leave_out_the_last_line_of_azimuths():
    open_ended = front(zemax(azimuths=tuple(range(0, 360, 15))))
    np.testing.assert_allclose(open_ended.values, front(zemax()).values, atol=1e-5)


def test_zemax_keeps_odd_azimuths():
    # None of these lies at 180 degrees, where our azimuth begins.
    assert_same(front(zemax(azimuths=(0, *range(7, 360, 8), 360))), handed, (0, 30, 60), 0.02)


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
    file = read("\n".join(lines).encode())
    table = file.sides["front_reflection"]
    assert "normal of the plane of incidence" in told(file)
    # The normal at 90 degrees: the plane is along x, and light comes from a right angle ahead.
    wi, wo = (
        polar(np.full(4, 30.0), np.array([0.0, 90.0, 180.0, 270.0])),
        polar(np.full(4, 5.0), 0.0),
    )
    np.testing.assert_array_equal(evaluate_table(table, wi, wo)[:, 0] > 0.0, [0, 0, 1, 0])


def test_zemax_btdf_is_transmission_about_the_straight_direction():
    file = read(zemax(kind="BTDF"))
    assert list(file.sides) == ["front_transmission"]
    assert_same(file.sides["front_transmission"], handed, (0, 30, 60), 0.02)


def test_zemax_values_hold_where_its_zeros_are_below_the_horizon():
    # Light at 60 degrees: the mirror's neighbours on the side of the horizon have no data beyond 90 degrees.
    wo = polar(np.array([86.0]), 180.0)
    wi = polar(np.array([60.0]), 0.0)
    flat = front(zemax(lambda wi, wo: np.full(len(wo), 0.2)))
    assert evaluate_table(flat, wi, wo)[0, 0] == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize("light", [90.0, 0.0, 270.0])
def test_lighttools_values_are_for_their_directions_wherever_light_comes_from(light):
    file = read(lighttools(light=light))
    assert ("brightest" in told(file)) == (light != 90.0)
    assert_same(file.sides["front_reflection"], handed, (0, 30, 60), 0.06)


def test_lighttools_planes_of_incidence_become_rotations():
    file = read(lighttools(incidences=(0, 45), planes=(0, 120, 240)))
    table = file.sides["front_reflection"]
    np.testing.assert_allclose(np.degrees(table.rotations), [90.0, 210.0, 330.0])
    assert_same(table, handed, (0, 45), 0.08, rotations=(90.0, 210.0, 330.0))


def test_lighttools_rows_may_be_angles_to_the_normal():
    lines = lighttools(incidences=(30,)).decode().split("\n")
    start = next(k for k, line in enumerate(lines) if line.startswith("TIS")) + 1
    rows = np.array([line.split() for line in lines[start:]])
    turned = "\n".join(lines[:start] + [" ".join(row) for row in rows.T])
    np.testing.assert_array_equal(
        front(turned.encode()).values, front("\n".join(lines).encode()).values
    )


@pytest.mark.parametrize(("side", "kind", "name"), [
    ("Back", "BRDF", "back_reflection"), ("Front", "BTDF", "front_transmission"), ("Back", "BTDF", "back_transmission"),
])  # fmt: skip
def test_lighttools_sides(side, kind, name):
    assert list(read(lighttools(side=side, kind=kind)).sides) == [name]


def test_lighttools_wavelengths_become_spectra():
    table = front(lighttools(bands=(400, 500, 650)))
    share = [total(table, np.radians(30.0))[k] for k in (0, -1)]
    assert share[1] / share[0] == pytest.approx(650 / 400, rel=1e-3)
    assert table.wavelengths[[0, -1]] == pytest.approx([400, 650])


@pytest.mark.parametrize("mirror", [0.0, 180.0])
@pytest.mark.parametrize("is_intensity", [False, True])
def test_speos_values_are_for_their_directions(mirror, is_intensity):
    file = read(anisotropic(mirror=mirror, is_intensity=is_intensity))
    table = file.sides["front_reflection"]
    assert ("azimuth 180" in told(file)) == (mirror == 180.0)
    factor = 0.5 / reflectance(handed, 30)
    assert_same(table, handed, (0, 30, 60), 0.06, factor)


def test_speos_binary_and_text_hold_the_same():
    text = anisotropic(is_intensity=True, spectrum=((400, 50.0), (700, 50.0)))
    np.testing.assert_allclose(front(anisotropic_binary()).values, front(text).values, rtol=1e-4)


def test_speos_sample_angles_become_rotations_all_around():
    table = front(anisotropic(turns=(0, 45, 90), factors=(1.0, 2.0, 3.0), spectrum=((400, 10.0),)))
    np.testing.assert_allclose(np.degrees(table.rotations), np.arange(0, 360, 45))
    shares = [albedo_of(table, np.radians(30.0), p)[0] for p in table.rotations]
    np.testing.assert_allclose(shares, 0.1 * np.array([1, 2, 3, 2, 1, 2, 3, 2]), rtol=0.01)


def test_speos_sample_angles_with_the_same_values_are_one():
    file = read(anisotropic(turns=(0, 90, 180)))
    assert len(file.sides["front_reflection"].rotations) == 1
    assert "same values at all anisotropy angles" in told(file)


def test_speos_brdf_holds_both_sides_of_a_pane():
    file = read(brdf_text())
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

    table = front(mdl(skewed))
    assert_same(table, skewed, (3.0, 33.0, 63.0), 0.06)


def test_mdl_holds_both_sides():
    file = read(
        mdl(lambda wi, wo: np.full(len(wi), 0.25 / np.pi), marks=("_REFLECTION", "_TRANSMISSION"))
    )
    assert list(file.sides) == ["front_reflection", "front_transmission"]
    for table in file.sides.values():
        assert total(table, np.radians(45.0))[0] == pytest.approx(0.25, rel=1e-3)


# ---- amounts ----


def test_zemax_blocks_are_scaled_to_their_totals():
    file = read(zemax(totals=(0.1, 0.2, 0.3)))
    table = file.sides["front_reflection"]
    shares = [albedo_of(table, np.radians(s))[0] for s in (0, 30, 60)]
    np.testing.assert_allclose(shares, [0.1, 0.2, 0.3], rtol=1e-5)
    np.testing.assert_allclose(file.stated["front_reflection"], [0.1, 0.2, 0.3])
    assert "were scaled" in told(file)


def test_zemax_keeps_the_luminous_value_of_colours():
    file = read(zemax(content="XYZ"))
    assert "colour is left out" in told(file)
    assert_same(file.sides["front_reflection"], handed, (0, 30, 60), 0.02)


def test_values_that_send_away_more_light_than_comes_are_told():
    file = read(zemax(lambda wi, wo: np.ones(len(wi)), totals=(0, 0, 0)))
    assert "sends away 3.14 times the light" in told(file)
    assert "divide by pi" in told(read(mdl(lambda wi, wo: np.ones(len(wi)))))


def test_negative_values_are_taken_as_nothing_and_told():
    file = read(zemax(lambda wi, wo: np.where(wo[:, 0] > 0.8, -1.0, 0.1), totals=(0, 0, 0)))
    assert file.sides["front_reflection"].values.min() == 0.0
    assert "are negative" in told(file)


def test_speos_spectrum_is_the_total_in_its_own_direction():
    file = read(anisotropic())
    table = file.sides["front_reflection"]
    np.testing.assert_allclose(total(table, np.radians(30.0)), [0.5, 0.25], rtol=3e-3)
    # In other directions values are as many times larger as the file has them.
    ratio = reflectance(handed, 60) / reflectance(handed, 30)
    assert total(table, np.radians(60.0))[0] == pytest.approx(0.5 * ratio, rel=5e-3)
    np.testing.assert_array_equal(file.stated["front_reflection"], [np.nan, 0.375, np.nan])


def test_missing_directions_are_told():
    assert "no values beyond 60 degrees" in told(read(anisotropic(thetas=range(0, 61, 6))))


def test_mixtures_have_the_shares_that_they_state():
    file = read(scattering())
    for side, part in (("front_reflection", 1.0), ("front_transmission", 0.1)):
        table = file.sides[side]
        for incidence, direct in ((0.0, 0.04), (60.0, 0.1)):
            wi = polar(np.array([incidence]), 0.0)
            assert direct_share(table, wi)[0, 0] == pytest.approx(part * direct, rel=1e-5)
            share = albedo_of(table, np.radians(incidence))[0]
            assert share == pytest.approx(part * 0.5, rel=5e-3)
    assert "taken as direct, Lambertian and Gaussian share" in told(file)


def test_simple_mixtures_share_what_is_not_absorbed():
    table = front(simple("20 30 60 20"))
    wi = polar(np.array([40.0]), 0.0)
    assert total(table, np.radians(40.0))[0] == pytest.approx(0.8, rel=5e-3)
    assert direct_share(table, wi)[0, 0] == pytest.approx(0.08, rel=1e-5)
    # Half of the lobe's top at half of its full width, in and across the plane of incidence.
    at, matt = np.array([0.0, 0.0, 0.0]), 0.8 * 0.3 / np.pi
    radial, azimuth = np.radians([0.0, 10.0, 10.0]), np.radians([0.0, 90.0, 180.0])
    wo = direction_of(at, radial, azimuth)
    top, side, ahead = evaluate_table(table, polar(np.zeros(3), 0.0), wo)[:, 0] - matt
    assert side / top == pytest.approx(0.5, rel=0.03)
    assert ahead / top == pytest.approx(0.5, rel=0.03)


def test_a_lambertian_mixture_has_the_same_value_everywhere():
    table = front(simple("0 100 0 5"))
    wi, wo = pairs((0.0, 40.0, 70.0))
    np.testing.assert_allclose(evaluate_table(table, wi, wo), 1.0 / np.pi, rtol=1e-5)
    assert list(read(simple(mode="Transmission")).sides) == ["front_transmission"]


def test_lobes_as_narrow_as_a_mirror_are_direct():
    wi = polar(np.array([30.0]), 0.0)
    assert direct_share(front(simple("0 40 60 0.1")), wi)[0, 0] == pytest.approx(0.6)


@pytest.mark.parametrize("data", [coated(), bsdf180()])
def test_coatings_are_direct_and_the_mean_of_both_polarisations(data):
    file = read(data)
    mean = 0.01 * SHARES.mean(axis=1)
    for k, kind in enumerate(("reflection", "transmission")):
        np.testing.assert_allclose(file.sides[f"front_{kind}"].direct[0], mean[..., k], atol=1e-6)
        assert not file.sides[f"front_{kind}"].values.any()
    if len(file.sides) > 2:
        np.testing.assert_allclose(
            file.sides["back_reflection"].direct[0], 0.5 * mean[..., 0], atol=1e-6
        )
    assert file.name.startswith("glass")


# ---- colours ----


def test_colours_come_back_under_daylight():
    rng = np.random.default_rng(3)
    wanted = np.concatenate([np.eye(3), 1.0 - np.eye(3), rng.random((200, 3))])
    wavelengths, spectra = spectra_of_rgb(wanted)
    fine = np.stack([np.interp(GRID, wavelengths, each) for each in spectra])
    light = illuminant(GRID, "D65")
    xyz = fine @ (light[:, None] * observer()) / (light @ observer()[:, 1])
    np.testing.assert_allclose(xyz @ XYZ_TO_REC709.T, wanted, atol=1e-5)
    assert spectra.min() >= 0.0
    assert spectra.max() <= 1.0


def test_greys_are_the_same_at_all_wavelengths_and_nothing_is_negative():
    greys = np.array([0.0, 1e-6, 0.18, 1.0, 300.0])
    spectra = spectra_of_rgb(np.repeat(greys[:, None], 3, axis=1))[1]
    assert (spectra == greys[:, None]).all()
    wild = spectra_of_rgb(np.random.default_rng(4).normal(size=(500, 3)))[1]
    assert wild.min() >= 0.0


def test_mdl_colours_become_spectra():
    file = read(mdl(lambda wi, wo: np.full(len(wi), 0.5 / np.pi), colour=(0.8, 0.2, 0.1)))
    assert "Rec. 709" in told(file)
    table = file.sides["front_reflection"]
    wavelengths, spectra = spectra_of_rgb([[0.4, 0.1, 0.05]])
    wanted = np.interp(table.wavelengths, wavelengths, spectra[0])
    np.testing.assert_allclose(total(table, np.radians(33.0)), wanted, rtol=2e-3)


# ---- packing ----


def test_lz4_repeats_what_was_unpacked():
    # One plain letter, 19 more from one place back, then one plain letter.
    assert unpack_lz4(b"\x1fa\x01\x00\x00\x10b", 21) == b"a" * 20 + b"b"
    assert unpack_lz4(b"\x32abc\x03\x00\x10!", 10) == b"abcabcabc!"
    # Too far back, and another size than stated.
    assert unpack_lz4(b"\x1fa\x02\x00\x00\x10b", 21) is None
    assert unpack_lz4(b"\x1fa\x01\x00\x00\x10b", 20) is None


# ---- what is wrong ----


def changed(data: bytes, old: bytes, new: bytes) -> bytes:
    assert old in data
    return data.replace(old, new, 1)


FOUR_GIGABYTES = struct.pack("<I", 0xFFFFFFFF)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (changed(zemax(), b"Asymmetrical", b"Twisted"), "states 'Twisted' as symmetry"),
        (changed(zemax(), b"BRDF", b"BSSRDF"), "states 'BSSRDF' as scattertype"),
        (changed(zemax(), b"SampleRotation 1\n0\n", b""), "lacks the keyword 'samplerotation'"),
        (changed(zemax(), b"ScatterRadial 31", b"ScatterRadial 30"), "has the keyword '180'"),
        (changed(zemax(), b"ScatterRadial 31", b"ScatterRadial 900"), "has 'Monochrome' among angles"),
        (changed(zemax(), b"ScatterRadial 31", b"ScatterRadial 90000"), "more than the file can hold"),
        (changed(zemax(), b"ScatterAzimuth 25", b"ScatterAzimuth 99999999999"), "expected a whole number"),
        (changed(zemax(), b"0\t30\t60", b"0\t30\t95"), "expected 0 to 90"),
        (changed(zemax(), b"0\t30\t60", b"0\t30\t30"), "same angle of incidence twice"),
        (changed(zemax(), b"TIS 0", b"TIS 3"), "as TIS, expected a number from 0 to 1.02"),
        (changed(zemax(), b"0\t6\t12", b"0\t6\t6"), "do not ascend"),
        (changed(zemax(), b"DataEnd", b""), "ends before 'dataend'"),
        (zemax(azimuths=range(0, 181, 15)), "expected 0 to 360"),
        (zemax()[:-4000], "ends after"),
        (b"MATE A\n.5 1.5 0\nCOAT AR\nA .25\nscarce", "thin-film coatings"),
        (changed(lighttools(), b"Side Front", b"Side Top"), "has the side 'top'"),
        (changed(lighttools(), b"AOI 30", b"AOI 0"), "expected one for each"),
        (lighttools(azimuths=range(45, 180, 15)), "leave out one side"),
        (b"OPTIS - Spectrum file v1.0\n", "begins with 'OPTIS - Spectrum file v1.0'"),
        (changed(anisotropic(), b"description\n1\t0", b"description\n1\tx"), "has 'x' among the direction"),
        (changed(anisotropic(), b"16 25\n", b"16 24\n"), "has polar angles that do not ascend"),
        (changed(anisotropic(), b"16 25\n", b"9000 9000\n"), "81000000 values"),
        (changed(anisotropic(), b"\n11\n", b"\n100001\n"), "length of the description"),
        (anisotropic(spectrum=((700, 50.0), (400, 50.0))), "wavelengths that do not ascend"),
        (anisotropic(lambda wi, wo: np.zeros(len(wi))), "has no light"),
        (anisotropic(phis=range(0, 136, 15)), "neither all around nor from 0 to 180"),
        (anisotropic() + b"5 5 5", None),
        (changed(anisotropic_binary(), b"\n1\x03", b"\n1\x04"), "export the file in text mode"),
        (anisotropic_binary()[:900], "cut short"),
        (changed(anisotropic_binary(), struct.pack("<II", 16, 25), struct.pack("<II", 16, 26)), "expected"),
        (changed(brdf_text(), b"\n0\ncomment", b"\n1\ncomment"), "text mode"),
        (changed(scattering(), b"2 2", b"2 3"), "wavelengths"),
        (changed(scattering(), b"\t4\t", b"\t400\t"), "expected|not 0 to 100"),
        (simple("20 30 90 20"), "at most 100 together"),
        (simple(mode="Glow"), "expected Reflection or Transmission"),
        (changed(coated(), b"95", b"99"), "expected 0 to 100"),
        (changed(bsdf180(), b"Coated surface file v2", b"Coated surface file v3"), "another kind"),
        (bsdf180()[:-10], "cut short"),
        (b"OPTIS - BSDF180 file v1\n\4\0\0\0" + packed(b"both", 1 << 30), "which cannot be"),
        (b"OPTIS - BSDF180 file v1\n\4\0\0\0" + packed(bytes(900), 800), "to another size"),
        (b"NVIDIA ARC MBSDF V1\n", "has no data"),
        (b"file format error NVIDIA ARC MBSDF V1\n", "expected to begin with"),
        (mdl()[:-1], "cut short"),
        (mdl() + b"\0", "1 bytes after the data"),
        (changed(mdl(), struct.pack("<I", 24), FOUR_GIGABYTES), "expected 1 to"),
        (changed(mdl(), struct.pack("<I", 15), struct.pack("<I", 9999)), "cut short"),
        (b"NVIDIA ARC MBSDF V1\nMBSDF_DATA=\n" + mdl_block(np.full((1, 1, 2), np.nan)), "no numbers up to"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_one_sentence(data, message):
    if message is None:
        assert read(data).sides
        return
    with pytest.raises(FileFormatError, match=message) as caught:
        read(data)
    assert str(caught.value).startswith("surface")
    assert "\n" not in str(caught.value)


# ---- real files ----


def real(name: str):
    return read((DATA / name).read_bytes())


def differences(one, other, incidence, steepest):
    """Factor between two tables about the mirror direction, and deviation from it root mean square, also if mirrored."""
    rng = np.random.default_rng(1)
    radial, azimuth = np.radians(steepest) * rng.random(20000), 2.0 * np.pi * rng.random(20000)
    wo = direction_of(np.full(20000, incidence), radial, azimuth)
    wo = wo[wo[:, 2] > np.cos(np.radians(80.0))]
    wi = np.broadcast_to(polar(np.degrees(incidence), 0.0), wo.shape)
    a, b, c = (
        evaluate_table(table, wi, directions)[:, 0]
        for table, directions in ((one, wo), (other, wo), (other, wo * [1.0, -1.0, 1.0]))
    )
    factor = np.median(b / a)
    rms = np.sqrt((a**2).mean())
    return factor, *(np.sqrt(((each / factor - a) ** 2).mean()) / rms for each in (b, c))


@needs_data
def test_a_measured_paint_of_zemax_has_its_totals_by_itself():
    """The sphere that measured it integrated the values that it wrote, held where it saw nothing."""
    file = real("zemax/planesymmetric_brdf.bsdf")
    assert told(file).count("|") == 0
    assert "no values farther than 80 degrees from the mirror direction" in told(file)
    assert len(file.incidences) == 13
    assert file.stated["front_reflection"][0] == pytest.approx(0.134506)


@needs_data
def test_a_sample_has_the_same_handedness_in_zemax_and_speos():
    one = real("zemax/asymmetrical_one_wavelength_BRDF.bsdf").sides["front_reflection"]
    data = (DATA / "speos/one_wavelength.brdf").read_bytes()
    # The error of resampling must not hide how near the two files are.
    other = read_speos(data, "one_wavelength.brdf", 0.005).sides["front_reflection"]
    found = np.array([differences(one, other, incidence, 80.0) for incidence in one.incidences])
    np.testing.assert_allclose(found[:, 0], 1.0, atol=0.02)
    assert found[:, 1].max() < 0.02
    assert found[:, 1].sum() < 0.6 * found[:, 2].sum()


@needs_data
def test_a_converted_paint_is_what_it_was_made_of():
    one = real("zemax/planesymmetric_brdf.bsdf").sides["front_reflection"]
    other = real("speos/planesymmetric_brdf_reference.anisotropicbsdf").sides["front_reflection"]
    np.testing.assert_allclose(other.incidences, one.incidences, atol=1e-9)
    for k in (0, 3, 6):
        incidence = one.incidences[k]
        # The converter has nothing where the values of the other hold, so the rest of the same light is brighter.
        factor, off, _ = differences(one, other, incidence, 40.0)
        assert 1.0 < factor < 1.2
        assert off < 0.02
        share = albedo_of(other, incidence)[0] / albedo_of(one, incidence)[0]
        assert share == pytest.approx(1.0, abs=0.01)


@needs_data
def test_real_binary_and_text_files_of_speos_hold_the_same():
    text = real("speos/aniso_bsdf.anisotropicbsdf").sides["front_reflection"]
    binary = real("speos/R_test.anisotropicbsdf").sides["front_reflection"]
    np.testing.assert_array_equal(binary.values, text.values)
    # The spectrum is for 6 degrees.
    at_five, at_ten = (total(text, np.radians(s))[0] for s in (5.0, 10.0))
    assert 0.8 * at_five + 0.2 * at_ten == pytest.approx(0.6227, rel=3e-3)


@needs_data
def test_real_coatings_agree_between_both_files():
    one, both = real("speos/coating_air_substrate.coated"), real("speos/coating_reference.bsdf180")
    for side in ("front_reflection", "front_transmission"):
        np.testing.assert_allclose(one.sides[side].direct, both.sides[side].direct, atol=1e-6)
    # From inside the glass all light is reflected beyond the critical angle, 41.2 degrees for n = 1.5168.
    back = both.sides["back_transmission"]
    assert back.direct[0, back.incidences > np.radians(42.0)].max() == 0.0
    assert back.direct[0, back.incidences < np.radians(40.0)].min() > 0.3


@needs_data
def test_a_measured_car_paint_is_red_and_reflects_less_than_all(monkeypatch):
    # A coarse table has the same light, and is made sooner.
    monkeypatch.setattr("lumenray.engine.scattering.readers.slices.MOST_NODES", 1 << 13)
    table = real("mdl/carpaint_red.mbsdf").sides["front_reflection"]
    for incidence in table.incidences[::11]:
        share = total(table, incidence)
        assert share.max() < 0.3
        assert share[-1] > 1.5 * np.interp(540.0, table.wavelengths, share)


@needs_data
def test_real_files_that_are_no_scattering_are_refused():
    for name in (
        "zemax/coating_zemax.dat",
        "mdl/test_none.mbsdf",
        "mdl/test_file_format_error.mbsdf",
    ):
        with pytest.raises(FileFormatError):
            real(name)


@pytest.mark.parametrize(
    "make", [scattering_files.lighttools, scattering_files.anisotropic, scattering_files.mdl]
)
def test_the_wanted_error_of_resampling_counts(make):
    coarse, fine = (
        next(iter(parse_scattering(make(), "x", Wish(e)).sides.values())) for e in (0.1, 0.01)
    )
    assert fine.error <= 0.01 < coarse.error <= 0.1
    assert fine.values.size > coarse.values.size
