"""Compositions found from readings: least squares within bounds, and paints that come back from their own colours."""

import numpy as np
import pytest
from folders import WILD
from paints import aspecular, interference, mirrors, one_layer

from lumenray.engine.errors import SceneError
from lumenray.engine.paint.fitting import (
    BrdfReadings,
    LabReadings,
    Parameter,
    fit_paint,
    read_place,
    usual_parameters,
    with_values,
)
from lumenray.engine.paint.least_squares import minimise
from lumenray.engine.paint.measured import read_brdf
from lumenray.engine.paint.reader import read_paint
from lumenray.engine.paint.readings import SIX, read_lab
from lumenray.engine.paint.solution import solve
from lumenray.libraries import paints

CAR = WILD / "bsdf/mdl/carpaint_red.mbsdf"

ANGLES = [(45, a) for a in (15, 25, 45, 75)] + [(20, 10), (60, 20)]

AREA = "layers/0/flakes/0/amount/area_per_volume_per_um"

TILT = "layers/0/flakes/0/tilt_deg"

CORE = "layers/0/flakes/0/stack/core/thickness_nm"


def test_least_squares_finds_a_valley():
    """Rosenbrock's function, scaled into the unit square."""

    def residuals(place):
        x, y = 4.0 * place - 2.0
        return np.array([10.0 * (y - x * x), 1.0 - x])

    found = minimise(residuals, [0.1, 0.9], 200)
    assert 4.0 * found.place - 2.0 == pytest.approx([1.0, 1.0], abs=1e-3)


def test_least_squares_stops_at_bounds():
    found = minimise(lambda place: place - np.array([0.3, 1.4]), [0.9, 0.1])
    assert found.place == pytest.approx([0.3, 1.0], abs=1e-6)


def test_mirrors_come_back_from_their_brdf():
    true = one_layer([mirrors(0.7, 6.0, area=0.08)], 0.2)
    wi, wo = aspecular(ANGLES)
    bands = np.array([450.0, 600.0])
    readings = BrdfReadings(wi, wo, solve(true, bands).evaluate(wi, wo), bands)
    start = with_values(
        true.content, [Parameter(AREA, 0.01, 1), Parameter(TILT, 1, 20)], [0.2, 12.0]
    )
    found = fit_paint(start, readings, starts=1, scanned=8)
    assert found.values == pytest.approx([0.08, 6.0], abs=1.0 * found.errors.max())
    assert (np.abs(found.values - [0.08, 6.0]) < found.errors).all()
    assert found.residual < 0.1 and not found.at_bounds
    assert np.diag(found.correlations) == pytest.approx([1.0, 1.0])


@pytest.mark.slow
def test_interference_orders_are_told_apart():
    true = one_layer([interference(522, 1.6, 50, 0.12, 5)], 0.1)
    readings = LabReadings(np.array(SIX), read_lab(solve(true), SIX))
    start = with_values(
        true.content,
        [Parameter(CORE, 1, 2), Parameter(AREA, 1, 2), Parameter(TILT, 1, 2)],
        [350, 0.05, 8],
    )
    found = fit_paint(start, readings)
    want = dict(zip((AREA, TILT, CORE), (0.12, 5, 522), strict=True))
    for parameter, value, error in zip(found.parameters, found.values, found.errors, strict=True):
        assert abs(value - want[parameter.place]) < error


def test_what_cannot_be_looked_for_is_said():
    content = one_layer([mirrors(0.7, 6.0)]).content
    readings = LabReadings(np.array([15.0]), np.zeros((1, 3)))
    with pytest.raises(SceneError, match="nothing at 'layers/3/tilt_deg'"):
        fit_paint(content, readings, [Parameter("layers/3/tilt_deg", 1, 2)])
    with pytest.raises(SceneError, match="found 0 numbers"):
        fit_paint(content, readings, [])
    with pytest.raises(SceneError, match="no number at 'name'"):
        read_place(content, "name")
    assert [each.place for each in usual_parameters(content)] == [AREA, TILT]


@pytest.mark.slow
@pytest.mark.skipif(not CAR.is_file(), reason="needs ../shared/data/bsdf")
def test_flakes_of_a_measured_car_paint_are_found():
    content = read_paint(paints.presets()["three_coat_red"]).content
    looked_for = [
        Parameter("layers/1/thickness_um", 1.0, 40.0),
        Parameter("layers/2/flakes/0/amount/mass_fraction", 0.001, 0.3),
        Parameter("layers/2/flakes/0/tilt_deg", 3.0, 25.0),
    ]
    # Without pearl, which such a file does not tell; its own noise is a fifth.
    content["layers"][1]["flakes"] = []
    found = fit_paint(content, read_brdf(CAR, 0.2), looked_for, starts=1)
    assert found.residual < 3.0 and not found.at_bounds
    assert found.values[2] == pytest.approx(5.0, abs=1.0)
