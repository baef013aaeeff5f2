"""Scenes of the benchmark of pictures: what cameras see, and that Cycles is given the same."""

import numpy as np
import pytest

from lumenray.engine.photometry.colour import REC709_LUMINANCE

pytestmark = pytest.mark.mitsuba

LIGHT_SCENES = ("cabin", "hall", "glass", "window", "product")
"""Those that need no Blender."""

SIZE = (48, 30)


def test_cameras_keep_their_width_and_square_pixels():
    from lumenray.benchmarks.pictures.scenes import look, resize

    camera = look((1.0, 2.0, 1.5), (4.0, 6.0, 1.5), 1.2)
    assert camera.frame[:3, :3] @ camera.frame[:3, :3].T == pytest.approx(np.eye(3))
    # It looks along its -z, and stands upright.
    assert -camera.frame[:3, 2] == pytest.approx([0.6, 0.8, 0.0])
    assert camera.frame[2, 1] == pytest.approx(1.0)
    other = resize(camera, (300, 100))
    assert (other.width, other.height) == (300, 100)
    assert other.extent_x / 300 == pytest.approx(other.extent_y / 100)
    assert other.extent_x == camera.extent_x


@pytest.mark.parametrize("key", LIGHT_SCENES)
def test_scenes_are_stated_to_cycles_whole(key):
    """Every triangle, every light with its amount, and no material that is not known."""
    from lumenray.benchmarks.pictures.cycles_scene import describe
    from lumenray.benchmarks.pictures.scenes import build
    from lumenray.engine.scene.light import PlacedLight
    from lumenray.engine.scene.mesh import Mesh

    scene = build(key, SIZE)
    request = describe(scene.known_items, scene.camera)
    told = sum(
        len(entry["triangles"]) for name in ("meshes", "textured") for entry in request[name]
    )
    meshes = [item for item in scene.items if isinstance(item, Mesh)]
    # An opening with nothing in it is not told; it becomes portals.
    expected = sum(len(mesh.triangles) for mesh in meshes if mesh.id != "opening")
    assert told == expected
    lamps = [entry for entry in request["lights"] if not entry.get("is_portal")]
    assert len(lamps) >= sum(isinstance(item, PlacedLight) for item in scene.items)
    for entry in lamps:
        assert np.dot(entry["tint"], REC709_LUMINANCE) == pytest.approx(1.0)
    assert request["camera"]["size"] == SIZE


def test_stand_ins_are_for_others_only():
    from lumenray.benchmarks.common.still_lifes import PAINTS
    from lumenray.benchmarks.pictures.scenes import build
    from lumenray.engine.scene.material import Material, Measured

    scene = build("product", SIZE)
    assert sorted(scene.stand_ins) == sorted(PAINTS)

    def surfaces(items):
        return {item.id: item.surface for item in items if isinstance(item, Material)}

    assert all(isinstance(surface, Measured) for surface in surfaces(scene.items).values())
    assert surfaces(scene.known_items) == scene.stand_ins


@pytest.mark.parametrize("key", ["cabin", pytest.param("glass", marks=pytest.mark.slow)])
def test_cameras_see_the_room_and_its_light(key):
    """No pixel looks out of the closed room, and most of it is lit."""
    from lumenray.benchmarks.pictures.scenes import build
    from lumenray.engine.accuracy.stopping import StopRule
    from lumenray.engine.scene.scene import SceneDelta
    from lumenray.engine.session import Session
    from lumenray.engine.views import ViewSettings

    scene = build(key, SIZE)
    session = Session(witness=False)
    session.apply(SceneDelta(changed=scene.items))
    picture = session.render(scene.camera, ViewSettings(StopRule(samples=32)))
    assert picture.depth.max() < 20.0
    luminance = picture.tristimulus[..., 1]
    assert np.median(luminance) > 0.05 * luminance.mean()


SAMPLES = {"glass": 1024}
"""Of Cycles, per pixel, where fewer leave most pictures without the rare bright samples that its mean is made of."""

AGREEMENT = {"office": 0.03, "product": 0.15}
"""Where Cycles has other models, of coats and of paints, by how much means may differ beyond noise; others agree. [-]"""


@pytest.mark.blender
@pytest.mark.slow
@pytest.mark.parametrize("key", ["office", *LIGHT_SCENES])
def test_programs_see_the_same(key):
    """Mean luminance of the whole and of quarters of the picture, within their noise."""
    pytest.importorskip("bpy")
    from lumenray.benchmarks.pictures.programs import Cycles, Lumenray
    from lumenray.benchmarks.pictures.scenes import build

    scene = build(key, SIZE)
    programs = [Lumenray(scene), Cycles(scene)]
    try:
        samples = [48, SAMPLES.get(key, 48)]
        quarters = np.array(
            [
                [_quarters(each.render(count, seed).luminance) for seed in range(3)]
                for each, count in zip(programs, samples, strict=True)
            ]
        )
    finally:
        programs[1].close()
    mean = quarters.mean(axis=1)
    error = np.sqrt((quarters.var(axis=1, ddof=1) / 3).sum(axis=0))
    # With three seeds errors are known by half at best.
    allowed = 6.0 * error + (AGREEMENT.get(key, 0.0) + 0.01) * mean[0]
    assert (np.abs(mean[0] - mean[1]) <= allowed).all(), (mean, error)


def _quarters(luminance: np.ndarray) -> np.ndarray:
    """Means of the quarters and of the whole. (5,) [cd/m2]"""
    y, x = luminance.shape[0] // 2, luminance.shape[1] // 2
    parts = [
        luminance[a, b] for a in (slice(y), slice(y, None)) for b in (slice(x), slice(x, None))
    ]
    return np.array([part.mean() for part in (*parts, luminance)])
