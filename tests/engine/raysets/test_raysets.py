"""Ray files: what is read of every format, what is refused or mended, and what is written."""

import struct

import numpy as np
import pytest
from folders import WILD
from ray_files import (
    COUNT,
    asap,
    lambert_rays,
    lighttools,
    lighttools_text,
    speos,
    tm25,
    tracepro_text,
    zemax,
    zemax_text,
)

from lumenray.engine.errors import Cancelled, FileFormatError, LumenrayError
from lumenray.engine.raysets.reader import read_rays, read_rayset
from lumenray.engine.raysets.survey import survey_rays
from lumenray.engine.raysets.text import Assumed
from lumenray.engine.raysets.writers import write_tm25, write_zemax

DATA = WILD / "rayset"

RAYS = lambert_rays()
NANOMETRES = np.where(np.arange(COUNT) % 2, 450.0, 620.0)[:, None].astype("<f4")
RADIANT = np.concatenate([RAYS, NANOMETRES], axis=1)
MICROMETRES = np.concatenate([RAYS, NANOMETRES / 1000.0], axis=1)
SPEOS = np.concatenate([RAYS[:, :6], NANOMETRES, RAYS[:, 6:]], axis=1)

FORMATS = {
    "TM-25-13": tm25(RAYS, lumens=100.0),
    "Zemax binary": zemax(RAYS),
    "LightTools binary 2.0": lighttools(RAYS),
    "ASAP": asap(RAYS),
    "Zemax text": zemax_text(RAYS),
    "LightTools text": lighttools_text(RAYS),
    "TracePro text": tracepro_text(RAYS),
    "text of rays": tracepro_text(RAYS).split(b"flux\n")[1],
}

COLOURED = {
    "TM-25-13": tm25(
        np.concatenate([RAYS, NANOMETRES], axis=1), (1, 1, 1, 1, 0, 0, 0, 0), kind=2, watts=100.0
    ),
    "Zemax binary": zemax(MICROMETRES, kind=2, quantity=0),
    "LightTools binary 2.0": lighttools(RADIANT, quantity=0, colour=2),
    "SPEOS": speos(SPEOS, watts=100.0),
    "Zemax text": zemax_text(MICROMETRES, kind=2, quantity=0),
    "LightTools text": lighttools_text(RADIANT, kind="radiant_power", colour="wavelength"),
    "text of rays": tracepro_text(MICROMETRES).split(b"flux\n")[1],
}


def write(tmp_path, data: bytes, name: str = "lamp.ray"):
    path = tmp_path / name
    path.write_bytes(data)
    return path


def rays_of(path, **more):
    pieces = list(read_rays(read_rayset(path, **more)))
    return [
        None
        if getattr(pieces[0], name) is None
        else np.concatenate([getattr(p, name) for p in pieces])
        for name in ("position", "direction", "weight", "wavelength", "spectrum")
    ]


# ---- every format ----


@pytest.mark.parametrize("name", FORMATS)
def test_rays_are_what_was_written_whatever_the_files_name(tmp_path, name):
    # The extension says nothing: all have the same.
    path = write(tmp_path, FORMATS[name])
    file = read_rayset(path)
    assert file.format == name
    assert file.count == COUNT
    position, direction, weight, wavelength, _ = rays_of(path)
    np.testing.assert_allclose(position, RAYS[:, :3] * 1e-3, rtol=1e-6)
    np.testing.assert_allclose(direction, RAYS[:, 3:6], atol=2e-7)
    np.testing.assert_allclose(weight, RAYS[:, 6])
    assert wavelength is None


