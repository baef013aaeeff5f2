"""Which lights make up the layers of a bake: the groups that they name, or each for itself."""

from typing import get_args

import bpy

from ...engine.baking.light_layers import REST, WORLD
from ...engine.baking.order import LightGroup
from ...engine.errors import SceneError
from ...engine.scene.light import CieSky, ImageWorld, Light, UniformWorld
from ...engine.scene.material import Material
from ..foundation import identity

LIGHTS = get_args(Light)
SURROUNDINGS = (CieSky, ImageWorld, UniformWorld)

MOST = 64
"""Most layers; each is as large as all pages together."""


def find_groups(items, world, mode: str) -> tuple[LightGroup, ...]:
    """Sort what shines into groups.

    Parameters
    ----------
    items : iterable of scene items    As they were converted: lights, materials, the world.
    world : bpy.types.World or None    Of the scene.
    mode : str    ``none``; ``groups``: as lights, glowing materials and the world name them; ``each``: each for itself.

    Returns
    -------
    tuple of LightGroup    In the order of their names; members are in the order of their ids.

    Raises
    ------
    SceneError    There are too many.
    """
    if mode == "none":
        return ()
    named = _names_by_group(world) if mode == "groups" else None
    members: dict[str, list[str]] = {}
    for key, own_name, uid in sorted(_shining(items)):
        if named is None:
            members.setdefault(_free_name(own_name, members), []).append(key)
        elif named.get(uid) not in {None, "", REST}:
            members.setdefault(named[uid], []).append(key)
    if len(members) > MOST:
        raise SceneError(
            f"{len(members)} layers are too many: put the lights into at most {MOST} light groups"
        )
    return tuple(LightGroup(name, tuple(members[name])) for name in sorted(members))


def _shining(items) -> list[tuple[str, str, str]]:
    """Id for the engine, name for people and identity in the file of everything that gives light."""
    found = []
    for item in items:
        if isinstance(item, SURROUNDINGS):
            found.append((WORLD, "World", WORLD))
        elif isinstance(item, LIGHTS) or (isinstance(item, Material) and item.emission is not None):
            # An instance's id ends with the identity of what it is an instance of.
            uid = item.id.partition(":")[2].rpartition("/")[2]
            found.append((item.id, item.name, uid))
    return found


def _names_by_group(world) -> dict[str, str]:
    """Names of groups by the identity of what names them."""
    found = {} if world is None else {WORLD: world.lumenray.light_group.strip()}
    for source in bpy.data.objects:
        if source.type in {"LIGHT", "EMPTY"}:
            owner = source.data if source.type == "LIGHT" else source
            found[identity.identity_of(source)] = owner.lumenray.light_group.strip()
    for material in bpy.data.materials:
        found[identity.identity_of(material)] = material.lumenray.light_group.strip()
    return found


def _free_name(wanted: str, taken) -> str:
    name, number = wanted, 1
    while name in taken or name == REST:
        number += 1
        name = f"{wanted} ({number})"
    return name
