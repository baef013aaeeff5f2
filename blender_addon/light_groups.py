"""Which lights belong together: the groups that they name, or each for itself; for layers of bakes and for pictures."""

import bpy

from ..engine.errors import SceneError
from ..engine.scene.light_groups import REST, WORLD, LightGroup
from .foundation import identity

MOST = 64
"""Most groups; each is as large as the picture, or as all pages of a bake together."""


def find_groups(luminous, world, mode: str) -> tuple[LightGroup, ...]:
    """Sort what shines into groups.

    Parameters
    ----------
    luminous : iterable of (str, str)    As of `SceneSync.luminous`.
    world : bpy.types.World or None    Of the scene.
    mode : str    ``none``; ``groups``: as lights, glowing materials and the world name them, or else as Blender's own light
        groups have their objects; ``each``: each for itself.

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
    for key, own_name in sorted(luminous):
        # An instance's id ends with the identity of what it is an instance of.
        uid = WORLD if key == WORLD else key.partition(":")[2].rpartition("/")[2]
        if named is None:
            members.setdefault(_free_name(own_name, members), []).append(key)
        elif named.get(uid) not in {None, "", REST}:
            members.setdefault(named[uid], []).append(key)
    if len(members) > MOST:
        raise SceneError(
            f"{len(members)} groups are too many: put the lights into at most {MOST} light groups"
        )
    return tuple(LightGroup(name, tuple(members[name])) for name in sorted(members))


def _names_by_group(world) -> dict[str, str]:
    """Names of groups by the identity of what names them."""
    found = {} if world is None else {WORLD: world.lumenray.light_group.strip() or world.lightgroup}
    worn: dict[str, set[str]] = {}
    for source in bpy.data.objects:
        if source.type in {"LIGHT", "EMPTY"}:
            owner = source.data if source.type == "LIGHT" else source
            name = owner.lumenray.light_group.strip()
            found[identity.identity_of(source)] = name or source.lightgroup
            continue
        for slot in source.material_slots:
            if slot.material is not None:
                worn.setdefault(slot.material.name_full, set()).add(source.lightgroup)
    for material in bpy.data.materials:
        # What glows is told apart by its material: one on objects of several groups belongs to none.
        names = worn.get(material.name_full, set())
        own = next(iter(names)) if len(names) == 1 else ""
        name = material.lumenray.light_group.strip() or own
        found[identity.identity_of(material)] = name
    return found


def _free_name(wanted: str, taken) -> str:
    name, number = wanted, 1
    while name in taken or name == REST:
        number += 1
        name = f"{wanted} ({number})"
    return name
