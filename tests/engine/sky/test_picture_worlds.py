"""Pictures of the surroundings: the engine's values, sampling and illuminances against the picture's own definition."""

import numpy as np
import pytest
from folders import WILD
from scipy import ndimage, stats
from small_scenes import quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import ImageWorld
from lumenray.engine.scene.material import Black, Emission, Material
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.sky.picture import find_illuminance
from lumenray.engine.views import ViewSettings

REC709 = np.array([0.2126, 0.7152, 0.0722])

PLANES = np.array(
    [[0, 0, 1.0], [0, 0, -1], [1, 0, 0], [0, -1, 0], [0.6, 0, 0.8], [-0.48, 0.64, -0.6]]
)
"""Normals: horizontal, upright and tilted."""

SIGNIFICANCE = 1e-4

PICTURES = WILD / "hdr"


def turn(about_z, about_x=0.0):
    c, s = np.cos(about_z), np.sin(about_z)
    d, t = np.cos(about_x), np.sin(about_x)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, d, -t], [0, t, d]]
    )


def speckled(height, width, seed=1, sun=0.0):
    """Coloured noise, with one pixel above the horizon as a sun."""
    pixels = (np.random.default_rng(seed).random((height, width, 3)) ** 3).astype(np.float32)
    pixels[height // 2 + height // 6, width // 3] += sun
    return pixels


def look_up(pixels, direction, interpolation="linear"):
    """Values of a picture by an interpolation of another maker. (h, w), (n, 3) -> (n,)"""
    height, width = pixels.shape
    u = 0.5 - np.arctan2(direction[:, 1], direction[:, 0]) / (2 * np.pi)
    v = 0.5 + np.arctan2(direction[:, 2], np.hypot(direction[:, 0], direction[:, 1])) / np.pi
    x, y = u * width - 0.5, v * height - 0.5
    if interpolation == "closest":
        x, y = np.round(x), np.round(y)
    padded = np.pad(np.pad(pixels, ((1, 1), (0, 0)), "edge"), ((0, 0), (1, 1)), "wrap")
    return ndimage.map_coordinates(padded.astype(np.float64), [y + 1, x + 1], order=1)


def cells(height, width):
    """Middles (height width, 3) of small cells, and their solid angles (height width,)."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width)
    polar, azimuth = np.pi * v.T.ravel(), (0.5 - u.T.ravel()) * 2 * np.pi
    edges = -np.cos(np.pi * np.arange(height + 1) / height)
    plan = np.sin(polar)
    made = np.stack([plan * np.cos(azimuth), plan * np.sin(azimuth), -np.cos(polar)], axis=1)
    return made, np.repeat(np.diff(edges), width) * 2 * np.pi / width


def sum_illuminance(image, rotation, normals, fineness=6):
    """Illuminances by a plain sum over small cells. [lx per unit]"""
    luminance = image.pixels.astype(np.float64) @ REC709
    height, width = luminance.shape
    direction, solid = cells(height * fineness, width * fineness)
    value = look_up(luminance, direction, image.interpolation) * solid
    seen = np.maximum(direction @ (np.asarray(rotation) @ np.asarray(normals).T), 0.0)
    return value @ seen


def measure(world, normals, samples=1 << 16, transport="mono", seed=1):
    places = np.zeros((len(normals), 3))
    rule = StopRule(samples=samples)
    return session_of(world).measure(places, normals, rule, transport=transport, seed=seed)


def emitter_of(world, transport="mono"):
    """The world's emitter, as rays see it."""
    session = session_of(world)
    session.measure([[0, 0, 0]], [[0, 0, 1.0]], StopRule(samples=4), transport=transport)
    return session._compiled.surroundings, session


# ---- values ----


@pytest.mark.mitsuba
@pytest.mark.parametrize("interpolation", ["linear", "closest"])
def test_rays_see_what_the_picture_shows_in_their_direction(interpolation):
    import drjit as dr
    import mitsuba as mi

    pixels, rotation = speckled(9, 14), turn(0.4, 1.1)
    world = ImageWorld(ImageTexture(pixels, interpolation=interpolation), 7.0, rotation)
    emitter, kept = emitter_of(world)
    chance = np.random.default_rng(3)
    own = chance.normal(size=(20000, 3))
    own[:500, :2] *= 1e-2  # near the poles
    own[500:1000] = [-1.0, 0.0, 0.3]  # where the picture closes
    own[500:1000, 1] = chance.normal(size=500) * 1e-3
    own /= np.linalg.norm(own, axis=1, keepdims=True)
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(*(-(own @ rotation).T).astype(np.float32))
    found = np.array(emitter.eval(si)).ravel()
    expected = 7.0 * look_up(pixels @ REC709, own, interpolation)
    near = np.isclose(found, expected, rtol=2e-4, atol=2e-5)
    # Between even cells single precision may choose the neighbour.
    assert near.all() if interpolation == "linear" else near.mean() > 0.998
    assert kept is not None


@pytest.mark.mitsuba
@pytest.mark.slow
def test_the_camera_sees_the_picture_pixel_by_pixel(transport):
    pixels, rotation = speckled(8, 16), turn(0.3, 0.2)
    session = session_of(ImageWorld(ImageTexture(pixels), 3.0, rotation))
    middles, _ = cells(8, 16)
    for pixel in (0, 23, 64, 71, 90, 127):
        back = -(middles[pixel] @ rotation)
        right = np.cross((0.3, 0.5, 0.8), back)
        right /= np.linalg.norm(right)
        frame = np.eye(4)
        frame[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
        camera = Camera(frame, Projection.PERSPECTIVE, 1, 1, 1e-5, 1e-5)
        made = session.render(camera, ViewSettings(StopRule(samples=64), transport=transport))
        seen, noise = made.tristimulus[0, 0, 1], made.luminance_error[0, 0]
        expected = 3.0 * (pixels.reshape(-1, 3)[pixel] @ REC709)
        assert abs(seen - expected) < 5.0 * noise + 1e-3 * expected


# ---- sampling ----


@pytest.mark.one_at_a_time
@pytest.mark.mitsuba
@pytest.mark.parametrize("interpolation", ["linear", "closest"])
@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (6, 10), (16, 32)], ids=str)
def test_directions_are_drawn_as_the_density_says(shape, interpolation):
    import drjit as dr
    import mitsuba as mi

    count = 1 << 18
    pixels, rotation = speckled(*shape, sun=3.0 if shape[0] > 2 else 0.0), turn(0.5, 0.8)
    image = ImageTexture(pixels, interpolation=interpolation)
    surroundings, kept = emitter_of(ImageWorld(image, 1.0, rotation))
    points = np.random.default_rng(5).random((2, count)).astype(np.float32)
    at = dr.zeros(mi.Interaction3f)
    ds, _ = surroundings.sample_direction(at, mi.Point2f(*points))
    drawn = np.array(ds.d).T @ rotation.T
    rows, columns = 12, 20
    row = np.minimum((0.5 + np.arcsin(np.clip(drawn[:, 2], -1, 1)) / np.pi) * rows, rows - 1)
    column = (0.5 - np.arctan2(drawn[:, 1], drawn[:, 0]) / (2 * np.pi)) * columns
    column = np.minimum(column, columns - 1)
    bins = row.astype(int) * columns + column.astype(int)
    found = np.bincount(bins, minlength=rows * columns)
    fine = 24
    direction, solid = cells(rows * fine, columns * fine)
    asked = dr.zeros(mi.DirectionSample3f)
    asked.d = mi.Vector3f(*(direction @ rotation).T.astype(np.float32))
    density = np.array(surroundings.pdf_direction(at, asked)).ravel()
    expected = (density * solid).reshape(rows, fine, columns, fine).sum(axis=(1, 3)).ravel()
    assert expected.sum() == pytest.approx(1.0, abs=2e-3)
    chi = ((found - expected * count) ** 2 / np.maximum(expected * count, 1e-9)).sum()
    assert stats.chi2.sf(chi, rows * columns - 1) > SIGNIFICANCE
    # In proportion to the value, but for the cosine within a band of rows.
    value = look_up(pixels @ REC709, direction, interpolation)
    lit = value > 1e-3 * value.max()
    inside = np.isclose(
        np.array(surroundings.eval(_towards(direction @ rotation))).ravel(), value, rtol=1e-3
    )
    ratio = (density / value)[lit & inside]
    assert ratio.max() / ratio.min() < (1.6 if shape[0] < 4 else 1.0 + (np.pi / shape[0]) ** 2 / 4)
    assert kept is not None


