"""The library of materials: catalogue, files within physics, and folders of users."""

import json

import numpy as np
import pytest
from library_materials import ENTRIES, FILES, NAMES, RECIPES, at, sides_of, total

from lumenray.engine.photometry.spectra import GRID, illuminant, luminous_efficiency
from lumenray.engine.scattering.data.evaluation import evaluate, measure_reciprocity
from lumenray.engine.scattering.data.surface import excess_of
from lumenray.engine.scattering.readers.reader import read_scattering
from lumenray.engine.scene.material import Measured
from lumenray.engine.scene.scattering import ScatterTable
from lumenray.libraries import materials, spectra
from lumenray.libraries.materials.catalogue import SETTINGS
from lumenray.tools.libraries.materials import colour, fresnel, indices, metals, tables


def luminous(part, values):
    weights = luminous_efficiency() * illuminant(GRID, "D65")
    return float(np.interp(GRID, part.wavelengths, values) @ weights / weights.sum())


def test_the_library_is_large_and_sorted():
    library = materials.read_library(materials.LIBRARY)
    assert library.problems == ()
    assert len(library.entries) >= 28
    groups = materials.by_category(library.entries)
    assert {name.split("/")[0] for name in groups} >= {
        "Paint", "Metal", "Glass", "Diffuser", "Textile", "Road", "Building", "Screen",
    }  # fmt: skip
    for entry in library.entries:
        assert entry.description, entry.name
        assert entry.source, entry.name
        assert entry.tags, entry.name
        assert entry.licence == "CC0-1.0"
        assert "/" in entry.category or entry.category in {"Screen", "Crystal", "Liquid"}
    assert {entry.model for entry in ENTRIES} >= {
        "MEASURED", "CONDUCTOR", "DIELECTRIC", "THIN_GLASS",
    }  # fmt: skip


def test_the_catalogue_is_what_the_recipes_say():
    written = json.loads((materials.LIBRARY / "materials.json").read_text(encoding="utf-8"))
    assert written["materials"] == [recipe.entry for recipe in RECIPES.values()]
    stems = {path.stem for path in materials.FOLDER.iterdir()}
    assert stems == set(FILES)


def test_files_are_small():
    sizes = [path.stat().st_size for path in materials.FOLDER.iterdir()]
    assert max(sizes) < 1_000_000
    assert sum(sizes) < 3_000_000


def test_writing_again_gives_the_same_bytes(tmp_path):
    made = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        *_, path = tables.write(folder, {"screen_fabric_grey"})
        made.append(path.read_bytes())
    assert made[0] == made[1]


@pytest.mark.parametrize("name", FILES)
def test_no_side_sends_away_more_light_than_comes(name):
    sides = sides_of(name)
    for side in ("front", "back"):
        parts = [sides[key] for key in sides if key.startswith(side)]
        for part in parts:
            assert np.isfinite(part.values).all()
        tables = [part for part in parts if isinstance(part, ScatterTable)]
        if len(tables) < len(parts):
            (part,) = parts
            assert excess_of(part, None) <= 1.0
            continue
        axis = tables[0].incidences
        places = np.concatenate([axis, 0.5 * (axis[1:] + axis[:-1])])
        # Of what has a grain, the axes, what lies between, and between rotations of the table.
        turns = tables[0].rotations
        for rotation in (
            [turns[0], *turns[9::9], 0.5 * turns[:2].sum()] if len(turns) > 1 else turns
        ):
            for s in places:
                share = sum(total(part, s, rotation) for part in tables)
                assert share.max() <= 1.002, (side, np.degrees(s))


@pytest.mark.parametrize("name", FILES)
def test_a_file_says_what_the_physics_says(name):
    """At the table's incidences and any rotation, root mean square over even directions, relative to the value and 5 % of
    the mean."""
    rng, parts = np.random.default_rng(11), RECIPES[name].make()
    for side, scatter in sides_of(name).items():
        if not isinstance(scatter, ScatterTable) or not scatter.values.any():
            continue
        sine, turn = 0.999 * np.sqrt(rng.random(1500)), 2.0 * np.pi * rng.random(1500)
        wo = np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1.0 - sine**2)], axis=1)
        tilt = rng.choice(scatter.incidences[:-3], 1500)
        wi = at(np.degrees(tilt), 360.0 * rng.random(1500))
        true, found = parts[side].evaluate(wi, wo), evaluate(scatter, wi, wo)
        if true.shape[1] > 1 and found.shape[1] > 1:
            true = true[:, np.searchsorted(colour.WAVELENGTHS, scatter.wavelengths)]
        true, found = (values.mean(axis=1) for values in (true, found))
        error = (found - true) / (true + 0.05 * true.mean())
        assert np.sqrt((error**2).mean()) < (0.07 if len(scatter.rotations) > 1 else 0.06), side


