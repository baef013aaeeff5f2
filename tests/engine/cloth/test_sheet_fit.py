"""From data sheets to cloths."""

import pytest

pytest.importorskip("mitsuba")

from lumenray.engine.cloth.reader import parse_cloth
from lumenray.engine.errors import SceneError
from lumenray.engine.transport import backend

pytestmark = [pytest.mark.mitsuba, pytest.mark.slow]


@pytest.fixture(scope="module", autouse=True)
def fit_sheet():
    backend.start(spectral=False)
    from lumenray.engine.cloth.sheet_fit import fit_sheet

    return fit_sheet


def test_a_screen_does_what_its_sheet_states(fit_sheet):
    """Its tables, of other rays and all wavelengths, are those of the sheet within 1.5 %."""
    made = fit_sheet(0.05, 0.2, 0.5, rays=9000, exits=64)
    assert (made.transmittance, made.reflectance) == pytest.approx((0.2, 0.5), abs=0.01)
    from lumenray.engine.cloth.readings import read_sheet
    from lumenray.engine.cloth.woven import weave

    sheet = read_sheet(weave(parse_cloth(made.content), [550.0], rays=2000, seed=3, exits=64))
    slack = 0.015 + 4.0 * sheet.transmittance_error
    assert (sheet.transmittance, sheet.reflectance) == pytest.approx((0.2, 0.5), abs=slack)
    assert sheet.openness == pytest.approx(0.05, abs=0.015)


@pytest.mark.parametrize(
    "sheet, words",
    [
        ((0.1, 0.05, 0.5), "expected the openness at least"),
        ((0.1, 0.5, 0.6), "less than 100 %"),
        ((0.95, 0.96, 0.01), "expected 0 to 90 %"),
    ],
)
def test_what_cannot_be_is_said(fit_sheet, sheet, words):
    with pytest.raises(SceneError, match=words):
        fit_sheet(*sheet)