def _towards(direction):
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(*(-direction).T.astype(np.float32))
    return si


@pytest.mark.mitsuba
def test_a_sun_of_a_few_pixels_is_found_at_once(transport):
    pixels = speckled(128, 256)
    pixels[100:102, 40:42] = 1e5
    image = ImageTexture(pixels)
    true = sum_illuminance(image, np.eye(3), PLANES[:1], 8)
    made = measure(ImageWorld(image, 1.0), PLANES[:1], 1 << 12, transport)
    assert made.standard_error[0] < 0.004 * true[0]
    assert abs(made.illuminance[0] - true[0]) < 4.0 * made.standard_error[0] + 1e-3 * true[0]


# ---- illuminance ----


@pytest.mark.mitsuba
@pytest.mark.parametrize("interpolation", ["linear", "closest"])
@pytest.mark.parametrize("shape", [(8, 16), (33, 40)], ids=str)
@pytest.mark.slow
def test_planes_of_every_slope_get_the_sum_over_the_picture(shape, interpolation, transport):
    image = ImageTexture(speckled(*shape, sun=20.0), interpolation=interpolation)
    rotation = turn(0.7, 0.4)
    true = 10.0 * sum_illuminance(image, rotation, PLANES, 30)
    made = measure(ImageWorld(image, 10.0, rotation), PLANES, 1 << 18, transport)
    np.testing.assert_array_less(made.standard_error, 1.5e-3 * true)
    off = np.abs(made.illuminance - true)
    np.testing.assert_array_less(off, 4.0 * made.standard_error + 2e-4 * true)
    for normal, value in zip(PLANES, true, strict=True):
        own = 10.0 * find_illuminance(image, rotation, normal)
        assert own == pytest.approx(value, rel=3e-4)


