"""Choice of the emitter for next-event estimation."""

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import pointer_id, table_size, upload
from ..luminaires.palette import LuminairePalette, Row
from ..luminaires.tables import FLOOR
from .rays import spawn_ray

PILOT_POINTS = 1024
"""Points at which the lights are compared before a job."""

PILOT_LANES = 1 << 18
"""Shadow rays spent on the comparison, so that each point is asked several times about each light."""

FEWEST_POINTS = 4
"""With fewer points in its beam, a luminaire's strength follows from its flux."""

EVEN_SHARE = 0.04
"""Share of choices made evenly, so that no light is forgotten where only it counts."""

LOCAL_LIMIT = 32
"""Up to this many lights, each point weighs all of them by distance; beyond, one choice serves all points."""


COLUMNS = ("x", "y", "z", "spread", "axis_x", "axis_y", "axis_z", "radius", "flat", "real")
"""What the table on the device holds about each light."""


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
    axis : (3,) array or None    Direction to which a flat one-sided emitter shines; nothing behind it is lit.
    luminaire : Row or None    What the `LuminairePalette` holds of it; ``emitter`` is the palette's then.
    """

    emitter: object
    flux: float
    density: np.ndarray
    centre: np.ndarray | None
    radius: float = 0.0
    axis: np.ndarray | None = None
    luminaire: Row | None = None
    number: int = field(init=False)

    def __post_init__(self):
        """Note the number by which kernels know the emitter."""
        self.number = pointer_id(self.emitter)

    def order(self) -> tuple:
        """Key that puts sources in an order that depends on the scene alone, not on ids: infinity first, luminaires last."""
        if self.centre is None:
            return (0,)
        axis = (0.0, 0.0, 0.0) if self.axis is None else tuple(self.axis)
        kind, more = (1, ()) if self.luminaire is None else (2, self.luminaire.order())
        return (kind, *self.centre, self.radius, *axis, self.flux, *more)


class LightTable:
    """Chooses one of the scene's emitters.

    The probability at a point is proportional to strength / (distance^2 + radius^2), for luminaires also to the intensity
    towards the point; light from infinity counts by the
    rough solid angle of the portals, or evenly without any. Next to a desk lamp the desk lamp counts, across the room the
    ceiling. Strengths are fluxes at first; `learn` replaces them by what arrives at the points that a job looks at, shadows
    included, so that a sky of enormous flux outside a small window does not draw the samples from the lamps inside.

    The tables on the device are filled up to a power of two, and all numbers are data, so that a moved, dimmed or added
    light meets the same compiled kernel.

    Parameters
    ----------
    sources : list of Source    In the order of `Source.order`.
    reach : float    Radius of the scene. [m]
    portals : PortalSet or None
    palette : LuminairePalette or None    Holds the luminaires among the sources, in their order.
    """

    def __init__(
        self,
        sources: list[Source],
        reach: float,
        portals=None,
        palette: LuminairePalette | None = None,
    ):
        self.count = len(sources)
        self.palette = palette
        self.portals = portals
        self.sources = sources
        self.reach = reach
        if not sources:
            return
        ids = np.array([source.number for source in sources])
        number = np.zeros(table_size(int(ids.max()) + 1), dtype=np.uint32)
        # Luminaires share a number, that of the first, and are told apart by their row.
        number[ids[::-1]] = np.arange(self.count)[::-1]
        self._plain = sum(source.luminaire is None for source in sources)
        self._rows = {id(source): i for i, source in enumerate(sources[self._plain :])}
        self._first_luminaire = dr.opaque(mi.UInt32, self._plain)
        self._last_row = dr.opaque(mi.UInt32, max(self.count - self._plain, 1) - 1)
        self.is_local = self.count <= LOCAL_LIMIT
        self._slots = 1 << (self.count - 1).bit_length()
        padded = np.full(self._slots, ids[0], dtype=np.uint32)
        padded[: self.count] = ids
        self._pointers = upload(mi.UInt32, padded)
        self._number = upload(mi.UInt32, number)
        self._even = mi.Float(1.0 / self.count)
        self._places = upload(mi.Float, self._place_table())
        dr.make_opaque(self._even)
        dr.eval(self._pointers, self._number, self._places)
        self.reset()

    def _place_table(self) -> np.ndarray:
        table = np.zeros((self._slots, len(COLUMNS)), dtype=np.float32)
        for row, source in zip(table, self.sources, strict=False):
            if source.centre is not None:
                row[:3] = source.centre
            row[3] = max(source.radius, 1e-3) ** 2
            if source.axis is not None:
                row[4:7] = source.axis
                row[8] = 1.0
            row[7] = source.radius
            row[9] = 1.0
        return table

    def reset(self) -> None:
        """Forget what was learned: strengths are fluxes."""
        if self.count:
            fluxes = np.array([source.flux for source in self.sources])
            kernels = [
                1.0 if s.centre is None else 1.0 / (self.reach**2 + s.radius**2)
                for s in self.sources
            ]
            arriving = fluxes / self.reach**2
            self.set_strengths(arriving, arriving / np.array(kernels))

    def set_strengths(self, arriving: np.ndarray, strengths: np.ndarray) -> None:
        """Set what the choice goes by, each up to a factor.

        Parameters
        ----------
        arriving : (n,) array    Light that arrives on the whole, for one choice at all points.
        strengths : (n,) array    What the kernels of the lights are multiplied by, for a choice at every point.
        """
        arriving = np.asarray(arriving, dtype=np.float64)
        if not (arriving.sum() > 0.0 and strengths.sum() > 0.0):
            arriving, strengths = np.ones(self.count), np.ones(self.count)
        arriving, wanted = arriving / arriving.sum(), strengths / strengths.sum()
        strengths = np.zeros(self._slots)
        strengths[: self.count] = wanted
        shares = np.zeros(self._slots)
        shares[: self.count] = EVEN_SHARE / self.count + (1.0 - EVEN_SHARE) * arriving
        cdf = np.cumsum(shares)
        cdf[self.count - 1 :] = 2.0
        self._strength = upload(mi.Float, strengths)
        self._cdf = upload(mi.Float, cdf)
        self._share = upload(mi.Float, shares)
        self._start = upload(mi.Float, np.cumsum(shares) - shares)
        dr.eval(self._strength, self._cdf, self._share, self._start)

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
                if source.axis is not None:
                    height = np.maximum(away @ source.axis, 1e-9)
                    rise = height + np.minimum(height, source.radius)
                    made[:, i] *= np.minimum(rise / np.sqrt(squared), 1.0)
        return made * self.importances(points)

    def importances(self, points: np.ndarray) -> np.ndarray:
        """Coarse intensity of the luminaires towards points (k, 3) relative to their mean, 1 for other lights. (k, n)"""
        made = np.ones((len(points), self.count))
        if self.palette is not None:
            made[:, self._plain :] = self.palette.importances(points)
        return made

    def row_of(self, source: Source) -> int:
        """Row of a luminaire of this table in the palette."""
        return self._rows[id(source)]

    def pointer(self, index):
        """Return the emitter with a number."""
        return dr.reinterpret_array(mi.EmitterPtr, dr.gather(mi.UInt32, self._pointers, index))

    def row(self, index):
        """Row of a luminaire in the palette, as the time by which it is told; 0 for other emitters."""
        if self.palette is None:
            return mi.Float(0.0)
        first = self._first_luminaire
        return mi.Float(dr.select(index >= first, index - first, 0))

    def sample(self, u, point):
        """Return an emitter's number, its probability at a point, and the stretched remainder of ``u``."""
        if not self.is_local:
            index = dr.binary_search(
                0, self._slots - 1, lambda i: dr.gather(mi.Float, self._cdf, i) <= u
            )
            share = dr.gather(mi.Float, self._share, index)
            start = dr.gather(mi.Float, self._start, index)
        else:
            index, share, start = mi.UInt32(0), mi.Float(1.0), mi.Float(0.0)
            running = mi.Float(0.0)
            for i, value in enumerate(self._local_shares(point)):
                chosen = (u >= running) & (value > 0.0)
                index = dr.select(chosen, mi.UInt32(i), index)
                share = dr.select(chosen, value, share)
                start = dr.select(chosen, running, start)
                running = running + value
        return index, share, dr.clip((u - start) / share, 0.0, 0.9999999)

    def probability(self, pointer, point, active, row=0):
        """Probability of choosing an emitter at a point. ``row``: which luminaire, if the pointer is the palette's."""
        if self.count == 0:
            return mi.Float(0.0)
        ids = dr.reinterpret_array(mi.UInt32, pointer)
        index = dr.gather(mi.UInt32, self._number, ids, active) + mi.UInt32(row)
        if not self.is_local:
            return dr.gather(mi.Float, self._share, index, active)
        probability = mi.Float(0.0)
        for i, value in enumerate(self._local_shares(point)):
            probability = dr.select(active & (index == i), value, probability)
        return probability

    def _local_shares(self, point) -> list:
        """Probabilities of all lights at a point; 0 where the table is only filled up."""
        if self.count == 1:
            return [mi.Float(1.0)]

        def entry(row, name):
            place = row * len(COLUMNS) + COLUMNS.index(name)
            return dr.gather(mi.Float, self._places, mi.UInt32(place))

        weights = []
        for i in range(self._slots):
            weight = dr.gather(mi.Float, self._strength, mi.UInt32(i))
            if i == 0 and self.sources[0].centre is None:
                if self.portals is not None:
                    weight = weight * self.portals.openness(point)
            else:
                away = point - mi.Point3f(*(entry(i, name) for name in "xyz"))
                squared = dr.squared_norm(away) + entry(i, "spread")
                axis = mi.Vector3f(*(entry(i, f"axis_{name}") for name in "xyz"))
                # The cosine at the emitter, at most that of its nearest part.
                height = dr.maximum(dr.dot(away, axis), 0.0)
                rise = height + dr.minimum(height, entry(i, "radius"))
                cosine = dr.minimum(rise * dr.rsqrt(squared), 1.0)
                weight = weight / squared * dr.select(entry(i, "flat") > 0.0, cosine, 1.0)
                if self.palette is not None:
                    shines = mi.Bool(mi.UInt32(i) >= self._first_luminaire)
                    row = dr.select(shines, mi.UInt32(i) - self._first_luminaire, 0)
                    row = dr.minimum(row, self._last_row)
                    value = self.palette.importance(row, mi.Vector3f(away), shines)
                    weight *= dr.select(shines, value, 1.0)
            weights.append(weight)
        total = sum(weights[1:], weights[0])
        total = dr.maximum(total, 1e-30)
        shares = [(1.0 - EVEN_SHARE) * w / total for w in weights]
        # Whatever is missing to 1 (all of it where no light shines) is spread evenly.
        rest = (1.0 - sum(shares[1:], shares[0])) * self._even
        return [share + rest * entry(i, "real") for i, share in enumerate(shares)]


