"""Scenes in which only some of the lights shine: by linearity their maps add up to that of all."""

from dataclasses import replace

from ..scene.light_groups import WORLD, LightGroup, share_out
from ..scene.scene import Scene


def split_lights(scene: Scene, groups: tuple[LightGroup, ...]) -> list[tuple[str, Scene]]:
    """Scenes of the groups, and that of the lights in none of them if there are any; names may not repeat.

    Raises
    ------
    SceneError    As `share_out`.
    """
    return [(name, _only(scene, members)) for name, members in share_out(scene, groups)]


def _only(scene: Scene, members: frozenset[str]) -> Scene:
    """The same scene with no other lights than these."""
    return replace(
        scene,
        lights={key: light for key, light in scene.lights.items() if key in members},
        materials={
            key: item if key in members or item.emission is None else replace(item, emission=None)
            for key, item in scene.materials.items()
        },
        world=scene.world if WORLD in members else None,
    )
