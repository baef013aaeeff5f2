"""The library of materials as Blender assets: what ships, what is made of a user's folder, and what an asset does."""

import json
import shutil

import bpy
import numpy as np
import pytest
from blend_assets import catalogues, opened_assets
from PIL import Image

from lumenray.blender_addon.scattering.files import scattering_files
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.command_line.asset_library import material_assets
from lumenray.command_line.asset_library.material_stage import (
    EYE,
    RADIUS,
    TARGET,
    lets_through,
    set_material_stage,
    surface_of,
)
from lumenray.command_line.main import main
from lumenray.engine.scene.material import Conductor, Dielectric, Material, Measured, ThinGlass
from lumenray.libraries import materials
from lumenray.libraries.materials.catalogue import SETTINGS

pytestmark = pytest.mark.usefixtures("empty_file")

ENTRIES = materials.entries()
MODELS = {
    "MEASURED": Measured,
    "CONDUCTOR": Conductor,
    "DIELECTRIC": Dielectric,
    "THIN_GLASS": ThinGlass,
}


def append(title):
    """Append a material that ships and put it onto an object in a light, as dropping it onto one does."""
    bpy.ops.object.light_add(type="POINT", location=(0.0, 0.0, 3.0))
    place = str(materials.LIBRARY / material_assets.ASSETS)
    with bpy.data.libraries.load(place, link=False) as (_, taken):
        taken.materials = [title]
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    bpy.context.object.data.materials.append(taken.materials[0])
    bpy.context.view_layer.update()
    return taken.materials[0]


def converted():
    """Surfaces of the scene's materials, and what the conversion had to warn of."""
    made = convert_scene(bpy.context.evaluated_depsgraph_get())
    surfaces = [item.surface for item in made.delta.changed if isinstance(item, Material)]
    return surfaces, [row.message for row, _ in made.report.rows if row.severity.value != "info"]


# ---- what ships ----


def test_every_material_is_an_asset_in_its_catalogue_with_its_picture():
    known = catalogues(materials.LIBRARY)
    assets = opened_assets(materials.LIBRARY / material_assets.ASSETS)
    assert set(assets) == {entry.title for entry in ENTRIES}
    for entry in ENTRIES:
        data = assets[entry.title].asset_data
        assert known[data.catalog_id] == f"Materials/{entry.category}"
        assert entry.description in data.description
        assert entry.source in data.description
        assert data.license == entry.licence
        assert set(entry.tags) <= {tag.name for tag in data.tags}
        preview = assets[entry.title].preview
        assert tuple(preview.image_size) == (160, 160), entry.name
        shown = np.empty(160 * 160 * 4, np.float32)
        preview.image_pixels_float.foreach_get(shown)
        with Image.open(entry.thumbnail) as picture:
            wanted = np.asarray(picture.convert("RGBA"), np.float32)[::-1]
        assert np.abs(shown - wanted.ravel() / 255.0).max() < 0.01, entry.name


def test_settings_are_those_of_the_catalogue():
    assets = opened_assets(materials.LIBRARY / material_assets.ASSETS)
    for entry in ENTRIES:
        override = assets[entry.title].lumenray
        assert override.use_override
        assert override.model == entry.model
        for name, value in entry.settings.items():
            if isinstance(value, dict):
                assert override.measured.filepath == value["filepath"]
            elif isinstance(value, float):
                assert getattr(override, name) == pytest.approx(value, rel=1e-5), entry.name
            else:
                assert getattr(override, name) == value, entry.name


def test_looks_for_other_engines_are_as_light_as_the_material():
    assets = opened_assets(materials.LIBRARY / material_assets.ASSETS)
    white, black = (
        np.mean(assets[materials.find_entry(name).title].diffuse_color[:3])
        for name in ("wall_white_matt", "lacquer_black_gloss")
    )
    assert white > 0.7
    assert black < 0.15
    glass = assets["N-BK7"].node_tree.nodes["Principled BSDF"].inputs
    assert glass["Transmission Weight"].default_value == 1.0


def test_pictures_are_small_and_lit():
    for entry in ENTRIES:
        with Image.open(entry.thumbnail) as picture:
            assert picture.size == (160, 160), entry.name
            grey = np.asarray(picture.convert("L"), np.float32)
        assert entry.thumbnail.stat().st_size < 60_000, entry.name
        assert 40.0 < grey.mean() < 200.0, entry.name
        assert (grey > 253.0).mean() < 0.05, entry.name


@pytest.mark.parametrize("name", ["wall_white_matt", "sign_ra1", "car_silver", "curtain_sheer"])
def test_an_appended_material_scatters_as_its_file_says(name):
    entry = materials.find_entry(name)
    material = append(entry.title)
    assert material.library is None
    (surface,), warnings = converted()
    assert warnings == []
    reading = scattering_files.obtain(material.lumenray.measured)
    assert reading.file.name == entry.title
    assert surface.front_reflection is reading.file.sides["front_reflection"]


