"""The library of luminaires: its files are what their formulas say, and folders of users are read with all faults told."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires import distribution as distributions
from lumenray.engine.luminaires.coordinates import directions
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.luminaires.openings import projected_area
from lumenray.engine.photometry.spectra import evaluate_emission
from lumenray.engine.scene.distribution import SHAPES, Opening
from lumenray.engine.scene.spectrum import Blackbody, Illuminant
from lumenray.libraries import luminaires
from lumenray.libraries.luminaires import catalogue
from lumenray.tools.libraries.luminaires import recipes

NAMES = [item.name for item in luminaires.models()]
LAMPS = [item.name for item in luminaires.models() if item.parts]


def read(name):
    return read_luminaire(luminaires.find_model(name).file)


def at(name, azimuth, gamma):
    """Intensity in directions of type C [degree], whatever the type of the file."""
    file = read(name)
    return distributions.intensity(
        file.distribution, directions(np.radians(azimuth), np.radians(gamma))
    )


# ---- the library as a whole ----


def test_the_library_is_large_and_sorted_by_use():
    library = luminaires.read_library(luminaires.FOLDER)
    assert library.problems == ()
    assert len(library.models) >= 24
    assert len({item.category for item in library.models}) >= 12
    assert len(LAMPS) >= 2
    assert {item.maker for item in library.models} == {"Lumenray"}
    for item in library.models:
        assert item.description, item.name
        assert item.licence == "CC0-1.0"
        assert item.tags, item.name
        assert item.category.count("/") >= 1, item.name


def test_all_photometric_types_and_both_formats_occur():
    files = [read(name) for name in NAMES]
    assert {file.photometric_type for file in files} == {"A", "B", "C"}
    assert {file.format for file in files} == {"LM-63-2002", "EULUMDAT"}
    assert {file.symmetry for file in files} >= {"rotational", "quadrant", "C90-C270", "none"}
    assert {file.opening.shape for file in files} >= set(SHAPES) - {"point", "box"}


@pytest.mark.parametrize("name", NAMES)
def test_a_file_reads_without_remarks_and_has_the_stated_flux(name):
    item, file = luminaires.find_model(name), read(name)
    assert file.remarks == ()
    assert distributions.flux(file.distribution) == pytest.approx(item.luminous_flux, rel=1e-4)
    assert (file.watts or 0.0) == pytest.approx(item.watts)
    assert "Lumenray synthetic" in file.metadata.values()
    assert max(file.opening.size) > 0.0


@pytest.mark.parametrize("name", NAMES)
def test_a_spectrum_is_one_that_the_engine_knows(name):
    light = luminaires.find_model(name).light
    kinds = {"illuminant": lambda: Illuminant(light.name)}
    kinds["blackbody"] = lambda: Blackbody(light.temperature)
    assert evaluate_emission(kinds[light.kind](), np.arange(400.0, 701.0, 50.0)).min() > 0.0


def test_the_files_are_those_that_the_generator_writes(tmp_path):
    for path in recipes.write(tmp_path):
        shipped = luminaires.FOLDER / path.relative_to(tmp_path)
        # A zero may come from below, by how the processor rounds.
        made, kept = (
            re.sub(rb"\s-0(?=\s)", b" 0", p.read_bytes()).split() for p in (path, shipped)
        )
        assert made == kept, path.name
    written = {path.name for path in tmp_path.glob("photometry/*")}
    assert written == {path.name for path in luminaires.FOLDER.glob("photometry/*")}


@pytest.mark.parametrize(
    ("entry", "photometry", "words"),
    [
        ({"file": "../elsewhere.ies"}, {}, "needs a 'file' in the library's folder"),
        ({"file": "photometry/a.xml"}, {}, "is '.xml', expected one of .ies, .ldt"),
        ({"mount": "tree"}, {}, "'mount' is 'tree'"),
        ({"watts": None}, {}, "needs a 'luminous_flux_lm' and 'watts'"),
        ({"parts": ["candelabra", 5]}, {}, "'parts' is 'candelabra', expected one of"),
        ({}, {"formula": "cone"}, "'formula' is 'cone', expected one of"),
        ({}, {"formula": ["beam"]}, "missing 1 required positional argument: 'width'"),
        ({}, {"kind": "D"}, "'kind' is 'D', expected one of C, B, A"),
        ({"file": "photometry/a.ldt"}, {"symmetry": "none"}, "'symmetry' is 'none'"),
        ({}, {"vertical": [[0, 90, 1e-6]]}, "a step of at least 0.01 degrees"),
        ({}, {"opening": ["ring", [1, 1, 0]]}, "'opening' is 'ring', expected one of point"),
        ({}, {"opening": ["ellipse", [1, 1]]}, "needs three sides"),
        ({}, {"lumens": 5}, "unexpected keyword argument 'lumens'"),
    ],
)
def test_a_recipe_that_cannot_be_is_told(tmp_path, entry, photometry, words):
    content = json.loads(recipes.RECIPES.read_text(encoding="utf-8"))
    first = content["models"][0]
    first |= entry
    first["photometry"] |= photometry
    path = tmp_path / "recipes.json"
    path.write_text(json.dumps(content))
    with pytest.raises(FileFormatError, match=re.escape(words)) as refused:
        recipes.read_recipes(path)
    assert str(refused.value).startswith(f"{path}: luminaire 1: ")


def test_an_unknown_model_is_refused():
    with pytest.raises(KeyError):
        luminaires.find_model("chandelier")


# ---- what the distributions are ----


@pytest.mark.parametrize(
    ("name", "width"),
    [(f"downlight_{width}", width) for width in (15, 24, 40, 60, 90)]
    + [("spot_6", 6), ("pencil_beam_2", 2), ("high_bay", 80)],
)
def test_a_beam_falls_to_half_at_half_its_width(name, width):
    axis, edge = at(name, 0.0, np.array([0.0, width / 2.0]))
    assert edge / axis == pytest.approx(0.5, abs=0.003)


@pytest.mark.parametrize(("name", "width"), [("downlight_15", 15), ("spot_6", 6)])
def test_the_peak_of_a_cosine_power_follows_from_its_flux(name, width):
    n = np.log(0.5) / np.log(np.cos(np.radians(width / 2.0)))
    expected = luminaires.find_model(name).luminous_flux * (n + 1.0) / (2.0 * np.pi)
    assert at(name, 0.0, 0.0) == pytest.approx(expected, rel=0.005)


def test_an_opal_panel_is_lambertian():
    gamma = np.array([0.0, 30.0, 60.0, 85.0])
    expected = 3800.0 / np.pi * np.cos(np.radians(gamma))
    assert at("panel_600_opal", 33.0, gamma) == pytest.approx(expected, rel=1e-3, abs=0.1)


@pytest.mark.parametrize(("name", "axis"), [("tube_t8_36w", 0), ("compact_fluorescent_9w", 2)])
def test_a_bare_tube_shines_as_the_sine_of_the_angle_to_its_axis(name, axis):
    """Its flux is pi^2 times its largest intensity."""
    d = np.random.default_rng(5).normal(size=(200, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    largest = luminaires.find_model(name).luminous_flux / np.pi**2
    expected = largest * np.sqrt(1.0 - d[:, axis] ** 2)
    found = distributions.intensity(read(name).distribution, d)
    assert found == pytest.approx(expected, abs=0.02 * largest)


def test_an_opal_drum_shines_as_the_area_that_it_shows():
    down, side = at("bulkhead", 0.0, np.array([0.0, 90.0]))
    assert side / down == pytest.approx(4.0 * 0.09 / (np.pi * 0.28), rel=1e-3)


def test_a_flame_gives_a_candela_to_the_side_and_less_upwards():
    side, above = at("candle", 0.0, np.array([90.0, 180.0]))
    assert side == pytest.approx(1.0, abs=0.03)
    # The areas of an ellipsoid of 12 x 35 mm from its end and from its side are as 12 to 35.
    assert above / side == pytest.approx(12.0 / 35.0, rel=1e-3)


def test_a_globe_shines_evenly():
    values = at("opal_globe_300", 0.0, np.linspace(0.0, 155.0, 32))
    assert values == pytest.approx(1000.0 / (4.0 * np.pi), rel=0.05)
    assert np.ptp(values) < 1e-3 * values.mean()


def test_the_wall_washer_lights_its_wall_evenly():
    gamma = np.linspace(27.0, 59.0, 65)
    # At the distance 1 from the wall: E = I sin / r^2 with r = 1 / sin.
    illuminance = at("wall_washer", 90.0, gamma) * np.sin(np.radians(gamma)) ** 3
    assert np.ptp(illuminance) < 0.03 * illuminance.mean()
    assert at("wall_washer", 270.0, 40.0) < 0.03 * at("wall_washer", 90.0, 40.0)


@pytest.mark.parametrize(
    ("name", "azimuth", "end", "dark"),
    [
        ("batwing_office", 0.0, 35.0, 72.0),
        ("low_bay_wide", 0.0, 44.0, 74.0),
        ("escape_route", 0.0, 62.0, 77.0),
    ],
)
def test_a_wide_luminaire_lights_the_plane_below_evenly(name, azimuth, end, dark):
    gamma = np.linspace(0.0, end, 50)
    illuminance = at(name, azimuth, gamma) * np.cos(np.radians(gamma)) ** 3
    assert np.ptp(illuminance) < 0.02 * illuminance.mean()
    assert at(name, azimuth, dark + 1.0) == 0.0


def test_the_prismatic_panel_is_dim_for_screens():
    """EN 12464-1 takes 3000 cd/m2 as the limit from 65 degrees on, for bright screens and ordinary tasks."""
    file = read("troffer_600_prismatic")
    for azimuth in np.arange(0.0, 360.0, 15.0):
        d = directions(np.radians(azimuth), np.radians(np.array([65.0, 70.0, 75.0, 80.0, 85.0])))
        luminance = distributions.intensity(file.distribution, d) / projected_area(file.opening, d)
        assert luminance.max() < 3000.0


def test_the_shares_above_and_below_are_as_described():
    half = np.pi / 2.0
    for name, below in (
        ("pendant_direct_indirect", 0.55),
        ("linear_indirect", 0.0),
        ("torchiere", 0.0),
        ("wall_up_down", 0.5),
        ("post_top", 1.0),
        ("bollard", 1.0),
        ("street_type_2", 1.0),
        ("street_type_3", 1.0),
        ("flood_asymmetric", 1.0),
    ):
        distribution = read(name).distribution
        share = distributions.flux(distribution, 0.0, half) / distributions.flux(distribution)
        assert share == pytest.approx(below, abs=1e-3), name


@pytest.mark.parametrize(
    ("name", "nearest", "farthest"), [("street_type_2", 1.0, 1.75), ("street_type_3", 1.75, 2.75)]
)
def test_a_street_luminaire_has_its_type(name, nearest, farthest):
    """By the half-maximum trace, in mounting heights, of a medium luminaire (ANSI/IES TM-15, IES RP-8)."""
    along, across = np.meshgrid(np.linspace(0.0, 6.0, 301), np.linspace(0.0, 5.0, 501))
    d = np.stack([along, across, -np.ones_like(along)], axis=-1)
    intensity = distributions.intensity(read(name).distribution, d)
    largest = np.unravel_index(np.argmax(intensity), intensity.shape)
    assert 2.25 <= along[largest] < 3.75
    trace = (intensity >= 0.5 * intensity.max()) & (along >= 2.25) & (along < 3.75)
    assert nearest < across[trace].max() <= farthest


def test_the_asymmetric_flood_throws_to_c90():
    values = at("flood_asymmetric", np.array([90.0, 90.0, 270.0]), np.array([55.0, 80.0, 55.0]))
    assert values[0] == pytest.approx(distributions.peak(read("flood_asymmetric").distribution)[0])
    assert values[1] < 0.05 * values[0]
    assert values[2] < 0.05 * values[0]


def test_the_narrow_flood_is_symmetrical_about_its_beam():
    d = np.array([(0.0, 0.0, -1.0), *_off_axis(7.0), *_off_axis(14.0)])
    values = distributions.intensity(read("flood_narrow").distribution, d)
    assert values[1:5] / values[0] == pytest.approx(0.5, abs=0.005)
    assert values[5:] / values[0] == pytest.approx(1.0 / 16.0, abs=0.005)


def _off_axis(angle):
    s, c = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    return (s, 0.0, -c), (-s, 0.0, -c), (0.0, s, -c), (0.0, -s, -c)


def test_the_oval_lens_is_wide_along_x():
    x, y = np.radians(30.0), np.radians(7.5)
    d = np.array(
        [(0.0, 0.0, -1.0), (np.sin(x), 0.0, -np.cos(x)), (0.0, np.sin(y), -np.cos(y))], dtype=float
    )
    values = distributions.intensity(read("track_oval").distribution, d)
    assert values[1:] / values[0] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(
    ("point", "right", "up", "least", "most"),
    [
        ("B50L", -3.43, 0.57, 0, 350),
        ("BR", 2.5, 1.0, 0, 1750),
        ("75R", 1.15, -0.57, 10100, np.inf),
        ("75L", -3.43, -0.57, 0, 10600),
        ("50L", -3.43, -0.86, 0, 13200),
        ("50R", 1.72, -0.86, 10100, np.inf),
        ("50V", 0.0, -0.86, 5100, np.inf),
        ("25L", -9.0, -1.72, 1700, np.inf),
        ("25R", 9.0, -1.72, 1700, np.inf),
        ("zone III", -8.0, 1.0, 0, 625),
    ],
)
def test_the_low_beam_meets_the_test_points_of_un_r112_class_b(point, right, up, least, most):
    h, v = np.radians(right), np.radians(up)
    # +x is right and +y is up, seen along the beam -z.
    d = np.array([np.cos(v) * np.sin(h), np.sin(v), -np.cos(v) * np.cos(h)])
    value = distributions.intensity(read("headlamp_low_beam").distribution, d)
    assert least <= value <= most, point


# ---- lamps of several emitters ----


@pytest.mark.parametrize("name", LAMPS)
def test_the_emitters_share_the_whole_flux(name):
    parts = luminaires.find_model(name).parts
    assert sum(part.share for part in parts) == pytest.approx(1.0, abs=1e-9)
    assert all(part.share > 0.0 for part in parts)
    for part in parts:
        assert np.linalg.norm(part.axis) == pytest.approx(1.0)
        assert Opening(part.shape, part.size, part.opening_axis).shape in SHAPES


def test_the_tube_has_seven_zones_without_gaps_and_dark_ends():
    parts = luminaires.find_model("tube_t8_36w").parts
    assert len(parts) == 7
    x = np.array([part.position[0] for part in parts])
    length = np.array([part.size[0] for part in parts])
    assert x[:-1] + 0.5 * length[:-1] == pytest.approx(x[1:] - 0.5 * length[1:], abs=2e-6)
    assert length.sum() == pytest.approx(read("tube_t8_36w").opening.size[0], abs=1e-5)
    # A cylinder of luminance L without ends gives the flux pi L A.
    luminance = np.array([part.share for part in parts]) * 3350.0 / (np.pi**2 * 0.026 * length)
    assert luminance == pytest.approx(luminance[::-1], rel=1e-3)
    assert np.all(np.diff(luminance[:4]) > 0.0)
    # Makers state 1.1 to 1.2 cd/cm2 for this lamp.
    assert 11000.0 < luminance[3] < 12000.0


def test_the_filament_is_dimmer_where_the_leads_cool_it():
    parts = luminaires.find_model("halogen_50w").parts
    share = np.array([part.share for part in parts])
    z = np.array([part.position[2] for part in parts])
    assert {part.shape for part in parts} == {"point"}
    assert len(parts) >= 9
    assert np.diff(z) == pytest.approx(np.diff(z)[0], abs=2e-6)
    assert share == pytest.approx(share[::-1], abs=1e-5)
    # The luminance of a blackbody, by Planck's law and V(lambda), at the temperatures of the ends and the middle.
    temperature = 3000.0 * (1.0 - 0.2 * np.exp((np.abs(z) - 0.002) / 0.0006))
    expected = np.array([_luminance(kelvin) for kelvin in temperature])
    assert share / share.max() == pytest.approx(expected / expected.max(), rel=0.05)


def _luminance(kelvin):
    from lumenray.libraries import spectra

    nm, xyz = spectra.observer()
    planck = nm**-5.0 / np.expm1(1.438777e7 / (nm * kelvin))
    return float(planck @ xyz[:, 1])


# ---- folders of users ----


@pytest.fixture
def folder(tmp_path):
    """A folder of a user's with two files, whose content the catalogue does not look at."""
    for place in ("Office/Recessed/panel.ldt", "Street/lantern.IES", "Street/notes.txt"):
        path = tmp_path / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("text")
    return tmp_path


