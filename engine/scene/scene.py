"""The scene as a set of items with ids, the delta that changes it, and the hash that names its state."""

import hashlib
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum

import numpy as np

from ..errors import SceneError
from .checks import check_item
from .light import CieSky, CloudySky, ImageWorld, Light, PerezSky, UniformWorld, World
from .material import Material
from .memo import recall
from .mesh import Geometry, Mesh, Placement, place
from .modelling import Modelling
from .sensor import SensorSet
from .texture import Pixels, replace_pixels

Item = Geometry | Placement | Mesh | Material | Light | World | SensorSet | Pixels | Modelling

LARGE = 1 << 16
"""Arrays from this size on have a digest of their own, which is kept with them. [byte]"""


@dataclass(frozen=True)
class Attachment:
    """Data that a user puts on an item on the engine's side: ``values`` replace the item's own fields of those names.

    It belongs to the id, so it stays when the host sends the item anew or takes it away and brings it back, and copies of
    the item get it too. Empty values take it off.
    """

    id: str
    values: dict[str, object]


@dataclass(frozen=True)
class SceneDelta:
    """A change.

    Parameters
    ----------
    changed : tuple of Item    Items that are new or different.
    removed : tuple of str    Ids that are gone.
    copies : tuple of (str, str)    Ids that are copies of others: (new, original). They inherit attachments.
    attached : tuple of Attachment
    """

    changed: tuple[Item, ...] = ()
    removed: tuple[str, ...] = ()
    copies: tuple[tuple[str, str], ...] = ()
    attached: tuple[Attachment, ...] = ()

    def __bool__(self) -> bool:
        """Whether it changes anything."""
        return bool(self.changed or self.removed or self.copies or self.attached)


