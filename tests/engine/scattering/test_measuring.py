"""From counts to a table: a known paint is recovered from a noisy instrument, and what is told about it is true."""

from dataclasses import replace

import numpy as np
import pytest
from instruments import DARK, INCIDENCES, REFERENCE_DARK, STEEPEST, WHITE, measure, paint, text_of

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.scattering.data.table import (
    albedo_of,
    check_table,
    direction_of,
    evaluate_table,
)
from lumenray.engine.scattering.measuring.calibration import calibrate
from lumenray.engine.scattering.measuring.processing import process_measurement
from lumenray.engine.scattering.measuring.raw_measurement import (
    Instrument,
    is_raw_measurement,
    read_raw_measurement,
)

BANDS = np.arange(390.0, 711.0, 10.0)

FEW = np.array([450.0, 550.0, 650.0])

FINE = np.radians(
    [0, 0.2, 0.4, 0.6, 0.8, 1, 1.3, 1.6, 2, 2.5, 3, 4, 5, 6, 8, 10, 13, 16, 20, 25, 30, 40, 50, 60, 75, 90, 110]
)  # fmt: skip
"""Radial angles that resolve a mirror's peak."""


def pairs(incidence, seed=9):
    """Light at angles of incidence, and directions within what was measured, half within 25 degrees of the mirror's."""
    rng = np.random.default_rng(seed)
    count = len(incidence)
    wi = np.stack([np.sin(incidence), 0.0 * incidence, np.cos(incidence)], axis=1)
    z, turn = rng.uniform(np.cos(STEEPEST), 1.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    sine = np.sqrt(1.0 - z**2)
    wo = np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=1)
    near = direction_of(incidence, np.radians(25.0) * rng.random(count), turn)
    chosen = (np.arange(count) % 2 == 0) & (near[:, 2] > np.cos(STEEPEST))
    return wi, np.where(chosen[:, None], near, wo)


def off(table, evaluate, incidence):
    """Difference relative to the value plus 0.02 / sr, root mean square."""
    wi, wo = pairs(np.asarray(incidence))
    true = evaluate(wi, wo)
    return float(np.sqrt((((evaluate_table(table, wi, wo) - true) / (true + 0.02)) ** 2).mean()))


@pytest.fixture(scope="module")
def noisy():
    """33 bands, 3 % noise, 10 % of the directions and 5 % of the single bands missing, dark counts, a drifting lamp."""
    return process_measurement(measure(paint(BANDS), BANDS))


@pytest.mark.slow
def test_a_paint_is_recovered_within_two_per_cent(noisy):
    rng = np.random.default_rng(2)
    check_table(noisy.table)
    assert off(noisy.table, paint(BANDS), rng.choice(INCIDENCES, 4000)) < 0.02
    # Between the measured angles of incidence too, and from there to the normal.
    assert off(noisy.table, paint(BANDS), np.radians(rng.uniform(10.0, 60.0, 4000))) < 0.02
    assert off(noisy.table, paint(BANDS), np.radians(rng.uniform(0.0, 10.0, 4000))) < 0.02


def test_what_is_stated_about_errors_is_true(noisy):
    # 3 % of the sample and 1 % of the white one.
    assert noisy.residual == pytest.approx(np.hypot(0.03, 0.01), rel=0.1)
    # At the directions of the measurement, as that is what the statistical error is stated for.
    square = []
    for piece in measure(paint(BANDS), BANDS).slices:
        wi = np.tile(
            [np.sin(piece.incidence), 0.0, np.cos(piece.incidence)], (len(piece.radial), 1)
        )
        wo = direction_of(piece.incidence, piece.radial, piece.azimuth)
        true = paint(BANDS)(wi, wo)
        square.append((evaluate_table(noisy.table, wi, wo) / true - 1.0) ** 2)
    actual = np.sqrt(np.concatenate(square).mean())
    assert 0.5 * actual < noisy.statistical_error < 2.0 * actual
    assert noisy.table.error == noisy.statistical_error
    assert noisy.missing == pytest.approx(0.15, abs=0.03)
    assert noisy.reciprocity < 0.02


@pytest.mark.slow
def test_no_more_light_leaves_than_comes(noisy):
    for angle in np.radians([0, 10, 35, 60, 75, 85, 89.9]):
        assert albedo_of(noisy.table, angle).max() <= 1.0
    # A white sample that is certified far too bright makes a sample that shines.
    white = measure(lambda wi, wo: np.full((len(wi), 3), WHITE), FEW, noise=0.01, holes=0.0)
    made = process_measurement(replace(white, white_brdf=np.full(3, 1.3 / np.pi)))
    shares = [albedo_of(made.table, angle).max() for angle in np.radians(np.arange(0, 90, 3))]
    assert max(shares) <= 1.0 + 1e-6
    assert max(shares) > 0.98
    assert "bands were scaled to 100 %" in "; ".join(map(str, made.remarks))