def listed(folder, name="luminaires.json", **content):
    (folder / name).write_text(json.dumps(content))
    return luminaires.read_library(folder)


def test_folders_are_categories(folder):
    library = luminaires.read_library(folder)
    assert library.problems == ()
    found = {item.name: item.category for item in library.models}
    assert found == {"panel": "Office/Recessed", "lantern": "Street"}
    assert all(item.light is None for item in library.models)


def test_json_beside_a_file_describes_it(folder):
    library = listed(
        folder,
        "Street/lantern.json",
        title="Old lantern",
        maker="Me",
        category="Outdoor/Old town",
        spectrum={"blackbody_K": 2200},
        watts=70,
        tags=["gas"],
    )
    item = next(item for item in library.models if item.name == "lantern")
    assert library.problems == ()
    assert (item.title, item.maker, item.category) == ("Old lantern", "Me", "Outdoor/Old town")
    assert item.light == luminaires.Light("blackbody", temperature=2200.0)
    assert (item.watts, item.tags) == (70.0, ("gas",))


def test_a_list_describes_all_files_of_its_folder_and_some_in_particular(folder):
    library = listed(
        folder,
        maker="House",
        licence="CC-BY-4.0",
        models=[{"file": "Street/lantern.IES", "title": "Lantern", "maker": "Other"}],
    )
    assert library.problems == ()
    assert {item.title: item.maker for item in library.models} == {
        "panel": "House",
        "Lantern": "Other",
    }
    assert {item.licence for item in library.models} == {"CC-BY-4.0"}