@dataclass
class Scene:
    """All items by id. Objects refer to geometries and materials by id; a missing one is an error at compile time.

    So is a number that is not finite: ``faults`` says what is wrong with which item. The rest of its delta counts all the
    same, so that nothing is missing once the item is put right. ``given`` holds items with attachments as the host sent
    them; the tables hold them as they count. ``pixels`` holds
    what later pictures may name by its id; the pictures in the tables have the arrays themselves.
    """

    geometries: dict[str, Geometry] = field(default_factory=dict)
    meshes: dict[str, Mesh | Placement] = field(default_factory=dict)
    materials: dict[str, Material] = field(default_factory=dict)
    lights: dict[str, Light] = field(default_factory=dict)
    sensors: dict[str, SensorSet] = field(default_factory=dict)
    world: World | None = None
    modelling: Modelling = Modelling()
    pixels: dict[str, Pixels] = field(default_factory=dict)
    attachments: dict[str, Attachment] = field(default_factory=dict)
    given: dict[str, Item] = field(default_factory=dict)
    faults: dict[str, tuple[Item, str]] = field(default_factory=dict, repr=False)
    _digests: dict[str, tuple[object, bytes]] = field(default_factory=dict, repr=False)

    def apply(self, delta: SceneDelta) -> None:
        """Bring the scene to the state after ``delta``.

        Raises
        ------
        SceneError    An attachment names a field that the item does not have, or a picture names pixels that are not
            there; the scene is as before.
        """
        pixels = dict(self.pixels)
        for item in delta.changed:
            if isinstance(item, Pixels):
                # Equal ids have equal values, and everything that was made of the first ones stays of use.
                pixels.setdefault(item.id, item)
        changed = [
            _with_pixels(item, item.id, pixels)
            for item in delta.changed
            if not isinstance(item, Pixels)
        ]
        attachments = dict(self.attachments)
        for new, original in delta.copies:
            if original in attachments and new not in attachments:
                attachments[new] = replace(attachments[original], id=new)
        for attachment in delta.attached:
            attachments[attachment.id] = _with_pixels(attachment, attachment.id, pixels)
        # What is attached to changes with its attachment, although the host has not sent it.
        sent = {item.id for item in changed}
        for key in {a.id for a in delta.attached} - sent:
            item = self.given.get(key) or self._find(key)
            if item is not None:
                changed.append(item)
        counted = [_with_attachment(item, attachments.get(item.id)) for item in changed]
        renewed = {item.id for item in delta.changed}
        for gone in delta.removed:
            self._drop(gone)
            if gone not in renewed:
                pixels.pop(gone, None)
        self.pixels = pixels
        for item, given in zip(counted, changed, strict=True):
            self._put(item)
            if item is not given:
                self.given[item.id] = given
            else:
                self.given.pop(item.id, None)
        self.attachments = {key: a for key, a in attachments.items() if a.values}

    def snapshot(self) -> SceneDelta:
        """Return the delta that makes this scene of an empty one, its items in the order in which they stand."""
        tables = (
            self.pixels,
            self.geometries,
            self.materials,
            self.meshes,
            self.lights,
            self.sensors,
        )
        items = [self.given.get(key, item) for table in tables for key, item in table.items()]
        if self.world is not None:
            items.append(self.given.get(self.world.id, self.world))
        attached = tuple(self.attachments.values())
        return SceneDelta(changed=(*items, self.modelling), attached=attached)

    def check(self) -> None:
        """Refuse to go on while an item holds a number that is not finite.

        Raises
        ------
        SceneError    Names the item, the field and the value.
        """
        for key, (item, fault) in self.faults.items():
            if self._find(key) is item:
                raise SceneError(fault)

    def mesh(self, key: str) -> Mesh:
        """Return an object's triangles in the world.

        Raises
        ------
        SceneError    There is no such object, or its geometry is missing.
        """
        item = self.meshes.get(key)
        if item is None:
            raise SceneError(f"the scene holds no object with the id {key}")
        if isinstance(item, Mesh):
            return item
        geometry = self.geometries.get(item.geometry)
        if geometry is None:
            raise SceneError(
                f"object '{item.name}' refers to a geometry that the scene does not hold ({item.geometry})"
            )
        return place(geometry, item)

    def with_items(self, changes: dict[str, object]) -> "Scene":
        """Return a scene with other items in place of this one's, by id; None: left out. This one stays as it is."""
        tables = ("geometries", "meshes", "materials", "lights")
        made = {name: dict(getattr(self, name)) for name in tables}
        world = self.world
        for key, item in changes.items():
            if world is not None and key == world.id:
                world = item
            for table in made.values():
                if key in table:
                    table.pop(key)
                    if item is not None:
                        table[key] = item
        return replace(self, **made, world=world)

    def hash(self) -> str:
        """Return a hexadecimal SHA-256 of all content that can change a result.

        Ids and names do not count, nor does the order of the items.
        """
        materials = {key: self._digest(item) for key, item in self.materials.items()}
        geometries = {key: self._digest(item) for key, item in self.geometries.items()}
        parts = []
        for item in self.meshes.values():
            part = hashlib.sha256(self._digest(item))
            for key in item.materials:
                part.update(materials.get(key, b"?"))
            if isinstance(item, Placement):
                part.update(geometries.get(item.geometry, b"?"))
            parts.append(part.digest())
        shining = (item for item in self.lights.values() if item.output.value > 0.0)
        parts += [self._digest(item) for item in shining]
        digest = hashlib.sha256(b"".join(sorted(parts)))
        if self.world is not None:
            digest.update(self._digest(self.world))
        if self.modelling != Modelling():
            digest.update(content_digest(self.modelling))
        return digest.hexdigest()

    def digests(self) -> dict[str, str]:
        """Fingerprints of the items that make light or are lit, by name; items of one name have one together."""
        found: dict[str, list[str]] = {}
        tables = (self.meshes, self.materials, self.lights)
        items = [item for table in tables for item in table.values()]
        for item in items if self.world is None else [*items, self.world]:
            part = hashlib.sha256(self._digest(item))
            if isinstance(item, Placement) and item.geometry in self.geometries:
                part.update(self._digest(self.geometries[item.geometry]))
            part.update(repr(getattr(item, "materials", ())).encode())
            found.setdefault(getattr(item, "name", "") or item.id, []).append(part.hexdigest()[:16])
        return {name: "".join(sorted(parts)[:8]) for name, parts in found.items()}

    def _digest(self, item) -> bytes:
        """SHA-256 of an item's content; kept, because meshes are large."""
        known = self._digests.get(item.id)
        if known is None or known[0] is not item:
            known = (item, content_digest(item))
            self._digests[item.id] = known
        return known[1]

    def _tables(self):
        return (self.geometries, self.meshes, self.materials, self.lights, self.sensors)

    def _find(self, key: str):
        for table in self._tables():
            if key in table:
                return table[key]
        single = (each for each in (self.world, self.modelling) if each is not None)
        return next((each for each in single if each.id == key), None)

    def _drop(self, gone: str) -> None:
        for table in self._tables():
            table.pop(gone, None)
        self._digests.pop(gone, None)
        self.given.pop(gone, None)
        self.faults.pop(gone, None)
        if self.world is not None and self.world.id == gone:
            self.world = None
        if self.modelling.id == gone:
            self.modelling = Modelling()

    def _put(self, item) -> None:
        known = self._digests.get(item.id)
        if known is not None and known[0] is not item:
            # It would keep the old item's arrays alive.
            del self._digests[item.id]
        self.faults.pop(item.id, None)
        try:
            check_item(item)
        except SceneError as fault:
            self.faults[item.id] = (item, str(fault))
        match item:
            case Geometry():
                self.geometries[item.id] = item
            case Mesh() | Placement():
                self.meshes[item.id] = item
            case Material():
                self.materials[item.id] = item
            case UniformWorld() | ImageWorld() | CieSky() | CloudySky() | PerezSky():
                self.world = item
            case SensorSet():
                self.sensors[item.id] = item
            case Modelling():
                self.modelling = item
            case _:
                self.lights[item.id] = item


