"""Groups of lights: which of a scene's lights shine together, and whose light is told apart from the rest."""

from dataclasses import dataclass

from ..errors import SceneError
from .scene import Scene

WORLD = "world"
"""How a group names the surroundings."""

REST = "rest"
"""Name of the group of lights that are in no other."""


@dataclass(frozen=True)
class LightGroup:
    """Lights whose light is kept apart, to be dimmed and recoloured afterwards.

    Parameters
    ----------
    name : str    For people, and in file names.
    members : tuple of str
        Ids of lights and of glowing materials; ``world`` stands for the surroundings without the sun lights.
    """

    name: str
    members: tuple[str, ...]


def share_out(scene: Scene, groups: tuple[LightGroup, ...]) -> list[tuple[str, frozenset[str]]]:
    """Names of the groups that shine, and of the rest if there is one, with the ids of all that shines in each.

    Raises
    ------
    SceneError    A member is in two groups, or two groups share a name.
    """
    shining = {key for key, light in scene.lights.items() if light.output.value > 0.0}
    used = {key for mesh in scene.meshes.values() for key in mesh.materials}
    glows = [m for m in scene.materials.values() if _glows(m) or (m.seen and _glows(m.seen))]
    shining |= {material.id for material in glows if material.id in used}
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
    shares = [(group.name, frozenset(shining & set(group.members))) for group in groups]
    shares.append((REST, frozenset(shining - set(owner))))
    return [(name, members) for name, members in shares if members]


def _glows(material) -> bool:
    return material.emission is not None and material.emission.luminance > 0.0
