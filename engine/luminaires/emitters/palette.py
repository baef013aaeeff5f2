"""All luminaires of a scene as one emitter of Mitsuba, so that a thousand of them cost no more to trace than one.

Mitsuba visits every emitter that it can ask when it makes a kernel. Here it finds one: which luminaire is meant is a row of
a table, and the row travels as the `time` of the interaction or ray that the emitter is asked about, since Mitsuba hands an
emitter nothing else and time has no other use in a scene that stands still.

A luminaire gives the intensity I(direction) of its distribution. From an extended opening, a point of it sends the
luminance I(direction) / projected area(direction): then all of it together gives I from afar, whatever the shape, and a
ray from anywhere meets what stands in the data.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.distribution import SHAPES, IntensityDistribution, Opening
from ...scene.ray_emission import RayEmission
from .opening_sampling import (
    ELLIPSE,
    POINT,
    RECTANGLE,
    draw_departure,
    draw_point,
    meet,
    projected_area,
)
from .row_spectra import RowSpectra
from .tables import DistributionTables
from .tints import Tints

AXES = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}
"""The luminaire's axes in the order of the opening's own, whose z is the normal or the cylinder's axis."""

KINDS = {name: number for number, name in enumerate(SHAPES)}
"""Numbers of the shapes of openings."""

CANDIDATES = 10
"""Points of an opening that are compared at a next event where beams are narrow; an even number."""

NARROW = 25.0
"""Peak over mean intensity from which a distribution has narrow beams: one of about 40 degrees between half values."""

NEAR_BEAM = 5.0
"""Candidates are compared where the opening's solid angle is more than a twentieth of the beam's, so within the distance
whose square is this number times the squared radius times the sharpness."""

LEAST_SHARE = 1e-3
"""Share of the flux below which the directions from an opening to a receiver are not searched for beams."""

NEAR = 4.0
"""Within this many radii the direction from the centre says little, and importance fades to that of all directions."""

VECTORS = 8
"""Vectors of a row: three of the grid's axes, three of the opening's, half sizes and centre."""

NUMBERS = 3
"""Of a row: the kind of its opening, its distribution, and its colours, see `Tints`."""


@dataclass(frozen=True, eq=False)
class Row:
    """A luminaire as the table holds it.

    Parameters
    ----------
    distribution : IntensityDistribution
    digest : bytes    Of it, see `tables.distribution_digest`.
    grid : (3, 3) array    Axes of the distribution's grid in the scene's frame, as columns.
    kind : int    Of the opening.
    axes : (3, 3) array    Of the opening, likewise.
    half : (3,) array    Half sizes along them. [m]
    centre : (3,) array    In the scene's frame. [m]
    amount : float    Flux [lm], 0 in photometric variants for light without a visible part.
    density : (471,) array    Spectral density per unit of it. [1/nm]
    rotation : (3, 3) array or None    Of a light from a ray set: the luminaire's axes in the scene's frame, as columns.
    rays : RayEmission or None    Likewise.
    """

    distribution: IntensityDistribution
    digest: bytes
    grid: np.ndarray
    kind: int
    axes: np.ndarray
    half: np.ndarray
    centre: np.ndarray
    amount: float
    density: np.ndarray
    rotation: np.ndarray | None = None
    rays: RayEmission | None = None

    @property
    def radius(self) -> float:
        """Of a sphere around the opening. [m]"""
        return float(np.linalg.norm(self.half))

    def order(self) -> tuple:
        """Key that tells apart luminaires of equal flux at one place."""
        return (self.kind, *self.grid.ravel(), *self.half, self.digest, self.density.tobytes())


