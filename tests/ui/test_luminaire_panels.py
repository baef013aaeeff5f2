"""Panels of luminaires: figures of the file, what it states instead of the light, and what is wrong with it."""

import math

import bpy
import pytest
from panels import context, draw, new_light
from photometric_files import write_ies, write_peaks

from lumenray import ui
from lumenray.blender_addon.luminaires.files import photometric_files
from lumenray.engine.errors import FileFormatError
from lumenray.engine.reading.remarks import Remark
from lumenray.ui.luminaire import LuminaireChild


def context_of(source):
    return context(light=source.data, object=source)


def children():
    return [kind for kind in ui.CLASSES if issubclass(kind, LuminaireChild)]


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA"])
def test_light_without_a_file_offers_to_open_one(kind):
    where = new_light(kind)
    for name in ("LUMENRAY_PT_luminaire", "LUMENRAY_PT_active_luminaire"):
        seen = draw(name, where)
        assert "lumenray.load_luminaire_file" in seen
        assert "filepath" not in seen
    assert not any(child.poll(where) for child in children())


def test_sun_and_mesh_cannot_be_luminaires():
    mesh = bpy.data.objects.new("Floor", bpy.data.meshes.new("Floor"))
    for where in (new_light("SUN"), context(object=mesh), context()):
        assert draw("LUMENRAY_PT_luminaire", where) is None
        assert draw("LUMENRAY_PT_active_luminaire", where) is None


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA", "EMPTY"])
def test_panel_shows_the_figures_of_the_file(new_luminaire, kind):
    # The same all around, 1 cd at 0 and 45 degrees and none at 90.
    source, settings = new_luminaire(write_peaks(azimuths=(0,), peaks=(1,)), kind)
    where = context_of(source)
    seen = draw("LUMENRAY_PT_luminaire", where)
    edge = math.pi / 4.0
    # 2 pi times the integral of sin up to the edge, and of the line to 0 at 90 degrees times sin beyond.
    lumens = 2.0 * math.pi * (1.0 - math.cos(edge) + math.cos(edge) - (1.0 - math.sin(edge)) / edge)
    assert f"{lumens:.2f} lm" in seen
    for text in ("LM-63-2002", "type C, rotational", "absolute", "1.00 cd", "γ 0°", "135°"):
        assert text in seen, text
    assert f"{lumens / 5.0:.3f} lm/W" in seen
    assert {"rectangle", "600 × 300 mm"} <= set(seen)
    assert any("Embedded" in text for text in seen)
    assert "lumenray.unpack_luminaire_file" in seen
    seen = draw("LUMENRAY_PT_active_luminaire", where)
    assert {"dimming", "rotation", "show_solid", "emission"} <= set(seen)
    assert f"{lumens:.2f} lm" in seen
    for child in children():
        assert draw(child.__name__, where)
        assert not child.poll(context(engine="CYCLES", light=source.data, object=source))
    assert "Example" in draw("LUMENRAY_PT_luminaire_words", where)
    settings.use_file = False
    assert not any(child.poll(where) for child in children())


def test_panels_of_a_file_in_watts_tell_watts_and_that_nothing_is_visible(new_luminaire):
    text = write_ies([[100.0, 100.0]], [0, 180], [0], keywords=("[_INTENSITYUNITS] mW/sr",))
    source, settings = new_luminaire(text)
    where = context_of(source)
    for panel in ("LUMENRAY_PT_luminaire", "LUMENRAY_PT_active_luminaire"):
        seen = draw(panel, where)
        assert "1.26 W" in seen
        assert "0.100 W/sr" in seen
        assert not any(text.endswith((" lm", " cd", " lm/W")) for text in seen)
    assert "none without a spectrum" in draw("LUMENRAY_PT_luminaire", where)
    settings.dimming = 0.5
    seen = draw("LUMENRAY_PT_luminaire_amount", where)
    assert "0.628 W" in seen
    assert "lights nothing visible" in " ".join(map(str, seen))
    assert "nothing visible" in " ".join(map(str, draw("LUMENRAY_PT_luminaire_spectrum", where)))


def test_light_panels_leave_out_what_the_file_states(new_luminaire):
    source, settings = new_luminaire(write_peaks(), "SPOT")
    where = context_of(source)
    assert draw("LUMENRAY_PT_light_photometry", where) is None
    assert draw("LUMENRAY_PT_active_light", where) is None
    assert set(draw("LUMENRAY_PT_light", where)) == {"type"}
    settings.emission = "LIGHT"
    assert set(draw("LUMENRAY_PT_light", where)) == {"type", "shadow_soft_size"}
    settings.use_file = False
    assert draw("LUMENRAY_PT_light_photometry", where)
    assert {"spot_size", "spot_blend"} <= set(draw("LUMENRAY_PT_light", where))


