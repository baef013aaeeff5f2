"""The library of materials: its physics against closed forms and standards, its files, and folders of users."""

import json
from functools import lru_cache

import numpy as np
import pytest
from lumenray.engine.photometry.spectra import GRID, illuminant, luminous_efficiency
from lumenray.engine.scattering.data import evaluation
from lumenray.engine.scattering.data.evaluation import evaluate, measure_reciprocity
from lumenray.engine.scattering.data.surface import excess_of, is_grained
from lumenray.engine.scattering.data.table import direct_share, interpolate, quadrature
from lumenray.engine.scattering.readers.reader import read_scattering
from lumenray.engine.scene.material import Measured
from lumenray.engine.scene.scattering import ScatterTable
from lumenray.libraries import materials, spectra
from lumenray.libraries.materials import __main__ as command
from lumenray.libraries.materials import (
    coats,
    colour,
    diffusers,
    flakes,
    fresnel,
    grains,
    indices,
    metals,
    microfacets,
    pigments,
    roads,
    sheets,
)
from lumenray.libraries.materials.catalogue import SETTINGS
from lumenray.libraries.materials.recipes import recipes

ENTRIES = materials.entries()
NAMES = [entry.name for entry in ENTRIES]
FILES = [entry.name for entry in ENTRIES if entry.file is not None]
RECIPES = {recipe.name: recipe for recipe in recipes()}
UP = np.array([[0.0, 0.0, 1.0]])


@lru_cache
def sides_of(name):
    return read_scattering(materials.find_entry(name).file).sides


def total(part, polar, rotation=0.0):
    """Share of light from an angle that is sent away, direct part included; by few points in every cell. [rad]"""
    if not isinstance(part, ScatterTable):
        return evaluation.total(part, polar, rotation)
    radial, azimuth, weight = quadrature(part, polar, 2)
    turn, tilt = np.full_like(radial, rotation), np.full_like(radial, polar)
    share = weight @ interpolate(part, turn, tilt, radial, azimuth)
    wi = at(np.degrees(polar), np.degrees(rotation))
    return share + (direct_share(part, wi)[0] if part.direct is not None else 0.0)


def luminous(part, values):
    weights = luminous_efficiency() * illuminant(GRID, "D65")
    return float(np.interp(GRID, part.wavelengths, values) @ weights / weights.sum())


def at(polar, azimuth=0.0):
    """Directions by angles. [degree]"""
    t, a = np.broadcast_arrays(np.radians(polar), np.radians(azimuth))
    parts = (np.sin(t) * np.cos(a), np.sin(t) * np.sin(a), np.cos(t))
    return np.stack([np.atleast_1d(p) for p in parts], axis=-1)


def hemisphere(count=200):
    """Directions and weights that integrate f cos over the hemisphere: even in the projected disk."""
    u = (np.arange(count) + 0.5) / count
    r, turn = (m.ravel() for m in np.meshgrid(np.sqrt(u), 2.0 * np.pi * u))
    wo = np.stack([r * np.cos(turn), r * np.sin(turn), np.sqrt(1.0 - r * r)], axis=1)
    return wo, np.pi / len(wo)


def sent(evaluate, polar, count=200):
    """Share of light from an angle that is scattered, by brute force."""
    wo, weight = hemisphere(count)
    return weight * evaluate(np.broadcast_to(at(polar), wo.shape), wo).sum(axis=0)


# ---- the catalogue ----


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
        *_, path = command.write(folder, {"screen_fabric_grey"})
        made.append(path.read_bytes())
    assert made[0] == made[1]


# ---- all files ----


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
    grained = {name for name in FILES if is_grained(Measured(**sides_of(name)))}
    assert grained == {"aluminium_brushed", "steel_brushed", "film_40x10"}


# ---- boundaries ----


