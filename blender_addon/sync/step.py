"""What one walk over the scene yields, and how it is handed on in pieces."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace

import numpy as np

from ...engine.scene.material import Material
from ...engine.scene.mesh import Geometry, Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.scene.texture import Pixels
from ..foundation.report import ConversionReport

PART_BYTES = 1 << 26
"""Most bytes of arrays that are handed on at once, so that neither side holds a large scene twice."""


@dataclass(frozen=True)
class SyncStats:
    """What a walk did.

    Parameters
    ----------
    walk_seconds : float    Time of the walk, reading of changed data included.
    visited : int    Instances that were looked at.
    sent : dict of str to int    Number of items by kind: picture, geometry, object, material, light, world, modelling.
    removed : int    Number of items that are gone.
    changed : str    For people: what changed; empty if nothing did.
    remade : int    Materials that are others, those aside whose pictures only follow where objects stand.
    """

    walk_seconds: float = 0.0
    visited: int = 0
    sent: dict[str, int] = field(default_factory=dict)
    removed: int = 0
    changed: str = ""
    remade: int = 0


@dataclass(frozen=True)
class SyncStep:
    """A change of the engine's scene, the complete report of the conversion as it stands, and what was done."""

    delta: SceneDelta
    report: ConversionReport
    stats: SyncStats

    def parts(self, limit: int) -> Iterator[SceneDelta]:
        """Yield the delta in pieces of at most ``limit`` bytes of arrays, as `split` does."""
        return split(self.delta, limit)


def split(delta: SceneDelta, limit: int) -> Iterator[SceneDelta]:
    """Yield pieces of a delta, to be applied in order.

    Pictures come first, then geometries, then materials, then what uses them; removals come with the last piece, so that
    nothing shown lacks what it refers to.

    Parameters
    ----------
    limit : int    Most bytes of arrays in one piece; a single item that is larger is a piece of its own.
    """
    part, size, copies = [], 0, delta.copies
    for item in sorted(delta.changed, key=_rank):
        own = array_bytes(item)
        if part and size + own > limit:
            yield SceneDelta(changed=tuple(part), copies=copies)
            part, size, copies = [], 0, ()
        part.append(item)
        size += own
    yield replace(delta, changed=tuple(part), copies=copies)


def array_bytes(value) -> int:
    """Return the bytes of all arrays inside an item."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, dict):
        return sum(array_bytes(entry) for entry in value.values())
    if isinstance(value, tuple | list):
        return sum(array_bytes(entry) for entry in value)
    if is_dataclass(value):
        return sum(array_bytes(getattr(value, entry.name)) for entry in fields(value))
    return 0


def _rank(item) -> int:
    for rank, kind in enumerate((Pixels, Geometry | Mesh, Material)):
        if isinstance(item, kind):
            return rank
    return 3