@pytest.mark.parametrize("name", COLOURED)
def test_wavelengths_are_in_nanometres(tmp_path, name):
    path = write(tmp_path, COLOURED[name])
    assert read_rayset(path).format == name
    np.testing.assert_allclose(rays_of(path)[3], NANOMETRES[:, 0], rtol=1e-6)
    made = survey_rays(read_rayset(path))
    assert made.wavelengths == pytest.approx((450.0, 620.0))
    # V(450 nm) = 0.038, V(620 nm) = 0.381 (CIE 018:2019).
    assert made.radiant_flux == pytest.approx(100.0, rel=1e-6)
    expected = 100.0 if name == "SPEOS" else 100.0 * 683.0 * 0.5 * (0.038 + 0.381)
    assert made.luminous_flux == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(
    ("unit", "metres"), [(0, 1.0), (1, 0.0254), (2, 0.01), (3, 0.3048), (4, 0.001)]
)
def test_units_of_length_of_zemax(tmp_path, unit, metres):
    for data in (zemax(RAYS, unit=unit), zemax_text(RAYS, unit=unit)):
        position = rays_of(write(tmp_path, data))[0]
        np.testing.assert_allclose(position, RAYS[:, :3] * metres, rtol=1e-6)


@pytest.mark.parametrize(
    ("unit", "metres"), [(1, 1e-3), (2, 1e-2), (3, 1.0), (4, 0.0254), (5, 0.3048), (6, 1e-6)]
)
def test_units_of_length_of_lighttools(tmp_path, unit, metres):
    position = rays_of(write(tmp_path, lighttools(RAYS, unit=unit)))[0]
    np.testing.assert_allclose(position, RAYS[:, :3] * metres, rtol=1e-6)


def test_rows_without_a_unit_are_taken_as_asked_for(tmp_path):
    path = write(tmp_path, FORMATS["text of rays"])
    file = read_rayset(path, Assumed("inch", "luminous"))
    assert file.quantity == "luminous"
    assert file.scale == 0.0254
    told = " ".join(str(each) for each in file.remarks)
    assert "inch" in told
    assert "luminous" in told


def test_gaps_of_spectra_in_tm25_are_told_of_the_first_few_tables(tmp_path):
    holed = [(float(nm), 1.0) for nm in (*range(380, 500, 5), *range(620, 790, 5))]
    smooth = [(float(nm), 1.0) for nm in range(380, 790, 5)]
    path = write(tmp_path, tm25(RAYS, kind=3, spectra=(smooth, *[holed] * 20)))
    told = [remark.text for remark in read_rayset(path).remarks]
    assert len(told) == 3
    assert told[0].startswith("spectral table 2 has no value between 495 and 620 nm")


def test_additional_columns_tables_and_text_of_tm25_are_stepped_over(tmp_path):
    rows = np.concatenate(
        [RAYS[:, :6], RAYS[:, 6:], np.ones((COUNT, 1)), RAYS[:, 6:], np.zeros((COUNT, 9))], axis=1
    )
    rows[:, 7] = 1.0 + np.arange(COUNT) % 2
    rows = np.concatenate([RAYS[:, :6], RAYS[:, 6:], rows[:, 7:8], np.zeros((COUNT, 2))], axis=1)
    spectra = ([(400.0, 0.0), (500.0, 100.0), (600.0, 0.0)], [(500.0, 1.0), (600.0, 1.0)])
    data = tm25(
        rows,
        (1, 1, 1, 0, 0, 0, 0, 1),
        4,
        watts=100.0,
        spectra=spectra,
        more=("a", "b"),
        text="made by hand",
    )
    path = write(tmp_path, data)
    file = read_rayset(path)
    assert [list(values) for _, values in file.spectra] == [[0.0, 1.0, 0.0], [1.0, 1.0]]
    assert file.metadata["SOURCE"] == "lamp of tests"
    (remark,) = file.remarks
    assert "spectral table 2 begins at 500 nm with 100% of its largest value" in remark.text
    _, direction, weight, _, spectrum = rays_of(path)
    np.testing.assert_allclose(direction, RAYS[:, 3:6], atol=2e-7)
    np.testing.assert_allclose(weight, 0.5)
    np.testing.assert_array_equal(spectrum, np.arange(COUNT) % 2)
    made = survey_rays(file)
    # Each has half of the watts; a flat table from 500 to 600 nm has a tail of the triangle beside it.
    wavelengths, values = made.spectrum
    values /= values.sum()
    assert values[wavelengths < 500.0].sum() == pytest.approx(0.25, abs=0.01)
    assert values[wavelengths > 500.0].sum() == pytest.approx(0.75, abs=0.01)