@pytest.mark.parametrize("name", FILES)
def test_scattering_is_nearly_reciprocal(name):
    """Residuals as `measure_reciprocity` says: 7 % for the steep flanks of rough coats on coarse grids, 3 % else."""
    sides = sides_of(name)
    limit = 0.07 if is_lobed(name) else 0.03
    for side in ("front_reflection", "back_reflection"):
        assert measure_reciprocity(sides[side]).residual < limit
    if "front_transmission" in sides and sides["front_transmission"].values.any():
        pair = sides["front_transmission"], sides["back_transmission"]
        assert measure_reciprocity(*pair).residual < 0.03


def is_lobed(name):
    words = ("silk", "powder", "film", "glass", "linoleum", "wood", "asphalt_dry", "perforated")
    return any(word in name for word in (*words, "sign", "blackout", "wall"))


@pytest.mark.parametrize("name", FILES)
def test_a_file_reflects_and_lets_through_what_the_catalogue_states(name):
    """Light 8 degrees from the normal, as spectrophotometers measure."""
    entry, sides = materials.find_entry(name), sides_of(name)
    stated = {"reflection": entry.reflectance, "transmission": entry.transmittance}
    for way, share in stated.items():
        part = sides.get(f"front_{way}")
        if share is None or (part is None and share == 0.0):
            continue
        found = luminous(part, total(part, np.radians(8.0)))
        assert found == pytest.approx(share, abs=0.007), way


@pytest.mark.parametrize("name", NAMES)
def test_measured_settings_are_of_a_known_form(name):
    entry = materials.find_entry(name)
    assert entry.model in SETTINGS
    if entry.file is not None:
        assert entry.settings["measured"]["filepath"] == f"library:{name}"
        file = read_scattering(entry.file)
        assert file.name == entry.title
        assert file.source == entry.source


def test_what_has_a_grain_has_one():
    grained = {name for name in FILES if Measured(**sides_of(name)).has_grain}
    assert grained == {"aluminium_brushed", "steel_brushed", "film_40x10"}


def test_polished_metals_state_their_reflectance():
    mirrors = [entry for entry in ENTRIES if entry.model == "CONDUCTOR"]
    assert len(mirrors) >= 5
    for entry in mirrors:
        assert entry.settings["metal"] in spectra.conductor_names()
        made = fresnel.reflectance(1.0, metals.index_of(entry.settings["metal"]))
        assert colour.luminous(made) == pytest.approx(entry.reflectance, abs=0.01), entry.name


@pytest.mark.parametrize(
    "entry", [e for e in ENTRIES if e.model == "DIELECTRIC"], ids=lambda e: e.name
)
def test_settings_of_glasses_give_the_stated_index_and_abbe_number(entry):
    listed = json.loads((materials.LIBRARY / "materials.json").read_text(encoding="utf-8"))
    stated = next(item for item in listed["materials"] if item["name"] == entry.name)
    micrometres = {line: 1e-3 * nm for line, nm in indices.LINES.items()}
    n = {
        line: entry.settings["ior"] + entry.settings["cauchy_b"] / w**2
        for line, w in micrometres.items()
    }
    assert n["d"] == pytest.approx(stated["refractive_index_d"], abs=2e-5)
    assert (n["d"] - 1.0) / (n["F"] - n["C"]) == pytest.approx(stated["abbe_number"], rel=2e-3)


def test_panes_let_through_what_is_stated():
    panes = [entry for entry in ENTRIES if entry.model == "THIN_GLASS"]
    assert len(panes) == 2
    for entry in panes:
        n, inside = entry.settings["ior"], entry.settings["transmittance"]
        face = ((n - 1.0) / (n + 1.0)) ** 2
        passed = (1.0 - face) ** 2 * inside / (1.0 - (face * inside) ** 2)
        assert passed == pytest.approx(entry.transmittance, abs=0.005)


