"""Places on lumels, span by span: collected on the host, kept on the device, chosen from in kernels."""

from concurrent.futures import Future, ThreadPoolExecutor

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ..paths import gather
from .path_guiding import Aims
from .tiles import tile_numbers

SPAN_PLACES, KEPT_SPANS = 1 << 21, 2
"""Places of lumels that are worked on together, and how many such lots stay on the device."""


class LumelPlaces:
    """Places on the lumels of a table.

    Parameters
    ----------
    scene : CompiledScene
    table : LumelTable
    counts : (b,) int array    Places of its blocks.
    missed : (n,) bool array or None    Lumels that ask for light over bends; None: nothing is said of it.

    Attributes
    ----------
    spans : list of slice    Lumels that are worked on together: those of as many blocks as their places fit.
    aims : dict    Where rays go, by the first lumel of a span; empty while they go by the cosine law.
    """

    def __init__(self, scene, table, counts: np.ndarray, missed: np.ndarray | None):
        self.scene, self.table, self._missed = scene, table, missed
        self._first = np.concatenate([[0], np.cumsum(table.counts)]).astype(np.int64)
        self.spans = self._find_spans(counts)
        self.aims: dict[int, np.ndarray] = {}
        self._uploaded: dict[int, dict] = {}
        self._collector = ThreadPoolExecutor(1)
        self._coming: tuple[int, Future | None] = (-1, None)

    def set_aims(self, aims: dict[int, np.ndarray]) -> None:
        """Aim rays so from now on."""
        if aims is not self.aims:
            self.aims, self._uploaded = aims, {}

    def tiles(self, span: slice) -> np.ndarray:
        """Number of the tile of every lumel of a span, from 0 on. (k,)"""
        made, count = [], 0
        inside = (self._first[:-1] >= span.start) & (self._first[:-1] < span.stop)
        for number in np.flatnonzero(inside):
            own = tile_numbers(self.table.facts(int(number)), self.table.width(int(number)))
            made.append(own + count)
            count += int(own.max(initial=-1)) + 1
        return np.concatenate(made)

    def upload(self, span: slice) -> dict:
        """Places of a span on the device; those of a few spans are kept."""
        if span.start not in self._uploaded:
            if len(self._uploaded) >= KEPT_SPANS:
                self._uploaded.pop(next(iter(self._uploaded)))
            arrays, boxes = self._collected(span), self.table.boxes
            self._uploaded[span.start] = {
                "p": [upload(mi.Float, arrays["p"][:, i]) for i in range(3)],
                "n": [upload(mi.Float, arrays["n"][:, i]) for i in range(3)],
                "g": [upload(mi.Float, arrays["g"][:, i]) for i in range(3)],
                "start": upload(mi.UInt32, arrays["start"]),
                "count": upload(mi.UInt32, arrays["count"]),
                "box": upload(mi.UInt32, arrays["box"]),
                "right": [upload(mi.Float, arrays["steps"][:, 0, i]) for i in range(3)],
                "up": [upload(mi.Float, arrays["steps"][:, 1, i]) for i in range(3)],
                "corners": [upload(mi.Float, boxes.corners[:, i]) for i in range(2)],
                "points": [upload(mi.Float, boxes.points[:, i]) for i in range(2)],
                "size": [dr.opaque(mi.Float, float(side)) for side in boxes.size],
            }
            if self.aims:
                self._uploaded[span.start] |= {
                    "aims": Aims(self.aims[span.start]),
                    "tile": upload(mi.UInt32, self.tiles(span)),
                }
            if self._missed is not None:
                self._uploaded[span.start]["missed"] = upload(mi.Bool, self._missed[span])
            dr.eval(self._uploaded[span.start])
        return self._uploaded[span.start]

    def choose(self, places: dict, lumel, sample, wavelengths):
        """A place of a lumel, or any other in the part of the lumel that it stands for."""
        mine = dr.gather(mi.UInt32, places["count"], lumel)
        scaled = sample.x * mi.Float(mine)
        number = dr.minimum(mi.UInt32(scaled), mine - 1)
        chosen = dr.gather(mi.UInt32, places["start"], lumel) + number

        def fetch(made, name, row):
            return made(*(dr.gather(mi.Float, column, row) for column in places[name]))

        # Fixed places would miss the same edges of shadows in all passes, whose scatter would not show it.
        box = dr.gather(mi.UInt32, places["box"], chosen)
        is_box, box = box > 0, dr.maximum(box, 1) - 1
        inside = mi.Vector2f(scaled - mi.Float(number), sample.y) * mi.Vector2f(*places["size"])
        aside = dr.clip(fetch(mi.Vector2f, "corners", box) + inside, *self.table.boxes.ends)
        aside -= fetch(mi.Vector2f, "points", box)
        shift = (
            fetch(mi.Vector3f, "right", lumel) * aside.x + fetch(mi.Vector3f, "up", lumel) * aside.y
        )
        return gather.receiver(
            fetch(mi.Point3f, "p", chosen) + dr.select(is_box, shift, 0.0),
            fetch(mi.Normal3f, "n", chosen),
            fetch(mi.Normal3f, "g", chosen),
            wavelengths,
            self.scene.extent,
        )

    # ---- private ----

    def _find_spans(self, counts: np.ndarray) -> list[slice]:
        spans, start, places = [], 0, 0
        for number, more in enumerate(counts.tolist()):
            if places and places + more > SPAN_PLACES:
                spans.append(slice(start, int(self._first[number])))
                start, places = int(self._first[number]), 0
            places += more
        return [*spans, slice(start, int(self._first[-1]))] if self._first[-1] else []

    def _collected(self, span: slice) -> dict[str, np.ndarray]:
        """Places of a span on the host; those of the next one are collected meanwhile."""
        start, coming = self._coming
        arrays = coming.result() if start == span.start else self._collect(span)
        after = self.spans[(self.spans.index(span) + 1) % len(self.spans)]
        if after.start not in self._uploaded and after is not span:
            self._coming = after.start, self._collector.submit(self._collect, after)
        return arrays

    def _collect(self, span: slice) -> dict[str, np.ndarray]:
        inside = (self._first[:-1] >= span.start) & (self._first[:-1] < span.stop)
        blocks = [self.table.block(int(i)) for i in np.flatnonzero(inside)]
        parts = [block.receivers for block in blocks]
        begins = np.cumsum([0, *(len(part.positions) for part in parts)])
        starts = [part.start + begin for part, begin in zip(parts, begins, strict=False)]
        return {
            "p": self.scene.local(np.concatenate([part.positions for part in parts])),
            "n": np.concatenate([part.normals for part in parts]),
            "g": np.concatenate([part.geometric_normals for part in parts]),
            "start": np.concatenate(starts),
            "count": np.concatenate([part.count for part in parts]),
            "box": np.concatenate([block.box for block in blocks]),
            "steps": np.concatenate([block.steps for block in blocks]),
        }
