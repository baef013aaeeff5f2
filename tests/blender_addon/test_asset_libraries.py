"""Our libraries in Blender's Asset Browser: there while the extension is on, and beside those of the user."""

import bpy
import pytest

from lumenray.blender_addon import asset_libraries
from lumenray.blender_addon.foundation import preferences
from lumenray.libraries import luminaires, materials


def entries():
    found = bpy.context.preferences.filepaths.asset_libraries
    return {item.name: (item.path, item.import_method) for item in found}


@pytest.fixture
def detached():
    """Blender's preferences without our libraries, as they are before asset_libraries."""
    asset_libraries.detach()
    yield
    asset_libraries.detach()


def test_the_library_is_in_the_asset_browser_while_the_extension_is_on(detached):
    before = entries()
    bpy.context.preferences.is_dirty = False
    asset_libraries.attach()
    asset_libraries.attach()
    assert entries() == {
        **before,
        "Lumenray": (str(luminaires.FOLDER), "APPEND"),
        "Lumenray: materials": (str(materials.LIBRARY), "APPEND"),
    }
    asset_libraries.detach()
    assert entries() == before
    assert not bpy.context.preferences.is_dirty


def test_a_library_of_the_user_with_our_name_stays(detached, tmp_path):
    libraries = bpy.context.preferences.filepaths.asset_libraries
    mine = libraries.new(name="Lumenray", directory=str(tmp_path))
    asset_libraries.attach()
    assert str(luminaires.FOLDER) in {path for path, _ in entries().values()}
    asset_libraries.detach()
    assert entries()["Lumenray"][0] == str(tmp_path)
    libraries.remove(mine)


def test_an_entry_of_an_older_version_is_moved(detached):
    libraries = bpy.context.preferences.filepaths.asset_libraries
    libraries.new(name="Lumenray", directory="/old/lumenray/libraries/luminaires")
    asset_libraries.attach()
    assert {path for name, (path, _) in entries().items() if name.startswith("Lumenray")} == {
        str(luminaires.FOLDER),
        str(materials.LIBRARY),
    }


def test_the_own_folder_follows_the_preferences(detached, tmp_path, monkeypatch):
    chosen = [tmp_path]
    monkeypatch.setattr(preferences, "luminaire_folder", lambda: chosen[0])
    asset_libraries.attach()
    assert entries()[asset_libraries.OWN_NAME] == (str(tmp_path), "APPEND")
    chosen[0] = None
    asset_libraries.follow_own_folder()
    assert asset_libraries.OWN_NAME not in entries()
