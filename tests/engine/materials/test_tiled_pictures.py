"""Pictures of several tiles: values of the table beside a look-up by the words of Cycles, place by place."""

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.scene.texture import ImageTexture, Tile
from lumenray.engine.transport import backend

TILES = (Tile(0, 0, 5, 3), Tile(1, 0, 2, 6), Tile(1, 2, 1, 1))
TURNED = np.array([[1.3, 0.4, 0.7], [-0.3, 1.6, 0.2], [0.0, 0.0, 1.0]])
WRAP = {
    "repeat": lambda k, n: k % n,
    "extend": lambda k, n: min(max(k, 0), n - 1),
    "mirror": lambda k, n: min(k % (2 * n), 2 * n - 1 - k % (2 * n)),
}


def tiled(channels, interpolation, extension, transform, seed=0):
    count = sum(tile.width * tile.height for tile in TILES) + 1
    values = np.random.default_rng(seed).random((1, count, channels)).astype(np.float32)
    values.flags.writeable = False
    return ImageTexture(values, "", transform, interpolation, extension, tiles=TILES)


def value_at(picture, u, v):
    """One place: the tile by cutting decimals off, and on it the pixels about the place."""
    u, v, _ = picture.transform @ (u, v, 1.0)
    column, line = int(u), int(v)
    start = 0
    for tile in picture.tiles:
        if (tile.column, tile.line) == (column, line) and min(u, v) > -1.0:
            break
        start += tile.width * tile.height
    else:
        return picture.pixels[0, -1]
    size = tile.width * tile.height
    own = picture.pixels[0, start : start + size].reshape(tile.height, tile.width, -1)
    wrap = WRAP[picture.extension]
    x, y = (u - column) * tile.width, (v - line) * tile.height
    if picture.interpolation == "closest":
        return own[wrap(int(np.floor(y)), tile.height), wrap(int(np.floor(x)), tile.width)]
    x, y = x - 0.5, y - 0.5
    left, low = int(np.floor(x)), int(np.floor(y))
    total = 0.0
    for i, across in ((0, 1.0 - (x - left)), (1, x - left)):
        for j, up in ((0, 1.0 - (y - low)), (1, y - low)):
            pixel = own[wrap(low + j, tile.height), wrap(left + i, tile.width)]
            total = total + across * up * pixel
    return total


@pytest.mark.mitsuba
@pytest.mark.parametrize("extension", WRAP)
@pytest.mark.parametrize("interpolation", ["linear", "closest"])
@pytest.mark.parametrize("transform", [np.eye(3), TURNED], ids=["plain", "turned"])
def test_every_place_shows_its_tile(extension, interpolation, transform):
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.arrays import upload
    from lumenray.engine.transport.compiled.bitmaps import Bitmaps

    backend.start(False)
    bitmaps = Bitmaps()
    plain = np.full((2, 2, 3), 0.25, np.float32)
    plain.flags.writeable = False
    beside = bitmaps.row(ImageTexture(plain), largest=np.inf)
    picture = tiled(3, interpolation, extension, transform)
    row = bitmaps.row(picture, largest=np.inf)
    other = bitmaps.row(tiled(3, interpolation, extension, transform, seed=1), largest=np.inf)
    bitmaps.table.commit()
    places = np.random.default_rng(2).random((2, 600)) * 6.0 - 2.5
    uv = mi.Point2f(*(upload(mi.Float, axis) for axis in places))

    def vectors(which):
        found = bitmaps.table.vector(uv, dr.opaque(mi.UInt32, which), mi.Bool(True))
        return np.array(found).T

    wanted = np.array([value_at(picture, *place) for place in places.T])
    apart = np.abs(vectors(row) - wanted).max(axis=1)
    # By rounding a place may fall on the other side of an edge.
    assert (apart > 1e-4).sum() <= 1
    assert vectors(beside) == pytest.approx(0.25, abs=1e-6)
    assert np.abs(vectors(other) - wanted).max() > 0.1


