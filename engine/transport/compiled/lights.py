"""Choice of the emitter for next-event estimation."""

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import pointer_id, table_size, upload
from ...luminaires.emitters.distribution_arrays import FLOOR
from ...luminaires.emitters.palette import LuminairePalette, Row
from ...luminaires.emitters.rectangle_plugin import RectangleRow, RectangleTable
from .light_profiles import CONE, FLAT, LAMBERTIAN, columns_of, cone_intensity, make_profiles
from .light_tree import NOWHERE, TINY, LightTree

EVEN_SHARE = 0.04
"""Share of choices made evenly, so that no light is forgotten where only it counts."""

LOCAL_LIMIT = 16
"""Up to this many lights, each point weighs all of them; beyond, a tree leads it to those that count there."""


@dataclass
class Source:
    """An emitter that next-event may choose.

    Parameters
    ----------
    emitter : mi.Emitter
    flux : float    [lm]
    density : (471,) array    Spectral density on the 1 nm grid, any scale.
    centre : (3,) array or None    Roughly where it is, in the scene's frame [m]; None: light from infinity.
    radius : float    Of a sphere around it. [m]
    axis : (3,) array or None    Direction to which a flat one-sided emitter shines, or axis of a cone.
    luminaire : Row or None    What the `LuminairePalette` holds of it; ``emitter`` is the palette's then.
    cone : float or None    Cosine of the angle to the axis beyond which nothing is lit; None: nothing behind it is.
    rectangle : RectangleRow or None    What the `RectangleTable` holds of it; ``emitter`` stands for all of them then.
    """

    emitter: object
    flux: float
    density: np.ndarray
    centre: np.ndarray | None
    radius: float = 0.0
    axis: np.ndarray | None = None
    luminaire: Row | None = None
    cone: float | None = None
    rectangle: RectangleRow | None = None
    number: int = field(init=False)

    def __post_init__(self):
        """Note the number by which kernels know the emitter."""
        self.number = pointer_id(self.emitter)

    def order(self) -> tuple:
        """Key that puts sources in an order that depends on the scene alone, not on ids: infinity first, luminaires last."""
        if self.centre is None:
            return (0,)
        axis = (0.0, 0.0, 0.0) if self.axis is None else tuple(self.axis)
        cone = -2.0 if self.cone is None else self.cone
        kind, more = 1, ()
        if self.rectangle is not None:
            kind, more = 2, self.rectangle.order()
        if self.luminaire is not None:
            kind, more = 3, self.luminaire.order()
        return (kind, *self.centre, self.radius, *axis, cone, self.flux, *more)


