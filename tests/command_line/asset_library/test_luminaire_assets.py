"""The library of luminaires as Blender assets: what ships, what is made of a user's folder, and its pictures."""

import hashlib

import bpy
import numpy as np
import pytest
from blend_assets import catalogues, opened_assets
from PIL import Image

from lumenray.blender_addon.luminaires.files import photometric_files
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.command_line.asset_library import build
from lumenray.command_line.asset_library.stage import STAGES, part_frame, set_stage
from lumenray.command_line.main import main
from lumenray.engine.luminaires.distribution import flux
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.scene.light import Luminaire
from lumenray.engine.scene.spectrum import Blackbody, Illuminant
from lumenray.libraries import luminaires
from lumenray.libraries.luminaires.model import MOUNTS

pytestmark = pytest.mark.usefixtures("empty_file")

MODELS = luminaires.models()

SINGLE = [item.name for item in MODELS if not item.parts]

LAMPS = [item.name for item in MODELS if item.parts]

SMALL = """IESNA:LM-63-2002
[TEST] 1
[TESTLAB] None
[ISSUEDATE] 2026-01-01
[MANUFAC] A maker
TILT=NONE
1 -1 1 3 1 1 2 0.1 0.1 0
1 1 5
0 45 90
0
300 200 0
"""


def append(title, kind="objects"):
    """Append an asset of the library that ships, as dropping it into the scene does."""
    with bpy.data.libraries.load(str(luminaires.FOLDER / build.ASSETS), link=False) as (_, taken):
        setattr(taken, kind, [title])
    asset = getattr(taken, kind)[0]
    scene = bpy.context.scene
    if kind == "collections":
        scene.collection.children.link(asset)
    else:
        scene.collection.objects.link(asset)
    bpy.context.view_layer.update()
    return asset


def converted():
    """Luminaires of the scene, and what the conversion had to say."""
    made = convert_scene(bpy.context.evaluated_depsgraph_get())
    lights = [item for item in made.delta.changed if isinstance(item, Luminaire)]
    return lights, [row.message for row, _ in made.report.rows if row.severity.value != "info"]


def test_every_model_is_an_asset_in_its_catalogue_with_its_picture():
    known = catalogues(luminaires.FOLDER)
    assets = opened_assets(luminaires.FOLDER / build.ASSETS)
    assert set(assets) == {item.title for item in MODELS}
    for item in MODELS:
        asset = assets[item.title]
        assert known[asset.asset_data.catalog_id] == f"Luminaires/{item.category}"
        assert item.description in asset.asset_data.description
        assert asset.asset_data.license == item.licence
        assert set(item.tags) <= {tag.name for tag in asset.asset_data.tags}
        assert tuple(asset.preview.image_size) == (256, 256), item.name
        shown = np.empty(256 * 256 * 4, np.float32)
        asset.preview.image_pixels_float.foreach_get(shown)
        picture = np.asarray(Image.open(item.thumbnail).convert("RGBA"), np.float32)[::-1] / 255.0
        assert np.abs(shown - picture.ravel()).max() < 0.01, item.name


def test_pictures_are_small_lit_and_not_burnt_out():
    for item in MODELS:
        with Image.open(item.thumbnail) as picture:
            assert picture.size == (256, 256), item.name
            grey = np.asarray(picture.convert("L"), np.float32)
        assert item.thumbnail.stat().st_size < 120_000, item.name
        assert np.quantile(grey, 0.998) > 120.0, item.name
        assert (grey > 253.0).mean() < 0.05, item.name


def test_the_files_are_embedded_as_they_are():
    assets = opened_assets(luminaires.FOLDER / build.ASSETS)
    for name in SINGLE:
        item = luminaires.find_model(name)
        settings = assets[item.title].data.lumenray.luminaire
        digest = hashlib.sha256(item.file.read_bytes()).hexdigest()
        assert settings.use_file
        assert settings.filepath == ""
        assert settings.text.lumenray.digest == settings.digest == digest, name
        assert hashlib.sha256(photometric_files.content_of(settings.text)).hexdigest() == digest, (
            name
        )


@pytest.mark.parametrize("name", ["downlight_40", "street_type_2", "candle", "headlamp_low_beam"])
def test_an_appended_luminaire_shines_as_its_file_says(name):
    item = luminaires.find_model(name)
    append(item.title)
    (light,), remarks = converted()
    file = read_luminaire(item.file)
    assert remarks == []
    assert light.output.value == pytest.approx(item.luminous_flux, rel=1e-4)
    assert light.opening == file.opening
    assert np.array_equal(light.distribution.intensity, file.distribution.intensity)
    expected = Illuminant(item.light.name) if item.light.name else Blackbody(item.light.temperature)
    assert light.output.spectrum == expected


def test_an_appended_luminaire_is_local_and_brings_its_file():
    item = append("Wall washer")
    text = item.data.lumenray.luminaire.text
    assert item.library is None
    assert text.library is None
    assert photometric_files.obtain(item.data.lumenray.luminaire).flux == pytest.approx(
        2500.0, rel=1e-4
    )


