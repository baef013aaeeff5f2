"""Pictures by id: what a scene makes of them, and what an edit around a picture builds."""

import gc
from dataclasses import replace

import numpy as np
import pytest
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene import memo
from lumenray.engine.scene.light import ImageWorld, Output, PointLight, Quantity
from lumenray.engine.scene.material import Coated, Emission, Glossy, Material, Mix
from lumenray.engine.scene.scene import Attachment, Scene, SceneDelta, array_digest, content_digest
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.scene.texture import ImageTexture, Pixels

UP = [[0.0, 0.0, 1.0]]


def pixels(seed=0, size=160, channels=3):
    values = np.random.default_rng(seed).random((size, size, channels), dtype=np.float32)
    return Pixels(f"pixels:{seed}", values)


def painted(picture, roughness=0.5, key="m"):
    return Material(key, key, Coated(ImageTexture(picture), roughness=roughness))


def scene_of(*items):
    made = Scene()
    made.apply(SceneDelta(changed=items))
    return made


# ---- the scene ----


def test_ids_become_the_arrays_whatever_the_order():
    shared = pixels()
    deep = Mix(Glossy(ImageTexture(shared.id)), Coated(), ImageTexture(shared.id))
    items = (
        Material("m", "m", deep, Emission(luminance=1.0, pattern=ImageTexture(shared.id))),
        ImageWorld(ImageTexture(shared.id), 1.0),
        shared,
    )
    for order in (items, items[::-1]):
        scene = scene_of(*order)
        material = scene.materials["m"]
        for picture in (
            material.surface.first.reflectance,
            material.surface.factor,
            material.emission.pattern,
            scene.world.image,
        ):
            assert picture.pixels is shared.values


def test_the_hash_does_not_know_how_pixels_came():
    shared = pixels()
    by_id = scene_of(shared, painted(shared.id), ImageWorld(ImageTexture(shared.id), 1.0))
    inline = scene_of(painted(shared.values.copy()), ImageWorld(ImageTexture(shared.values), 1.0))
    assert by_id.hash() == inline.hash()
    assert by_id.hash() != scene_of(painted(pixels(1).values)).hash()
    # Pixels that nothing shows do not count.
    unused = scene_of(shared, pixels(2), painted(shared.id), by_id.world)
    assert unused.hash() == by_id.hash()


def test_a_missing_id_is_told_and_changes_nothing():
    scene = scene_of(pixels(1), painted("pixels:1"))
    before, held = scene.hash(), set(scene.pixels)
    delta = SceneDelta((pixels(2), painted("pixels:1", 0.1), painted("pixels:3", key="n")))
    with pytest.raises(SceneError, match=r"a picture of n refers to pixels .* \(pixels:3\)"):
        scene.apply(delta)
    assert scene.hash() == before
    assert set(scene.pixels) == held
    with pytest.raises(SceneError, match="does not hold"):
        scene.apply(
            SceneDelta(attached=(Attachment("m", {"surface": Coated(ImageTexture("pixels:3"))}),))
        )
    assert not scene.attachments


def test_removed_pixels_stay_where_they_are_shown():
    shared = pixels()
    scene = scene_of(shared, painted(shared.id))
    scene.apply(SceneDelta(attached=(Attachment("m", {"index": 3}),), removed=(shared.id,)))
    assert not scene.pixels
    assert scene.materials["m"].surface.reflectance.pixels is shared.values
    # What is attached is put on the item again, which needs its pixels once more.
    scene.apply(SceneDelta(attached=(Attachment("m", {}),)))
    assert scene.materials["m"].surface.reflectance.pixels is shared.values
    with pytest.raises(SceneError, match="does not hold"):
        scene.apply(SceneDelta((painted(shared.id),)))


def test_pixels_that_come_again_are_the_ones_that_are_there():
    scene = scene_of(pixels(), painted("pixels:0"))
    first = scene.materials["m"].surface.reflectance.pixels
    scene.apply(SceneDelta((painted("pixels:0", 0.2), pixels()), removed=("pixels:0",)))
    assert scene.materials["m"].surface.reflectance.pixels is first