def learn(scene, points, normals, wavelengths, lanes: int = PILOT_LANES) -> None:
    """Set the probabilities by the illuminance that each light gives at a job's points and one bounce further.

    The choice is made once from a fixed seed and does not depend on the job's own samples, so estimates stay unbiased.

    Parameters
    ----------
    scene : CompiledScene
    points, normals : (k, 3) float32 array    In the compiled scene's frame.
    wavelengths : Spectrum or None    Four wavelengths that stand for the visible range.
    lanes : int    Shadow rays to be spent at most.
    """
    scene.lights.reset()
    if scene.lights.count < 2 or len(points) == 0:
        return
    chosen = np.random.default_rng(1).integers(0, len(points), PILOT_POINTS)
    near = _surface(mi.Point3f(*_columns(points[chosen])), mi.Normal3f(*_columns(normals[chosen])))
    stream = mi.PCG32(size=PILOT_POINTS, initstate=7)
    away = near.to_world(
        mi.warp.square_to_cosine_hemisphere(
            mi.Point2f(stream.next_float32(), stream.next_float32())
        )
    )
    hit = scene.solid.ray_intersect(spawn_ray(scene, near, away))
    facing = hit.n * dr.select(dr.dot(hit.n, away) < 0.0, 1.0, -1.0)
    far = _surface(hit.p, facing)
    logarithms, found, kernels, eligible = [], [], [], []
    for si, active in ((near, mi.Bool(True)), (far, hit.is_valid())):
        arriving = _arriving(scene, si, active, wavelengths, lanes)
        place = np.stack([np.array(c) for c in si.p], axis=1)
        place = np.nan_to_num(place, posinf=0.0, neginf=0.0)
        # Beside its beam a luminaire's kernel is only a floor and says nothing about its strength.
        lit = scene.lights.importances(place) > 2.0 * FLOOR
        seen = (arriving > 0.0) & lit
        logarithms.append(np.where(seen, np.log(np.where(seen, arriving, 1.0)), 0.0))
        found.append(seen)
        eligible.append(lit)
        kernels.append(np.log(scene.lights.kernels(place)))
    found, eligible = np.concatenate(found), np.concatenate(eligible)
    times = np.maximum(found.sum(axis=0), 1)
    # Geometric means over the points that a light reaches: a few bright places must not stand for all.
    mean = np.exp((np.concatenate(logarithms) * found).sum(axis=0) / times)
    kernel = np.exp((np.concatenate(kernels) * found).sum(axis=0) / times)
    strengths = mean / kernel * found.sum(axis=0) / np.maximum(eligible.sum(axis=0), 1)
    # Of a beam that no point of the pilot run lies in nothing is known but its flux.
    fluxes = np.array([source.flux for source in scene.lights.sources])
    known, missed = strengths > 0.0, eligible.sum(axis=0) < FEWEST_POINTS
    if known.any():
        strengths[missed] = fluxes[missed] * np.median(strengths[known] / fluxes[known])
    scene.lights.set_strengths(mean * found.mean(axis=0), strengths)


