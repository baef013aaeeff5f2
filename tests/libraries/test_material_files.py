"""The library's materials as their names and standards say: paints, diffusers, screens, cloth, roads and signs."""

import numpy as np
import pytest
from library_materials import RECIPES, UP, at, sides_of, total

from lumenray.engine.scattering.data.evaluation import evaluate
from lumenray.engine.scattering.data.table import direct_share
from lumenray.tools.libraries.materials import diffusers, fresnel, roads, sheets


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
