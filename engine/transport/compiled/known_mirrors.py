"""Which mirrors and panes of a scene light is aimed over, and where they are."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from ...luminaires.emitters.opening_sampling import POINT
from .mirrors import MirrorSet, Plane, choose_planes

SMALL_LIGHT = 0.05
"""Bodies of lights smaller than this share of the scene's radius are aimed at over panes, too. [-]"""


def is_hard_to_meet(source, radius: float) -> bool:
    """Tell whether scattered rays meet a light never or seldom. ``radius``: of the scene [m]."""
    if source.luminaire is not None:
        is_point = source.luminaire.kind == POINT
    else:
        is_point = mi.has_flag(source.emitter.flags(), mi.EmitterFlags.DeltaPosition)
    return is_point or source.radius < SMALL_LIGHT * radius


class KnownMirrors:
    """Planes that chains of mirrors are drawn from, and which of them each triangle lies in.

    ``planes``: a `MirrorSet`, None when there are none.
    """

    def __init__(self):
        self.planes: MirrorSet | None = None
        self._given: list[Plane] = []
        self._places: dict[int, int] = {}
        self._first = self._numbers = None

    def choose(self, parts, with_panes: bool, origin: np.ndarray) -> None:
        """Choose the planes.

        Parameters
        ----------
        parts : iterable of bodies.Part
        with_panes : bool    Whether panes are aimed over: only where scattered rays would not do.
        origin : (3,) array    Of the compiled scene's frame. [m]
        """
        given = [p for part in parts for p in part.mirrors if with_panes or not p.is_pane]
        if [id(p) for p in given] != [id(p) for p in self._given]:
            self._given = given
            chosen, self._places = choose_planes(given)
            self.planes = MirrorSet(chosen, origin) if chosen else None

    def commit(self, size: int, parts) -> None:
        """Bring the tables up to date. ``size``: of tables by the number of a shape."""
        if self.planes is None:
            self._first = self._numbers = None
            return
        first, numbers, used = np.zeros(size), [], 0
        for part in parts:
            if part.mirrors:
                # The last stands for triangles in no plane.
                known = [self._places.get(id(p), -1) + 1 for p in part.mirrors] + [0]
                first[part.number] = used + 1
                numbers.append(np.array(known)[part.planes])
                used += len(part.planes)
        whole = np.zeros(table_size(used))
        whole[:used] = np.concatenate(numbers)
        self._first, self._numbers = upload(mi.UInt32, first), upload(mi.UInt32, whole)
        dr.eval(self._first, self._numbers)

    def holds(self, part) -> bool:
        """Tell whether all faces of a part lie in the planes."""
        return self.holds_most(part) and not (part.planes < 0).any()

    def holds_most(self, part) -> bool:
        """As `holds`, whatever becomes of a pane's edges."""
        return bool(part.mirrors) and all(id(plane) in self._places for plane in part.mirrors)

    def at(self, si, active):
        """Number of the plane that a surface lies in, plus 1; 0: none."""
        shape = dr.reinterpret_array(mi.UInt32, si.shape)
        first = dr.gather(mi.UInt32, self._first, shape, active)
        place = first - 1 + si.prim_index
        return dr.gather(mi.UInt32, self._numbers, place, active & (first > 0))