def _columns(array):
    return [upload(mi.Float, array[:, i]) for i in range(3)]


def _surface(point, normal):
    si = dr.zeros(mi.SurfaceInteraction3f, PILOT_POINTS)
    si.p, si.n, si.sh_frame = point, normal, mi.Frame3f(normal)
    return si


def _arriving(scene, si, active, wavelengths, lanes) -> np.ndarray:
    """Illuminance that each light gives at each point, shadows included, up to a factor. (points, lights)"""
    from .paths import transmittance

    count = scene.lights.count
    # A power of two, since kernels have it in them.
    repeats = 1 << int(np.clip(lanes // (PILOT_POINTS * count), 1, 64)).bit_length() - 1
    lane = dr.arange(mi.UInt32, PILOT_POINTS * count * repeats)
    # Numbers of lights as data, so that one more needs no new kernel.
    many, times = dr.opaque(mi.UInt32, count), dr.opaque(mi.UInt32, repeats)
    light = (lane // times) % many
    point = lane // (times * many)
    at = dr.gather(mi.SurfaceInteraction3f, si, point)
    active = dr.gather(mi.Bool, dr.select(active, True, dr.zeros(mi.Bool, PILOT_POINTS)), point)
    if wavelengths is not None:
        at.wavelengths = wavelengths
    stream = mi.PCG32(size=dr.width(lane), initstate=11)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    at.time = scene.lights.row(light)
    ds, value = scene.lights.pointer(light).sample_direction(at, sample, active)
    cosine = dr.maximum(dr.dot(ds.d, at.n), 0.0)
    lit = active & (ds.pdf > 0.0) & (cosine > 0.0)
    # A sum, since a mean has the number of lanes in its kernel.
    amount = dr.sum(value * transmittance(scene, at, ds, lit)) * cosine
    amount = dr.select(lit & dr.isfinite(amount), amount, 0.0)
    sums = dr.block_reduce(dr.ReduceOp.Add, amount, repeats)
    return np.array(sums, dtype=np.float64).reshape(PILOT_POINTS, count)