def test_one_file_may_serve_several_models(folder):
    entries = [
        {"file": "Street/lantern.IES", "title": f"Lantern {kelvin} K",
         "spectrum": {"blackbody_K": kelvin}} for kelvin in (2000, 3000)
    ]  # fmt: skip
    library = listed(folder, models=entries)
    lanterns = [item for item in library.models if item.file.name == "lantern.IES"]
    assert {item.title for item in lanterns} == {"Lantern 2000 K", "Lantern 3000 K"}
    assert len({item.name for item in library.models}) == len(library.models)
    assert len({item.thumbnail for item in library.models}) == len(library.models)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"mount": "shelf"}, "'mount' is 'shelf'"),
        ({"title": 5}, "'title' should be a text"),
        ({"tags": "one"}, "'tags' should be a list"),
        ({"watts": -1}, "'watts' should be a number"),
        ({"watts": True}, "'watts' should be a number"),
        ({"watts": 10**400}, "'watts' should be a number"),
        ({"parts": [{"share": 10**400}]}, "every part needs a 'share'"),
        ({"spectrum": "FL11"}, "'spectrum' should hold one of"),
        ({"spectrum": {"illuminant": "D99"}}, "no illuminant 'D99'"),
        ({"spectrum": {"illuminant": ["D65"]}}, "no illuminant"),
        ({"spectrum": {"blackbody_K": 3}}, "from 500 to 40000"),
        ({"spectrum": {"gas": 1}}, "does not know 'gas'"),
        ({"thumbnail": "../secret.png"}, "'thumbnail' should lie in"),
        ({"parts": {}}, "'parts' should be a list"),
        ({"parts": [{"share": 0.5}]}, "add up to 0.5, expected 1"),
        ({"parts": [{"share": 1, "position_m": [0, 0]}]}, "list of three numbers"),
        ({"parts": [{"share": 1, "axis": [0, 0, 0]}]}, "must not be 0"),
        ({"parts": [{"share": 1, "opening": {"shape": "star"}}]}, "'shape'"),
        ({"parts": [{}]}, "needs a 'share'"),
    ],
)
def test_a_wrong_description_is_told_and_its_model_left_out(folder, entry, words):
    library = listed(folder, "Street/lantern.json", **entry)
    assert [item.name for item in library.models] == ["panel"]
    (problem,) = library.problems
    assert words in problem.message
    assert problem.path == folder / "Street" / "lantern.json"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is not JSON: line 1"),
        ("[1]", "expected an object"),
        ('{"models": 3}', "'models' should be a list"),
        ('{"models": [3]}', "model 1 needs a 'file'"),
        ('{"models": [{"file": "../outside.ies"}]}', "model 1 needs a 'file' in this folder"),
        ('{"models": [{"file": "none.ies"}]}', "names none.ies, which is not there"),
        ("[" * 100_000, "cannot be read"),
        ("\udcff", "cannot be read"),
    ],
)
def test_a_broken_list_is_told_and_the_files_stay(folder, text, words):
    (folder / "luminaires.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    library = luminaires.read_library(folder)
    assert {item.name for item in library.models} == {"panel", "lantern"}
    (problem,) = library.problems
    assert words in problem.message


def test_a_folder_that_is_not_there_is_told(tmp_path):
    library = luminaires.read_library(tmp_path / "none")
    assert library.models == ()
    assert "no such folder" in str(library.problems[0])


def test_folders_that_lead_into_themselves_or_too_deep_end(folder, monkeypatch):
    (folder / "Street" / "loop").symlink_to(folder, target_is_directory=True)
    deep = folder.joinpath(*["deep"] * 14)
    deep.mkdir(parents=True)
    (deep / "lost.ies").write_text("text")
    library = luminaires.read_library(folder)
    assert {item.name for item in library.models} == {"panel", "lantern"}
    assert "deeper than 12" in library.problems[0].message
    monkeypatch.setattr(catalogue, "MOST_FILES", 1)
    library = luminaires.read_library(folder)
    assert len(library.models) == 1
    assert any("the rest is left out" in problem.message for problem in library.problems)


def test_files_of_the_same_name_keep_names_of_their_own(folder):
    for place in ("A", "B"):
        (folder / place).mkdir()
        (folder / place / "panel.ies").write_text("text")
    names = [item.name for item in luminaires.read_library(folder).models]
    assert sorted(names) == ["lantern", "panel", "panel 2", "panel 3"]
    assert all(Path(name).name == name for name in names)
