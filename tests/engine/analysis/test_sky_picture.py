"""Pictures of skies: each direction is where a map has it."""

import numpy as np
import pytest

from lumenray.engine.analysis.colour_scale import ColourScale
from lumenray.engine.analysis.sky_picture import ShownSun, draw_sky
from lumenray.engine.scene.light import CieSky
from lumenray.engine.sky.cie import sun_direction
from lumenray.engine.sky.place import Place
from lumenray.engine.sky.skies import find_luminances

SCALE = ColourScale(0.0, 100.0, "cd/m²")

CENTRE, RADIUS = np.array([273.3, 341.3]), 229.0
"""Of the sky in a picture of 640 by 640 pixels."""


def disk_of(picture):
    return np.asarray(picture).astype(int)


def near(picture, value):
    """Pixels (n, 2), across and down, of a value's colour in the sky."""
    hit = np.argwhere(np.abs(disk_of(picture) - SCALE.colours(value)).sum(axis=-1) < 12)[:, ::-1]
    return hit[np.hypot(*(hit - CENTRE).T) < RADIUS + 3]


@pytest.mark.parametrize(
    ("elevation", "azimuth"), [(45.0, 0.0), (45.0, 90.0), (20.0, 180.0), (70.0, 300.0)]
)
def test_a_bright_spot_is_where_a_map_has_it(elevation, azimuth):
    towards = sun_direction(np.radians(elevation), np.radians(azimuth))

    def luminances(directions):
        return np.where(directions @ towards > np.cos(np.radians(6.0)), 62.5, 0.0)

    picture = draw_sky(luminances, "Spot", scale=SCALE)
    middle = near(picture, 62.5).mean(axis=0)
    share = (90.0 - elevation) / 90.0 * RADIUS
    turn = np.radians(azimuth)
    expected = CENTRE + share * np.array([np.sin(turn), -np.cos(turn)])
    assert np.hypot(*(middle - expected)) < 4.0


def test_an_even_sky_fills_the_disk():
    picture = draw_sky(lambda d: np.full(d.shape[:-1], 62.5), "Even", scale=SCALE)
    assert len(near(picture, 62.5)) == pytest.approx(np.pi * RADIUS**2, rel=0.06)


def test_sun_is_a_dot_above_the_horizon_alone():
    def dark(directions):
        return np.zeros(directions.shape[:-1])

    def whites(elevation):
        picture = draw_sky(dark, "Sun", sun=ShownSun(elevation, 90.0), scale=SCALE)
        hit = np.argwhere((disk_of(picture) > 250).all(axis=-1))[:, ::-1]
        inside = hit[np.hypot(*(hit - CENTRE).T) < RADIUS - 5]
        return inside.mean(axis=0) if len(inside) > 20 else None

    np.testing.assert_allclose(whites(30.0), CENTRE + np.array([RADIUS * 60 / 90, 0.0]), atol=3.0)
    assert whites(-1.0) is None


@pytest.mark.parametrize(
    "place",
    [
        Place(52.5, 13.4, "Europe/Berlin"),
        Place(-33.9, 151.2, "Australia/Sydney"),
        Place(69.6, 19.0, "Europe/Oslo"),
        Place(0.0, 0.0),
        Place(90.0, 0.0),
    ],
)
@pytest.mark.parametrize("year", [1900, 2100])
def test_ways_of_the_sun_are_in_the_south_for_the_north(place, year):
    """They are drawn light with a dark rim on a sky of one colour."""
    picture = draw_sky(
        lambda d: np.full(d.shape[:-1], 62.5), "Ways", place=place, year=year, scale=SCALE
    )
    light = np.argwhere(np.abs(disk_of(picture) - [255, 243, 196]).sum(axis=-1) < 20)
    assert len(light) > 100
    down = np.mean(light[:, 0]) - CENTRE[1]
    if 20.0 < abs(place.latitude) < 60.0:
        assert (down > 30.0) == (place.latitude > 0.0)
        assert (down < -30.0) == (place.latitude < 0.0)


@pytest.mark.parametrize(("kind", "is_even"), [(16, True), (12, False)])
def test_scales_suit_the_sky(kind, is_even, monkeypatch):
    chosen = []
    draw = ColourScale.draw_bar
    monkeypatch.setattr(
        ColourScale, "draw_bar", lambda self, *a: (chosen.append(self), draw(self, *a))
    )
    sky = CieSky(kind, sun_direction(0.8, 1.0), 15_000.0)
    draw_sky(lambda d: find_luminances(sky, d), "CIE", size=(300, 300), dark=True)
    (scale,) = chosen
    assert scale.is_log == (not is_even)
    top = find_luminances(sky, np.array([0.0, 0.0, 1.0] if is_even else sky.towards_sun))
    assert top <= scale.high <= 2.6 * top


def test_a_dark_sky_is_a_picture_too():
    draw_sky(lambda d: np.zeros(d.shape[:-1]), "Night", size=(200, 300))
