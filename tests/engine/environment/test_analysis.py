"""What is said of pictures of the surroundings: range, sun against sky, scale, words and the marked picture."""

import numpy as np
import pytest
from folders import WILD

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.engine.environment.analysis import analyse, format_ratio
from lumenray.engine.environment.map_file import read_map
from lumenray.engine.environment.marked_picture import draw_marked
from lumenray.engine.environment.scale import Scale, find_scale
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.texture import ImageTexture

MAPS = WILD / "hdr"


def image_of(spots, height=128, **options):
    return ImageTexture(make_map(height, spots, **options))


def test_sun_and_sky_are_weighed_on_a_horizontal_plane():
    """An even sky of 2000 cd/m2 gives 2000 pi lx, the disk its illuminance times the sine of its height."""
    sun = Spot(30.0, 45.0, 3.0, illuminance=30.0)
    made = analyse(image_of([sun], 512, sky=2.0, ground=0.5), 1000.0)
    assert made.horizontal == pytest.approx(1000.0 * (2.0 * np.pi + 15.0), rel=5e-3)
    assert made.rest == pytest.approx(2000.0 * np.pi, rel=0.02)
    assert made.below == pytest.approx(500.0 * np.pi, rel=5e-3)
    assert made.ratio == pytest.approx(15.0 / (2.0 * np.pi), rel=0.02)
    assert made.conserved == pytest.approx(1.0, abs=1e-5)
    row = made.sun
    assert (row.elevation, row.azimuth) == pytest.approx((30.0, 45.0), abs=0.1)
    assert (row.row, row.column) == pytest.approx(
        (512 * 60 / 180, 1024 * (0.5 - 45 / 360)), abs=0.2
    )
    turned = analyse(image_of([sun]), 1.0, rotation=np.diag([-1.0, -1.0, 1.0]))
    assert turned.sun.azimuth == pytest.approx(225.0, abs=0.1)


def test_the_range_begins_at_one_candela():
    pixels = np.full((8, 16, 3), 1e-9, np.float32)
    pixels[6, 3] = 5000.0
    assert analyse(ImageTexture(pixels), 2.0).range == pytest.approx(1e4)
    assert analyse(ImageTexture(pixels), 1e-6).range == 1.0


@pytest.mark.parametrize(
    ("light", "words"),
    [(40.0, "expect clear shadows"), (4.0, "clipped at 1 : 1.6"), (0.0, "no bright source")],
)
def test_the_verdict_is_in_words(light, words):
    spots = [Spot(30.0, 45.0, 2.0, light)] if light else []
    made = analyse(image_of(spots, height=256, sky=1.0), 1000.0)
    assert words in " | ".join(made.verdict)
    two = analyse(image_of([Spot(30.0, 45.0, 2.0, 9.0), Spot(50.0, 300.0, 2.0, 8.0)]), 1000.0)
    assert "2 bright lamps, none that stands out" in two.verdict[0]
    assert analyse(ImageTexture(np.zeros((4, 8, 3), np.float32)), 1.0).verdict == (
        "the picture is black",
    )


BLUE = np.array([0.6, 1.0, 1.8])


@pytest.mark.parametrize(
    ("spot", "sky", "words"),
    [
        # A lamp of 3 degrees; a bluish lamp in a room whose walls are yellowish; a lamp in a dark hall.
        (Spot(50.0, 200.0, 3.0, 9.0), BLUE, "3.1° wide"),
        (Spot(50.0, 200.0, 0.53, 9.0, (0.9, 1.0, 1.2)), 1.0 / BLUE, "bluer than that of all else"),
        (Spot(50.0, 200.0, 0.53, 900.0), BLUE, "times the light of all else"),
    ],
)
def test_a_lamp_that_stands_alone_is_asked_about(spot, sky, words):
    pixels = make_map(256, [spot])
    pixels[pixels.max(axis=2) < 1.5] *= sky.astype(np.float32)
    made = analyse(ImageTexture(pixels), 1000.0)
    assert made.sun is not None and len(made.doubts) == 1
    assert made.verdict[0].startswith("a sun or a lamp")
    assert made.verdict[1].startswith("lamp or sun? ") and words in made.verdict[1]


@pytest.mark.parametrize("clip", [None, 2000.0, 200.0])
def test_a_sun_in_a_blue_sky_is_not_doubted(clip):
    image = make_map(512, [Spot(40.0, 200.0, 0.53, 12.0, (1.1, 1.0, 0.8))], clip=clip)
    image[image.max(axis=2) < 1.5] *= BLUE.astype(np.float32)
    made = analyse(ImageTexture(image), 1000.0)
    assert made.sun is not None and made.doubts == ()


def test_ratios_read_as_people_say_them():
    assert [format_ratio(each) for each in (4.04, 1.0, 0.2, 0.0)] == [
        "4 : 1",
        "1 : 1",
        "1 : 5",
        "0 : 1",
    ]


def test_scales_say_what_a_value_of_one_is():
    image = image_of([], sky=1.0, ground=0.0)
    assert find_scale(Scale(), image) == 179.0
    assert find_scale(Scale(white=500.0, factor=2.0), image) == 1000.0
    assert find_scale(Scale(measured=1000.0), image) == pytest.approx(1000.0 / np.pi, rel=1e-3)
    # Half of the sky is before an upright plane.
    upright = Scale(measured=1000.0, facing=(0.0, 2.0, 0.0))
    assert find_scale(upright, image) == pytest.approx(2000.0 / np.pi, rel=5e-3)
    with_light = find_scale(Scale(measured=1000.0), image, [(np.pi, np.array([0.0, 0.0, 1.0]))])
    assert with_light == pytest.approx(500.0 / np.pi, rel=1e-3)
    with pytest.raises(SceneError, match="no light"):
        find_scale(Scale(measured=1.0), image_of([], sky=0.0, ground=0.0))


def test_sources_are_marked_where_they_are():
    """The circle of a source near the border goes on at the other side."""
    image = image_of([Spot(20.0, 269.0, illuminance=30.0)], height=64)
    made = analyse(image, 1000.0)
    plain = np.asarray(draw_marked(image, analyse(image, 1000.0, choose_sun=lambda *_: None)))
    shown = np.asarray(draw_marked(image, made, "Map")).astype(int)
    assert shown.shape == (680, 900, 3)
    red = (shown[..., 0] > 190) & (shown[..., 1] < 120) & (shown[..., 2] < 90)
    columns = np.flatnonzero(red[100:400].any(axis=0))
    assert columns.min() < 60
    assert columns.max() > 840
    assert not np.array_equal(plain, shown)


@pytest.mark.parametrize(
    ("name", "elevation", "usual"),
    [("kloppenheim_05_1k.hdr", 74.5, 4.65), ("modern_buildings_2_1k.hdr", 33.9, 2.6)],
)
def test_pictures_with_a_sun_that_people_see_have_it(name, elevation, usual):
    if not (MAPS / name).exists():
        pytest.skip("the collection of pictures is not here")
    image, remarks = read_map(MAPS / name)
    made = analyse(image, 179.0)
    assert remarks == ()
    assert len(made.sources) == 1
    assert made.sun.elevation == pytest.approx(elevation, abs=0.2)
    assert made.ratio == pytest.approx(usual, rel=0.05)
    assert made.conserved == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("name", ["museum.exr", "leadenhall_market_1k.hdr"])
def test_pictures_without_a_sun_have_none(name):
    if not (MAPS / name).exists():
        pytest.skip("the collection of pictures is not here")
    assert analyse(read_map(MAPS / name)[0], 179.0).sun is None
