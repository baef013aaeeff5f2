"""Panels of measured materials: figures of the file, what is wrong with it, and its pictures."""

import numpy as np
import pytest
from blender_scattering import add_paint, matt
from panels import context, draw, finish_pictures

from lumenray.blender_addon.scattering import preview as scattering_pictures
from lumenray.blender_addon.scattering.files import scattering_files
from lumenray.engine.errors import LumenrayError


def lines_of(seen):
    """Values by the labels before them."""
    return dict(zip(seen, seen[1:], strict=False))


def test_panels_are_there_for_measured_materials_alone(write_scattering):
    paint = add_paint()
    where = context(material=paint)
    assert draw("LUMENRAY_PT_measured", where) is None
    paint.lumenray.use_override, paint.lumenray.model = True, "MEASURED"
    seen = draw("LUMENRAY_PT_measured", where)
    assert "lumenray.load_scattering_file" in seen
    assert "filepath" not in seen
    assert draw("LUMENRAY_PT_measured_cuts", where) is None
    assert "model" in draw("LUMENRAY_PT_material_override", where)


def test_panel_shows_the_figures_of_the_file(write_scattering):
    wavelengths = np.linspace(400.0, 700.0, 16)
    sides = {
        "front_reflection": matt(np.full(16, 0.4), wavelengths),
        "front_transmission": matt(np.full(16, 0.25), wavelengths),
    }
    paint = add_paint(write_scattering(**sides))
    scattering_files.obtain(paint.lumenray.measured)
    where = context(material=paint)
    seen = draw("LUMENRAY_PT_measured", where)
    told = lines_of(seen)
    assert told["Name"] == "Paint"
    assert told["Symmetry"] == "isotropic"
    assert told["Incidence"] == "0° to 60°, 3 angles"
    assert told["Wavelengths"] == "400 to 700 nm, 16 bands"
    assert told["Front Reflectance 8°"] == "40 %"
    assert told["Front Transmittance 8°"] == "25 %"
    assert told["Resampling Error"] == "none stated"
    assert {"back", "is_turned", "rotation", "tolerance"} <= set(seen)
    assert "lumenray.pack_scattering_file" in seen
    scattering_files.pack(paint.lumenray.measured)
    scattering_files.obtain(paint.lumenray.measured)
    assert "lumenray.unpack_scattering_file" in draw("LUMENRAY_PT_measured", where)
    colour = draw("LUMENRAY_PT_measured_colour", where)
    assert {"illuminant", "swatch"} <= set(colour)


def test_refused_file_says_what_is_wrong(tmp_path):
    bad = tmp_path / "bad.bsdf"
    bad.write_bytes(b"nothing of the kind")
    paint = add_paint(str(bad))
    with pytest.raises(LumenrayError):
        scattering_files.obtain(paint.lumenray.measured)
    said = " ".join(draw("LUMENRAY_PT_measured", context(material=paint)))
    assert "no scattering file of a known format" in " ".join(said.split())
    assert "plain grey" in said
    assert tuple(paint.lumenray.measured.swatch) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("kind", ["cuts", "totals"])
def test_pictures_become_icons(write_scattering, kind):
    paint = add_paint(write_scattering())
    reading = scattering_files.obtain(paint.lumenray.measured)
    scattering_pictures.pictures.close()
    where = context(material=paint)
    assert "Drawing the picture…" in draw(f"LUMENRAY_PT_measured_{kind}", where)
    made = scattering_pictures.pictures
    finish_pictures(made)
    # Without a window icons have no numbers, so they are looked for by name.
    (name,) = made._icons
    assert name.startswith(f"{reading.digest} {kind} ")
    assert draw(f"LUMENRAY_PT_measured_{kind}", where)
    assert not made._drawing
    made.close()