def test_amount_shows_the_flux_after_every_factor(new_luminaire):
    source, settings = new_luminaire(write_peaks())
    settings.amount, settings.luminous_flux = "LUMENS", 1000.0
    settings.dimming, settings.maintenance_factor, settings.lamp_factor = 0.5, 0.8, 1.1
    seen = draw("LUMENRAY_PT_luminaire_amount", context_of(source))
    assert "luminous_flux" in seen
    shown_values = [text for text in seen if text.endswith(" lm")]
    assert shown_values == ["1\u2009000 lm", "1\u2009100 lm", "550 lm", "440 lm", "440 lm"]
    settings.dimming = settings.maintenance_factor = settings.lamp_factor = 1.0
    seen = draw("LUMENRAY_PT_luminaire_amount", context_of(source))
    assert [text for text in seen if text.endswith(" lm")] == ["1\u2009000 lm", "1\u2009000 lm"]


@pytest.mark.parametrize(("kind", "own"), [("POINT", "color"), ("EMPTY", "color")])
def test_spectrum_tells_the_files_reason_or_offers_a_choice(new_luminaire, kind, own):
    source, settings = new_luminaire(write_peaks(), kind)
    said = " ".join(draw("LUMENRAY_PT_luminaire_spectrum", context_of(source)))
    assert "LED" in said
    assert "4000 K" in said
    assert own not in said.split()
    settings.spectrum_source = "LIGHT"
    assert {"spectrum", own} <= set(draw("LUMENRAY_PT_luminaire_spectrum", context_of(source)))


@pytest.mark.parametrize(("kind", "own"), [(1, "mirror"), (2, None), (3, "flip_h")])
def test_mounting_offers_what_the_photometric_type_can_need(new_luminaire, kind, own):
    planes = {"azimuths": (-90, 0, 30, 90), "peaks": (0, 1, 9, 0)} if kind > 1 else {}
    # In LM-63, 2 is type B and 3 is type A.
    own = {2: "flip_h", 3: None}.get(kind, own)
    source, _ = new_luminaire(write_peaks(kind=kind, **planes))
    seen = set(draw("LUMENRAY_PT_luminaire_mounting", context_of(source)))
    assert seen & {"mirror", "flip_h"} == ({own} if own else set())


def test_refused_file_says_what_is_wrong(new_luminaire):
    source, settings = new_luminaire(write_peaks())
    settings.text.from_string("IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 banana\n")
    with pytest.raises(FileFormatError) as refused:
        photometric_files.obtain(settings)
    seen = draw("LUMENRAY_PT_luminaire", context_of(source))
    assert " ".join(str(refused.value).split()) in " ".join(" ".join(seen).split())
    assert "Drawing the diagram…" not in seen
    assert "another one is chosen" in " ".join(seen)
    assert not any(child.poll(context_of(source)) for child in children())
    assert str(refused.value)[:20] in " ".join(
        draw("LUMENRAY_PT_active_luminaire", context_of(source))
    )


def test_missing_linked_file_says_so(new_luminaire, tmp_path):
    source, settings = new_luminaire(write_peaks())
    settings.filepath = str(tmp_path / "gone.ies")
    said = " ".join(draw("LUMENRAY_PT_luminaire", context_of(source)))
    assert "cannot be opened" in said
    assert "pack_luminaire_file" in said


def test_edited_file_is_told(new_luminaire):
    source, settings = new_luminaire(write_peaks())
    assert "edited" not in " ".join(draw("LUMENRAY_PT_luminaire", context_of(source)))
    settings.text.from_string(write_peaks(peaks=(5, 1, 1, 1, 5)))
    assert "edited" in " ".join(draw("LUMENRAY_PT_luminaire", context_of(source)))


@pytest.mark.parametrize("count", [0, 1, 5])
def test_warnings_of_the_reader_are_counted_and_listed(new_luminaire, monkeypatch, count):
    source, settings = new_luminaire(write_peaks())
    remarks = tuple(Remark(f"oddity {number}", number + 1) for number in range(count))
    file = photometric_files.obtain(settings).file
    monkeypatch.setattr(type(file), "remarks", remarks, raising=False)
    object.__setattr__(file, "remarks", remarks)
    seen = draw("LUMENRAY_PT_luminaire", context_of(source))
    heading = {0: None, 1: "1 warning about the file", 5: "5 warnings about the file"}[count]
    assert [text for text in seen if "about the file" in text] == [heading] * bool(count)
    assert [text for text in seen if "oddity" in text] == [str(remark) for remark in remarks]


def test_stated_ratio_that_does_not_fit_is_shown_beside_the_computed_one(new_luminaire):
    source, settings = new_luminaire(
        write_peaks(azimuths=(0,), peaks=(1,)).replace("1 -1 1", "1 10 1")
    )
    file = photometric_files.obtain(settings).file
    object.__setattr__(file, "light_output_ratio", 0.9)
    seen = draw("LUMENRAY_PT_luminaire", context_of(source))
    assert "39.4 % (stated 90.0 %)" in seen
    assert "10.0 lm" in seen
