"""Pictures of a scene that was kept current through hundreds of edits, beside those of a fresh start."""

import os

import bpy
import numpy as np
import pytest
from random_edits import RandomEdits

from lumenray.blender_addon.rendering.feed import SceneFeed
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, Quantity, SunLight
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.session import Session
from lumenray.engine.views import Display, LiveSettings, ViewSettings

pytestmark = [pytest.mark.blender, pytest.mark.mitsuba]

SEEDS = range(20 if os.environ.get("LUMENRAY_ALL_SEEDS") else 2)
"""Seeds of the random edits; set LUMENRAY_ALL_SEEDS for all twenty."""


def look_down(low, high) -> Camera:
    """Camera above everything, a little aslant so that no edge lies along its rows."""
    centre, size = 0.5 * (low + high), float(np.linalg.norm(high - low))
    c, s = np.cos(0.3), np.sin(0.3)
    frame = np.eye(4)
    frame[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, np.cos(0.5), -np.sin(0.5)], [0, np.sin(0.5), np.cos(0.5)]]
    )
    frame[:3, 3] = centre + 1.5 * size * frame[:3, 2]
    return Camera(frame, Projection.PERSPECTIVE, 40, 30, 0.6, 0.45)


def middle(scene):
    """Corners around the middle half of an engine's scene: random edits throw some objects far away."""
    points = [scene.mesh(key).vertices for key in scene.meshes]
    centres = np.array([p.mean(axis=0) for p in points if len(p)] or [np.zeros(3)])
    low, high = np.percentile(centres, (25, 75), axis=0)
    # Between clusters there may be nothing, so look at what is next to the middle.
    away = centres - 0.5 * (low + high)
    centre = centres[np.argmin((away**2).sum(axis=1))]
    half = 0.5 * (high - low) + bpy.context.scene.unit_settings.scale_length
    return centre - half, centre + half


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.slow
def test_five_hundred_random_edits_give_the_picture_of_a_fresh_start(seed, tmp_path):
    edits, done, lit = RandomEdits(seed, tmp_path), [], []
    # A lamp of the engine's own, which no edit of Blender's scene touches: some of them leave it dark.
    down = np.array([0.3, 0.2, -0.93])
    lamp = SunLight("test:sun", "sun", Output(Quantity.ILLUMINANCE, 100.0), down, 0.02)
    kept = SceneFeed(Session(witness=False), final=bool(seed % 2))
    kept.session.apply(SceneDelta(changed=(lamp,)))
    settings = ViewSettings(StopRule(samples=4), seed=7)
    for number in range(1, 501):
        done.append(edits.edit())
        kept.update(bpy.context.evaluated_depsgraph_get())
        camera = look_down(*middle(kept.session.scene))
        if number % 25 == 0:
            kept.session.watch(camera, LiveSettings(samples=4), Display())
            kept.session.refine()
        if number % 250 == 0:
            fresh = SceneFeed(Session(witness=False), final=kept.sync.final)
            fresh.session.apply(SceneDelta(changed=(lamp,)))
            fresh.update(bpy.context.evaluated_depsgraph_get())
            a = kept.session.render(camera, settings)
            b = fresh.session.render(camera, settings)
            assert a.provenance.scene_hash == b.provenance.scene_hash, f"after {done[-50:]}"
            lit.append((a.tristimulus[..., 1] > 0.0).mean())
            assert a.provenance.variant == b.provenance.variant
            np.testing.assert_array_equal(a.object_index, b.object_index)
            same = np.isclose(a.tristimulus, b.tristimulus, rtol=1e-3, atol=1e-4).all(axis=2)
            # Surfaces at exactly the same place (copies that were not moved) may show either, at the same depth.
            assert same.mean() > 0.95, f"after {done[-50:]}"
            assert np.isclose(a.depth, b.depth, rtol=1e-4).mean() > 0.999
    assert max(lit) > 0.01