class LightTable:
    """Chooses one of the scene's emitters.

    The probability at a point is proportional to strength / (distance^2 + radius^2), for luminaires also to the intensity
    towards the point; light from infinity counts by the rough solid angle of the portals, or evenly without any. Next to a
    desk lamp the desk lamp counts, across the room the ceiling. Where lights are many, a `LightTree` leads to those that
    count.
    Strengths are fluxes at first; `learn` replaces them by what arrives at the points that a job looks at, shadows
    included, so that a sky of enormous flux outside a small window does not draw the samples from the lamps inside.

    The tables on the device are filled up to a power of two, and all numbers are data, so that a moved, dimmed or added
    light meets the same compiled kernel.

    Parameters
    ----------
    sources : list of Source    In the order of `Source.order`.
    reach : float    Radius of the scene. [m]
    portals : PortalSet or None
    palette : LuminairePalette or None    Holds the luminaires among the sources, in their order.
    rectangles : RectangleTable or None    Holds the rectangles, likewise.
    """

    def __init__(
        self,
        sources: list[Source],
        reach: float,
        portals=None,
        palette: LuminairePalette | None = None,
        rectangles: RectangleTable | None = None,
    ):
        self.count = len(sources)
        self.palette, self.rectangles = palette, rectangles
        self.portals = portals
        self.sources = sources
        self.reach = reach
        self.tree = None
        if not sources:
            return
        ids = np.array([source.number for source in sources])
        number = np.zeros(table_size(int(ids.max()) + 1), dtype=np.uint32)
        # Luminaires share a number, that of the first, and are told apart by their row, and so do rectangles of lamps.
        number[ids[::-1]] = np.arange(self.count)[::-1]
        self._plain = sum(source.luminaire is None for source in sources)
        single = sum(source.rectangle is None for source in sources[: self._plain])
        first = np.repeat([single, self._plain], [self._plain, self.count - self._plain])
        rows = np.maximum(np.arange(self.count) - first, 0)
        self._rows = {id(source): int(row) for source, row in zip(sources, rows, strict=True)}
        self._first_luminaire = dr.opaque(mi.UInt32, self._plain)
        self._first_rectangle = dr.opaque(mi.UInt32, single)
        # No plain number: emitters are asked straight and over mirrors by the same code.
        self._no_row = dr.opaque(mi.Float, 0.0)
        self._last_row = dr.opaque(mi.UInt32, max(self.count - self._plain, 1) - 1)
        self._slots = 1 << (self.count - 1).bit_length()
        padded = np.full(self._slots, ids[0], dtype=np.uint32)
        padded[: self.count] = ids
        self._pointers = upload(mi.UInt32, padded)
        self._number = upload(mi.UInt32, number)
        self._even = dr.opaque(mi.Float, 1.0 / self.count)
        self._many = dr.opaque(mi.UInt32, self.count)
        dr.eval(self._pointers, self._number)
        self._columns = columns_of(sources)
        self._has_outside = sources[0].centre is None
        self._arrange()
        self.reset()

    def _arrange(self) -> None:
        """Give every light its place on the device: that in the tree's leaves where there is a tree."""
        first = int(self._has_outside)
        order = np.full(self._slots, -1, dtype=np.int64)
        order[: self.count] = np.arange(self.count)
        if self.count > LOCAL_LIMIT:
            rows = [source.luminaire for source in self.sources[self._plain :]]
            profiles, which = make_profiles(self._columns, rows, self.palette)
            self.tree = LightTree(
                self._columns["centre"][first:],
                self._columns["radius"][first:],
                profiles,
                which[first:],
                _raised(self._columns["flux"][first:]),
            )
            order = self.tree.places.ravel()
            order = np.where(order >= 0, order + first, -1)
        self._order = order
        is_real = order >= 0
        place = np.full(self._slots, NOWHERE, dtype=np.uint32)
        place[order[is_real]] = np.flatnonzero(is_real)
        self._place = upload(mi.UInt32, place)
        self._light = upload(mi.UInt32, np.where(is_real, order, NOWHERE).astype(np.uint32))
        columns = {name: values[order] for name, values in self._columns.items()}
        self._shape = np.column_stack(
            [
                columns["centre"],
                np.maximum(columns["radius"], 1e-3) ** 2,
                columns["axis"],
                columns["radius"],
                np.zeros(len(order)),
                columns["kind"],
                columns["cone"],
                cone_intensity(columns["cone"]),
            ]
        )
        dr.eval(self._place, self._light)

    def reset(self) -> None:
        """Forget what was learned: strengths are fluxes."""
        if not self.count:
            return
        columns = self._columns
        strengths = columns["flux"] / self.reach**2
        nearby = strengths * (self.reach**2 + columns["radius"] ** 2)
        strengths = np.where(self._is_outside(), strengths, nearby)
        self.set_strengths(strengths)

    def _is_outside(self) -> np.ndarray:
        return np.arange(self.count) < int(self._has_outside)

    def set_strengths(self, strengths: np.ndarray) -> None:
        """Set what the kernels of the lights are multiplied by, up to a factor. (n,)"""
        strengths = np.asarray(strengths, dtype=np.float64)
        if not strengths.sum() > 0.0:
            strengths = np.ones(self.count)
        strengths = strengths / strengths.sum()
        if self.tree is not None:
            first = int(self._has_outside)
            strengths[first:] = _raised(strengths[first:])
            self.tree.set_strengths(strengths[first:])
        self.strengths = strengths
        shape = self._shape.copy()
        shape[:, 8] = np.where(self._order >= 0, strengths[self._order], 0.0)
        self._shapes = upload(mi.Float, shape)
        self._outside = dr.opaque(mi.Float, strengths[0])
        dr.eval(self._shapes)

    def kernels(self, points: np.ndarray) -> np.ndarray:
        """Distance kernels of all lights at points (k, 3), shape (k, n). [1/m2, 1 for light from infinity]"""
        made = np.ones((len(points), self.count))
        for i, source in enumerate(self.sources):
            if source.centre is None:
                if self.portals is not None:
                    made[:, i] = self.portals.openness_of(points)
            else:
                away = points - source.centre
                squared = (away**2).sum(axis=1) + max(source.radius, 1e-3) ** 2
                made[:, i] = 1.0 / squared
                if source.axis is not None and source.cone is None:
                    height = np.maximum(away @ source.axis, 1e-9)
                    rise = height + np.minimum(height, source.radius)
                    made[:, i] *= LAMBERTIAN * np.minimum(rise / np.sqrt(squared), 1.0)
        return made * self.importances(points)

    def importances(self, points: np.ndarray) -> np.ndarray:
        """Coarse intensity of luminaires and cones towards points (k, 3) over their mean, 1 for other lights. (k, n)"""
        made = np.ones((len(points), self.count))
        for i in np.flatnonzero(self._columns["kind"] == CONE):
            source = self.sources[i]
            away = points - source.centre
            is_lit = away @ source.axis + source.radius >= source.cone * np.linalg.norm(
                away, axis=1
            )
            made[:, i] = np.where(is_lit, cone_intensity(source.cone), FLOOR)
        if self.palette is not None:
            made[:, self._plain :] = self.palette.importances(points)
        return made

    def row_of(self, source: Source) -> int:
        """Row by which a luminaire or a rectangle is told apart from others of this table, 0 for other lights."""
        return self._rows[id(source)]

    def pointer(self, index):
        """Return the emitter with a number."""
        return dr.reinterpret_array(mi.EmitterPtr, dr.gather(mi.UInt32, self._pointers, index))

    def index(self, pointer, active, row):
        """Number of an emitter that shines. ``row``: as `row` gives it, and the time of a surface does."""
        ids = dr.reinterpret_array(mi.UInt32, pointer)
        return dr.gather(mi.UInt32, self._number, ids, active) + mi.UInt32(row)

    def sample_place(self, index, sample, active):
        """Draw a place on a luminous surface, evenly over its area; luminaires have none. PositionSample3f"""
        made = self.pointer(index).get_shape().sample_position(0.0, sample, active)
        if self.rectangles is None:
            return made
        is_own = active & (index >= self._first_rectangle) & (index < self._first_luminaire)
        own = self.rectangles.sample_place(mi.UInt32(self.row(index)), sample, is_own)
        return dr.select(is_own, own, made)

    def is_outside(self, index):
        """Whether the emitter with a number gives light from infinity."""
        return (index == 0) & self._has_outside

    def row(self, index):
        """Row of a luminaire in the palette or of a rectangle, as the time by which it is told; 0 for other emitters."""
        if self.palette is None and self.rectangles is None:
            return self._no_row
        row = mi.UInt32(0)
        for table, first in (
            (self.rectangles, self._first_rectangle),
            (self.palette, self._first_luminaire),
        ):
            if table is not None:
                row = dr.select(index >= first, index - first, row)
        return mi.Float(row)

    def sample(self, u, point):
        """Return an emitter's number, its probability at a point, and the stretched remainder of ``u``."""
        if self.tree is not None:
            return self._sample_tree(u, point)
        index, share, start = mi.UInt32(0), mi.Float(1.0), mi.Float(0.0)
        running = mi.Float(0.0)
        for i, value in enumerate(self._local_shares(point)):
            chosen = (u >= running) & (value > 0.0)
            index = dr.select(chosen, mi.UInt32(i), index)
            share = dr.select(chosen, value, share)
            start = dr.select(chosen, running, start)
            running = running + value
        return index, share, dr.clip((u - start) / share, 0.0, 0.9999999)

    def _sample_tree(self, u, point):
        is_even = u < EVEN_SHARE
        wanted = u * (mi.Float(self._many) / EVEN_SHARE)
        index = dr.minimum(mi.UInt32(dr.select(is_even, wanted, 0.0)), self._many - 1)
        place = dr.gather(mi.UInt32, self._place, index)
        stretched = dr.maximum(u - EVEN_SHARE, 0.0) * (1.0 / (1.0 - EVEN_SHARE))
        place, share, rest = self._descend(stretched, place, is_even, point)
        at_light = place != NOWHERE
        index = dr.select(at_light, dr.gather(mi.UInt32, self._light, place, at_light), 0)
        rest = dr.select(is_even, dr.clip(wanted - dr.floor(wanted), 0.0, 0.9999999), rest)
        return index, share, rest

    def probability(self, pointer, point, active, row=0):
        """Probability of choosing an emitter at a point. ``row``: as of `index`."""
        if self.count == 0:
            return mi.Float(0.0)
        index = self.index(pointer, active, row)
        if self.tree is not None:
            place = dr.gather(mi.UInt32, self._place, index, active)

            def find(place):
                return self._descend(mi.Float(0.0), place, mi.Bool(True), point)[1]

            # Most rays meet no light and need no way to it.
            return dr.if_stmt(
                (place,), mi.Bool(active), find, lambda place: mi.Float(0.0), arg_labels=("place",)
            )
        probability = mi.Float(0.0)
        for i, value in enumerate(self._local_shares(point)):
            probability = dr.select(active & (index == i), value, probability)
        return probability

    def _descend(self, u, place, is_given, point):
        """As `LightTree.descend`, with the share of even choices in the probability."""

        def weigh(place):
            value, _ = self._weigh(place, point)
            is_real = dr.gather(mi.UInt32, self._light, place) != NOWHERE
            return dr.select(is_real, dr.maximum(value, TINY), 0.0)

        outside = self._weigh_outside(point) if self._has_outside else None
        place, share, rest = self.tree.descend(point, u, place, is_given, weigh, outside=outside)
        return place, EVEN_SHARE * self._even + (1.0 - EVEN_SHARE) * share, rest

    def _local_shares(self, point) -> list:
        """Probabilities of all lights at a point; 0 where the table is only filled up."""
        if self.count == 1:
            return [mi.Float(1.0)]
        weights = []
        for i in range(self._slots):
            if i == 0 and self._has_outside:
                weights.append(self._weigh_outside(point))
            else:
                weights.append(self._weigh(mi.UInt32(i), point)[0])
        total = dr.maximum(sum(weights[1:], weights[0]), TINY)
        shares = [(1.0 - EVEN_SHARE) * w / total for w in weights]
        # Whatever is missing to 1 (all of it where no light shines) is spread evenly.
        rest = (1.0 - sum(shares[1:], shares[0])) * self._even
        return [share + dr.select(i < self._many, rest, 0.0) for i, share in enumerate(shares)]

    def _weigh_outside(self, point):
        if self.portals is None:
            return self._outside
        return self._outside * self.portals.openness(point)

    def _weigh(self, place, point):
        """Give what the light at a place gives at a point, unoccluded.

        Returns
        -------
        (Float, Float)    That, and the coarse intensity towards the point over the mean, 1 where it is not known.
        """
        where, to, how = (dr.gather(mi.Vector4f, self._shapes, place * 3 + k) for k in range(3))
        strength, kind, cone, intensity = how
        axis, radius = mi.Vector3f(to.x, to.y, to.z), to.w
        away = mi.Vector3f(point) - mi.Vector3f(where.x, where.y, where.z)
        distance = dr.squared_norm(away)
        squared = distance + where.w
        weight = strength / squared
        along = dr.dot(away, axis)
        # The cosine at the emitter, at most that of its nearest part.
        height = dr.maximum(along, 0.0)
        rise = height + dr.minimum(height, radius)
        cosine = LAMBERTIAN * dr.minimum(rise * dr.rsqrt(squared), 1.0)
        weight *= dr.select(kind == float(FLAT), cosine, 1.0)
        in_cone = along + radius >= cone * dr.sqrt(distance)
        lit = dr.select(kind == float(CONE), dr.select(in_cone, intensity, FLOOR), 1.0)
        if self.palette is not None:
            light = dr.gather(mi.UInt32, self._light, place)
            shines = (light >= self._first_luminaire) & (light != NOWHERE)
            row = dr.minimum(dr.select(shines, light - self._first_luminaire, 0), self._last_row)
            lit = dr.select(shines, self.palette.importance(row, away, shines), lit)
        return weight * lit, lit

    def expect(self, index, point):
        """Return what a light is expected to give at a point, unoccluded, and whether its coarse intensity tells much."""
        place = dr.gather(mi.UInt32, self._place, index)
        is_inside = place != NOWHERE
        value, lit = self._weigh(dr.select(is_inside, place, 0), point)
        if self._has_outside:
            value = dr.select(is_inside, value, self._weigh_outside(point))
        return value, ~is_inside | (lit > 2.0 * FLOOR)


def _raised(strengths: np.ndarray) -> np.ndarray:
    """Strengths of which none is 0, so that every node of a tree has a weight."""
    return np.maximum(strengths, 1e-9 * max(strengths.max(initial=0.0), TINY))
