"""Cloths by their description: found again by all that they follow from, and not where one of it differs."""

import json
import os

import numpy as np
import pytest

pytest.importorskip("mitsuba")

from lumenray.engine.cloth import plan
from lumenray.engine.cloth.kept import key_of, load_woven, save_woven
from lumenray.engine.cloth.reader import parse_cloth
from lumenray.engine.cloth.surface import Sheet, WovenSurface
from lumenray.engine.cloth.tabulation import CELLS, Counted, tabulate
from lumenray.engine.errors import Cancelled
from lumenray.engine.scattering.data.evaluation import albedo, measure_reciprocity
from lumenray.engine.scattering.data.record import SIDES
from lumenray.engine.scene.material import Measured
from lumenray.engine.scene.scattering import ScatterTable
from lumenray.engine.session import Session

CONTENT = {
    "lumenray_cloth": 1,
    "name": "Net",
    "warp": {"width_mm": 0.1},
    "weft": {"width_mm": 0.1},
    "weave": {"pattern": "plain", "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.3},
}

BANDS = np.array([450.0, 550.0, 650.0])


def small_surface(key: str) -> WovenSurface:
    zero, axis = np.zeros(1), np.array([0.0, np.pi])
    values = np.random.default_rng(1).random((4, 1, 1, 2, 2, 1)).astype(np.float32)
    sides = [
        ScatterTable(zero, zero, axis, axis, np.array([550.0]), each, error=0.02 * (k + 1))
        for k, each in enumerate(values)
    ]
    sheet = Sheet(*np.linspace(0.1, 0.9, 11).tolist())
    surface = Measured(**dict(zip(SIDES, sides, strict=True)))
    return WovenSurface(
        surface, sheet, np.full(3, 0.3), np.full(3, 0.1), 0.08, 1200, 3, key, ("a note",)
    )


def test_what_was_computed_is_found_again(tmp_path):
    made = small_surface("a" * 64)
    save_woven(made, tmp_path)
    held = load_woven(made.key, tmp_path)
    for side in SIDES:
        there, here = (getattr(each.surface, side) for each in (made, held))
        np.testing.assert_allclose(here.values, there.values, rtol=1e-3)
    assert (held.sheet, held.notes, held.rays, held.seed) == (made.sheet, made.notes, 1200, 3)
    assert held.table_error == pytest.approx(0.08)
    np.testing.assert_array_equal(held.reflected, made.reflected)
    assert load_woven("b" * 64, tmp_path) is None


def test_what_is_damaged_is_computed_anew(tmp_path):
    made = small_surface("a" * 64)
    save_woven(made, tmp_path)
    tables = tmp_path / f"{made.key}.lumbsdf"
    tables.write_bytes(tables.read_bytes()[:-40])
    assert load_woven(made.key, tmp_path) is None
    save_woven(made, tmp_path)
    (tmp_path / f"{made.key}.json").write_text('{"sheet": {}}')
    assert load_woven(made.key, tmp_path) is None


def test_the_oldest_goes_when_there_are_too_many(tmp_path, monkeypatch):
    from lumenray.engine.cloth import kept

    monkeypatch.setattr(kept, "KEPT", 2)
    for number in range(3):
        save_woven(small_surface(f"{number}" * 64), tmp_path)
        for path in tmp_path.glob(f"{number}*"):
            os.utime(path, (1000 + number, 1000 + number))
    assert {path.stem[0] for path in tmp_path.iterdir()} == {"1", "2"}


def test_a_key_is_of_all_that_counts_and_of_nothing_else():
    cloth = parse_cloth(CONTENT)
    key = key_of(cloth, 1000, 0)
    named = parse_cloth(CONTENT | {"name": "Other", "description": "words"})
    assert key_of(named, 1000, 0) == key
    wider = parse_cloth(CONTENT | {"warp": {"width_mm": 0.11}})
    assert len({key, key_of(wider, 1000, 0), key_of(cloth, 2000, 0), key_of(cloth, 1000, 1)}) == 4


def test_bitmaps_count_by_their_pixels(tmp_path):
    from PIL import Image

    keys = []
    for pixels in ([[0, 255], [255, 0]], [[255, 0], [0, 255]]):
        Image.fromarray(np.array(pixels, np.uint8)).save(tmp_path / "weave.png")
        weave = {"bitmap": "weave.png", "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.3}
        cloth = parse_cloth(CONTENT | {"weave": weave}, tmp_path / "cloth.json")
        keys.append(key_of(cloth, 1000, 0))
    rows = parse_cloth(
        CONTENT | {"weave": {"rows": [".X", "X."], "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.3}}
    )
    assert keys[0] != keys[1]
    # The picture's lowest row is the first pick.
    assert key_of(rows, 1000, 0) in keys


@pytest.mark.parametrize("name", ["velour", "cotton", "polyester_satin"])
def test_directions_are_told_that_rays_are_sent_from(name):
    """A plain weave: a quarter; a satin: half a turn of each side; a pile: all of both. The normal counts twice."""
    from lumenray.libraries import cloths

    cloth = parse_cloth(json.loads(cloths.presets()[name].read_text(encoding="utf-8")))
    count = {"cotton": 2 + 7 * 7, "polyester_satin": 2 * (2 + 6 * 7), "velour": 2 * (2 + 12 * 7)}
    assert plan.directions_of(cloth) == count[name]
    assert plan.rays_in_all(cloth, draft=True) == count[name] * plan.DRAFT_RAYS


def test_both_ways_of_light_are_averaged_and_totals_are_those_that_were_counted():
    """Counts of an even cloth with noise: its tables agree better both ways than noise lets them, and keep the light."""
    rng = np.random.default_rng(4)
    shape = (len(plan.QUARTER), len(plan.INCIDENCES), 2, CELLS * CELLS, len(BANDS))
    counts = [rng.poisson(share / (CELLS * CELLS) / 5e-6, shape) * 5e-6 for share in (0.4, 0.3)]
    straight = np.full(shape[:2], 0.1)
    found = Counted(*counts, straight, np.full((*shape[:2], len(BANDS)), 0.2))
    sides = tabulate({"front": found, "back": found}, plan.QUARTER, BANDS, True)
    assert sides["back_transmission"] is sides["front_transmission"]
    for part, own in zip(("reflection", "transmission"), counts, strict=True):
        table = sides[f"front_{part}"]
        for s, p in ((0, 0), (3, 2), (7, 6)):
            angles = plan.INCIDENCES[s], plan.QUARTER[p]
            want = own[p, s].sum(axis=1).mean(axis=0)
            assert albedo(table, *angles) == pytest.approx(want, rel=1e-3)
        both = measure_reciprocity(table).scattered
        assert both < 0.75 * table.error
        assert table.error == pytest.approx(0.02, abs=0.015)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_session_computes_a_cloth_once_and_stops_when_told(tmp_path, monkeypatch):
    monkeypatch.setenv("LUMENRAY_CLOTH_CACHE", str(tmp_path))
    monkeypatch.setattr(plan, "DRAFT_RAYS", 240)
    session, told = Session(), []

    def cancel(progress):
        told.append(progress)
        if len(told) == 3:
            session.cancel()

    text = json.dumps(CONTENT)
    with pytest.raises(Cancelled, match="cloth"):
        session.compute_cloth(text, draft=True, progress=cancel)
    assert not list(tmp_path.iterdir())
    assert told[0].seconds_left is None
    assert told[-1].seconds_left > 0.0
    made = session.compute_cloth(text, draft=True)
    # Yarns of 0.1 every 0.3 leave four ninths open.
    assert made.sheet.openness == pytest.approx(4.0 / 9.0, abs=4.0 * np.sqrt(0.25 / 480))
    assert made.surface.passes_straight
    # Nothing absorbs: what is not reflected passes.
    assert made.sheet.reflectance + made.sheet.transmittance == pytest.approx(1.0, abs=2e-3)
    again = session.compute_cloth(text, draft=True, progress=cancel)
    assert len(told) == 3
    np.testing.assert_array_equal(
        again.surface.front_reflection.values, made.surface.front_reflection.values
    )
