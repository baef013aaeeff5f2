"""Road lighting against sums written out by hand, closed forms and published figures of the tables."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from luminaires import grid, rotational

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.luminaires.formats.record import LUMINOUS
from lumenray.engine.roads.installation import Road
from lumenray.engine.roads.light import light_road, threshold_increment, veiling_of
from lumenray.engine.roads.surface import RoadSurface, find_surface, read_surface


def lamp(distribution):
    """A photometric file of a distribution, as far as roads ask for it."""
    return SimpleNamespace(distribution=distribution, quantity=LUMINOUS)


@pytest.fixture(scope="module")
def matt():
    """Luminaire of 1000 cd straight down, Lambertian."""
    return lamp(rotational(lambda gamma: 1000.0 * np.cos(gamma)))


def even_surface(reflectance):
    """Matt surface as a table: r = q cos^3, q = reflectance / pi."""
    tangents = np.concatenate([np.linspace(0.0, 12.0, 1201), np.linspace(13.0, 300.0, 2871)])
    column = reflectance / math.pi * (1.0 + tangents**2) ** -1.5
    return RoadSurface("even", tangents, np.array([0.0, 180.0]), np.tile(column[:, None], 2))


@pytest.mark.parametrize(("name", "specular"), [("C2", 0.97), ("R3", 1.11)])
def test_surfaces_have_the_published_figures(name, specular):
    """Q0 = 0.07: the mean of q over the rectangle from 4 H before to 12 H behind, 3 H to both sides (CIE 144)."""
    surface = find_surface(name)
    x, y = np.meshgrid(np.linspace(-4.0, 12.0, 641), np.linspace(0.0, 3.0, 121))
    tangent = np.hypot(x, y)
    weights = (1.0 + tangent**2) ** -1.5
    r = surface.reduced_coefficient(tangent, np.degrees(np.arctan2(y, x)))
    assert r.sum() / weights.sum() == pytest.approx(0.07, rel=0.03)
    assert surface.reduced_coefficient(2.0, 0.0) / surface.reduced_coefficient(
        0.0, 0.0
    ) == pytest.approx(specular, abs=0.005)


def test_coefficients_are_linear_between_those_of_the_table():
    surface = find_surface("R3")
    assert surface.reduced_coefficient(1.0, 0.0) == pytest.approx(362e-4)
    assert surface.reduced_coefficient(1.0, 3.5) == pytest.approx(0.5 * (362e-4 + 352e-4))
    assert surface.reduced_coefficient(1.125, 180.0) == pytest.approx(0.5 * (100e-4 + 78e-4))
    assert surface.reduced_coefficient(12.01, 0.0) == 0.0
    assert surface.reduced_coefficient(7.0, 90.0) == 0.0


def test_a_matt_road_has_the_luminance_of_its_illuminance(matt):
    """L = rho E / pi, whoever looks from wherever."""
    found = light_road(matt, Road(7.0, 2, 30.0, 8.0, "opposite", -0.5), even_surface(0.3))
    for view in found.views:
        np.testing.assert_allclose(view.luminances, 0.3 / math.pi * found.illuminances, rtol=1e-3)
        assert view.mean == pytest.approx(0.3 / math.pi * found.illuminances.mean(), rel=1e-3)


def test_sums_written_out_by_hand():
    """One row on the right over a road of R3: every step of EN 13201-3 written out for one point and one driver."""
    polar = np.arange(0.0, 181.0, 5.0)
    batwing = grid(
        0.0, polar, lambda c, g: 1000.0 * np.maximum(np.cos(g), 0.0) * (1 + 2 * np.sin(g))
    )
    road, surface = Road(8.0, 2, 36.0, 9.0, "right", overhang=0.5), find_surface("R3")
    found = light_road(lamp(batwing), road, surface, 0.8)
    assert len(road.stations) == 12
    assert road.stations[0] == 1.5

    def candela(gamma):
        return np.interp(math.degrees(gamma), polar, batwing.intensity[0])

    # Third station, fourth point across, which is the first of the left lane; its driver sits at y = 6.
    x, y = 7.5, 8.0 * 3.5 / 6.0
    lux = luminance = 0.0
    for k in range(-20, 40):
        along, aside = 36.0 * k - x, 0.5 - y
        tangent = math.hypot(along, aside) / 9.0
        gamma = math.atan(tangent)
        lux += candela(gamma) * math.cos(gamma) ** 3 / 81.0
        beta = math.degrees(abs(math.atan2(aside, along) - math.atan2(y - 6.0, x + 60.0)))
        beta = 360.0 - beta if beta > 180.0 else beta
        row = [
            np.interp(beta, surface.angles, coefficients) for coefficients in surface.coefficients
        ]
        r = np.interp(tangent, surface.tangents, row, right=0.0)
        luminance += candela(gamma) * r / 81.0
    assert found.illuminances[2, 3] == pytest.approx(0.8 * lux, rel=1e-5)
    assert found.views[1].luminances[2, 3] == pytest.approx(0.8 * luminance, rel=1e-6)

    # The driver in the right lane, where the roof just uncovers the luminaire over the field's beginning.
    eye = -2.7474774 * 7.5
    veiling = 0.0
    for k in range(60):
        ahead, aside, up = 36.0 * k - eye, 0.5 - 2.0, 7.5
        distance = math.sqrt(ahead**2 + aside**2 + up**2)
        if distance > 500.0:
            break
        cosine = (ahead * math.cos(math.radians(1.0)) - up * math.sin(math.radians(1.0))) / distance
        lux = candela(math.acos(up / distance)) * cosine / distance**2
        veiling += 9.86 * lux * (1 + (23 / 66.4) ** 4) / math.degrees(math.acos(cosine)) ** 2
    assert found.views[0].veiling == pytest.approx(veiling, rel=1e-6)
    new = found.views[0].mean / 0.8
    assert found.views[0].increment == pytest.approx(65.0 * veiling / new**0.8, rel=1e-6)
    assert found.increment == max(view.increment for view in found.views)


def test_glare_by_closed_forms():
    """The formula of Stiles and Holladay for a driver of 23 years, and its forms for small angles and bright roads."""
    assert veiling_of(1.0, 10.0) == pytest.approx(0.1, rel=1e-3)
    assert veiling_of(2.0, 1.0) == pytest.approx(2.0 * (10.0 + 5.0 * 1.01834), rel=1e-4)
    assert veiling_of(1.0, 61.0) == 0.0
    assert threshold_increment(0.2, 1.0) == pytest.approx(13.0)
    assert threshold_increment(0.2, 10.0) == pytest.approx(95.0 * 0.2 / 10.0**1.05)
    assert math.isnan(threshold_increment(0.2, 0.04))


def test_a_road_mirrored_has_the_same_light(matt):
    """Luminaires at the left instead of the right: what the right lane's driver saw, the left one's does."""
    surface = find_surface("C2")
    right = light_road(matt, Road(7.0, 2, 34.0, 8.0, "right", 0.3), surface)
    left = light_road(matt, Road(7.0, 2, 34.0, 8.0, "left", 0.3), surface)
    np.testing.assert_allclose(left.views[1].luminances, right.views[0].luminances[:, ::-1])
    assert left.views[1].increment == pytest.approx(right.views[0].increment)
    assert left.edge_ratios == pytest.approx(right.edge_ratios[::-1])
    assert right.edge_ratios[0] > right.edge_ratios[1] > 0.0


def test_lifting_a_narrow_beam_moves_it_across_the_road():
    beam = lamp(rotational(lambda gamma: 1e4 * np.exp(-((gamma / math.radians(12.0)) ** 2))))
    surface, row = find_surface("C2"), {"overhang": 0.0, "arrangement": "right"}
    straight = light_road(beam, Road(8.0, 2, 12.0, 8.0, **row), surface).illuminances
    lifted = light_road(beam, Road(8.0, 2, 12.0, 8.0, tilt=30.0, **row), surface).illuminances
    assert straight.mean(axis=0).argmax() == 0
    # 8 m times the tangent of 30 degrees is 4.6 m; the middles of the points are 4 m and 5.3 m from the edge.
    assert lifted.mean(axis=0).argmax() == 3


def test_bad_roads_and_tables_are_refused(tmp_path, matt):
    with pytest.raises(SceneError, match="spacing is 0, expected 2 to 200 m"):
        Road(7.0, 2, 0.0, 8.0)
    with pytest.raises(SceneError, match="expected right, left"):
        Road(7.0, 2, 30.0, 8.0, "above")
    with pytest.raises(SceneError, match="there are C2, R3"):
        find_surface("Q0")
    narrow = lamp(rotational(lambda gamma: np.where(gamma < 0.1, 1.0, 0.0)))
    with pytest.raises(SceneError, match="gets no light at all"):
        light_road(narrow, Road(7.0, 2, 30.0, 8.0), find_surface("C2"))
    table = tmp_path / "own.csv"
    for text, words in (
        ("tan,0,90,180\n0,300,300,300\n1,200,-1,150\n", "line 3.*found '-1'"),
        ("tan,0,90,170\n0,300,300,300\n1,200,1,150\n", "expected 0 to 180"),
        ("tan,0,90,180\n0,300,300,300\n0,200,1,150\n", "do not ascend"),
        ("tan,0,90,180\n0,1,1,1,1\n1,200,1,150\n", "line 2 has 5 cells"),
    ):
        table.write_text(text)
        with pytest.raises(FileFormatError, match=words):
            read_surface(table)
    table.write_text("tan,0,90,180\n0,300,300,300\n1,200,150\n")
    assert find_surface(str(table)).reduced_coefficient(1.0, 90.0) == pytest.approx(150e-4)