def test_what_follows_from_an_array_is_computed_once_and_forgotten_with_it(monkeypatch):
    array = np.ones((200, 200, 3), np.float32)
    shown = array.view()
    shown.flags.writeable = False
    count = []
    for _ in range(2):
        assert memo.recall(shown, "sum", lambda v: count.append(1) or float(v.sum())) == 120000
        memo.recall(array, "sum", lambda v: count.append(1))
    assert len(count) == 3
    part = memo.recall(shown, "half", lambda v: v[:100])
    assert not np.may_share_memory(part, array)
    assert memo.held_bytes(shown) == array.nbytes * 3 // 2
    other = pixels(5).values
    for expected in (4, 4, 5):
        memo.recall_latest(shown, "mix", [other], expected, lambda: count.append(1))
        assert len(count) == expected
    before = len(memo._known)
    assert array_digest(shown) == array_digest(array)
    assert content_digest(painted(shown)) == content_digest(painted(array.copy()))
    del shown, other
    gc.collect()
    assert len(memo._known) == before - 1


# ---- the engine ----


def floor(material="m", key="floor"):
    return replace(quad(key, (0, 0, 0), (1, 0, 0), (0, 1, 0), material), id=key)


def lit(*items):
    lamp = PointLight("l", "l", Output(Quantity.LUMINOUS_INTENSITY, 100.0), np.array([0.4, 0.5, 1]))
    return session_of(lamp, floor(), *items)


def work(session):
    session.measure([[0.5, 0.5, 0.5]], UP, StopRule(samples=4))
    return session._compiled._material_palette.make.bitmaps


@pytest.fixture
def built(monkeypatch):
    """Sizes of the bitmaps that are built from here on, those of two pixels aside."""
    import mitsuba as mi

    from lumenray.engine.transport import backend

    backend.start(True)
    sizes, make = [], mi.Bitmap

    def count(values):
        if values.shape[0] > 2:
            sizes.append(values.shape)
        return make(values)

    monkeypatch.setattr(mi, "Bitmap", count)
    return sizes


SURFACES = (
    lambda picture, value: Coated(picture, roughness=value),
    Glossy,
    lambda picture, value: Mix(Glossy(picture, value), Coated(picture), 0.5),
    lambda picture, value: Glossy(Constant(value), picture),
)


@pytest.mark.mitsuba
@pytest.mark.parametrize("surface", SURFACES)
def test_an_edit_around_a_picture_builds_no_bitmap(surface, built):
    shared = pixels()
    session = lit(shared, Material("m", "m", surface(ImageTexture(shared.id), 0.5)))
    bitmaps = work(session)
    assert (len(built), len(bitmaps)) == (1, 1)
    for step in range(3):
        made = Material("m", "m", surface(ImageTexture(shared.id), 0.2 + 0.1 * step))
        session.apply(SceneDelta((made,)))
        work(session)
    turned = ImageTexture(shared.id, transform=np.diag([2.0, 2.0, 1.0]), extension="mirror")
    session.apply(SceneDelta((Material("m", "m", surface(turned, 0.4)),)))
    work(session)
    assert (len(built), len(bitmaps)) == (1, 1)
    session.apply(SceneDelta((pixels(1), Material("m", "m", surface(ImageTexture("pixels:1"), 1)))))
    work(session)
    assert (len(built), len(bitmaps)) == (2, 1)


@pytest.mark.mitsuba
def test_two_materials_share_a_bitmap_and_one_of_them_can_change(built):
    shared, other = pixels(), pixels(1)
    rule, at = StopRule(samples=1 << 10), [[0.5, 0.5, 0.2]]
    down = [[0.0, 0.0, -1.0]]

    def metal(key, picture, **more):
        return Material(key, key, Glossy(ImageTexture(picture, **more), 0.3))

    session = lit(shared, other, metal("m", shared.id), metal("n", shared.id), floor("n", "second"))
    bitmaps = work(session)
    assert (len(built), len(bitmaps)) == (1, 1)
    for made in (metal("n", other.id), metal("n", other.id, extension="extend")):
        session.apply(SceneDelta((made,)))
        work(session)
    session.apply(SceneDelta(removed=("second",)))
    fresh = lit(shared, metal("m", shared.id))
    # The picture of one material must not have gone into the texture of the other.
    np.testing.assert_allclose(
        session.measure(at, down, rule).illuminance,
        fresh.measure(at, down, rule).illuminance,
        rtol=1e-4,
    )
    session.apply(SceneDelta((metal("m", shared.id, extension="extend"),)))
    assert len(work(session)) == 1


@pytest.mark.mitsuba
def test_an_edit_gives_what_a_fresh_scene_gives():
    turned = np.array([[2.0, 0.3, 0.1], [0.0, 1.5, 0.2], [0.0, 0.0, 1.0]])
    rule, at, down = StopRule(samples=1 << 10), [[0.5, 0.5, 0.2]], [[0.0, 0.0, -1.0]]
    for surface in SURFACES:
        before = Material("m", "m", surface(ImageTexture("pixels:0"), 0.5))
        after = ImageTexture("pixels:0", transform=turned, interpolation="closest")
        after = Material("m", "m", surface(after, 0.3))
        session = lit(pixels(), before)
        work(session)
        session.apply(SceneDelta((after,)))
        np.testing.assert_allclose(
            session.measure(at, down, rule).illuminance,
            lit(pixels(), after).measure(at, down, rule).illuminance,
            rtol=1e-4,
        )