def test_dark_counts_and_the_lamp_have_no_influence():
    """Without noise the calibrated values are exact, whatever the lamp did."""
    raw = measure(paint(FEW), FEW, noise=0.0)
    for piece in calibrate(raw):
        wi = np.tile(
            [np.sin(piece.incidence), 0.0, np.cos(piece.incidence)], (len(piece.radial), 1)
        )
        true = paint(FEW)(wi, direction_of(piece.incidence, piece.radial, piece.azimuth))
        known = np.isfinite(piece.values)
        assert 0.8 < known.mean() < 0.95
        np.testing.assert_allclose(piece.values[known], true[known], rtol=1e-9)


def test_saturated_and_dark_counts_are_no_data():
    raw = measure(paint(FEW), FEW, noise=0.0, holes=0.0)
    first = raw.slices[0]
    top = float(np.percentile(first.sample - DARK, 90.0))
    limited = replace(raw, instrument=Instrument(lowest=0.0, highest=top))
    values = calibrate(limited)[0].values
    np.testing.assert_array_equal(np.isnan(values), first.sample - DARK > top)
    dimmed = replace(first, sample=np.full_like(first.sample, DARK))
    assert np.isnan(calibrate(replace(raw, slices=(dimmed,)))[0].values).all()


@pytest.mark.slow
def test_light_along_the_normal_is_the_even_parabola_of_the_logarithm():
    """A surface of the BRDF exp(a + b s^2) is exact: (4 f(10) - f(20)) / 3 of the logarithms."""

    def even(wi, wo):
        angle = np.arccos(wi[:, 2])
        return np.repeat(0.05 * np.exp(1.5 * angle**2)[:, None], 3, axis=1)

    made = process_measurement(measure(even, FEW, noise=0.0, holes=0.0))
    np.testing.assert_allclose(made.table.values[0, 0], 0.05, rtol=2e-3)
    # At the horizon stands what was measured last.
    np.testing.assert_allclose(made.table.values[0, -1], made.table.values[0, -2])


def mirror(share, width, matt=0.5 / np.pi):
    """A matt surface with a smooth coat, whose mirror image an instrument of a resolution sees as a bell."""

    def evaluate(wi, wo):
        away = 2.0 * np.arcsin(0.5 * np.linalg.norm(wi * [-1.0, -1.0, 1.0] - wo, axis=1))
        bell = (
            np.exp(-4.0 * np.log(2.0) * (away / width) ** 2)
            * 4.0
            * np.log(2.0)
            / (np.pi * width**2)
        )
        return np.repeat((matt + share * bell / wi[:, 2])[:, None], 3, axis=1)

    return evaluate


@pytest.mark.slow
def test_the_image_of_the_lamp_becomes_a_mirrors_share():
    width = np.radians(1.0)
    raw = measure(mirror(0.05, width), FEW, radials=FINE, resolution=width)
    made = process_measurement(raw)
    np.testing.assert_allclose(made.table.direct, 0.05, rtol=0.03)
    np.testing.assert_allclose(made.table.values, 0.5 / np.pi, rtol=0.03)
    assert "a mirror's peak of 5 %" in str(made.remarks[0])


@pytest.mark.slow
def test_a_narrow_lobe_of_the_surface_stays_a_lobe():
    """Three times as wide as the instrument's own profile: no mirror, and not smoothed away."""
    lobe = mirror(0.05, np.radians(3.0))
    made = process_measurement(measure(lobe, FEW, radials=FINE, resolution=np.radians(1.0)))
    assert made.table.direct is None
    tilt = INCIDENCES[2]
    wi = np.tile([np.sin(tilt), 0.0, np.cos(tilt)], (5, 1))
    wo = direction_of(np.full(5, tilt), np.radians([0.0, 0.5, 1.0, 1.5, 2.0]), np.full(5, 1.0))
    np.testing.assert_allclose(evaluate_table(made.table, wi, wo), lobe(wi, wo), rtol=0.04)


