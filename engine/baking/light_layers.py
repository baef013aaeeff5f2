"""Scenes in which only some of the lights shine: by linearity their maps add up to that of all."""

from dataclasses import replace

from ..errors import SceneError
from ..scene.scene import Scene
from .order import LightGroup

WORLD = "world"
"""How a group names the surroundings."""

REST = "rest"
"""Name of the layer of lights that are in no group."""


def split_lights(scene: Scene, groups: tuple[LightGroup, ...]) -> list[tuple[str, Scene]]:
    """Scenes of the groups, and that of the lights in none of them if there are any; names may not repeat.

    Raises
    ------
    SceneError    A member is in two groups, shines nowhere, or two groups share a name.
    """
    shining = {key for key, light in scene.lights.items() if light.output.value > 0.0}
    shining |= {k for k, m in scene.materials.items() if m.emission and m.emission.luminance > 0.0}
    if scene.world is not None:
        shining.add(WORLD)
    owner: dict[str, str] = {}
    for group in groups:
        for member in group.members:
            if member in owner:
                raise SceneError(
                    f"a light is in the light groups '{owner[member]}' and '{group.name}'; it can be in one"
                )
            owner[member] = group.name
    names = [group.name for group in groups]
    if len(set(names)) < len(names) or REST in names:
        raise SceneError(f"light groups need names of their own, and not '{REST}': {names}")
    layers = [
        (group.name, _only(scene, shining & set(group.members)))
        for group in groups
        if shining & set(group.members)
    ]
    rest = shining - set(owner)
    if rest:
        layers.append((REST, _only(scene, rest)))
    return layers


def _only(scene: Scene, members: set[str]) -> Scene:
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