@pytest.mark.mitsuba
@pytest.mark.parametrize("spectral", [False, True])
def test_colours_of_tiles_are_those_of_pictures_of_their_own(spectral):
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.arrays import upload
    from lumenray.engine.transport.compiled.bitmaps import Bitmaps

    backend.start(spectral)
    bitmaps, picture = Bitmaps(), tiled(3, "linear", "repeat", np.eye(3))
    rows, start = [], 0
    for tile in TILES:
        size = tile.width * tile.height
        own = picture.pixels[0, start : start + size].reshape(tile.height, tile.width, 3).copy()
        own.flags.writeable = False
        rows.append(bitmaps.row(ImageTexture(own)))
        start += size
    row = bitmaps.row(picture)
    bitmaps.table.commit()
    rng = np.random.default_rng(3)
    places = rng.random((2, 300)) * 0.998 + 1e-3
    si = dr.zeros(mi.SurfaceInteraction3f, 300)
    for k in range(len(si.wavelengths)):
        si.wavelengths[k] = upload(mi.Float, rng.random(300) * 470.0 + 360.0)
    for tile, own in zip(TILES, rows, strict=True):

        def look_up(which, shift):
            uv = mi.Point2f(
                *(upload(mi.Float, axis + by) for axis, by in zip(places, shift, strict=True))
            )
            found = bitmaps.table.eval(
                uv, si.wavelengths, dr.opaque(mi.UInt32, which), mi.Bool(True)
            )
            return np.array(found)

        assert look_up(row, tile[:2]) == pytest.approx(look_up(own, (0, 0)), abs=2e-4)


@pytest.mark.mitsuba
def test_slopes_of_heights_on_tiles_are_differences_of_their_values():
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.arrays import upload
    from lumenray.engine.transport.compiled.bitmaps import Bitmaps

    backend.start(False)
    bitmaps = Bitmaps()
    row = bitmaps.row(tiled(1, "linear", "extend", TURNED), largest=np.inf)
    bitmaps.table.commit()
    places = np.random.default_rng(4).random((2, 400)) * 2.0
    number = dr.opaque(mi.UInt32, row)

    def heights(du, dv):
        uv = mi.Point2f(upload(mi.Float, places[0] + du), upload(mi.Float, places[1] + dv))
        return np.array(bitmaps.table.eval_1(uv, number, mi.Bool(True)))

    uv = mi.Point2f(*(upload(mi.Float, axis) for axis in places))
    slopes = bitmaps.table.slope(uv, number, mi.Bool(True))
    step = 1e-3
    for slope, shift in zip(slopes, ((step, 0.0), (0.0, step)), strict=True):
        wanted = (heights(*shift) - heights(-shift[0], -shift[1])) / (2.0 * step)
        apart = np.abs(np.array(slope) - wanted)
        # Differences over the middle of a pixel, or over an edge, mix two slopes.
        assert np.quantile(apart, 0.9) < 0.02


def test_what_is_no_tile_does_not_count_in_the_mean():
    picture = ImageTexture(np.array([[[0.2], [0.4], [9.0]]], np.float32), tiles=(Tile(0, 0, 2, 1),))
    assert picture.mean() == pytest.approx([0.3])


@pytest.mark.mitsuba
@pytest.mark.parametrize(
    ("tiles", "word"),
    [((Tile(-1, 0, 1, 1),), "squares"), ((Tile(70000, 0, 1, 1),), "squares"), (TILES, "pixels")],
)
def test_tiles_that_cannot_be_are_refused(tiles, word):
    from lumenray.engine.transport.compiled.bitmaps import Bitmaps

    backend.start(False)
    values = np.zeros((1, 2, 1), np.float32)
    values.flags.writeable = False
    with pytest.raises(SceneError, match=word):
        Bitmaps().row(ImageTexture(values, tiles=tiles), largest=np.inf)
