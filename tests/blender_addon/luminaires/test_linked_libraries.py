"""Luminaires of linked and appended libraries shine by the files that came with them."""

import bpy
import pytest
from blender_luminaires import activate, add_luminaire
from conversion import converted_light
from photometric_files import EVEN, FULL_FLUX

from lumenray.blender_addon.foundation.report import Severity
from lumenray.blender_addon.luminaires.settings import settings_of

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture
def library(write_photometry, tmp_path):
    """Path of a .blend file with an embedded and a linked luminaire, in a folder of its own."""
    folder = tmp_path / "library"
    folder.mkdir()
    (folder / "even.ies").write_text(EVEN)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "library.blend"))
    add_luminaire("EMPTY", str(folder / "even.ies"), "Embedded")
    linked = add_luminaire("POINT", name="Linked")
    settings_of(linked).use_file = True
    settings_of(linked).filepath = "//even.ies"
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    return folder / "library.blend"


def test_luminaires_of_a_library_shine(library):
    with bpy.data.libraries.load(str(library), link=True) as (there, here):
        here.objects = list(there.objects)
    for thing in here.objects:
        bpy.context.scene.collection.objects.link(thing)
        light, rows = converted_light(thing)
        assert light.output.value == pytest.approx(FULL_FLUX)
        assert rows == []
    embedded = bpy.data.objects["Embedded"]
    assert settings_of(embedded).text.library is not None
    activate(embedded)
    assert not bpy.ops.lumenray.load_luminaire_file.poll()
    assert not bpy.ops.lumenray.unpack_luminaire_file.poll()
    # What is embedded here is a text of this file, not the library's.
    own = add_luminaire("POINT", str(library.parent / "even.ies"), "Own")
    assert settings_of(own).text.library is None


def test_appended_luminaires_bring_their_file(library):
    with bpy.data.libraries.load(str(library), link=False) as (_, here):
        here.objects = ["Embedded"]
    (thing,) = here.objects
    bpy.context.scene.collection.objects.link(thing)
    assert settings_of(thing).text.library is None
    assert converted_light(thing)[0].output.value == pytest.approx(FULL_FLUX)


def test_a_text_that_the_library_lost_leaves_the_light_out(library, tmp_path):
    with bpy.data.libraries.load(str(library), link=True) as (_, here):
        here.objects, here.texts = [], ["even.ies"]
    lamp = add_luminaire("POINT", name="Own")
    settings_of(lamp).use_file, settings_of(lamp).text = True, bpy.data.texts["even.ies"]
    assert converted_light(lamp)[0] is not None
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "user.blend"))
    library.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "user.blend"))
    light, rows = converted_light(bpy.data.objects["Own"])
    assert light is None
    assert [row.severity for row in rows] == [Severity.ERROR]
    assert "missing" in rows[0].message