def test_even_light_is_held_back_inside_as_known():
    """Internal reflectance 0.596 and external 0.092 of a boundary of index 1.5 (Judd; Saunderson)."""
    coat = coats.Coat(1.5)
    assert coat.mean_share == pytest.approx(0.0918, abs=1e-4)
    assert coat.held_back == pytest.approx(0.596, abs=5e-4)


@pytest.mark.parametrize("alpha", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("polar", [0.0, 45.0, 75.0])
def test_a_white_body_under_a_coat_sends_everything_out(alpha, polar):
    paint = coats.Paint(coats.Coat(1.5, alpha), np.ones(1))
    share = sent(paint.evaluate, polar, 400)
    share = share + paint.direct(np.radians([polar]))[0]
    assert share == pytest.approx(1.0, abs=4e-3)


def test_a_slab_without_absorption_loses_nothing():
    slab = coats.Slab(coats.Coat(1.49), np.array([0.3]), np.array([0.7]))
    assert sum(slab.totals()) == pytest.approx(1.0, abs=1e-9)
    assert sum(pigments.layer(0.0, 2.5)) == pytest.approx(1.0, abs=1e-6)
    # Kubelka and Munk without absorption: R = S / (1 + S).
    assert pigments.layer(0.0, 2.5)[0] == pytest.approx(2.5 / 3.5, abs=1e-6)


def test_rough_facets_reflect_and_let_through_what_comes():
    """Walter's BTDF and the BRDF of smooth facets together: 1, but for second hits."""
    glass = microfacets.smooth_to_rough(0.15)
    (share,) = sent(lambda wi, wo: glass.reflection(wi, wo, np.ones_like), 20.0, 600)
    known = float(glass.albedo([np.cos(np.radians(20.0))], np.ones_like))
    assert share == pytest.approx(known, abs=2e-3)
    assert 0.96 < share <= 1.0

    def inward(wi, wo):
        down = wo * [1.0, 1.0, -1.0]
        return glass.transmission(wi, down, 1.5, np.zeros_like)[:, None]

    # Refraction deviates less, so that hardly a facet is met twice.
    assert sent(inward, 20.0, 600) == pytest.approx(1.0, abs=0.01)


def test_grains_keep_white_light_and_are_lambertian_when_smooth():
    for roughness in (0.0, 0.5, 1.0):
        for polar in (8.0, 60.0, 80.0):
            made = sent(grains.Grains(np.ones(1), roughness).evaluate, polar)
            assert made == pytest.approx(1.0, abs=2e-3)
    smooth = grains.Grains(np.array([0.4]), 0.0)
    assert smooth.evaluate(at(60.0), at(20.0, 50.0)) == pytest.approx(0.4 / np.pi)
    rough = grains.Grains(np.array([0.4]), 0.8)
    assert sent(rough.evaluate, 8.0) == pytest.approx(rough.total(), abs=1e-3)


# ---- flakes ----


@pytest.mark.parametrize(
    ("films", "nanometres", "expected"),
    [
        ((2.7, 1.5, 2.7), (12, 448, 12), (0.2203, 0.2480, 0.1483, 0.0893, 0.2535, 0.4525)),
        ((2.7, 1.77, 2.7), (165, 230, 165), (0.0309, 0.0545, 0.0561, 0.0576, 0.4075, 0.5932)),
    ],
)
def test_interference_flakes_reflect_as_another_program_finds(films, nanometres, expected):
    """Values of the package tmm for 450 nm in a binder of 1.45."""
    cosines = np.cos(np.radians([0.0, 15.0, 30.0, 45.0, 60.0, 75.0]))
    found = fresnel.stack_reflectance(cosines, [450.0], films, nanometres, 1.45)[:, 0]
    assert found == pytest.approx(expected, abs=1e-4)


def test_single_reflection_at_flakes_is_the_closed_form():
    """Opaque flakes of 0.9, slopes of 3 degrees, 2 per line, binder 1.45; light at 45 degrees, seen at 30, 45, 60."""
    spread = np.tan(np.radians(3.0))
    paint = flakes.Flakes(
        lambda c: 0.9 + 0.0 * c[:, None], np.zeros(1), spread, 2.0, np.zeros(1), 1.45
    )
    wi, wo = np.repeat(at(45.0), 3, axis=0), at([-30.0, -45.0, -60.0])
    found = paint.reflect_once(wi, wo)[:, 0]
    assert found == pytest.approx([1.1187, 3.6709, 1.7700], rel=3e-3)


def test_white_flakes_over_a_white_base_send_everything_out():
    paint = flakes.Flakes(
        lambda c: np.ones((len(c), 1)), np.ones(1), 0.1, 2.0, np.zeros(1), is_wide=True
    )
    for polar in (0.0, 30.0, 60.0, 80.0):
        share = sent(paint.evaluate, polar, 300) + paint.direct(np.radians([polar]))[0]
        assert share == pytest.approx(1.0, abs=0.01)


# ---- metals and glasses ----


@pytest.mark.parametrize(
    ("metal", "known"),
    # Normal reflectance at 550 nm by handbooks (n, k of Rakic 1995; Johnson and Christy 1972).
    [("Al", 0.92), ("Ag", 0.96), ("Cu", 0.62), ("Au", 0.82), ("Cr", 0.65)],
)
def test_metals_reflect_as_handbooks_say(metal, known):
    index = metals.index_of(metal)[colour.WAVELENGTHS == 550.0]
    assert fresnel.reflectance(1.0, index)[0] == pytest.approx(known, abs=0.04)
    n, k = index[0].real, index[0].imag
    normal = ((n - 1.0) ** 2 + k * k) / ((n + 1.0) ** 2 + k * k)
    assert fresnel.reflectance(1.0, index)[0] == pytest.approx(normal, rel=1e-12)


def test_aluminium_has_the_index_of_rakic():
    index = metals.index_of("Al")[colour.WAVELENGTHS == 550.0][0]
    assert (index.real, index.imag) == pytest.approx((0.96, 6.69), rel=0.02)


def test_polished_metals_state_their_reflectance():
    mirrors = [entry for entry in ENTRIES if entry.model == "CONDUCTOR"]
    assert len(mirrors) >= 5
    for entry in mirrors:
        assert entry.settings["metal"] in spectra.conductor_names()
        made = fresnel.reflectance(1.0, metals.index_of(entry.settings["metal"]))
        assert colour.luminous(made) == pytest.approx(entry.reflectance, abs=0.01), entry.name


@pytest.mark.parametrize(
    ("matter", "index", "abbe", "exactness"),
    # Schott's data sheets; Malitson; IAPWS for 20 degrees; refractiveindex.info.
    [
        ("N-BK7", 1.5168, 64.17, 0.01),
        ("N-SF11", 1.78472, 25.68, 0.01),
        ("fused silica", 1.45846, 67.82, 0.02),
        ("sapphire", 1.7682, 72.3, 0.1),
        ("water", 1.3334, 55.8, 0.1),
        ("polycarbonate", 1.5848, 27.9, 0.1),
        ("diamond", 2.4175, 55.3, 0.1),
    ],
)
def test_glasses_have_their_index_and_abbe_number(matter, index, abbe, exactness):
    formula = indices.CLEAR[matter]
    assert float(formula.index(indices.LINES["d"])) == pytest.approx(index, abs=1e-4)
    assert indices.abbe_number(formula) == pytest.approx(abbe, abs=exactness)


@pytest.mark.parametrize("entry", [e for e in ENTRIES if e.model == "DIELECTRIC"], ids=str)
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


# ---- paints ----


def test_a_gloss_paint_mirrors_by_fresnel_and_a_matt_one_does_not():
    table = sides_of("lacquer_red_gloss")["front_reflection"]
    share = direct_share(table, at([0.0, 62.0]))[:, 0]
    expected = fresnel.reflectance(np.cos(np.radians([0.0, 62.0])), 1.5)
    assert share == pytest.approx(expected, abs=1e-4)
    assert sides_of("wall_white_matt")["front_reflection"].direct is None


@pytest.mark.parametrize(
    ("name", "bright", "dark"),
    [
        ("lacquer_red_gloss", 650.0, 500.0),
        ("lacquer_blue_gloss", 460.0, 620.0),
        ("lacquer_yellow_gloss", 600.0, 440.0),
        ("lacquer_green_silk", 520.0, 660.0),
        ("brick_red", 660.0, 460.0),
        ("copper_satin", 660.0, 460.0),
        ("wall_white_matt", 600.0, 400.0),
    ],
)
def test_colours_lie_where_their_names_say(name, bright, dark):
    part = sides_of(name)["front_reflection"]
    spectrum = np.interp([bright, dark], part.wavelengths, total(part, np.radians(20.0)))
    assert spectrum[0] > 1.25 * spectrum[1]


def test_metallic_paint_is_brightest_at_its_mirror_direction_and_dark_aside():
    part = sides_of("car_silver")["front_reflection"]
    wi = np.repeat(at(45.0), 2, axis=0)
    # 15 and 75 degrees from the mirror direction, towards the normal.
    near, far = evaluate(part, wi, np.concatenate([at(-30.0), at(30.0)]))[:, 0]
    assert near > 3.0 * far


def test_pearlescent_paint_changes_its_colour_with_the_angle():
    part = sides_of("car_pearl")["front_reflection"]

    def hue(polar):
        values = evaluate(part, at(polar), at(-polar))[0]
        return part.wavelengths[np.argmax(values)]

    assert 520.0 < hue(10.0) < 590.0
    assert abs(hue(65.0) - hue(10.0)) > 30.0


# ---- diffusers, screens, cloth ----


@pytest.mark.parametrize(
    ("name", "angle"), [("film_10", 10.0), ("film_30", 30.0), ("film_60", 60.0)]
)
def test_a_film_halves_the_intensity_at_half_its_angle(name, angle):
    part = sides_of(name)["front_transmission"]
    wo = at([0.0, angle / 2.0])
    intensity = evaluate(part, np.repeat(UP, 2, axis=0), wo)[:, 0] * wo[:, 2]
    assert intensity[1] / intensity[0] == pytest.approx(0.5, abs=0.02)


def test_the_elliptic_film_spreads_wide_along_x():
    part = sides_of("film_40x10")["front_transmission"]
    wo = np.concatenate([at(0.0), at(20.0), at(5.0, 90.0)])
    intensity = evaluate(part, np.repeat(UP, 3, axis=0), wo)[:, 0] * wo[:, 2]
    assert intensity[1:] / intensity[0] == pytest.approx(0.5, abs=0.05)


def test_light_through_a_film_keeps_its_way():
    part = sides_of("film_10")["front_transmission"]
    wi = np.repeat(at(32.0), 81, axis=0)
    # x and y of what passes straight are those of light that goes on.
    polar = np.linspace(-72.0, 8.0, 81)
    values = evaluate(part, wi, at(polar))[:, 0]
    assert polar[np.argmax(values)] == pytest.approx(-32.0, abs=2.0)


def test_the_sandblasted_pane_is_reciprocal_by_construction():
    glass = diffusers.GroundGlass(0.3)
    wi, wo = at([10.0, 40.0, 70.0], [0.0, 50.0, 100.0]), at([30.0, 5.0, 60.0], [180.0, 200.0, 10.0])
    assert glass.transmit(wi, wo) == pytest.approx(glass.transmit_back(wo, wi))


@pytest.mark.parametrize("name", ["screen_gain_1_8", "screen_silver_2_4"])
def test_a_screen_has_its_gain_and_its_half_angle(name):
    stated = RECIPES[name].more
    part = sides_of(name)["front_reflection"]
    wo = at([0.0, stated["half_gain_angle_deg"]])
    gain = np.pi * evaluate(part, np.repeat(UP, 2, axis=0), wo)[:, 0]
    assert gain[0] == pytest.approx(stated["gain"], rel=0.02)
    assert gain[1] / gain[0] == pytest.approx(0.5, abs=0.02)


def test_opal_covers_spread_light_evenly_and_hide_the_lamp():
    sides = sides_of("acrylic_opal")
    part = sides["front_transmission"]
    values = evaluate(part, np.repeat(UP, 3, axis=0), at([0.0, 30.0, 60.0]))[:, 0]
    # Lambertian but for the loss at the boundary, which is small up to 60 degrees.
    assert values / values[0] == pytest.approx([1.0, 1.0, 0.95], abs=0.04)
    assert part.direct is None or not part.direct.any()


@pytest.mark.parametrize(
    ("name", "openness"),
    [("curtain_sheer", 0.30), ("screen_fabric_grey", 0.05), ("steel_perforated", 0.46)],
)
def test_light_passes_straight_through_the_holes(name, openness):
    part = sides_of(name)["front_transmission"]
    share = direct_share(part, at([0.0, 20.0, 76.0]))[:, 0]
    assert share[0] == pytest.approx(openness, rel=1e-3)
    assert share[0] > share[1] > share[2] >= 0.0


def test_round_holes_overlap_as_circles():
    """Two circles that are half their diameter apart share 0.391 of their area."""
    sheet = sheets.Perforated(None, 1.0, 0.5)
    expected = 2.0 / np.pi * (np.arccos(0.5) - 0.5 * np.sqrt(0.75))
    assert sheet.open_share(np.radians([45.0])) == pytest.approx(expected)
    assert expected == pytest.approx(0.391, abs=1e-3)


def test_the_blackout_cloth_lets_nothing_through():
    assert set(sides_of("blackout")) == {"front_reflection", "back_reflection"}


# ---- roads ----


def test_dry_asphalt_has_the_figures_of_class_r3():
    """Class R3 of CIE 144: S1 from 0.85 to 1.35 (standard 1.11), Q0 0.07."""
    part = sides_of("asphalt_dry")["front_reflection"]
    average, specular = roads.figures_of(lambda wi, wo: evaluate(part, wi, wo))
    assert average == pytest.approx(0.07, rel=0.1)
    assert 0.85 < specular < 1.35


@pytest.mark.parametrize(
    ("name", "observation", "entrance", "least"),
    [
        ("sign_ra1", 0.2, 5.0, 70.0), ("sign_ra1", 0.33, 5.0, 50.0), ("sign_ra1", 0.33, 30.0, 24.0),
        ("sign_ra2", 0.2, 5.0, 250.0), ("sign_ra2", 0.33, 5.0, 180.0), ("sign_ra2", 0.33, 30.0, 100.0),
    ],
)  # fmt: skip
def test_sign_sheeting_throws_back_what_en_12899_asks_for(name, observation, entrance, least):
    """Mean over the place of the eye around the lamp and the cells of the tree; the class's values within 15 %."""
    part = sides_of(name)["front_reflection"]
    rng = np.random.default_rng(7)
    wi = at(entrance + 0.5 * (rng.random(2000) - 0.5), 360.0 * rng.random(2000))
    first = np.cross(wi, [0.0, 0.0, 1.0])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second, turn = np.cross(wi, first), 2.0 * np.pi * rng.random((2000, 1))
    aside = np.cos(turn) * first + np.sin(turn) * second
    wo = np.cos(np.radians(observation)) * wi + np.sin(np.radians(observation)) * aside
    found = evaluate(part, wi, wo)[:, 0] * wi[:, 2] * wo[:, 2]
    assert found.mean() == pytest.approx(least, rel=0.15)


def test_signs_look_matt_from_aside():
    part = sides_of("sign_ra2")["front_reflection"]
    factor = np.pi * evaluate(part, at(45.0), at(0.0))[0, 0]
    # Luminance factor of white sheeting of class RA2 (EN 12899-1: at least 0.27).
    assert factor == pytest.approx(0.30, abs=0.03)


# ---- folders of users ----


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
