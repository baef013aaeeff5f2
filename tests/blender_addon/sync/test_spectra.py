"""Spectra of lights and materials: by name, by file, and never a colour in place of either."""

import pytest
from conversion import rgb_of

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.materials.materials import convert_material
from lumenray.blender_addon.sync.spectra import convert_spectrum, light_spectrum
from lumenray.engine.errors import LumenrayError
from lumenray.engine.scene.spectrum import Daylight, Illuminant

pytestmark = pytest.mark.blender


def test_white_light_is_d65_and_colours_keep_only_their_chromaticity():
    assert light_spectrum((0.2, 0.2, 0.2)) == Illuminant("D65")
    assert rgb_of(light_spectrum((4.0, 2.0, 1.0))) == pytest.approx((1.0, 0.5, 0.25))
    assert light_spectrum((0.0, 0.0, 0.0)) == Illuminant("D65")


def test_daylight_outside_its_range_is_held_and_reported(override):
    _, settings = override
    settings.spectrum, settings.colour_temperature = "DAYLIGHT", 3000.0
    report = ConversionReport()
    assert convert_spectrum(settings, (1, 1, 1), report, "Lamp") == Daylight(4000.0)
    (row,) = report.to_dicts()
    assert row["object"] == "Lamp"
    assert "3000 K" in row["message"]


def test_a_spectrum_file_that_is_not_there_is_never_replaced_by_the_colour(override):
    material, settings = override
    settings.spectrum, settings.spectrum_file = "FILE", "/nowhere/lamp.spdx"
    report = ConversionReport()
    with pytest.raises(LumenrayError, match=r"/nowhere/lamp\.spdx"):
        convert_spectrum(settings, (1.0, 0.5, 0.5), report, "Lamp")
    settings.model, settings.luminance = "EMITTER", 100.0
    assert convert_material(material, "m", report, 177.83).emission is None
    (row,) = report.to_dicts()
    assert row["missing"]
    assert "/nowhere/lamp.spdx" in row["message"]


def table_file(tmp_path, *columns):
    path = tmp_path / "lamp.txt"
    rows = zip(range(380, 781, 10), *columns, strict=True)
    path.write_text("\n".join(" ".join(map(str, row)) for row in rows))
    return str(path)


def test_a_spectrum_of_zeros_is_an_error_and_never_the_colour(override, convert, tmp_path):
    material, settings = override
    settings.spectrum, settings.spectrum_file = "FILE", table_file(tmp_path, [0] * 41)
    with pytest.raises(LumenrayError, match="no value above 0"):
        convert_spectrum(settings, (1.0, 0.5, 0.5), ConversionReport(), "Lamp")
    settings.model, settings.luminance = "EMITTER", 100.0
    made, rows = convert(material)
    assert made.emission is None
    assert rows[-1]["severity"] == "error"
    assert rows[-1]["instead"] == "the material does not shine"


def test_a_column_of_a_spectrum_is_chosen_and_one_that_is_not_is_told(override, tmp_path):
    _, settings = override
    settings.spectrum = "FILE"
    settings.spectrum_file = table_file(tmp_path, [1] * 41, [2] * 41)
    report = ConversionReport()
    assert convert_spectrum(settings, (1, 1, 1), report, "Lamp").values[0] == 1
    assert any("has 2 columns of values" in row["message"] for row in report.to_dicts())
    settings.spectrum_column, report = 2, ConversionReport()
    assert convert_spectrum(settings, (1, 1, 1), report, "Lamp").values[0] == 2
    assert not any("columns" in row["message"] for row in report.to_dicts())