@pytest.mark.mitsuba
def test_pictures_that_come_and_go_build_no_kernel():
    from lumenray.engine.transport import backend

    backend.start(True)
    import drjit as dr

    def shown(key, size, **laid):
        surface = Coated(ImageTexture(pixels(size, size).values, **laid))
        return Material(key, key, surface)

    def kernels():
        """Names of the kernels of a measurement, small ones that move texels aside."""
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            work(session)
            history = [entry for entry in dr.kernel_history() if "hash" in entry]
        return {entry["hash"] for entry in history if entry["operation_count"] > 100}

    session = lit(shown("m", 160), Material("n", "n", Coated()), floor("n", "second"))
    known = kernels()
    assert known
    for made in (
        shown("m", 72, extension="mirror", interpolation="closest"),
        shown("n", 200, extension="extend", transform=np.diag([2.0, 3.0, 1.0])),
        Material("m", "m", Coated()),
    ):
        session.apply(SceneDelta((made,)))
        assert kernels() <= known


@pytest.mark.mitsuba
def test_pictures_are_freed_with_their_last_use():
    session = lit(pixels(), painted("pixels:0"))
    bitmaps = work(session)
    before = len(memo._known)
    for seed in range(1, 30):
        key, old = f"pixels:{seed}", f"pixels:{seed - 1}"
        session.apply(SceneDelta((pixels(seed, size=200), painted(key)), (old,)))
        work(session)
        assert len(bitmaps) == len(session.scene.pixels) == 1
    gc.collect()
    assert len(memo._known) <= before
    session.apply(SceneDelta((Material("m", "m", Coated(Constant(0.5))),), ("pixels:29",)))
    assert (len(work(session)), len(session.scene.pixels)) == (0, 0)
    session.apply(SceneDelta((pixels(), painted("pixels:0"))))
    assert len(work(session)) == 1
    session.apply(SceneDelta(removed=("floor", "m", "pixels:0")))
    assert len(work(session)) == 0


@pytest.mark.mitsuba
def test_the_pattern_of_a_glowing_surface_stays_while_its_light_is_edited(built):
    def glowing(amount):
        pattern = ImageTexture("pixels:0")
        return Material("m", "m", Coated(), Emission(luminance=amount, pattern=pattern))

    session = lit(pixels(), glowing(10.0))
    bitmaps = work(session)
    for amount in (20.0, 30.0):
        session.apply(SceneDelta((glowing(amount),)))
        work(session)
        assert "object built" not in session.commit.action
    session.apply(SceneDelta((floor(),)))
    work(session)
    assert (len(built), len(bitmaps)) == (1, 1)


@pytest.mark.mitsuba
@pytest.mark.parametrize("transport", ["mono", "spectral"])
def test_a_world_is_laid_another_way_without_reading_its_picture(transport, built):
    def sky(amount, turn):
        c, s = np.cos(turn), np.sin(turn)
        rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        rotation = rotation @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        return ImageWorld(ImageTexture("pixels:0"), amount, rotation)

    bright = pixels().values.copy()
    bright[90:140, 20:40] = 30.0
    shared = Pixels("pixels:0", bright)
    rule = StopRule(samples=1 << 12)

    def lux(session):
        normals = [[0, 0, 1.0], [1.0, 0, 0], [0, -1.0, 0]]
        return session.measure([[0, 0, 3.0]] * 3, normals, rule, transport=transport).illuminance

    session = session_of(floor(), paint(0.5, "m"), shared, sky(10.0, 0.0))
    first = lux(session)
    built.clear()
    for amount, turn in ((20.0, 0.0), (30.0, 1.2)):
        session.apply(SceneDelta((sky(amount, turn),)))
        found = lux(session)
        assert not built
    fresh = lux(session_of(floor(), paint(0.5, "m"), shared, sky(30.0, 1.2)))
    np.testing.assert_allclose(found, fresh, rtol=1e-4)
    assert not np.allclose(found, 3.0 * first, rtol=0.05)
    session.apply(SceneDelta((sky(0.0, 0.0),)))
    assert not lux(session).any()
    session.apply(SceneDelta((sky(10.0, 0.0),)))
    np.testing.assert_allclose(lux(session), first, rtol=1e-4)
