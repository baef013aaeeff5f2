"""Pictures in a table have the values that Mitsuba's `bitmap` gives, whatever they are beside."""

from itertools import product

import numpy as np
import pytest

from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.transport import backend

TURNED = np.array([[2.3, 0.4, -0.7], [-0.3, -1.6, 0.2], [0.0, 0.0, 1.0]])
WRAPS = {"repeat": "repeat", "extend": "clamp", "mirror": "mirror"}
COUNT = 4000


def pixels(height, width, channels, seed=0):
    values = np.random.default_rng(seed).random((height, width, channels)).astype(np.float32)
    # Spectra of black and white are limits of the model of all others.
    values[0, 0], values[-1, -1] = 0.0, 1.0
    values.flags.writeable = False
    return values


def surfaces():
    """Random places, some of them far outside, in four random wavelengths."""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.arrays import upload

    rng = np.random.default_rng(1)
    uv = rng.random((2, COUNT)) * 8.0 - 4.0
    uv[:, :8] = [
        [0.0, 1.0, -1.0, 2.0, 0.5, 0.0, -2.0, 1.0],
        [0.0, 1.0, 1.0, 0.0, 0.5, -1.0, 3.0, 0.0],
    ]
    si = dr.zeros(mi.SurfaceInteraction3f, COUNT)
    si.uv = mi.Point2f(*(upload(mi.Float, axis) for axis in uv))
    for k in range(len(si.wavelengths)):
        si.wavelengths[k] = upload(mi.Float, rng.random(COUNT) * 470.0 + 360.0)
    return si


def bitmap(picture):
    import mitsuba as mi

    return mi.load_dict(
        {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.array(picture.pixels)),
            "raw": picture.pixels.shape[2] == 1,
            "format": "variant",
            "filter_type": "nearest" if picture.interpolation == "closest" else "bilinear",
            "wrap_mode": WRAPS[picture.extension],
            "to_uv": mi.ScalarTransform3f(picture.transform.tolist()),
        }
    )


def look_up(table, si, row):
    import drjit as dr
    import mitsuba as mi

    return table.eval(si.uv, si.wavelengths, dr.opaque(mi.UInt32, row), mi.Bool(True))


def laid():
    """Pictures of many sizes in all ways."""
    shapes = [(5, 7, 3), (16, 4, 1), (1, 9, 3), (64, 64, 3), (3, 1, 1)]
    stored = [pixels(*shape, seed) for seed, shape in enumerate(shapes)]
    ways = product(("linear", "closest"), WRAPS, (np.eye(3), TURNED))
    return [
        ImageTexture(values, "", transform, filtering, wrap)
        for filtering, wrap, transform in ways
        for values in stored
    ]


@pytest.mark.mitsuba
@pytest.mark.parametrize("spectral", [False, True])
def test_all_pictures_have_the_values_of_mitsubas_own(spectral):
    import mitsuba as mi

    from lumenray.engine.transport.compiled.bitmaps import Bitmaps

    backend.start(spectral)
    pictures, bitmaps, si = laid(), Bitmaps(), surfaces()
    rows = [bitmaps.row(picture) for picture in pictures]
    assert len(set(rows)) == len(pictures)
    bitmaps.table.commit()
    for picture, row in zip(pictures, rows, strict=True):
        found = np.array(look_up(bitmaps.table, si, row))
        wanted = np.array(bitmap(picture).eval(si, mi.Bool(True)))
        apart = np.abs(found - wanted).max(axis=0)
        # A place may fall on the other side of the border between two squares by rounding.
        allowed = 2 if picture.interpolation == "closest" else 0
        assert (apart > 1e-4).sum() <= allowed, (picture, apart.max())


@pytest.mark.mitsuba
def test_rows_keep_their_pictures_while_others_come_and_go():
    import mitsuba as mi

    from lumenray.engine.transport.compiled.bitmaps import Bitmaps, key_of

    backend.start(False)
    pictures, bitmaps, si = laid(), Bitmaps(), surfaces()

    def check(shown):
        kept = {key_of(picture) for picture in shown}
        bitmaps.keep(kept)
        rows = [bitmaps.row(picture) for picture in shown]
        bitmaps.table.commit()
        assert len(bitmaps) == len(bitmaps.table) == len(shown)
        for picture, row in zip(shown, rows, strict=True):
            found = np.array(look_up(bitmaps.table, si, row))
            wanted = np.array(bitmap(picture).eval(si, mi.Bool(True)))
            assert np.median(np.abs(found - wanted)) < 1e-6

    check(pictures[:7])
    check(pictures[3:5])
    check([pictures[9], *pictures[3:5]])
    check([pictures[4], pictures[14], pictures[5]])