# ---- the whole ----


def test_extents_centroid_and_axis_are_those_of_the_rays(tmp_path):
    rows = RAYS.copy()
    rows[:, 6] = np.linspace(0.0, 1.0, COUNT)
    made = survey_rays(read_rayset(write(tmp_path, zemax(rows, total=0.0))))
    kept, weight = rows[1:, :3] * 1e-3, rows[1:, 6].astype(np.float64)
    assert made.rays == COUNT - 1
    np.testing.assert_allclose(made.bounds, [kept.min(axis=0), kept.max(axis=0)], rtol=1e-6)
    np.testing.assert_allclose(made.centroid, weight @ kept / weight.sum(), rtol=1e-6)
    np.testing.assert_allclose(made.axis, weight @ rows[1:, 3:6] / weight.sum(), atol=1e-6)
    assert made.luminous_flux == pytest.approx(weight.sum())
    assert "carry no light" in str(made.remarks[0])


@pytest.mark.parametrize(
    ("data", "factor"),
    [
        (tm25(RAYS, lumens=100.0), 1.0),
        (tm25(RAYS, lumens=101.0), 1.0),
        (tm25(RAYS, lumens=None), 1.0),
        (tm25(RAYS, lumens=0.0), 1.0),
        (tm25(RAYS, lumens=1.0), 0.01),
        (speos(SPEOS, watts=5.0), 0.05),
    ],
)
def test_rays_that_do_not_sum_up_to_the_stated_flux_are_scaled(tmp_path, data, factor):
    made = survey_rays(read_rayset(write(tmp_path, data)))
    assert made.factor == pytest.approx(factor, rel=1e-6)
    has_remark = any("sum up to" in str(each) for each in made.remarks)
    assert has_remark == (factor == 0.01)


def test_relative_rays_without_a_flux_are_refused(tmp_path):
    with pytest.raises(FileFormatError, match="states no flux"):
        survey_rays(read_rayset(write(tmp_path, speos(SPEOS, watts=0.0))))


def test_one_wavelength_makes_lumens_of_watts(tmp_path):
    data = tm25(RAYS, (1, 1, 1, 0, 0, 0, 0, 0), 1, watts=100.0, single=555.0)
    made = survey_rays(read_rayset(write(tmp_path, data)))
    assert made.luminous_flux == pytest.approx(68300.0, rel=1e-3)


def test_reading_tells_how_far_it_is_and_can_be_ended(tmp_path, monkeypatch):
    monkeypatch.setattr("lumenray.engine.raysets.binary.PIECE", 64)
    file, told = read_rayset(write(tmp_path, zemax(RAYS))), []
    survey_rays(file, told.append)
    assert told == pytest.approx([0.32, 0.64, 0.96, 1.0])
    with pytest.raises(Cancelled):
        survey_rays(file, cancelled=lambda: True)


def test_lumens_that_contradict_the_watts_and_the_spectrum_are_remarked(tmp_path):
    # 100 W at 555 nm are 68 300 lm.
    def told(lumens):
        data = tm25(RAYS, (1, 1, 1, 0, 0, 0, 0, 0), 1, watts=100.0, single=555.0, lumens=lumens)
        made = survey_rays(read_rayset(write(tmp_path, data)))
        assert made.luminous_flux == pytest.approx(lumens)
        return " ".join(map(str, made.remarks))

    assert told(68_300.0) == ""
    assert "states 6.83e+05 lm, but its 100 W are 6.83e+04 lm by its own spectrum" in told(
        683_000.0
    )
    assert "6830 lm" in told(6830.0)


