"""The scene as a set of items with ids, the delta that changes it, and the hash that names its state."""

import hashlib
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum

import numpy as np

from .light import ImageWorld, Light, UniformWorld, World
from .material import Material
from .mesh import Mesh

Item = Mesh | Material | Light | World


@dataclass(frozen=True)
class SceneDelta:
    """A change: items that are new or different, and ids that are gone."""

    changed: tuple[Item, ...] = ()
    removed: tuple[str, ...] = ()


@dataclass
class Scene:
    """All items by id. Meshes refer to materials by id; a missing material is an error at compile time."""

    meshes: dict[str, Mesh] = field(default_factory=dict)
    materials: dict[str, Material] = field(default_factory=dict)
    lights: dict[str, Light] = field(default_factory=dict)
    world: World | None = None

    def apply(self, delta: SceneDelta) -> None:
        """Bring the scene to the state after ``delta``."""
        for gone in delta.removed:
            for table in (self.meshes, self.materials, self.lights):
                table.pop(gone, None)
            if self.world is not None and self.world.id == gone:
                self.world = None
        for item in delta.changed:
            if isinstance(item, Mesh):
                self.meshes[item.id] = item
            elif isinstance(item, Material):
                self.materials[item.id] = item
            elif isinstance(item, UniformWorld | ImageWorld):
                self.world = item
            else:
                self.lights[item.id] = item

    def hash(self) -> str:
        """Return a hexadecimal SHA-256 of all content that can change a result, whatever the order of the items."""
        digest = hashlib.sha256()
        for table in (self.meshes, self.materials, self.lights):
            for key in sorted(table):
                _feed(digest, table[key])
        _feed(digest, self.world)
        return digest.hexdigest()


def _feed(digest, value) -> None:
    """Feed a value into the digest, tagged by type and shape so that neighbours cannot run together."""
    if isinstance(value, np.ndarray):
        digest.update(f"array{value.shape}{value.dtype.str}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
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
