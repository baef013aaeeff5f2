"""Paints as tables of measured materials: how near they come, files, colours, waves of the surface."""

import numpy as np
import pytest
from paints import SAMPLES, aspecular, make_paint, mirrors, one_layer

from lumenray.engine.paint.orange_peel import evaluate
from lumenray.engine.paint.readings import ASPECULAR, lab_of, read_lab
from lumenray.engine.paint.solution import solve
from lumenray.engine.paint.tabulation import FINE, PREVIEW, STANDARD, compute, tabulate
from lumenray.engine.scattering.data.store import pack, read_store
from lumenray.engine.scattering.data.table import evaluate_table

BANDS = [450.0, 550.0, 650.0]


@pytest.fixture(scope="module")
def violet():
    return compute(SAMPLES[1], BANDS)


def test_tables_tell_their_errors(violet):
    assert violet.table.error < 0.06
    assert violet.convergence < 0.01
    assert violet.clamped < 1e-3
    assert violet.energy <= 1.0
    assert violet.reciprocity < 0.05
    coarse = tabulate(violet.solution, PREVIEW)
    fine = tabulate(violet.solution, FINE)
    assert coarse.values.size < violet.table.values.size < fine.values.size


def test_clear_coat_is_the_tables_direct_part(violet):
    face = ((1.45 - 1.0) / 2.45) ** 2
    assert violet.table.direct[0, 0] == pytest.approx(face * np.ones(3), rel=1e-5)


def test_tables_are_files(violet, tmp_path):
    data = pack(violet.file())
    back = read_store(data, tmp_path / "violet.lumbsdf")
    wi, wo = aspecular([(45, 15), (45, 25), (15, 15)])
    before, after = (
        evaluate_table(each, wi, wo) for each in (violet.table, back.sides["front_reflection"])
    )
    assert after == pytest.approx(before, rel=2e-3)
    assert before == pytest.approx(violet.solution.evaluate(wi, wo), rel=0.05)
    assert "directions" in back.remarks[0].text


def test_white_is_white():
    assert lab_of(np.ones(33), np.arange(390.0, 711.0, 10.0)) == pytest.approx(
        [100, 0, 0], abs=1e-9
    )


def test_violet_is_violet():
    """Violet at the gloss, as the reference says, and dark beside it."""
    solution = solve(SAMPLES[1])
    lab = read_lab(solution, ASPECULAR)
    assert lab[1, 1] > 40.0 and lab[1, 2] < -40.0
    assert lab[0, 0] > 100.0 and lab[-1, 0] < 2.0


def test_waves_spread_the_mirror():
    """A clear coat on black with waves mirrors as much as a smooth one, into a lobe."""
    smooth = make_paint([(30, [], [], 1.5)], 0.0)
    waved = make_paint([(30, [], [], 1.5)], 0.0, surface={"orange_peel_slope_deg": 3})
    solution = solve(waved, [550.0])
    table = tabulate(solution, STANDARD)
    assert table.direct is None
    from lumenray.engine.scattering.data.table import albedos_of

    incidence = np.radians([0.0, 20.0, 40.0])
    mirror = solve(smooth, [550.0]).mirror(np.sin(incidence))
    assert albedos_of(table, incidence, [0.0])[0] == pytest.approx(mirror, rel=0.03)


def test_waves_leave_a_matt_paint_alone():
    matt = make_paint([(30, [], [], 1.001)], 0.5, surface={"orange_peel_slope_deg": 5})
    solution = solve(matt, [550.0])
    wi, wo = aspecular([(30, 15), (0, 20)])
    assert evaluate(solution, wi, wo)[:, 0] == pytest.approx(0.5 / np.pi * np.ones(2), rel=0.02)


def test_spreads_widen_lobes():
    wi, wo = aspecular([(45, 0), (45, 25)])
    ratios = []
    for tilt in (3, 6):
        values = solve(one_layer([mirrors(0.9, tilt)]), [550.0]).evaluate(wi, wo)[:, 0]
        ratios.append(values[1] / values[0])
    assert ratios[1] > 3.0 * ratios[0]