def _with_attachment(item, attachment: Attachment | None):
    """Return an item as it counts."""
    if attachment is None or not attachment.values:
        return item
    known = {entry.name for entry in fields(item)} - {"id"}
    for name in attachment.values:
        if name not in known:
            raise SceneError(
                f"'{name}' cannot be attached to {item.id}: a {type(item).__name__} has {', '.join(sorted(known))}"
            )
    return replace(item, **attachment.values)


def _with_pixels(item, owner: str, table: dict[str, Pixels]):
    """Return an item whose pictures have their pixels themselves."""

    def find(pixels):
        if not isinstance(pixels, str):
            return pixels
        if pixels not in table:
            raise SceneError(
                f"a picture of {owner} refers to pixels that the scene does not hold ({pixels})"
            )
        return table[pixels].values

    return replace_pixels(item, find)


def content_digest(item) -> bytes:
    """SHA-256 of what an item says, without its identity: ids, names and references by id are left out."""
    digest = hashlib.sha256(type(item).__name__.encode())
    for entry in fields(item):
        if entry.name not in {"id", "name", "materials", "geometry"}:
            digest.update(entry.name.encode())
            _feed(digest, getattr(item, entry.name))
    return digest.digest()


def array_digest(array: np.ndarray) -> bytes:
    """SHA-256 of an array's numbers, their kind and the shape."""
    return recall(array, "digest", _digest_of)


def _digest_of(array: np.ndarray) -> bytes:
    digest = hashlib.sha256(f"array{array.shape}{array.dtype.str}".encode())
    digest.update(np.ascontiguousarray(array).data)
    return digest.digest()


def _feed(digest, value) -> None:
    """Feed a value into the digest, tagged by type and shape so that neighbours cannot run together."""
    if isinstance(value, np.ndarray):
        if value.nbytes >= LARGE:
            digest.update(b"digest" + array_digest(value))
            return
        digest.update(f"array{value.shape}{value.dtype.str}".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif is_dataclass(value):
        digest.update(type(value).__name__.encode())
        for entry in fields(value):
            digest.update(entry.name.encode())
            _feed(digest, getattr(value, entry.name))
    elif isinstance(value, dict):
        for key in value:
            _feed(digest, key)
            _feed(digest, value[key])
    elif isinstance(value, tuple | list):
        digest.update(f"sequence{len(value)}".encode())
        for entry in value:
            _feed(digest, entry)
    elif isinstance(value, Enum):
        digest.update(value.name.encode())
    else:
        digest.update(repr(value).encode() + b";")