@pytest.mark.slow
def test_wide_bands_are_undone():
    """Of a parabola a triangular band of the width d tells f + f'' d^2 / 12: exactly what is taken off again."""
    bands = np.arange(400.0, 701.0, 20.0)
    true = 0.1 + 0.1 * ((bands - 550.0) / 150.0) ** 2
    seen = true + 0.2 / 150.0**2 * 20.0**2 / 12.0

    def evaluate(wi, wo):
        return np.tile(seen, (len(wi), 1))

    raw = measure(evaluate, bands, incidences=INCIDENCES[:2], noise=0.0, holes=0.0, bandwidth=20.0)
    made = process_measurement(raw)
    np.testing.assert_allclose(made.table.values[0, 1, 0, 0, 1:-1], true[1:-1], rtol=2e-4)
    assert "bands are 20 nm wide, which is corrected for" in "; ".join(map(str, made.remarks))


def test_the_plane_of_incidence_is_there_before_and_after(noisy):
    assert [cut.incidence for cut in noisy.cuts] == pytest.approx(list(INCIDENCES))
    cut = noisy.cuts[3]
    assert np.all(np.diff(cut.angles) >= 0.0)
    table = np.stack(
        [np.interp(cut.angles, cut.table_angles, band) for band in cut.table.T], axis=1
    )
    difference = cut.measured / table - 1.0
    assert np.sqrt(np.nanmean(difference**2)) < 0.05
    # The lobe is on the positive side.
    assert np.degrees(cut.table_angles[cut.table[:, 16].argmax()]) == pytest.approx(45.0, abs=2.0)


def test_too_few_directions_are_refused():
    raw = measure(paint(FEW), FEW)
    piece = raw.slices[1]
    blind = piece.sample.copy()
    blind[10:, 2] = np.nan
    poor = (raw.slices[0], replace(piece, sample=blind))
    with pytest.raises(SceneError, match=r"valid directions at the incidence 20° and 650 nm"):
        process_measurement(replace(raw, slices=poor))


# ---- the text ----


def test_counts_come_back_from_their_text():
    raw = measure(paint(FEW), FEW, incidences=INCIDENCES[:2], radials=FINE[::6])
    dark = f"# dark: {DARK}", f"# reference dark: {REFERENCE_DARK}"
    data = text_of(raw, *dark, "# resolution: 1.5", "# highest: 200000")
    assert is_raw_measurement(data)
    made = read_raw_measurement(data, "raw.csv")
    np.testing.assert_array_equal(made.wavelengths, FEW)
    np.testing.assert_allclose(made.dark, DARK)
    assert made.instrument.resolution == pytest.approx(np.radians(1.5))
    assert made.instrument.highest == 200000.0
    for mine, theirs in zip(calibrate(made), calibrate(raw), strict=True):
        order = np.lexsort((theirs.azimuth.round(9), theirs.radial.round(9)))
        np.testing.assert_allclose(mine.radial, theirs.radial[order], atol=1e-9)
        np.testing.assert_allclose(mine.azimuth, theirs.azimuth[order], atol=1e-9)
        np.testing.assert_allclose(mine.values, theirs.values[order], rtol=1e-9)


HEAD = "# lumenray raw measurement 1\n# white brdf: 0.312\n"
NAMES = "sigma theta phi wavelength sample sample_reference white white_reference\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# lumenray raw measurement 3\n", "line 1: does not begin with"),
        (HEAD, "no line that names its columns"),
        (HEAD + NAMES, "no rows"),
        (HEAD + NAMES.replace(" white ", " black ") + "10 0 0 550 1 1 1 1\n", "lacks the column 'white'"),
        (HEAD + NAMES + "10 0 0 550 1 1 1\n", "line 4: has 7 columns, expected 8"),
        (HEAD + NAMES + "100 0 0 550 1 1 1 1\n", "line 4: has 100 as sigma, expected 0 to 89"),
        (HEAD + NAMES + "10 0 0 5 1 1 1 1\n", "has 5 as wavelength"),
        (HEAD + NAMES + "10 0 0 550 1e20 1 1 1\n", "has 1e\\+20 as sample"),
        ("# lumenray raw measurement 1\n" + NAMES + "10 0 0 550 1 1 1 1\n", "states no BRDF of the white sample"),
        (HEAD.replace("0.312", "x") + NAMES + "10 0 0 550 1 1 1 1\n", "states 'white brdf: x'"),
        (HEAD + "# shot: -1\n" + NAMES + "10 0 0 550 1 1 1 1\n", "states 'shot: -1', expected 0 to"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_text_is_said_in_one_sentence(text, message):
    with pytest.raises(FileFormatError, match=message):
        read_raw_measurement(text.encode(), "raw.csv")
