"""What an object's materials ask of it, read from Blender."""

import hashlib
from dataclasses import dataclass

import numpy as np

from ..foundation.identity import members
from .instance_attributes import InstanceAttributes
from .nodes import needs
from .nodes.placed import Subject
from .nodes.procedural.hashing import hash_integers
from .surfaces import Surface

SPAN = float(np.float32(1.0) / np.float32(0xFFFFFFFF))
"""What makes a number between 0 and 1 of an object's random one of 32 bits. [-]"""

REPEATED = 1e-4
"""How far a UV map may reach beyond its first tile before what is drawn for that tile alone is not enough. [tile]"""


@dataclass(frozen=True, eq=False)
class Place:
    """One slot of an object whose material asks for it.

    Parameters
    ----------
    key : str    Of the material that is made for it; the same for all that would get the same one.
    subject : Subject
    surface : Surface or None    None where pictures lie by UV maps as ever.
    slot : int
    is_last : bool    Whether it is the last slot.
    is_optional : bool    Whether a tile that repeats can take the place of pictures for the surface.
    """

    key: str
    subject: Subject
    surface: Surface | None = None
    slot: int = 0
    is_last: bool = True
    is_optional: bool = False

    def state(self) -> tuple:
        """Return what a material for it follows from, to be compared; the surface by its identity."""
        matrix = self.subject.matrix.tobytes()
        return id(self.surface), matrix, tuple(sorted(self.subject.values.items(), key=repr))


def wants_surface(asked: frozenset, uv_bounds: dict[str, tuple]) -> bool:
    """Whether needs make pictures for a surface of its own necessary.

    Parameters
    ----------
    asked : frozenset of tuple    As of `needs`.
    uv_bounds : dict    Least and largest coordinates of the geometry's UV maps, the default one first.
    """
    if needs.SURFACE in asked:
        return True
    for need in asked:
        if need[0] == needs.TILE:
            name = need[1] if need[1] in uv_bounds else next(iter(uv_bounds), "")
            low, high = uv_bounds.get(name, (0.0, 1.0))
            if low < -REPEATED or high > 1.0 + REPEATED:
                return True
    return False


def place_key(material: str, asked: frozenset, shown_key: str, geometry: str, slot, values) -> str:
    """Return the id of a material for one object, or for all objects that it would be the same for.

    Parameters
    ----------
    material : str    Id of the material for all objects.
    asked : frozenset of tuple
    shown_key, geometry : str    Ids of the object and of its geometry, that one empty where the surface does not count.
    slot : int
    values : dict    As of `Subject`.
    """
    own = shown_key if needs.PLACE in asked else ""
    where = (geometry, slot) if geometry else ()
    told = sorted((need, value) for need, value in values.items() if need[0] != needs.FRAME)
    digest = hashlib.blake2s(repr((own, where, told)).encode(), digest_size=8).hexdigest()
    kind, _, identity = material.partition(":")
    return f"{kind}:{digest}/{identity}"


def read_values(
    asked: frozenset, instance, source, parent, depsgraph, attributes: InstanceAttributes
) -> dict[tuple, tuple]:
    """Return what needs of an instance come to; what is not known is left out.

    Parameters
    ----------
    asked : frozenset of tuple
    instance : bpy.types.DepsgraphObjectInstance
    source : bpy.types.Object    Evaluated.
    parent : bpy.types.Object or None    What makes the instance.
    depsgraph : bpy.types.Depsgraph
    attributes : InstanceAttributes    Of this walk.
    """
    found = {}
    for need in asked:
        if need[0] == needs.VALUE:
            value = _value(need[1], instance, source)
        elif need[0] == needs.ATTRIBUTE:
            value = _attribute(need, instance, source, parent, depsgraph, attributes)
        elif need[0] == needs.FRAME:
            value = _matrix_from_world(need[1], depsgraph)
        else:
            continue
        if value is not None:
            found[need] = value
    return found


def _value(name: str, instance, source) -> tuple | None:
    if name == "colour":
        return tuple(source.color[:3])
    if name == "alpha":
        return (source.color[3],)
    if name == "index":
        return (float(source.pass_index),)
    if name == "random":
        number = instance.random_id if instance.is_instance else _number_of_name(source.name)
        return ((number & 0xFFFFFFFF) * SPAN,)
    if name == "instance generated":
        is_made = instance.is_instance
        return tuple(0.5 * each - 0.5 for each in instance.orco) if is_made else (0.0, 0.0, 0.0)
    if name == "instance uv":
        return (*instance.uv, 0.0) if instance.is_instance else (0.0, 0.0, 0.0)
    return None


def _number_of_name(name: str) -> int:
    """Return the random number that Cycles gives an object by its name; instances have theirs from Blender."""
    number = 0
    for letter in name.encode():
        number = (37 * number + letter) & 0xFFFFFFFF
    return int(hash_integers(number, 0))


def _attribute(need, instance, source, parent, depsgraph, attributes) -> tuple | None:
    """Return a property that an Attribute node names; None: it is not known."""
    _, kind, name = need
    owners = [source, source.data]
    if kind == "VIEW_LAYER":
        scene = depsgraph.scene
        owners = [depsgraph.view_layer, scene, scene.world]
    elif kind == "INSTANCER" and parent is not None:
        try:
            value = attributes.find(name, instance, parent)
        except LookupError:
            return None
        if value is not None:
            return value
        owners = [parent, parent.data, *owners]
    return _property(name, owners)


def _property(name: str, owners) -> tuple | None:
    """Return a property of the first owner that has it, custom ones first; four channels, 0 if none has it."""
    for owner in owners:
        if owner is None:
            continue
        value = owner.get(name)
        if value is None:
            try:
                value = owner.path_resolve(name)
            except ValueError:
                continue
        numbers = _numbers(value)
        if numbers is not None:
            return numbers
    return (0.0, 0.0, 0.0, 0.0)


def _numbers(value) -> tuple | None:
    if isinstance(value, bool | int | float):
        return (float(value),) * 3 + (1.0,)
    try:
        numbers = [float(each) for each in value]
    except (TypeError, ValueError):
        return None
    if not numbers:
        return None
    return tuple((numbers + [0.0, 0.0, 0.0, 1.0][len(numbers) :])[:4])


def _matrix_from_world(session_uid: int, depsgraph) -> tuple | None:
    blocks = members("objects", depsgraph)
    block = next((each for each in blocks if each.session_uid == session_uid), None)
    if block is None:
        return None
    matrix = np.array(block.evaluated_get(depsgraph).matrix_world, np.float64)
    if abs(np.linalg.det(matrix)) < 1e-30:
        return None
    return tuple(np.linalg.inv(matrix).ravel())
