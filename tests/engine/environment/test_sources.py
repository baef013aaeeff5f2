"""Bright sources of maps whose suns are known: found, taken out, and the illuminance conserved."""

from functools import partial

import numpy as np
import pytest

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.engine.environment.extraction import clip_sources, scale_sources
from lumenray.engine.environment.repair import find_sun_of
from lumenray.engine.environment.sources import Coefficients, find_sources
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.sky.cie import relative_luminance
from lumenray.engine.sky.picture import find_illuminance

HEIGHT = 1024

UP = np.array([0.0, 0.0, 1.0])


def image_of(pixels, **options):
    pixels.flags.writeable = False
    return ImageTexture(pixels, **options)


def sum_with_sources(image, normal, coefficients=None):
    """Illuminance by the clipped map and its sources as lights."""
    search = find_sources(image, coefficients)
    clipped = clip_sources(image, coefficients)
    by_map = find_illuminance(clipped, np.eye(3), normal)
    return by_map + sum(source.on(normal) for source in search.sources)


def off(source, spot):
    """Angle between a source and where it was drawn. [degree]"""
    return np.degrees(2.0 * np.arcsin(0.5 * np.linalg.norm(source.towards - spot.towards)))


SUNS = {
    "high": Spot(52.0, 140.0, illuminance=12.0),
    "near the horizon": Spot(4.0, 250.0, illuminance=12.0),
    "on the map's border": Spot(35.0, 270.0, illuminance=12.0),
    "over the pole": Spot(89.9, 30.0, illuminance=12.0),
    "tinted": Spot(30.0, 10.0, illuminance=9.0, colour=(1.6, 0.87, 0.51)),
}


@pytest.mark.parametrize(
    ("name", "clip"),
    [
        *((name, clip) for name in SUNS for clip in (None, 200.0)),
        ("high", 20000.0),
        ("high", 3000.0),
        ("high", 40.0),
    ],
)
def test_a_sun_is_found_and_the_illuminance_conserved(name, clip):
    spot = SUNS[name]
    image = image_of(make_map(HEIGHT, [spot], clip=clip))
    search = find_sources(image)
    (source,) = search.sources
    assert off(source, spot) < 0.1
    assert find_sun_of(search) is source
    for normal in (UP, spot.towards):
        before = find_illuminance(image, np.eye(3), normal)
        assert sum_with_sources(image, normal) == pytest.approx(before, rel=1e-5)
    clipped = clip_sources(image)
    assert clipped.pixels.max() <= search.edge * 2.0
    if clip is None:
        # All but what is as dark as the edge; the part of the sky behind is drawn with it.
        lost = search.edge * np.pi * np.radians(0.5 * spot.diameter + 0.2) ** 2
        assert source.illuminance == pytest.approx(
            spot.illuminance, rel=0.05 if name == "over the pole" else 0.01, abs=lost
        )
        part = source.irradiance / source.illuminance
        assert part == pytest.approx(spot.colour, abs=0.02)


def test_cells_that_are_even_are_conserved_as_well():
    spot = SUNS["on the map's border"]
    image = image_of(make_map(HEIGHT, [spot]), interpolation="closest")
    before = find_illuminance(image, np.eye(3), UP)
    assert find_sources(image).sources
    assert sum_with_sources(image, UP) == pytest.approx(before, rel=1e-5)


@pytest.mark.parametrize("clip", [None, 100.0])
def test_two_suns_are_two_sources(clip):
    spots = [Spot(40.0, 100.0, illuminance=6.0), Spot(40.0, 106.0, illuminance=4.0)]
    image = image_of(make_map(HEIGHT, spots, clip=clip))
    search = find_sources(image)
    assert len(search.sources) == 2
    for spot in spots:
        assert min(off(source, spot) for source in search.sources) < 0.1
    before = find_illuminance(image, np.eye(3), UP)
    assert sum_with_sources(image, UP) == pytest.approx(before, rel=1e-5)
    # Of two that are nearly alike neither is the sun.
    assert find_sun_of(search) is None


def test_a_lamp_is_a_source_as_wide_as_it_is():
    lamp = Spot(60.0, 200.0, 5.0, 3.0)
    image = image_of(make_map(HEIGHT, [lamp], sky=0.3))
    search = find_sources(image)
    (source,) = search.sources
    assert find_sun_of(search) is None
    assert np.degrees(source.angle) == pytest.approx(5.0, abs=0.15)
    assert source.illuminance == pytest.approx(3.0, rel=0.05)
    assert off(source, lamp) < 0.1


def test_a_window_stays_in_the_picture():
    window = Spot(30.0, 50.0, 25.0, 8.0)
    image = image_of(make_map(HEIGHT, [window], sky=0.05, ground=0.05))
    search = find_sources(image)
    assert search.sources == ()
    assert search.wide
    assert clip_sources(image) is image


@pytest.mark.parametrize("height", [1, 2, 3, 64])
def test_an_even_or_a_black_map_has_none(height):
    for sky in (0.0, 1.0):
        image = image_of(make_map(height, [], sky=sky, ground=sky))
        assert find_sources(image).sources == ()


def test_what_is_below_is_left_unless_asked_for():
    lamp = Spot(-30.0, 200.0, 2.0, 6.0)
    image = image_of(make_map(HEIGHT, [lamp]))
    assert find_sources(image).sources == ()
    both = Coefficients(is_upper=False)
    (source,) = find_sources(image, both).sources
    assert off(source, lamp) < 0.1
    before = find_illuminance(image, np.eye(3), -UP)
    assert sum_with_sources(image, -UP, both) == pytest.approx(before, rel=1e-5)


def test_a_dark_sky_is_no_bar_and_a_sky_of_the_cie_no_source():
    """A sun in a black map; and skies with a glow about a low sun, whose disk is left out."""
    sun = Spot(45.0, 180.0, illuminance=5.0)
    assert len(find_sources(image_of(make_map(HEIGHT, [sun], sky=0.0, ground=0.0))).sources) == 1
    for kind, elevation in ((12, 0.5), (13, 0.5), (14, 10.0), (15, 10.0)):
        low = Spot(elevation, 90.0).towards
        glow = make_map(128, [], partial(relative_luminance, kind, towards_sun=low))
        assert find_sources(image_of(glow)).sources == ()


def test_factors_scale_what_sources_have_above_their_edge():
    spot = SUNS["high"]
    image = image_of(make_map(HEIGHT, [spot], clip=300.0))
    search = find_sources(image)
    (source,) = search.sources
    before = find_illuminance(image, np.eye(3), UP)
    scaled = image_of(scale_sources(image, search, [3.0]))
    made = find_illuminance(scaled, np.eye(3), UP)
    assert made == pytest.approx(before + 2.0 * source.on(UP), rel=1e-5)


def test_pixels_that_are_none_are_left_out():
    pixels = make_map(256, [SUNS["high"]])
    pixels[5, 5], pixels[50, 60, 1], pixels[40, 3] = np.nan, np.inf, -2.0
    image = image_of(pixels)
    (source,) = find_sources(image).sources
    assert off(source, SUNS["high"]) < 0.3
    assert np.isfinite(sum_with_sources(image, UP))


@pytest.mark.parametrize(
    "wrong", [Coefficients(edge=30.0), Coefficients(edge=0.5), Coefficients(radius=2.0)]
)
def test_coefficients_that_are_none_are_refused(wrong):
    with pytest.raises(SceneError, match="expected"):
        find_sources(image_of(make_map(16, [])), wrong)