# ---- what is wrong ----


def test_a_text_without_its_end_is_refused_rather_than_made_brighter(tmp_path):
    whole = lighttools_text(RAYS)
    lines = whole.splitlines(keepends=True)
    for cut in (b"".join(lines[:-1]), b"".join(lines[:-51])):
        with pytest.raises(
            FileFormatError, match=r"is cut short after .* rays: no line lt_endofdata"
        ):
            read_rayset(write(tmp_path, cut))
    with pytest.raises(FileFormatError, match="has 5 numbers, expected 7"):
        read_rayset(write(tmp_path, b"".join(lines[:-2]) + b" ".join(lines[-2].split()[:5])))


@pytest.mark.parametrize("word", ["nan", "-nan(ind)", "1.#QNAN", "Infinity"])
@pytest.mark.parametrize("place", [0, 100, COUNT - 1])
def test_rays_of_texts_that_are_no_numbers_are_counted_wherever_they_are(tmp_path, word, place):
    for text in (tracepro_text(RAYS), lighttools_text(RAYS)):
        lines = text.decode().splitlines()
        first = next(i for i, line in enumerate(lines) if line.endswith(" 0.5"))
        lines[first + place] = " ".join([*lines[first + place].split()[:6], word])
        file = read_rayset(write(tmp_path, "\n".join(lines).encode()))
        assert file.count == COUNT
        made = survey_rays(file)
        assert made.rays == COUNT - 1
        assert (
            f"1 of {COUNT} rays, first number {place + 1}, have numbers that are none"
            in " ".join(map(str, made.remarks))
        )


def test_a_damaged_last_ray_is_no_text_behind_the_rays(tmp_path):
    whole = tracepro_text(RAYS).decode()
    for damaged in (whole.rstrip()[:-3] + "o.5\n", whole + "1 2 x\n"):
        with pytest.raises(FileFormatError, match="expected a number"):
            read_rayset(write(tmp_path, damaged.encode()))
    assert read_rayset(write(tmp_path, (whole + "End of 200 rays\n").encode())).count == COUNT


def test_bad_rays_are_left_out_and_counted(tmp_path):
    rows = lambert_rays(2000)
    rows[3, 6] = np.nan
    rows[5, 3:6] = 0.0
    rows[7, 0] = np.inf
    rows[9, 6] = 0.0
    rows[11, 3:6] *= 2.0
    path = write(tmp_path, tm25(rows, lumens=998.0))
    _, direction, weight, _, _ = rays_of(path)
    assert len(weight) == 1996
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, atol=1e-6)
    told = [str(each) for each in survey_rays(read_rayset(path)).remarks]
    assert any("1 of 2000 rays carry no light" in each for each in told)
    assert any("3 of 2000 rays, first number 4," in each for each in told)
    assert any("1 of 2000 directions" in each for each in told)


def test_too_many_bad_rays_are_an_error(tmp_path):
    rows = RAYS.copy()
    rows[:3, 6] = np.nan
    with pytest.raises(FileFormatError, match="3 of 200 rays, first number 1"):
        rays_of(write(tmp_path, zemax(rows)))


def test_negative_flux_is_an_error(tmp_path):
    rows = RAYS.copy()
    rows[17, 6] = -0.25
    with pytest.raises(FileFormatError, match=r"ray 18 has the flux -0\.25"):
        rays_of(write(tmp_path, zemax(rows)))


def test_files_without_light_are_an_error(tmp_path):
    rows = RAYS.copy()
    rows[:, 6] = 0.0
    with pytest.raises(FileFormatError, match="none of its 200 rays carries light"):
        survey_rays(read_rayset(write(tmp_path, zemax(rows))))


