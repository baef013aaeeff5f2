"""Photometric files of the active light: loading, embedding, linking, reloading and taking away."""

import bpy
import numpy as np
import pytest
from blender_luminaires import activate, add_luminaire, candelas, extent_of
from conversion import converted_light
from photometric_files import EVEN, FOUR, FULL_FLUX, SIDEWAYS

from lumenray.blender_addon.luminaires import placing
from lumenray.blender_addon.luminaires.settings import active_settings, settings_of

pytestmark = pytest.mark.usefixtures("extension")


def test_a_file_is_loaded_into_the_active_light_or_empty(write_photometry):
    path = write_photometry()
    with pytest.raises(RuntimeError):
        bpy.ops.lumenray.load_luminaire_file(filepath=path)
    sun = add_luminaire("SUN")
    activate(sun)
    assert active_settings(bpy.context) is None
    lamp = add_luminaire("SPOT")
    activate(lamp)
    assert bpy.ops.lumenray.load_luminaire_file(filepath=path) == {"FINISHED"}
    assert settings_of(lamp).use_file
    assert settings_of(lamp).text is not None
    with pytest.raises(RuntimeError, match="line"):
        bpy.ops.lumenray.load_luminaire_file(filepath=write_photometry(EVEN[:-30], "cut.ies"))
    assert converted_light(lamp)[0].output.value == pytest.approx(FULL_FLUX)
    bpy.ops.lumenray.load_luminaire_file(filepath=path, use_embed=False)
    assert settings_of(lamp).text is None
    assert settings_of(lamp).filepath == path


def test_another_file_gives_an_empty_another_body(write_photometry):
    bpy.ops.lumenray.add_luminaire(filepath=write_photometry())
    empty = bpy.context.object
    copied = empty.copy()
    bpy.context.scene.collection.objects.link(copied)
    before = extent_of(copied)
    bpy.ops.lumenray.load_luminaire_file(filepath=write_photometry(FOUR, "four.ies"))
    assert extent_of(empty) != before
    assert extent_of(copied) == before
    bpy.data.objects.remove(copied)
    bpy.ops.lumenray.clear_luminaire_file()
    assert not placing.has_body(empty)
    assert not settings_of(empty).use_file
    assert settings_of(empty).text is None


def test_embedding_linking_and_reloading(write_photometry, tmp_path):
    lamp, path = add_luminaire("AREA"), write_photometry()
    activate(lamp)
    assert not bpy.ops.lumenray.pack_luminaire_file.poll()
    assert not bpy.ops.lumenray.unpack_luminaire_file.poll()
    assert not bpy.ops.lumenray.reload_luminaire_file.poll()
    bpy.ops.lumenray.load_luminaire_file(filepath=path, use_embed=False)
    bpy.ops.lumenray.pack_luminaire_file()
    assert settings_of(lamp).text.name == "even.ies"
    assert settings_of(lamp).filepath == path
    bpy.ops.lumenray.unpack_luminaire_file()
    assert settings_of(lamp).text is None
    assert settings_of(lamp).filepath == path
    bpy.ops.lumenray.pack_luminaire_file()
    write_photometry(FOUR)
    bpy.ops.lumenray.reload_luminaire_file()
    np.testing.assert_allclose(candelas(converted_light(lamp)[0], SIDEWAYS), [100, 200, 300, 400])
    # Texts that nothing uses any more are not saved.
    assert [text.users for text in bpy.data.texts if text != settings_of(lamp).text] == [0]
    (tmp_path / "even.ies").unlink()
    with pytest.raises(RuntimeError, match="cannot be opened"):
        bpy.ops.lumenray.reload_luminaire_file()
    np.testing.assert_allclose(candelas(converted_light(lamp)[0], SIDEWAYS), [100, 200, 300, 400])
    with pytest.raises(RuntimeError, match="save the Blender file first"):
        bpy.ops.lumenray.unpack_luminaire_file()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.lumenray.unpack_luminaire_file()
    assert settings_of(lamp).filepath.startswith("//luminaires")
    assert (tmp_path / "luminaires" / "even.ies").read_text() == FOUR
