"""Tables of woven cloths: no light is made, openings are as wide as they are, ways and colours as dyes have them."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mitsuba")

from lumenray.engine.cloth.composition import Cloth, Scatterers, Yarn
from lumenray.engine.cloth.readings import hue_saturation_value, read_sheet
from lumenray.engine.cloth.weave import plain
from lumenray.engine.optical_constants.curves import Curve
from lumenray.engine.paint.composition import Diameters
from lumenray.engine.scattering.data.evaluation import evaluate, measure_reciprocity, totals
from lumenray.engine.transport import backend

pytestmark = [pytest.mark.mitsuba, pytest.mark.slow]

BANDS = np.array([450.0, 550.0, 650.0])

RAYS = 3000


def yarn(width: float, absorption=0.0) -> Yarn:
    dye = np.broadcast_to(np.asarray(absorption, float), BANDS.shape)
    voids = Scatterers(Curve(BANDS[:1], np.ones(1)), Diameters(0.5), 0.005)
    return Yarn(width, width, 1.557, 0.3, (voids,), Curve(BANDS, dye))


def compute(thread: Yarn, rays: int = RAYS):
    backend.start(spectral=False)
    from lumenray.engine.cloth.woven import weave

    return weave(Cloth(thread, thread, plain(0.2, 0.2)), BANDS, rays=rays, exits=48)


@pytest.fixture(scope="module")
def white():
    return compute(yarn(0.14))


@pytest.fixture(scope="module")
def red():
    return compute(yarn(0.14, [20.0, 20.0, 0.5]))


def test_all_light_of_a_clear_cloth_leaves_it(white):
    """T1 and T2: reflected, spread behind it and straight are 1 from everywhere, so that it is invisible in a furnace."""
    table = white.sides["front_reflection"]
    both = sum(
        totals(white.sides[side], table.incidences, table.rotations)
        for side in ("front_reflection", "front_transmission")
    )
    assert both == pytest.approx(1.0, abs=1e-6)
    assert np.abs(white.absorbed["front"]).max() < 1e-9
    assert white.lost == 0.0


def test_openings_are_as_wide_as_they_are(white):
    """Straight yarns of d / p = 0.7 leave 0.09 open (B7)."""
    error = np.sqrt(0.09 * 0.91 / (2 * RAYS))
    assert white.openness == pytest.approx(0.09, abs=4.0 * error)


def test_both_ways_of_light_agree(white):
    """T3 of the tables: between 0 and 45 degrees, the mean over azimuths, as each count is of some tens of rays."""
    turn = np.pi / 12.0 * np.arange(24)
    slant = np.stack([np.cos(turn), np.sin(turn), np.ones(24)], axis=1) / np.sqrt(2.0)
    up = np.tile([0.0, 0.0, 1.0], (24, 1))
    for side in ("reflection", "transmission"):
        there, back = (
            evaluate(white.sides[f"{light}_{side}"], *pair).mean()
            for light, pair in (("front", (up, slant)), ("back", (slant, up)))
        )
        assert there == pytest.approx(back, rel=0.12)
        both = measure_reciprocity(white.sides[f"front_{side}"], white.sides[f"back_{side}"])
        # Noise alone is 0.15 at these rays; at the default number 0.03 remains.
        assert both.scattered < 0.2


def test_light_behind_a_red_cloth_is_redder(red):
    """Its ways are longer, without anything that is made for it."""
    table = red.sides["front_reflection"]
    reflected = totals(table, [0.0], [0.0])[0, 0]
    behind = totals(red.sides["front_transmission"], [0.0], [0.0])[0, 0] - red.openness
    assert behind[2] / behind[1] > 1.5 * reflected[2] / reflected[1]
    assert red.absorbed["front"][0, 0, 1] > red.absorbed["front"][0, 0, 2] > 0.0


def test_sheet_states_what_the_tables_hold(red):
    sheet = read_sheet(red)
    assert sheet.diffused == pytest.approx(sheet.transmittance - sheet.openness)
    assert sheet.reflectance == pytest.approx(sheet.back_reflectance)
    assert 0.0 < sheet.cutoff_warp_deg == sheet.cutoff_weft_deg < 46.5
    assert 0.0 < sheet.diffuse_transmittance < sheet.transmittance


def test_hue_of_a_grey_is_none():
    grey = hue_saturation_value(np.full(33, 0.5), np.arange(390.0, 711.0, 10.0))
    assert grey[1] < 0.06
    red = np.where(np.arange(390.0, 711.0, 10.0) > 610.0, 0.8, 0.01)
    hue = hue_saturation_value(red, np.arange(390.0, 711.0, 10.0))[0]
    assert min(hue, 1.0 - hue) < 0.05


def test_more_dye_absorbs_more(red):
    darker = compute(replace(yarn(0.14), absorption=Curve(BANDS, np.full(3, 100.0))))
    assert (darker.absorbed["front"] > red.absorbed["front"]).all()


def test_mean_of_warp_and_weft_is_between_both():
    """Engine (i): no light is made, and half of the light that a warp of d / p = 0.7 leaves passes, half of the weft's."""
    backend.start(spectral=False)
    from lumenray.engine.cloth.woven import weave

    thread, other = yarn(0.14), yarn(0.06)
    made = weave(Cloth(thread, other, plain(0.2, 0.2)), BANDS, rays=1200, exits=48, is_mean=True)
    assert made.openness == pytest.approx(0.5 * (0.3 + 0.7), abs=4.0 * 0.5 / np.sqrt(2400))
    both = sum(
        totals(made.sides[side], made.sides[side].incidences, [0.0, 0.5 * np.pi])
        for side in ("front_reflection", "front_transmission")
    )
    assert both == pytest.approx(1.0, abs=1e-6)
    assert any("mean of warp and weft" in note for note in made.notes())