def opening_frame(opening: Opening, rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axes of an opening in the scene's frame (3, 3, columns) and half sizes along them (3,). [m]"""
    order = list(AXES[opening.axis])
    return rotation[:, order], 0.5 * np.asarray(opening.size, dtype=np.float64)[order]


class LuminairePalette:
    """The rows and their tables. The plug-in that stands for all of them holds it, see `luminaire_plugin`."""

    def __init__(self):
        self.tables, self.tints = DistributionTables(), Tints()
        self.commit([])

    def commit(self, rows: list[Row]) -> None:
        """Take these luminaires, in this order.

        Raises
        ------
        SceneError    A distribution has no flux.
        """
        self.count = len(rows)
        distributions = self.tables.commit(
            [row.distribution for row in rows], [row.digest for row in rows]
        )
        vectors = np.zeros((max(len(rows), 1), VECTORS, 3))
        for line, row in zip(vectors, rows, strict=False):
            line[0:3], line[3:6] = row.grid.T, row.axes.T
            line[6], line[7] = row.half, row.centre
        self._vectors = upload(mi.Float, vectors)
        numbers = np.zeros((max(len(rows), 1), NUMBERS), dtype=np.int64)
        tints = self.tints.commit(rows)
        for line, row, distribution, tint in zip(numbers, rows, distributions, tints, strict=False):
            line[:] = row.kind, distribution, tint
        self._numbers = upload(mi.UInt32, numbers)
        self._spectra = RowSpectra([row.amount for row in rows], [row.density for row in rows])
        self.kinds = {row.kind for row in rows}
        reach = np.array(
            [
                0.0 if row.kind == POINT else NEAR_BEAM * row.radius**2 * self._narrowness(number)
                for row, number in zip(rows, distributions, strict=True)
            ]
        )
        self._reach = upload(mi.Float, reach if len(rows) else [0.0])
        self.has_narrow = bool(reach.any())
        self.has_rays = any(row.rays is not None for row in rows)
        # What asks the rays of ray sets near by for a job, see `near_rays`.
        self.near = None
        bodies = [np.zeros(3) if row.rays is None else row.rays.half for row in rows]
        self._bodies = upload(mi.Float, bodies or [np.zeros(3)])
        self.set_limits(np.zeros(len(rows)))

    def set_limits(self, limits: np.ndarray) -> None:
        """Set the distances below which lights from ray sets give nothing here, since their rays are traced. (count,) [m]"""
        self._limits = upload(mi.Float, limits if len(limits) else [0.0])
        dr.eval(self._limits)

    def _narrowness(self, distribution: int) -> float:
        """Sharpness of a distribution that has narrow beams, 0 for others: unevenness alone needs no candidates."""
        if self.tables.contrast(distribution) < NARROW:
            return 0.0
        return self.tables.sharpness(distribution)

    # ---- inside kernels ----

    def _vector(self, row, place: int, active):
        return dr.gather(mi.Vector3f, self._vectors, row * VECTORS + place, active)

    def _number(self, row, place: int, active):
        return dr.gather(mi.UInt32, self._numbers, row * NUMBERS + place, active)

    def _to_local(self, row, first: int, v, active):
        """Coordinates of a vector in the axes of the grid (0) or the opening (3)."""
        return mi.Vector3f(*(dr.dot(self._vector(row, first + k, active), v) for k in range(3)))

    def _to_world(self, row, first: int, v, active):
        x, y, z = (self._vector(row, first + k, active) for k in range(3))
        return x * v.x + y * v.y + z * v.z

    def spectrum(self, row, wavelengths, active, direction=None):
        """Flux by wavelength [W/nm], or the flux itself in photometric variants [lm].

        ``direction``: of the scene's frame, by whose colour it counts; None: that of the lamp.
        """
        if direction is not None and len(self.tints):
            local = self._to_local(row, 0, direction, active)
            number = self._number(row, 2, active)
            tint = self.tints.eval(number, local, wavelengths, active)
            return self.spectrum(row, wavelengths, active) * tint
        return self._spectra.eval(row, wavelengths, active)

    def density(self, row, direction, active=True):
        """Intensity over flux in a direction of the scene's frame, the way light travels. [1/sr]"""
        local = self._to_local(row, 0, direction, active)
        return self.tables.density(self._number(row, 1, active), local, active)

    def importance(self, row, away, active=True):
        """Coarse intensity towards a place, relative to the mean. ``away``: from the luminaire's centre to it. [m]"""
        local = self._to_local(row, 0, away, active)
        value = self.tables.importance(self._number(row, 1, active), local, active)
        squared = dr.squared_norm(self._vector(row, 6, active))
        near = dr.clip(NEAR * squared / dr.maximum(dr.squared_norm(away), 1e-12), 0.0, 1.0)
        return dr.lerp(value, 1.0, near)

    def importances(self, points: np.ndarray) -> np.ndarray:
        """As `importance`, of every luminaire at points (k, 3) of the host. (k, count)"""
        lane = dr.arange(mi.UInt32, len(points) * self.count)
        many = dr.opaque(mi.UInt32, self.count)
        point = dr.gather(mi.Vector3f, upload(mi.Float, points), lane // many)
        row = lane % many
        value = self.importance(row, point - self._vector(row, 7, True))
        return np.array(value, dtype=np.float64).reshape(len(points), self.count)

    def radiance(self, row, direction, wavelengths, active):
        """Radiance that the opening sends along a direction of the scene's frame."""
        local = self._to_local(row, 3, direction, active)
        area = projected_area(
            self._number(row, 0, active), self._vector(row, 6, active), local, self.kinds
        )
        value = self.density(row, direction, active) / area
        return self.spectrum(row, wavelengths, active, direction) * value

    def receive(self, row, it, sample, active):
        """Draw a point of a luminaire for a receiver.

        Where beams are narrow and the receiver is near, half of several candidates are points of the opening and half are
        directions of the beam that are followed back to it, weighed by the balance heuristic, and one is kept in proportion
        to what it gives (resampled importance sampling, J. Talbot, 2005): the first serve receivers far away, the second
        those that a collimated beam reaches from a small part of the opening. The density in the result is the mean of the
        two kinds': both strategies of the paths weigh by it, so their weights sum to 1.

        Returns
        -------
        (DirectionSample3f, Spectrum)
        """
        number, half = self._number(row, 0, active), self._vector(row, 6, active)
        centre = self._vector(row, 7, active)
        q = mi.Point3f(self._to_local(row, 3, it.p - mi.Point3f(centre), active))
        is_point = active & (number == POINT)
        extended = active & ~is_point
        kept_at, kept_pdf, total = mi.Point3f(0.0), mi.Float(0.0), mi.Float(0.0)
        if self.kinds - {POINT}:
            beam, is_near = self._beam(row, it.p, extended)
            kept_at, kept_pdf, total = self._pick_point(
                row, number, half, q, sample, beam, is_near, extended
            )
            if self.has_narrow:
                kept_at, kept_pdf, total = self._compare(
                    row, number, half, q, sample, beam, is_near, (kept_at, kept_pdf, total)
                )
        ds = dr.zeros(mi.DirectionSample3f)
        ds.p = mi.Point3f(self._to_world(row, 3, mi.Vector3f(kept_at), active) + centre)
        ds.d = ds.p - it.p
        ds.dist = dr.norm(ds.d)
        ds.d /= dr.maximum(ds.dist, 1e-12)
        ds.n = mi.Normal3f(-ds.d)
        ds.delta = is_point
        ds.pdf = dr.select(is_point, 1.0, kept_pdf)
        if POINT in self.kinds:
            alone = self.density(row, -ds.d, is_point) / dr.maximum(dr.square(ds.dist), 1e-20)
            if self.has_rays:
                limit = dr.gather(mi.Float, self._limits, row, is_point)
                alone = dr.select(ds.dist < limit, 0.0, alone)
                self._start_at_body(row, ds, is_point)
            if self.near is not None:
                is_near, own = self.near.receive(row, it, sample, ds, is_point)
                alone = dr.select(is_near, own, alone)
            total = dr.select(is_point, alone, total)
        value = self.spectrum(row, it.wavelengths, active, -ds.d) * total
        return ds, mi.Spectrum(value & (active & (ds.pdf > 0.0)))

    def _start_at_body(self, row, ds, active) -> None:
        """Let light of a ray set come from the box around its starting points: what lies within shades nothing."""
        half = dr.gather(mi.Vector3f, self._bodies, row, active)
        local = dr.abs(self._to_local(row, 3, ds.d, active))
        way = dr.min(half / dr.maximum(local, 1e-6))
        begins = active & (ds.dist > way)
        ds.p = dr.select(begins, ds.p - ds.d * way, ds.p)
        ds.dist = dr.select(begins, ds.dist - way, ds.dist)

    def _compare(self, row, number, half, q, sample, beam, active, first):
        """Draw the rest of the candidates of near receivers and keep one. ``first``: place, density, value of the first."""
        choice = sample.x * 8192.0
        choice -= dr.floor(choice)

        def pick(found, kept_at, kept_pdf, total, choice):
            at, pdf, value = found
            total = total + value
            share = value / dr.maximum(total, 1e-30)
            picks = choice < share
            rest = dr.select(
                picks, choice / dr.maximum(share, 1e-20), (choice - share) / (1.0 - share)
            )
            kept_at, kept_pdf = dr.select(picks, at, kept_at), dr.select(picks, pdf, kept_pdf)
            return kept_at, kept_pdf, total, dr.clip(rest, 0.0, 1.0)

        def step(nth, kept_at, kept_pdf, total, choice):
            # Points of a lattice for either kind of candidate, each of them uniform by itself.
            shift = mi.Vector2f(0.7548776662, 0.5698402910)
            shifted = sample + shift * mi.Float(nth)
            shifted -= dr.floor(shifted)
            found = self._follow_back(row, number, half, q, mi.Point2f(shifted), beam, active)
            kept_at, kept_pdf, total, choice = pick(found, kept_at, kept_pdf, total, choice)
            nth = nth + 1
            shifted = sample + shift * mi.Float(nth)
            shifted -= dr.floor(shifted)
            more = active & (nth < CANDIDATES // 2)
            found = self._pick_point(row, number, half, q, mi.Point2f(shifted), beam, more, more)
            kept_at, kept_pdf, total, choice = pick(found, kept_at, kept_pdf, total, choice)
            return nth, kept_at, kept_pdf, total, choice

        _, kept_at, kept_pdf, total, _ = dr.while_loop(
            state=(mi.UInt32(0), *first, choice),
            cond=lambda nth, *_: active & (nth < CANDIDATES // 2),
            body=step,
            labels=("nth", "at", "pdf", "total", "choice"),
        )
        return kept_at, kept_pdf, dr.select(active, total / float(CANDIDATES), total)

    def _beam(self, row, point, active):
        """Part of the distribution that can reach a place from the opening, and whether candidates pay there.

        They do where the opening is large, measured by the beam's width, and enough of the light goes that way.

        Returns
        -------
        Part or None, Bool
        """
        if not self.has_narrow:
            return None, mi.Bool(False)
        away = point - mi.Point3f(self._vector(row, 7, active))
        squared = dr.squared_norm(away)
        near = active & (squared < dr.gather(mi.Float, self._reach, row, active))
        axis = self._to_local(row, 0, away, near)
        sine = dr.norm(self._vector(row, 6, near)) * dr.rsqrt(dr.maximum(squared, 1e-12))
        part = self.tables.surround(self._number(row, 1, near), axis, sine, near)
        return part, near & (part.share > LEAST_SHARE)

    def _pick_point(self, row, number, half, q, sample, beam, is_near, active):
        """Candidate on the opening: the point, its density, and what it gives over that density."""
        x, density, normal = draw_point(number, half, q, sample, self.kinds)
        away = q - x
        distance = dr.norm(away)
        local = away / dr.maximum(distance, 1e-12)
        seen = dr.dot(normal, local)
        usable = active & (density > 0.0) & (seen > 0.0)
        pdf = density * dr.square(distance) / dr.maximum(seen, 1e-20)
        pdf, value = self._weigh(row, number, half, local, pdf, beam, is_near, usable)
        return x, pdf, value

    def _follow_back(self, row, number, half, q, sample, beam, active):
        """Candidate in the beam: a direction of it, followed from the receiver back to the opening."""
        drawn = self.tables.draw_in(beam, sample, active)
        local = self._to_local(row, 3, self._to_world(row, 0, drawn, active), active)
        distance, pdf = meet(number, half, q, -local, self.kinds)
        pdf, value = self._weigh(row, number, half, local, pdf, beam, active, active & (pdf > 0.0))
        return q - local * distance, pdf, value

    def _weigh(self, row, number, half, local, pdf, beam, is_near, active):
        """Density of a candidate whatever way it was found, and what it gives over that. ``pdf``: that of a point."""
        density = self.density(row, self._to_world(row, 3, local, active), active)
        if beam is not None:
            pdf = dr.select(
                is_near, 0.5 * (pdf + density / dr.maximum(beam.share, LEAST_SHARE)), pdf
            )
        area = projected_area(number, half, local, self.kinds)
        value = density / (area * dr.maximum(pdf, 1e-20))
        active &= dr.isfinite(value)
        return dr.select(active, pdf, 0.0), dr.select(active, value, 0.0)

    def density_at(self, row, point, direction, active):
        """Mean density with which the candidates for a receiver lie in a direction from it. [1/sr]"""
        centre = mi.Point3f(self._vector(row, 7, active))
        q = mi.Point3f(self._to_local(row, 3, point - centre, active))
        local = self._to_local(row, 3, direction, active)
        number, half = self._number(row, 0, active), self._vector(row, 6, active)
        _, pdf = meet(number, half, q, local, self.kinds)
        hit = active & (pdf > 0.0)
        if self.has_narrow:
            beam, is_near = self._beam(row, point, hit)
            density = self.density(row, -direction, is_near) / dr.maximum(beam.share, LEAST_SHARE)
            pdf = dr.select(is_near, 0.5 * (pdf + density), pdf)
        return dr.select(hit, pdf, 0.0)

    def is_outside(self, row, si, active):
        """Whether a surface point of an opening is met from where it shines to."""
        number = self._number(row, 0, active)
        flat = (number == RECTANGLE) | (number == ELLIPSE)
        return flat | (mi.Frame3f.cos_theta(si.wi) > 0.0)

    def emit(self, row, place, angle, active):
        """Draw where and whereto light leaves a luminaire, in proportion to what it emits.

        Parameters
        ----------
        place, angle : Point2f    Two numbers in [0, 1) each.

        Returns
        -------
        (Point3f, Vector3f, Normal3f)    Point, direction and outward normal, in the scene's frame.
        """
        drawn = self.tables.draw(self._number(row, 1, active), angle, active)
        direction = self._to_world(row, 0, drawn, active)
        local = self._to_local(row, 3, direction, active)
        number, half = self._number(row, 0, active), self._vector(row, 6, active)
        point, normal = draw_departure(number, half, local, place, self.kinds)
        centre = self._vector(row, 7, active)
        start = mi.Point3f(self._to_world(row, 3, mi.Vector3f(point), active) + centre)
        return start, direction, mi.Normal3f(self._to_world(row, 3, normal, active))
