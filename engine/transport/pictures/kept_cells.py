"""Cells that are kept from picture to picture: by what is seen of a scene, and by what shines in it.

How surfaces are divided depends on objects and on what is seen, the light on everything. So pictures of a scene that has not
changed, its frames and a view of it use both again, an edit of a light finds the light anew from what it was, and an edit of
an object begins anew.
"""

import hashlib
from dataclasses import dataclass, replace

import numpy as np

from ..compiled.changes import Stamps
from ..paths.visible_surfaces import Sight
from .view_cells import CellLight, Division, ViewCells

CELLS_PER_PIXEL = 1.0 / 64.0
FEWEST_CELLS, MOST_CELLS = 3_000, 60_000
"""How many cells there are: as many as serve the pixels, within bounds."""

LOOKS, FEWEST_LOOKS = 4, 1 << 15
"""Rays for every cell that find which surfaces matter, and the fewest of all."""

UNKNOWN = 0.03
"""Share of the looks of another view that may meet sides of cells without light: paths go on there, which takes longer."""

OUTDATED = Stamps(-1, -1, -1)
"""State of no scene."""

MOST_BYTES = 1 << 28
"""Memory for kept light; beyond that the oldest is dropped. [byte]"""

NOTE = (
    "cells were kept from before in this session, whose error is common to pictures that share them; "
    "rendered alone, the picture would differ within its error"
)
"""Of pictures that a fresh start would not give bit for bit."""


@dataclass(frozen=True, eq=False)
class _Kept:
    """Light that was found.

    ``job``: of which picture; ``view``: digest of what the picture sees and of its seed, where a fresh start would have
    found the very same, else None.
    """

    light: CellLight
    job: int
    view: bytes | None


class KeptCells:
    """Cells of one compiled scene at a time. Owned by a session, which clears it when it drops the scene."""

    def __init__(self):
        self._job = 0
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._scene = self._division = None
        self._origin: tuple[int, bytes] | None = None
        self._lights: dict[frozenset[str] | None, _Kept] = {}

    def begin(self) -> None:
        """Take note that another picture begins. What is made for it is its own."""
        self._job += 1

    def open(
        self,
        scene,
        places,
        normals,
        pixels: int,
        seed: int,
        samples: float | None = None,
        cancelled=lambda: False,
    ) -> ViewCells:
        """Give cells for a picture, whose light is to be prepared.

        Parameters
        ----------
        scene : CompiledScene    With its lights over bends, if there are any.
        places, normals : (n, 3) array    What the camera sees, in the scene's frame. [m]
        pixels : int
        seed : int
        samples : float or None    Of the picture, where their number is known.
        cancelled : callable    Asked before every launch.
        """
        if scene is not self._scene:
            self.clear()
            self._scene = scene
        wanted = int(np.clip(pixels * CELLS_PER_PIXEL, FEWEST_CELLS, MOST_CELLS))
        rays = max(LOOKS * wanted, FEWEST_LOOKS)
        rows = np.random.default_rng([seed & 0xFFFFFFFF, 6]).integers(0, len(places), rays)
        sight = Sight(scene, places[rows], normals[rows], seed)
        is_traced = scene.bent is not None or scene.near is not None
        view = _digest(places, normals, wanted, seed, samples, is_traced)
        self._divide(scene, sight, wanted, view)
        return self._lit(scene, seed, view, is_traced, samples, cancelled)

    # ---- private ----

    def _divide(self, scene, sight: Sight, wanted: int, view: bytes) -> None:
        """Have a division that serves; drop what light does not."""
        if self._division is None or not self._division.serves(scene, sight, wanted):
            self._lights.clear()
            self._division = Division(scene, sight, wanted)
            self._origin = self._job, view
        elif self._division.look(sight, UNKNOWN):
            # Some sides have no light yet, so all is to be found anew from what there is.
            self._origin = self._job, b""
            self._lights = {
                key: replace(kept, light=replace(kept.light, stamps=OUTDATED), view=None)
                for key, kept in self._lights.items()
            }

    def _lit(self, scene, seed: int, view: bytes, is_traced, samples, cancelled) -> ViewCells:
        """Cells with the light that there is."""
        key = scene.shining
        kept = self._lights.get(key)
        is_stale = kept is not None and kept.light.stamps != scene.stamps
        is_same = kept is not None and not is_stale and kept.view == view
        if is_traced and not is_same:
            # What is traced instead depends on the view.
            kept, is_stale = None, False
        is_fresh = self._origin[1] == view and (is_same or kept is None)

        def keep(light: CellLight) -> None:
            self._lights.pop(key, None)
            self._lights[key] = _Kept(light, self._job, view if is_fresh else None)
            while len(self._lights) > 1 and self._bytes() > MOST_BYTES:
                del self._lights[next(iter(self._lights))]

        cells = ViewCells(
            scene,
            self._division,
            seed,
            cancelled,
            None if kept is None else kept.light,
            is_stale,
            keep,
            samples,
        )
        is_own = self._origin[0] == self._job and (kept is None or kept.job == self._job)
        if not (is_fresh or is_own):
            cells.notes = (NOTE,)
        return cells

    def _bytes(self) -> int:
        return sum(kept.light.bytes for kept in self._lights.values())


def _digest(places, normals, *more) -> bytes:
    """Name what the camera sees and what else decides how cells are found."""
    made = hashlib.sha256(repr(more).encode())
    for array in (places, normals):
        made.update(np.ascontiguousarray(array).tobytes())
    return made.digest()