def test_close_up_from_afar_is_the_table(white):
    """Rays from the eye against those of the table, which come from the light."""
    from lumenray.engine.cloth.close_up import draw_close_up, seen_from_afar

    made = draw_close_up(white.cloth, 40, 24, wavelengths=BANDS, exits=48)
    assert made.values.shape == (40, 40, 3)
    # The cloth is clear: pixels are grey but for what scatters.
    spread = made.values.mean(axis=(0, 1)).std()
    assert spread < 0.05 * made.values.mean()
    mean = made.values.mean(axis=(0, 1))
    assert mean == pytest.approx(
        seen_from_afar(white.sides["front_reflection"]), abs=0.04 * mean[0] + 4.0 * made.error[0]
    )


def test_tables_hold_what_is_sent_anew(white):
    """T5: light from directions between those of the table, in windows anywhere; tables of few rays are grainy."""
    from lumenray.benchmarks.cloth.direct import compare_directly

    made = compare_directly(white.cloth, white.sides, lights=6, windows=200, rays=20_000, exits=48)
    for part in ("reflection", "transmission"):
        assert made[part]["pairs"] == 1200
        assert abs(made[part]["mean"]) < 0.04
        assert made[part]["rms"] < 0.3


def test_close_ups_are_averaged_over_what_a_weave_repeats():
    backend.start(spectral=False)
    from lumenray.engine.cloth.close_up import _evened
    from lumenray.engine.cloth.composition import Weave
    from lumenray.engine.cloth.weave import twill_pattern

    thread = yarn(0.14)
    twill = Cloth(thread, thread, Weave(twill_pattern(2, 2), 0.2, 0.2))
    values = np.random.default_rng(3).random((8, 12, 2))
    made = _evened(values, twill)
    # One end further and one pick back everything is the same: 3 columns and 2 rows.
    assert np.roll(made, (-2, 3), (0, 1)) == pytest.approx(made)
    assert np.roll(made, (2, 3), (0, 1)) != pytest.approx(made)
    assert made.mean(axis=(0, 1)) == pytest.approx(values.mean(axis=(0, 1)))
