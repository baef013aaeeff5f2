"""Random scenes: simplifications stay within their bounds, whatever is in a scene."""

import numpy as np
import pytest
from lumenray.benchmarks.requirements.random_scenes import find_error, make_scene
from lumenray.engine.requirements.decision import Asked, boxes_of
from lumenray.engine.requirements.plan import DECISIONS, make_plan
from lumenray.engine.scene.light import PlacedLight
from lumenray.engine.scene.scene import Scene, SceneDelta


def scene_of(number):
    made, scene = make_scene(number), Scene()
    scene.apply(SceneDelta(changed=made.items))
    return made, scene


def test_a_number_gives_one_scene():
    (first, one), (_, same), (_, other) = map(scene_of, (3, 3, 4))
    assert one.hash() == same.hash() != other.hash()
    assert len(first.places) == len(first.normals)


def crossings(start, end, corners):
    """How many triangles (t, 3, 3) the way between two places crosses."""
    way, (a, b, c) = end - start, (corners - start).transpose(1, 0, 2)
    volumes = np.stack([np.cross(p, q) @ way for p, q in ((a, b), (b, c), (c, a))])
    normal = np.cross(b - a, c - a)
    along = (normal * a).sum(axis=1) / np.where(normal @ way == 0.0, np.inf, normal @ way)
    is_met = (volumes > 0.0).all(axis=0) | (volumes < 0.0).all(axis=0)
    return int((is_met & (along > 0.0) & (along < 1.0)).sum())


def test_nothing_that_is_left_out_can_be_reached_straight():
    """Ways from sensors to what is hidden meet something opaque that is kept; in some scenes something is hidden."""
    counts = {"hidden": 0, "simple": 0}
    for number in range(16):
        made, scene = scene_of(number)
        plan = make_plan(scene, Asked(None, False, places=boxes_of(made.places)))
        assert plan.spent == 0.0
        left = plan.simplify(scene)
        counts["simple"] += any(item is not None for item in plan.changes.values())
        gone = [key for key, item in plan.changes.items() if item is None]
        counts["hidden"] += bool(gone)
        opaque = [
            mesh.vertices[mesh.triangles]
            for mesh in left.meshes.values()
            if all(left.materials[key].surface.is_opaque for key in mesh.materials)
        ]
        for key in gone:
            light = scene.lights.get(key)
            if isinstance(light, PlacedLight):
                ends = [light.place]
            elif key in scene.meshes:
                ends = scene.meshes[key].vertices[:3]
            else:
                # The sky.
                ends = 1e3 * np.eye(3)
            for start in made.places:
                for end in ends:
                    assert sum(crossings(start, np.asarray(end), each) for each in opaque)
    assert counts["hidden"] > 4
    assert counts["simple"] > 2


@pytest.mark.slow
@pytest.mark.mitsuba
@pytest.mark.parametrize("number", range(6))
def test_no_simplification_is_off_by_more_than_its_bound(number):
    """Each alone, forced, against the full model, at every sensor."""
    scene = make_scene(number)
    for name in DECISIONS:
        trial = find_error(scene, name, 1 << 13, number)
        if np.isfinite(trial.bound):
            assert (trial.error <= trial.bound + 4.0 * trial.noise).all(), (name, scene.words)