@pytest.mark.mitsuba
def test_a_picture_of_another_kind_meets_the_same_kernel():
    import drjit as dr

    from lumenray.engine.transport.compiled.bitmaps import Bitmaps

    backend.start(True)
    si, built = surfaces(), []
    pictures = laid()
    for shown in ([pictures[0]], [pictures[16], pictures[3]], pictures[20:32]):
        bitmaps = Bitmaps()
        row = max(bitmaps.row(picture) for picture in shown)
        bitmaps.table.commit()
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            dr.eval(look_up(bitmaps.table, si, row))
            built.append([kernel["hash"] for kernel in dr.kernel_history() if "hash" in kernel])
    assert built[0]
    assert built[0] == built[1] == built[2]


@pytest.mark.mitsuba
@pytest.mark.parametrize("spectral", [False, True])
def test_a_palette_shows_each_shape_its_own_picture(spectral):
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.arrays import upload
    from lumenray.engine.materials import plugins
    from lumenray.engine.scene.material import Black, Coated, Diffuse, Material
    from lumenray.engine.scene.spectrum import Constant
    from lumenray.engine.transport.compiled.material_palette import MaterialPalette

    backend.start(spectral)
    plugins.register()
    pictures = [ImageTexture(pixels(8, 6, 3)), ImageTexture(pixels(4, 4, 1), "", TURNED, "closest")]
    surfaces_of = {
        "picture": Diffuse(pictures[0]),
        "plain": Coated(Constant(0.3), roughness=0.2),
        "other": Coated(pictures[1]),
        "black": Black(),
    }
    palette = MaterialPalette(np.ones(471))
    for key, surface in surfaces_of.items():
        palette.put(Material(key, key, surface))
    palette.commit(np.array([0.0, *(palette.row(key) for key in surfaces_of)]))
    assert len({palette.plugin_number(key) for key in surfaces_of}) == 1

    si = surfaces()
    shape = np.arange(COUNT) % 4
    si.shape = dr.reinterpret_array(mi.ShapePtr, upload(mi.UInt32, shape + 1))
    found = np.array(palette.palette.eval_diffuse_reflectance(si, mi.Bool(True)))
    shown = [np.array(bitmap(picture).eval(si, mi.Bool(True))) for picture in pictures]
    even = np.ones_like(shown[0])
    wanted = np.choose(shape, [shown[0], 0.3 * even, shown[1], 0.0 * even])
    # A place may fall on the other side of the border between two squares by rounding.
    assert (np.abs(found - wanted).max(axis=0) > 1e-5).sum() <= 2

    # The last picture leaves, and with it what looks for pictures.
    for key in ("picture", "other"):
        palette.put(Material(key, key, Coated(Constant(0.1))))
    palette.commit(np.array([0.0, *(palette.row(key) for key in surfaces_of)]))
    assert palette.palette.pictures is None
    found = np.array(palette.palette.eval_diffuse_reflectance(si, mi.Bool(True)))
    wanted = np.choose(shape, [0.1 * even, 0.3 * even, 0.1 * even, 0.0 * even])
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


@pytest.mark.mitsuba
def test_more_texels_than_can_be_addressed_are_refused(monkeypatch):
    from lumenray.engine.errors import SceneError
    from lumenray.engine.materials import picture_table
    from lumenray.engine.transport.compiled.bitmaps import Bitmaps

    backend.start(True)
    monkeypatch.setattr(picture_table, "MOST_NUMBERS", 400)
    bitmaps = Bitmaps()
    bitmaps.row(ImageTexture(pixels(10, 10, 3)))
    bitmaps.table.commit()
    bitmaps.row(ImageTexture(pixels(8, 8, 3)))
    with pytest.raises(SceneError, match="hold 494 numbers, and at most 400"):
        bitmaps.table.commit()