@pytest.mark.parametrize("name", [key for key in FORMATS if "text" not in key])
@pytest.mark.parametrize("cut", [1, 28, 1000])
def test_files_that_are_cut_short_are_told(tmp_path, name, cut):
    path = write(tmp_path, FORMATS[name][:-cut])
    if name.startswith("LightTools"):
        # It states no number of rays, so what is there is used.
        assert "cut short" in str(read_rayset(path).remarks[0])
    else:
        with pytest.raises(FileFormatError, match=r"cut short|no ray file"):
            read_rayset(path)


def swapped(data: bytes, offset: int) -> bytes:
    """The file as a big-endian machine would have written its rows and a number."""
    return data[:offset] + data[offset : offset + 4][::-1] + data[offset + 4 :]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is empty"),
        (b"\x89PNG\r\n\x1a\n" + bytes(100), "no ray file of a known format"),
        (b"hello\nworld\n", "holds no rows of rays"),
        (b"1 2 3 4 5 6\n", "has 6 numbers, expected 7 or 8"),
        (b"1 2 3 0 0 1 1\n1 2 3 0 0 1\n", "line 2: has 6 numbers, expected 7"),
        (b"x" * 5000, "more than 4096 characters"),
        (b"3 4 0 0\n1 2 3 0 0 1 1\n", "states 3 rays, but holds 1"),
        (swapped(tm25(RAYS), 20), "cut short"),
        (swapped(zemax(RAYS), 4), "no ray file"),
        (tm25(RAYS[:0]), "states 0 rays"),
        (tm25(RAYS, (1, 1, 0, 0, 0, 0, 0, 0)), "neither of radiant nor of luminous flux"),
        (tm25(RAYS, (1, 0, 0, 0, 1, 0, 0, 0)), "no column of positions or directions"),
        (tm25(RAYS, (1, 1, 0, 0, 9, 0, 0, 0)), "expected 0 or 1"),
        (tm25(RAYS, kind=2), "and no column of wavelengths"),
        (tm25(RAYS, kind=3), "but holds none"),
        (tm25(RAYS, kind=9), "identifier 9, expected 0 to 4"),
        (tm25(RAYS, kind=3, spectra=([(500.0, 1.0), (400.0, 1.0)],)), "do not ascend"),
        (tm25(RAYS, kind=3, spectra=([(400.0, -1.0), (500.0, 1.0)],)), "negative"),
        (
            tm25(RAYS, kind=3, spectra=([(0.4, 1.0), (0.7, 1.0)],)),
            "end at 0.7, expected nanometres",
        ),
        (
            tm25(
                RAYS, kind=3, spectra=([(nm, 1.0) for nm in (380.0, 480.0, 580.0, 680.0, 7800.0)],)
            ),
            "spectral table 1: wavelength 7800 nm, while the others lie 100 nm apart",
        ),
        (zemax(RAYS, unit=7), "unit code 7"),
        (zemax(RAYS, kind=1), "ray format 1"),
        (zemax(RAYS, quantity=5), "flux type 5"),
        (lighttools(RAYS, major=3), "polarised"),
        (lighttools(RAYS, colour=1), "colour information 1"),
        (lighttools(RAYS, unit=9), "unit code 9"),
        (lighttools_text(RAYS, units="parsecs"), "unit of length 'parsecs'"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(tmp_path, data, message):
    path = write(tmp_path, data)
    with pytest.raises(FileFormatError, match=message) as caught:
        rays_of(path)
    assert str(path) in str(caught.value)


def test_claims_of_billions_of_rays_take_no_memory(tmp_path):
    data = bytearray(tm25(RAYS))
    struct.pack_into("<Q", data, 20, 3_999_999_999)
    with pytest.raises(FileFormatError, match="cut short"):
        read_rayset(write(tmp_path, bytes(data)))


# ---- writing ----


@pytest.mark.parametrize("write_file", [write_tm25, write_zemax])
@pytest.mark.parametrize("is_coloured", [False, True])
def test_what_is_written_is_read_again(tmp_path, write_file, is_coloured):
    data = COLOURED["LightTools binary 2.0"] if is_coloured else FORMATS["LightTools binary 2.0"]
    first = read_rayset(write(tmp_path, data))
    path = tmp_path / "again"
    assert write_file(path, read_rays(first), first.quantity, factor=2.0) == COUNT
    again = read_rayset(path)
    assert again.quantity == first.quantity
    assert again.stated_flux == pytest.approx(200.0, rel=1e-6)
    for mine, theirs in zip(rays_of(path), rays_of(first.path), strict=True):
        assert (mine is None) == (theirs is None)
        if mine is not None and mine.ndim == 2:
            np.testing.assert_allclose(mine, theirs, atol=3e-7)
    np.testing.assert_allclose(rays_of(path)[2], 1.0)


def test_a_spectrum_of_all_rays_is_kept_by_tm25(tmp_path):
    path = tmp_path / "lamp.tm25ray"
    spectrum = np.array([400.0, 555.0, 700.0]), np.array([0.0, 1.0, 0.25])
    file = read_rayset(write(tmp_path, FORMATS["Zemax binary"]))
    write_tm25(path, read_rays(file), "radiant", spectrum, {"SOURCE": "lamp"})
    again = read_rayset(path)
    assert again.metadata["SOURCE"] == "lamp"
    np.testing.assert_allclose(again.spectra[0], spectrum)


def test_files_without_rays_are_not_written(tmp_path):
    with pytest.raises(LumenrayError, match="no rays with light"):
        write_tm25(tmp_path / "none", [], "luminous")


# ---- real files ----


@pytest.mark.skipif(not DATA.is_dir(), reason="needs ../shared/data/rayset")
def test_real_files_of_one_source_agree_across_formats():
    """Three rays and a cylinder that programs have converted into each other's formats."""
    for names in (
        (
            "lighttools/ThreeRays_Wavelength.1.ray",
            "lighttools/ThreeRays_Wavelength.1.txt",
            "lighttools/ThreeRays_Wavelength_ZMW_to_LT.ray",
            "zemax/ThreeRays_Wavelength_ZMX.ray",
        ),
        ("lighttools/Cyl10k.1.ray", "tm25/Cyl10k.1.tm25ray"),
        ("speos/test_08_ray.ray", "zemax/test_08_ray_reference.sdf"),
        ("zemax/test_08_sdf.sdf", "speos/test_08_sdf_reference.ray"),
    ):
        first, *others = (survey_rays(read_rayset(DATA / name)) for name in names)
        for other in others:
            np.testing.assert_allclose(other.bounds, first.bounds, atol=1e-8)
            np.testing.assert_allclose(other.centroid, first.centroid, atol=1e-8)
            np.testing.assert_allclose(other.axis, first.axis, atol=1e-6)
            for quantity in ("luminous_flux", "radiant_flux"):
                mine, theirs = getattr(first, quantity), getattr(other, quantity)
                # A file that states lumens is believed, also where another program counts them otherwise.
                if mine is not None and theirs is not None:
                    assert theirs == pytest.approx(mine, rel=0.011)


@pytest.mark.skipif(not DATA.is_dir(), reason="needs ../shared/data/rayset")
def test_a_measured_led_has_the_flux_that_its_maker_states():
    name = "tm25/rayfile_LERTDUW_S2WP_green_100k_20161013_IES_TM25.TM25RAY"
    made = survey_rays(read_rayset(DATA / name))
    assert made.rays == 100_000
    assert made.luminous_flux == pytest.approx(337.0, rel=1e-5)
    assert not made.remarks
    # Green: by its own spectrum within a hundredth of the stated watts.
    from lumenray.engine.raysets.survey import _efficacy

    assert made.luminous_flux / _efficacy(np.zeros(1), made.spectrum) == pytest.approx(
        0.694, rel=0.02
    )