@pytest.mark.parametrize("name", LAMPS)
def test_an_appended_lamp_is_the_sum_of_its_emitters(name):
    item = luminaires.find_model(name)
    asset = append(item.title, "collections")
    lights, remarks = converted()
    assert remarks == []
    assert len(lights) == len(asset.objects) == len(item.parts)
    assert sum(light.output.value for light in lights) == pytest.approx(item.luminous_flux, 1e-5)
    shared = read_luminaire(item.file).distribution
    found = {tuple(np.round(light.frame[:3, 3], 6)): light for light in lights}
    for part in item.parts:
        light = found[tuple(np.round(part.position, 6))]
        assert light.output.value == pytest.approx(part.share * item.luminous_flux, rel=1e-5)
        assert light.frame == pytest.approx(part_frame(part), abs=1e-6)
        assert light.opening.shape == part.shape
        assert light.opening.size == pytest.approx(part.size, abs=1e-7)
        # One distribution, up to its scale.
        scale = flux(light.distribution) / flux(shared)
        assert light.distribution.intensity == pytest.approx(scale * shared.intensity, abs=1e-3)


@pytest.fixture
def folder(tmp_path):
    """A folder of a user's with two files that are right and one that is not."""
    for place, text in (
        ("Office/Spots/small.ies", SMALL),
        ("plain.ies", SMALL.replace("300", "400")),
        ("Office/broken.ies", SMALL.replace("300 200 0", "300 200")),
    ):
        path = tmp_path / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


def test_a_folder_of_a_user_becomes_assets_and_a_broken_file_is_told(folder):
    built = build.build_assets(luminaires.read_library(folder))
    assert sorted(built.names) == ["plain", "small"]
    (problem,) = built.problems
    assert problem.path == folder / "Office" / "broken.ies"
    assert "3" in problem.message
    known = catalogues(folder)
    assets = opened_assets(built.path)
    assert set(assets) == {"plain", "small"}
    assert known[assets["small"].asset_data.catalog_id] == "Luminaires/Office/Spots"
    assert known[assets["plain"].asset_data.catalog_id] == "Luminaires"
    assert assets["small"].asset_data.author == "A maker"
    assert "A maker" in {tag.name for tag in assets["small"].asset_data.tags}
    assert assets["small"].data.lumenray.luminaire.spectrum_source == "FILE"


def test_catalogues_of_others_stay_and_ours_keep_their_identity(folder):
    other = "0f0e0d0c-0000-4000-8000-000000000001"
    (folder / build.CATALOGUES).write_text(f"VERSION 1\n\n{other}:Chairs/Old:Chairs-Old\n")
    library = luminaires.read_library(folder)
    build.build_assets(library)
    first = catalogues(folder)
    assert first[other] == "Chairs/Old"
    build.build_assets(library)
    assert catalogues(folder) == first
    assert build.catalogue_id("Office/Spots") == build.catalogue_id(" Office / Spots ")


def test_a_folder_without_photometric_files_is_refused(tmp_path, capsys):
    assert main(["luminaire", "library", str(tmp_path), "--pictures", "none"]) == 1
    assert "no photometric file" in capsys.readouterr().err


def test_the_command_tells_what_it_left_out(folder, capsys):
    assert main(["luminaire", "library", str(folder), "--pictures", "none"]) == 1
    said = capsys.readouterr()
    assert "2 assets" in said.out
    assert said.err.count("broken.ies") == 1
    (folder / "Office" / "broken.ies").unlink()
    assert main(["luminaire", "library", str(folder), "--pictures", "none"]) == 0


@pytest.mark.parametrize("mount", MOUNTS)
def test_a_stage_shows_the_luminaire_or_where_it_is_aimed(mount):
    item = next(model for model in MODELS if model.mount == mount)
    file = read_luminaire(item.file)
    items, camera = set_stage(item, file, Illuminant("E"), 64)
    lights = [light for light in items if isinstance(light, Luminaire)]
    total = sum(light.output.value for light in lights)
    assert total == pytest.approx(item.luminous_flux, rel=1e-4)
    position = np.mean([light.frame[:3, 3] for light in lights], axis=0)
    back = STAGES[mount].back * item.height / STAGES[mount].height
    assert 0.0 < position[2] <= item.height
    assert position[1] < back
    shown = position
    if mount in {"aimed", "level"}:
        beam = -lights[0].frame[:3, 2]
        shown = position + beam * (back - position[1]) / beam[1]
        assert 0.0 < shown[2] < STAGES[mount].top * item.height / STAGES[mount].height
    x, y, z = (shown - camera.frame[:3, 3]) @ camera.frame[:3, :3]
    assert z < 0.0
    assert abs(y / z) < 0.5 * camera.extent_y
    assert abs(x / z) < 0.5 * camera.extent_x


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_picture_shows_where_the_light_falls():
    from lumenray.command_line.asset_library.thumbnails import SIZE, render_thumbnail

    picture = render_thumbnail(luminaires.find_model("wall_washer"), samples=4)
    assert picture.shape == (SIZE, SIZE, 3)
    assert picture.min() >= 0.0
    assert picture.max() <= 1.0
    wall, floor = picture[90:190, 110:150].mean(), picture[5:30, 110:150].mean()
    assert wall > 2.0 * floor