@pytest.mark.mitsuba
@pytest.mark.parametrize("height", [16, 64, 256])
@pytest.mark.slow
def test_a_bright_cap_around_the_zenith_gives_its_closed_form(height):
    # 22.5 deg, a whole number of rows.
    pixels = np.zeros((height, 2 * height, 3), np.float32)
    pixels[-height // 8 :] = 1.0
    world = ImageWorld(ImageTexture(pixels, interpolation="closest"), 100.0)
    true = np.pi * 100.0 * np.sin(np.radians(22.5)) ** 2
    made = measure(world, PLANES[:1], 1 << 18)
    assert made.standard_error[0] < 1e-4 * true
    assert made.illuminance[0] == pytest.approx(true, rel=5e-4)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_pictures_add_and_turn_with_the_plane(transport):
    first, second = speckled(16, 32, 1, sun=9.0), speckled(16, 32, 2)
    rotation = turn(1.3, -0.6)

    def lux(pixels, rotation, normals):
        made = measure(ImageWorld(ImageTexture(pixels), 1.0, rotation), normals, 1 << 17, transport)
        return made.illuminance, made.standard_error

    one, two = (lux(each, np.eye(3), PLANES) for each in (first, second))
    both = lux(first + second, np.eye(3), PLANES)
    error = np.sqrt(one[1] ** 2 + two[1] ** 2 + both[1] ** 2)
    np.testing.assert_array_less(np.abs(both[0] - one[0] - two[0]), 4.5 * error + 1e-5)
    turned = lux(first, rotation, PLANES @ rotation)
    error = np.hypot(one[1], turned[1])
    np.testing.assert_array_less(np.abs(turned[0] - one[0]), 4.5 * error + 1e-5)


@pytest.mark.mitsuba
@pytest.mark.parametrize("colour", [(1, 0, 0), (0, 1, 0), (0, 0.02, 1), (5, 0.5, 0.1)], ids=str)
def test_the_spectra_of_colours_keep_their_luminance(colour):
    pixels = np.tile(np.float32(colour), (8, 16, 1))
    made = measure(ImageWorld(ImageTexture(pixels), 2.0), PLANES[:1], 1 << 16, "spectral")
    true = 2.0 * np.pi * (np.float32(colour) @ REC709)
    assert made.standard_error[0] < 1e-3 * true
    assert abs(made.illuminance[0] - true) < 4.0 * made.standard_error[0] + 1e-4 * true


@pytest.mark.mitsuba
@pytest.mark.skipif(not PICTURES.is_dir(), reason="the pictures from the wild are not here")
@pytest.mark.parametrize("name", ["kloppenheim_05_1k.hdr", "modern_buildings_2_1k.hdr"])
@pytest.mark.slow
def test_real_pictures_give_the_sum_over_their_pixels(name):
    bpy = pytest.importorskip("bpy")
    loaded = bpy.data.images.load(str(PICTURES / name))
    width, height = loaded.size
    pixels = np.array(loaded.pixels[:], np.float32).reshape(height, width, -1)[..., :3]
    true = sum_illuminance(ImageTexture(pixels.copy()), np.eye(3), PLANES[[0, 2, 4]], 1)
    made = measure(ImageWorld(ImageTexture(pixels.copy()), 1.0), PLANES[[0, 2, 4]], 1 << 18)
    np.testing.assert_array_less(made.standard_error, 2e-4 * true)
    np.testing.assert_allclose(made.illuminance, true, rtol=5e-4)


@pytest.mark.mitsuba
@pytest.mark.parametrize("fault", [0.0, np.nan])
def test_colours_of_the_picture_are_seen_in_a_scene_without_others(fault):
    pixels = np.tile(np.float32([1.0, 0.5, 0.2]), (8, 16, 1))
    pixels[3, 0] = fault
    session = session_of(ImageWorld(ImageTexture(pixels), 10.0))
    made = session.measure([[0, 0, 0]], PLANES[:1], StopRule(samples=1 << 14), colour=True)
    # IEC 61966-2-1, linear components to X, Y, Z.
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    true = to_xyz @ pixels[7, 7]
    found = made.tristimulus[0] / made.tristimulus[0].sum()
    np.testing.assert_allclose(found, true / true.sum(), atol=0.004)
    assert any("colours" in reason for reason in made.provenance.decisions)


# ---- what is wrong with a picture ----


@pytest.mark.mitsuba
@pytest.mark.slow
def test_pixels_without_a_meaning_are_told_with_their_number(transport):
    pixels = np.ones((8, 16, 3), np.float32)
    pixels[7, :3] = np.nan
    pixels[6, 0] = np.inf
    pixels[5, :2] = (-1.0, 2.0, 1.0)
    made = measure(ImageWorld(ImageTexture(pixels, name="odd.exr"), 1.0), PLANES[:1], transport=transport)  # fmt: skip
    text = " ".join(made.provenance.notes)
    for said in ("'odd.exr' has 3 NaN", "'odd.exr' has 1 infinite", "'odd.exr' has 2 pixels"):
        assert said in text
    mended = np.ones((8, 16, 1), np.float32)
    mended[7, :3] = mended[6, 0] = 0.0
    # What lies outside Rec. 709 has its luminance all the same.
    mended[5, :2] = (-1.0, 2.0, 1.0) @ REC709
    true = measure(ImageWorld(ImageTexture(mended), 1.0), PLANES[:1])
    error = np.hypot(made.standard_error, true.standard_error)
    assert abs(made.illuminance - true.illuminance)[0] < 4.5 * error[0] + 1e-4
    assert not true.provenance.notes


@pytest.mark.mitsuba
@pytest.mark.parametrize("value", [0.0, np.nan, -1.0, np.inf])
def test_a_picture_without_light_is_dark(value):
    pixels = np.full((4, 8, 3), value, np.float32)
    assert measure(ImageWorld(ImageTexture(pixels), 1.0), PLANES[:1]).illuminance[0] == 0.0


@pytest.mark.mitsuba
def test_a_matrix_that_is_no_rotation_is_refused():
    world = ImageWorld(ImageTexture(np.ones((4, 8, 3), np.float32)), 1.0, 2.0 * np.eye(3))
    with pytest.raises(SceneError, match="no rotation"):
        measure(world, PLANES[:1])


@pytest.mark.mitsuba
def test_a_transparent_picture_without_surroundings_shows_what_stands_there(transport):
    """The left half of the view is a glowing plane; behind the right half is nothing."""
    glow = Material("glow", "glow", Black(), Emission(luminance=50.0))
    plane = quad("plane", (-2.0, -2.0, 0.0), (2.0, 0.0, 0.0), (0.0, 4.0, 0.0), "glow")
    frame = np.eye(4)
    frame[2, 3] = 3.0
    camera = Camera(frame, Projection.ORTHOGRAPHIC, 8, 4, 2.0, 1.0)
    settings = ViewSettings(StopRule(samples=64), transport=transport, transparent=True)
    made = session_of(glow, plane).render(camera, settings)
    # The filter lets edges of pixels at the middle see both.
    assert made.coverage[:, :3] == pytest.approx(1.0)
    assert made.coverage[:, 5:] == pytest.approx(0.0)
    assert made.tristimulus[:, :3, 1].mean() == pytest.approx(50.0, rel=0.05)
    assert not made.backdrop.any()
