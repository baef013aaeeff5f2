"""Scenes of the engine that are kept current, and how they differ from a fresh export."""

import bpy

from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.scene.scene import Scene, content_digest


class KeptScene:
    """A scene of the engine that is kept current with Blender's."""

    def __init__(self, final=False):
        self.sync, self.scene = SceneSync(final), Scene()

    def step(self, **more):
        """Walk, keep the scene current and return the step."""
        bpy.context.view_layer.update()
        made = self.sync.walk(bpy.context.evaluated_depsgraph_get(), **more)
        self.scene.apply(made.delta)
        return made

    @classmethod
    def started(cls):
        """Return a scene that holds all that is there."""
        kept = cls()
        kept.step()
        return kept

    def differences(self):
        """Say where the scene differs from a fresh export."""
        fresh = Scene()
        made = SceneSync(self.sync.final).walk(bpy.context.evaluated_depsgraph_get())
        fresh.apply(made.delta)
        return differences(self.scene, fresh)

    def changes(self):
        """Walk and compare with a fresh export; return the items that were sent and the ids that are gone."""
        made = self.step()
        assert self.differences() == []
        return list(made.delta.changed), list(made.delta.removed)

    def sent(self):
        """Walk and compare with a fresh export; return the kinds of items that were sent and how many are gone."""
        changed, removed = self.changes()
        return [type(item).__name__ for item in changed], len(removed)


def differences(kept: Scene, fresh: Scene) -> list[str]:
    """Say where a scene kept current differs from a fresh export, object by object; empty if nowhere.

    Names do not count, nor what the kept scene holds in reserve: unused geometries and materials, and dark lights.
    """
    found = []
    for key in sorted(kept.meshes.keys() | fresh.meshes.keys()):
        if key not in kept.meshes or key not in fresh.meshes:
            found.append(f"{key} is only in the {'kept' if key in kept.meshes else 'fresh'} scene")
            continue
        old, new = kept.mesh(key), fresh.mesh(key)
        if content_digest(old) != content_digest(new):
            found.append(f"{key} '{new.name}' differs")
        if old.materials != new.materials:
            found.append(f"{key} '{new.name}' has other materials")
        found += [f"{m} is missing" for m in old.materials if m not in kept.materials]
    for key, new in fresh.materials.items():
        if key in kept.materials and content_digest(kept.materials[key]) != content_digest(new):
            found.append(f"{key} '{new.name}' differs")
    old_lights, new_lights = (
        {key: light for key, light in scene.lights.items() if light.output.value > 0}
        for scene in (kept, fresh)
    )
    for key in sorted(old_lights.keys() | new_lights.keys()):
        if key not in old_lights or key not in new_lights:
            found.append(f"{key} is only in the {'kept' if key in old_lights else 'fresh'} scene")
        elif content_digest(old_lights[key]) != content_digest(new_lights[key]):
            found.append(f"{key} '{new_lights[key].name}' differs")
    if (kept.world is None) != (fresh.world is None):
        found.append("only one of them has a world")
    elif kept.world is not None and (
        kept.world.id != fresh.world.id or content_digest(kept.world) != content_digest(fresh.world)
    ):
        found.append("the world differs")
    return found