@pytest.mark.parametrize("name", ["gold_polished", "glass_n_bk7", "pane_float_4mm"])
def test_an_appended_material_without_a_file_is_what_its_settings_say(name):
    entry = materials.find_entry(name)
    append(entry.title)
    (surface,), warnings = converted()
    assert warnings == []
    assert type(surface) is MODELS[entry.model]
    expected = surface_of(entry)
    for key, value in vars(expected).items():
        found = getattr(surface, key)
        if key == "ior" and not isinstance(value, float):
            assert (found.a, found.b) == pytest.approx((value.a, value.b), rel=1e-5)
        elif isinstance(value, float):
            assert found == pytest.approx(value, abs=2e-5)


def test_settings_that_lists_may_have_are_those_of_the_override():
    override = bpy.data.materials.new("any").lumenray
    for model, known in SETTINGS.items():
        override.model = model
        for name, rule in known.items():
            if isinstance(rule, dict):
                assert all(hasattr(getattr(override, name), own) for own in rule)
            elif isinstance(rule[0], str):
                for word in rule:
                    setattr(override, name, word)
            else:
                ends = override.bl_rna.properties[name]
                assert (ends.hard_min, ends.hard_max) == pytest.approx(rule[:2]), name


# ---- folders of users ----


@pytest.fixture
def folder(tmp_path):
    """A folder of a user's with a file of its own, one of ours, a metal, and a file that is broken."""
    (tmp_path / "files").mkdir()
    shutil.copy(materials.FOLDER / "brick_red.lumbsdf", tmp_path / "files" / "mine.lumbsdf")
    (tmp_path / "files" / "broken.bsdf").write_text("no scattering")
    listed = [
        ("mine", {"model": "MEASURED", "measured": {"filepath": "files/mine.lumbsdf"}}),
        ("ours", {"model": "MEASURED", "measured": {"filepath": "library:brick_red"}}),
        ("broken", {"model": "MEASURED", "measured": {"filepath": "files/broken.bsdf"}}),
        ("tin", {"model": "CONDUCTOR", "metal": "Cr", "roughness": 0.3}),
        ("blue", {"model": "DIFFUSE", "reflectance_source": "COLOR",
                  "reflectance_color": [0.1, 0.2, 0.6]}),
    ]  # fmt: skip
    entries = [
        {"name": name, "title": name, "category": "Own", "settings": settings}
        for name, settings in listed
    ]
    (tmp_path / "materials.json").write_text(json.dumps({"materials": entries}))
    return tmp_path


def test_a_folder_of_a_user_becomes_assets_and_a_broken_file_is_told(folder):
    built = material_assets.build_material_assets(materials.read_library(folder))
    assert sorted(built.names) == ["blue", "mine", "ours", "tin"]
    (problem,) = built.problems
    assert problem.path == folder / "files" / "broken.bsdf"
    known = catalogues(folder)
    assets = opened_assets(built.path)
    assert set(assets) == {"blue", "mine", "ours", "tin"}
    assert known[assets["mine"].asset_data.catalog_id] == "Materials/Own"
    assert assets["mine"].lumenray.measured.filepath == "//files/mine.lumbsdf"
    assert assets["ours"].lumenray.measured.filepath == "library:brick_red"
    assert assets["tin"].lumenray.metal == "Cr"
    # From the asset file's own folder the file is found.
    assert scattering_files.obtain(assets["mine"].lumenray.measured).file.name == "Red brick"


def test_the_command_makes_them_and_tells_what_it_left_out(folder, capsys):
    command = ["brdf", "library", str(folder), "--pictures", "none"]
    assert main(command) == 1
    said = capsys.readouterr()
    assert "4 assets" in said.out
    assert said.err.count("broken.bsdf") >= 1
    picture = folder / "thumbnails" / "mine.png"
    picture.parent.mkdir()
    shutil.copy(materials.find_entry("brick_red").thumbnail, picture)
    sheet = folder / "sheet.png"
    main([*command, "--sheet", str(sheet)])
    with Image.open(sheet) as made:
        assert made.size[1] < 300


# ---- pictures ----


@pytest.mark.parametrize("name", ["wall_white_matt", "film_30", "sign_ra2", "glass_n_bk7"])
def test_a_stage_shows_the_ball_in_its_light(name):
    entry = materials.find_entry(name)
    surface = surface_of(entry)
    items, camera = set_material_stage(entry, surface, 64)
    named = {item.id: item for item in items}
    assert named["ball"] is not None
    assert ("inner" in named) == lets_through(surface) == (name == "film_30")
    assert ("headlamp" in named) == (name == "sign_ra2")
    ahead = -camera.frame[:3, 2]
    wanted = np.subtract(TARGET, EYE)
    assert ahead == pytest.approx(wanted / np.linalg.norm(wanted))
    mesh = next(item for item in items if getattr(item, "materials", None) == ("ball",))
    away = np.linalg.norm(mesh.vertices - [0.0, 0.0, RADIUS], axis=1)
    assert away == pytest.approx(RADIUS)
    corners = mesh.vertices[mesh.triangles]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((outward * mesh.corner_normals.mean(axis=1)).sum(axis=1) > 0.0).all()


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_white_ball_is_brighter_than_a_black_one():
    from lumenray.command_line.asset_library.material_thumbnails import render_material

    white, black = (
        render_material(materials.find_entry(name), samples=2, size=32)
        for name in ("wall_white_matt", "lacquer_black_gloss")
    )
    assert white.shape == (32, 32, 3)
    assert white[12:20, 12:20].mean() > 5.0 * black[12:20, 12:20].mean()
