"""The geometries that the engine has, and which of them may be out of date."""

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np

from ....engine.scene.mesh import Geometry
from ...foundation.report import ConversionReport
from ..displacement import Displacement
from ..meshes import fingerprint, read_geometry
from ..surfaces import Surface, read_surface


@dataclass
class _Entry:
    """What is known of one geometry.

    ``fingerprint`` 0: it has no face and was not sent; ``corners`` of its box, (8, 3); ``note``: what is to be told of it;
    ``cause``: what it was displaced by, and ``report``: what is to be told of that;
    ``uv_bounds``: least and largest coordinates by UV map, the default one first; ``surface``: what materials that are made
    for it asked for; ``slots``: those whose charts it was sent with, ``is_unlaid``: unless it changed since.
    """

    owner: int
    fingerprint: int = 0
    is_stale: bool = True
    corners: np.ndarray | None = None
    note: str = ""
    cause: tuple = ()
    report: ConversionReport | None = None
    uv_bounds: dict[str, tuple] = field(default_factory=dict)
    surface: Surface | None = None
    slots: frozenset = frozenset()
    is_unlaid: bool = False


class GeometryTable:
    """Geometries by id. An owner, by session uid, is the object or the data whose edits change a geometry."""

    def __init__(self):
        self.changed: list[Geometry] = []
        self.removed: list[str] = []
        self.reshaped = 0
        self._entries: dict[str, _Entry] = {}
        self._of_owner: dict[int, set[str]] = {}

    def mark(self, owners: set[int]) -> None:
        """Note that the geometries of these owners may be out of date."""
        for owner in owners & self._of_owner.keys():
            for key in self._of_owner[owner]:
                self._entries[key].is_stale = True

    def take(
        self,
        key: str,
        owner: int,
        source,
        read: Callable | None = None,
        displacement: Displacement | None = None,
        cause=(),
    ) -> str | None:
        """Return the id of an object's geometry, read anew where needed; None when it has no face.

        Parameters
        ----------
        key : str
        owner : int
        source : bpy.types.Object    Evaluated.
        read : callable or None    As `hair.read_points`; None: as a mesh.
        displacement : Displacement or None    What moves the vertices of a mesh.
        cause : tuple    What that follows from: where it differs from before, it is applied anew.
        """
        entry = self._entries.get(key)
        if entry is None:
            entry = self._entries[key] = _Entry(owner)
            self._of_owner.setdefault(owner, set()).add(key)
        if entry.is_stale or entry.cause != cause:
            entry.cause = cause
            self._update(key, entry, source, read, displacement)
        return key if entry.fingerprint else None

    def note(self, key: str) -> str:
        """Return what is to be told of a geometry; empty if nothing is."""
        return self._entries[key].note

    def report(self, key: str) -> ConversionReport | None:
        """Return what is to be told of how a geometry was displaced; None: nothing."""
        return self._entries[key].report

    def corners(self, key: str) -> np.ndarray:
        """Return the corners of the box about a geometry that has faces, in its own frame. (8, 3)"""
        return self._entries[key].corners

    def uv_bounds(self, key: str) -> dict[str, tuple]:
        """Return the least and the largest coordinate of a geometry's UV maps, the default one first."""
        return self._entries[key].uv_bounds

    def surface(self, key: str, source, displacement: Displacement | None = None) -> Surface:
        """Return what materials may ask of a geometry that has faces; it is kept as long as one of them does.

        It is another object when anything of it has changed. Parameters as of `take`.
        """
        entry = self._entries[key]
        if entry.surface is None:
            # What is to be told of the displacement was when the geometry was taken.
            change = _change_by(displacement, ConversionReport())
            entry.surface = read_surface(source, key, change)
        return entry.surface

    def lay_out(self, wanted: dict[str, set]) -> None:
        """Send geometries with the charts of those slots that need them, and without those of others.

        Parameters
        ----------
        wanted : dict    Slots, (slot, whether it is the last), by geometries; of those that are not shown nothing changes.
        """
        for key, entry in self._entries.items():
            slots = frozenset(wanted.get(key, ()))
            is_current = slots == entry.slots and not entry.is_unlaid
            if entry.surface is None or is_current or key not in wanted:
                continue
            entry.slots, entry.is_unlaid = slots, False
            self.changed = [made for made in self.changed if made.id != key]
            self.changed.append(entry.surface.with_charts(slots))
            if not slots:
                entry.surface = None

    def take_made(self, geometry: Geometry) -> str:
        """Return the id of a geometry that no data of Blender's states and that never changes."""
        if geometry.id not in self._entries:
            self._entries[geometry.id] = _Entry(
                0, fingerprint(geometry), False, _corners_of(geometry)
            )
            self._of_owner.setdefault(0, set()).add(geometry.id)
            self.changed.append(geometry)
        return geometry.id

    def sweep(self, used: set[str], shown: set[int]) -> None:
        """Give up geometries that nothing shows, but keep those of objects that are only hidden.

        Parameters
        ----------
        used : set of str    Geometries that are shown.
        shown : set of int    Objects of which something is shown.
        """
        unused = self._entries.keys() - used
        if not unused:
            return
        alive = {
            block.session_uid
            for blocks in (bpy.data.objects, bpy.data.meshes)
            for block in blocks
            if block.users
        }
        for key in unused:
            entry = self._entries[key]
            if entry.owner in alive and entry.owner not in shown:
                continue
            if entry.fingerprint:
                self.removed.append(key)
            del self._entries[key]
            self._of_owner[entry.owner].discard(key)

    def flush(self) -> tuple[list[Geometry], list[str]]:
        """Hand over what changed and what was removed since the last time."""
        made, gone = self.changed, self.removed
        self.changed, self.removed, self.reshaped = [], [], 0
        return made, gone

    def __iter__(self):
        """Ids of the geometries that the engine has."""
        return (key for key, entry in self._entries.items() if entry.fingerprint)

    def _update(self, key, entry, source, read, displacement) -> None:
        surface, entry.note = None, ""
        entry.report = None if displacement is None else ConversionReport()
        change = _change_by(displacement, entry.report)
        if read is not None:
            geometry, entry.note = read(source, key)
        else:
            surface = None if entry.surface is None else read_surface(source, key, change)
            geometry = read_geometry(source, key, change) if surface is None else surface.geometry
        entry.is_stale, before = False, entry.fingerprint
        entry.fingerprint = fingerprint(geometry)
        if entry.fingerprint == before:
            if surface is not None and not surface.is_same(entry.surface):
                entry.surface = surface
            return
        entry.surface, entry.is_unlaid = surface, surface is not None
        self.reshaped += bool(before)
        entry.corners = None if geometry is None else _corners_of(geometry)
        entry.uv_bounds = {} if geometry is None else _bounds_of(geometry)
        if geometry is None or not np.isfinite(entry.corners).all():
            # What has a corner nowhere is left out by whoever shows it.
            self.removed.append(key)
        else:
            self.changed.append(geometry)


def _change_by(displacement: Displacement | None, report: ConversionReport | None):
    """What a displacement makes of a geometry that is read, as of `read_geometry`; None: nothing."""
    if displacement is None:
        return None
    return lambda made, mesh: displacement.apply(made, mesh, report)


def _bounds_of(geometry: Geometry) -> dict[str, tuple]:
    return {
        name: (float(uv.min()), float(uv.max())) for name, uv in geometry.uv_maps.items() if uv.size
    }


def _corners_of(geometry: Geometry) -> np.ndarray:
    box = np.stack([geometry.vertices.min(axis=0), geometry.vertices.max(axis=0)])
    return np.stack(np.meshgrid(*box.T.astype(np.float64)), axis=-1).reshape(-1, 3)