def listed(folder, **entry):
    """Library of a folder with one material."""
    (folder / "files").mkdir(exist_ok=True)
    (folder / "files" / "mine.lumbsdf").write_bytes(b"data")
    entry = {
        "name": "mine",
        "title": "Mine",
        "category": "Own / Paint",
        "settings": {"model": "MEASURED", "measured": {"filepath": "files/mine.lumbsdf"}},
        **entry,
    }
    (folder / "materials.json").write_text(json.dumps({"licence": "MIT", "materials": [entry]}))
    return materials.read_library(folder)


def test_a_folder_of_a_user_is_read_like_ours(tmp_path):
    library = listed(tmp_path, luminous_reflectance=0.5)
    assert library.problems == ()
    (entry,) = library.entries
    assert (entry.category, entry.licence, entry.reflectance) == ("Own/Paint", "MIT", 0.5)
    assert entry.file == tmp_path / "files" / "mine.lumbsdf"
    assert entry.thumbnail == tmp_path / "thumbnails" / "mine.png"


def test_a_folder_of_a_user_may_name_what_ships(tmp_path):
    settings = {"model": "MEASURED", "measured": {"filepath": "library:brick_red", "rotation": 1.0}}
    (entry,) = listed(tmp_path, settings=settings).entries
    assert entry.file == materials.FOLDER / "brick_red.lumbsdf"


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"name": "../mine"}, "needs a 'name'"),
        ({"name": 3}, "'name' should be a text"),
        ({"title": ""}, "needs a 'title'"),
        ({"tags": "red"}, "'tags' of mine"),
        ({"thumbnail": "../x.png"}, "'thumbnail' of mine"),
        ({"luminous_reflectance": 1.5}, "from 0 to 1"),
        ({"luminous_reflectance": float("nan")}, "from 0 to 1"),
        ({"settings": 1}, "a 'model' of"),
        ({"settings": {"model": "EMITTER"}}, "a 'model' of"),
        ({"settings": {"model": "DIFFUSE", "sheen": 1}}, "no setting 'sheen'"),
        ({"settings": {"model": "DIFFUSE", "reflectance": True}}, "a number from 0 to 1"),
        ({"settings": {"model": "DIFFUSE", "reflectance_color": [1, 2]}}, "3 numbers"),
        ({"settings": {"model": "CONDUCTOR", "metal": "Unobtainium"}}, "one of Ag"),
        ({"settings": {"model": "CONDUCTOR", "metal": ["Ag"]}}, "one of Ag"),
        ({"settings": {"model": "MEASURED"}}, "needs a 'filepath'"),
        ({"settings": {"model": "MEASURED", "measured": 4}}, "should be an object"),
        ({"settings": {"model": "MEASURED", "measured": {"filepath": 4}}}, "should be a text"),
        ({"settings": {"model": "MEASURED", "measured": {"filepath": "../a"}}}, "in this folder"),
        ({"settings": {"model": "MEASURED", "measured": {"filepath": "a"}}}, "not there"),
        ({"settings": {"model": "MEASURED", "measured": {"filepath": "library:a/b"}}}, "names no"),
    ],
)
def test_a_wrong_entry_is_told_and_left_out(tmp_path, entry, words):
    library = listed(tmp_path, **entry)
    assert library.entries == ()
    (problem,) = library.problems
    assert words in problem.message
    assert problem.path == tmp_path / "materials.json"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is not JSON: line 1"),
        ("[1]", "expected an object"),
        ('{"materials": 3}', "'materials' should be a list"),
        ('{"materials": [3]}', "material 1: expected an object"),
        ("[" * 100_000, "cannot be read"),
        ("\udcff", "cannot be read"),
    ],
)
def test_a_broken_list_is_told(tmp_path, text, words):
    (tmp_path / "materials.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    library = materials.read_library(tmp_path)
    assert library.entries == ()
    assert words in library.problems[0].message


def test_two_materials_of_one_name_are_told(tmp_path):
    listed(tmp_path)
    content = json.loads((tmp_path / "materials.json").read_text())
    content["materials"] *= 2
    (tmp_path / "materials.json").write_text(json.dumps(content))
    library = materials.read_library(tmp_path)
    assert len(library.entries) == 1
    assert "two materials" in library.problems[0].message


def test_an_unknown_material_is_refused():
    with pytest.raises(KeyError):
        materials.find_entry("unobtainium")
