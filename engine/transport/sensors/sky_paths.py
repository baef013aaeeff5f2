"""Paths from sensors that tell what sensors have of each part of the sky, instead of how much light arrives.

The world shines evenly, and the path loop is that of all others: at every vertex the world is asked, and scattered rays
that leave the scene find it too, joined by the power heuristic. But what is found is not added up; it is put down for the
nodes of the sky around the direction in which it was found. So one pass serves all skies.

The sun is no part of the sky. What sensors have of it straight is found sun by sun (`sun_rays`). What surfaces send on of it
is put down in two ways: for matt surfaces as what the sensor has of the light on the surface's cell, to be multiplied by the
sun there; for all else (coats, gloss, mirrors, panes that reflect) by the nodes of the sky, as with the sky.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...sky.nodes import SkyNodes
from ..lux_maps.cell_reader import locate, matt_response
from ..paths.next_event import power_heuristic, sample_emitter, surroundings_density
from ..paths.path_loop import Path, PathLoop, Vertex, _ray_weight
from ..paths.visibility import transmittance
from ..rays import spawn_ray
from .sky_bands import DeviceBands

UNIT = float(1 << 30)
"""Parts of 1 in which sums are kept as whole numbers: the order of the sums must not change them."""

QUARTERS = 4
"""Of a cell, whose light is compared."""

LARGEST = float(1 << 22)
"""More than that a single path cannot bring. [lx m2/cd]"""


class SkyTable:
    """Sums by sensor and node, on the device.

    Parameters
    ----------
    nodes : SkyNodes
    rows : int    Sensors, or anything that sums are kept apart for.
    cells : int    Of the scene.
    sides : (s,) uint32 array    Sides of them that are known.
    parts : int    In which all light of a row is put down too.
    bands : DeviceBands or None    By which sums of a row are kept apart; None: they are not. Rows, or sides where paths end,
        have their bands side by side.
    even : (g, s, b) array or None    Light of an even world of 1 cd/m2 on sides that paths end at, for every group of rows
        and every band, over the band's share; None: they do not end there. [lx]
    beyond : (s, q) array or None    By how much that on quarters of them differs from it. [lx]
    read_bands : DeviceBands or None    Of ``even``.
    """

    def __init__(
        self,
        nodes: SkyNodes,
        rows: int,
        cells: int,
        sides: np.ndarray,
        parts: int = 1,
        bands: DeviceBands | None = None,
        even=None,
        beyond=None,
        read_bands: DeviceBands | None = None,
    ):
        self.nodes, self.rows, self.sides = nodes, rows, sides
        self._bands, self._read_bands = bands, read_bands
        self._count = 1 if bands is None else bands.count
        # One more for all that is below the horizon.
        self.width = nodes.count + 1
        self._counts = upload(mi.UInt32, nodes.counts)
        self._starts = upload(mi.UInt32, nodes.starts)
        self.sky = dr.zeros(mi.UInt64, rows * self._count * self.width)
        self.rest = dr.zeros(mi.UInt64, rows * self._count * self.width)
        self.cells = dr.zeros(mi.UInt64, max(rows * self._count * len(sides), 1))
        self._part_count, self.reads = parts, even is not None
        self.parts = dr.zeros(mi.UInt64, rows * parts)
        self.read = dr.zeros(mi.UInt64, rows * np.size(even[0]) if self.reads else 1)
        # What quarters have more and less than their cells.
        self.more, self.less = (dr.zeros(mi.UInt64, rows) for _ in range(2))
        if self.reads:
            self._even, self._beyond = upload(mi.Float, even), upload(mi.Float, beyond)
            self._rows_of_group = rows // len(even)
            dr.eval(self._even, self._beyond)
        column, is_known = (
            np.zeros(max(2 * cells, 1), dtype=np.uint32),
            np.zeros(max(2 * cells, 1), bool),
        )
        column[sides], is_known[sides] = np.arange(len(sides)), True
        self._column, self._is_known = upload(mi.UInt32, column), upload(mi.Bool, is_known)
        self.lost = dr.zeros(mi.UInt32, rows)
        dr.eval(self._counts, self._starts)
        self.evaluate()

    def evaluate(self) -> None:
        """Have all sums in memory."""
        dr.eval(
            self.sky, self.rest, self.cells, self.parts, self.read, self.more, self.less, self.lost
        )

    def put(self, row, direction, light, share, part, active) -> None:
        """Put down light from a direction.

        ``light``: a `SkyLight`. ``share``: of it that counts for the sun too, by nodes. ``part``: of the row, where there
        are any.
        """
        is_lost = active & ~dr.isfinite(light.amount)
        dr.scatter_add(self.lost, mi.UInt32(1), row, is_lost)
        active = active & dr.isfinite(light.amount) & (light.amount > 0.0)
        whole = row * self._part_count + part
        dr.scatter_add(self.parts, _fixed(light.amount), whole, active)
        portions = light.divide(self._bands)
        for node, weight in self._around(direction, active):
            for band, amount in portions:
                index = (row * self._count + band) * self.width + node
                own = dr.minimum(amount, LARGEST) * weight
                dr.scatter_add(self.sky, _fixed(own), index, active & (own > 0.0))
                some = own * share
                dr.scatter_add(self.rest, _fixed(some), index, active & (some > 0.0))

    def put_cell(self, row, side, local, depth, light, active) -> None:
        """Put down what the sun on a side of a cell counts for, wherever in it."""
        active, column = self._find_side(side, light, active)
        for band, amount in light.divide(self._bands):
            index = (row * self._count + band) * len(self.sides) + column
            dr.scatter_add(self.cells, _fixed(amount), index, active & (amount > 0.0))

    def put_read(self, row, side, light, quarter, active) -> None:
        """Put down what all light on a side of a cell counts for, where a path ends there.

        ``quarter``: of the cell.
        """
        active, column = self._find_side(side, light, active)
        group = row // dr.opaque(mi.UInt32, self._rows_of_group)
        bands = 1 if self._read_bands is None else self._read_bands.count
        whole = mi.Float(0.0)
        for band, amount in light.divide(self._read_bands):
            index = (row * len(self.sides) + column) * bands + band
            dr.scatter_add(self.read, _fixed(amount), index, active & (amount > 0.0))
            index = (group * len(self.sides) + column) * bands + band
            whole += amount * dr.gather(mi.Float, self._even, index, active)
        dr.scatter_add(self.parts, _fixed(whole), row, active)
        beyond = dr.gather(mi.Float, self._beyond, column * QUARTERS + quarter, active)
        beyond *= dr.minimum(light.amount, LARGEST)
        for sums, sign in ((self.more, 1.0), (self.less, -1.0)):
            part = dr.maximum(sign * beyond, 0.0)
            dr.scatter_add(sums, _fixed(part), row, active & (part > 0.0))

    def knows(self, side, active):
        """Whether a side is one of those that are known."""
        return dr.gather(mi.Bool, self._is_known, side, active)

    def _find_side(self, side, light, active):
        """Which light counts for known sides, and the column of each."""
        active = active & dr.isfinite(light.amount) & (light.amount > 0.0)
        active &= self.knows(side, active)
        return active, dr.gather(mi.UInt32, self._column, side, active)

    def _around(self, direction, active):
        """The nodes around a direction and their weights, as `SkyNodes.locate`; below the horizon the last one alone."""
        steps = self.nodes.steps
        below = direction.z < 0.0
        plan = dr.sqrt(dr.square(direction.x) + dr.square(direction.y))
        height = dr.atan2(dr.maximum(direction.z, 0.0), plan) * (2.0 * steps * dr.inv_pi)
        row = dr.minimum(mi.UInt32(height), steps - 1)
        upper = dr.clip(height - mi.Float(row), 0.0, 1.0)
        turn = dr.atan2(direction.y, direction.x) * dr.inv_two_pi
        turn = dr.select(turn < 0.0, turn + 1.0, turn)
        for above, share in ((0, 1.0 - upper), (1, upper)):
            count = dr.gather(mi.UInt32, self._counts, row + above, active)
            start = dr.gather(mi.UInt32, self._starts, row + above, active)
            place = turn * mi.Float(count)
            left = dr.minimum(mi.UInt32(place), dr.maximum(count, 1) - 1)
            aside = dr.clip(place - mi.Float(left), 0.0, 1.0)
            right = dr.select(left + 1 < count, left + 1, 0)
            is_first = above == 0
            weight = dr.select(below, 1.0 if is_first else 0.0, share * (1.0 - aside))
            yield dr.select(below, self.width - 1, start + left), weight
            yield start + right, dr.select(below, 0.0, share * aside)


class SkyLight:
    """Light of an even world that is put down.

    Parameters
    ----------
    amounts : Spectrum    By wavelength of the path; one where there are none. [lx m2/cd]
    wavelengths : Spectrum or None    [nm]
    """

    def __init__(self, amounts, wavelengths):
        self._amounts, self._wavelengths = amounts, wavelengths
        self.amount = dr.sum(amounts)

    def divide(self, bands: DeviceBands | None) -> list[tuple]:
        """Return it by bands, as pairs of a band and an amount; None: all of it in one."""
        if bands is None:
            return [(mi.UInt32(0), self.amount)]
        return bands.divide(self._amounts, self._wavelengths)


def _fixed(amount):
    """An amount as a whole number."""
    return mi.UInt64(dr.minimum(amount, LARGEST) * UNIT)


@dataclass
class SkyPath(Path):
    """A path whose light is put down by direction. ``rest``: share of its last scattering that the sun has by nodes."""

    rest: object = None


class SkyPathLoop(PathLoop):
    """Follows paths of sensors to their ends and puts down what they find.

    Parameters
    ----------
    scene : CompiledScene    Lit by an even world of 1 cd/m2 alone.
    table : SkyTable, or anything that takes what paths find
    cells : CellSet
    row : UInt32    Of the table, by path.
    wavelengths : Spectrum or None    [nm]
    sampler : WavelengthSampler or None
    scale : Float    What a path's throughput counts for at its sensor.
    part : UInt32    Of the row, where the table has any.
    """

    def __init__(self, scene, table: SkyTable, cells, row, wavelengths, sampler, scale, part):
        super().__init__(scene)
        self._table, self._cells, self._row = table, cells, row
        self._wavelengths, self._sampler, self._scale = wavelengths, sampler, scale
        self._part = part
        away = dr.zeros(mi.SurfaceInteraction3f, dr.width(row))
        away.wi = mi.Vector3f(0.0, 0.0, -1.0)
        if wavelengths is not None:
            away.wavelengths = wavelengths
        self._even = scene.surroundings.eval(away, mi.Bool(True))

    def put(self, direction, value, rest, active) -> None:
        """Put down spectral light of an even world."""
        self._table.put(self._row, direction, self._light(value), rest, self._part, active)

    def _light(self, value) -> SkyLight:
        """What a spectral value counts for at the sensor."""
        if self._sampler is not None:
            value = self._sampler.luminances(value, self._wavelengths)
        return SkyLight(value * self._scale, self._wavelengths)

    def _count_emitter(self, path: SkyPath, at: Vertex) -> None:
        """No lamp shines."""

    def _count_surroundings(self, path: SkyPath, at: Vertex) -> None:
        scene, direction = self._scene, path.ray.d
        leaves = path.active & ~at.si.is_valid()
        competes = leaves & (path.pdf > 0.0)
        found = surroundings_density(scene, at.origin, direction, competes)
        weight = _ray_weight(path.pdf, found)
        if scene.mirrors is not None:
            # Behind known mirrors vertices do not ask for the world, so that rays alone find it.
            weight = dr.select(path.chain[0] > 0, 1.0, weight)
        value = path.throughput * self._even * weight
        self.put(direction, value, path.rest, leaves)

    def _ask_lights(self, path: SkyPath, at: Vertex) -> None:
        scene, cells, si = self._scene, self._cells, at.si
        row, coat, side, local, readable = locate(cells, at.hit, si, path.reference, path.active)
        is_matt = row > 0
        at.row = row
        at.matte = matt_response(cells, at.bsdf, si, row, coat, is_matt)
        at.is_readable = mi.Bool(False)
        if len(self._table.sides):
            light = self._light(path.throughput * at.matte * self._even)
            if self._table.reads:
                at.is_readable = readable & at.smooth & self._table.knows(side, readable)
                quarter = dr.select(local.x > 0.5, mi.UInt32(1), 0) + dr.select(
                    local.y > 0.5, mi.UInt32(2), 0
                )
                self._table.put_read(self._row, side, light, quarter, at.is_readable)
                # Of what is read only coats send paths on.
                path.active &= ~at.is_readable | (coat > 0.0)
                at.smooth &= path.active
            lands = is_matt & at.smooth & ~at.is_readable
            self._table.put_cell(self._row, side, local, path.depth, light, lands)

        ds, value = sample_emitter(scene, si, at.light_sample, at.smooth)
        lit = at.smooth & (ds.pdf > 0.0) & dr.any(value != 0.0)
        response, response_pdf = at.respond(ds.d, lit)
        amount = path.throughput * response * value * power_heuristic(ds.pdf, response_pdf)
        lit &= dr.any(amount != 0.0)
        rest = self._rest_of(at, si.to_local(ds.d), response)
        amount *= dr.select(at.is_readable, rest, 1.0)
        rest = dr.select(at.is_readable, 1.0, rest)
        self.put(ds.d, amount * transmittance(scene, si, ds, lit), rest, lit)

    def _rest_of(self, at: Vertex, wo, response):
        """Share of a response that is not that of a matt base. [-]"""
        if not self._cells.matt.has_coat:
            return dr.select(at.row > 0, mi.Float(0.0), 1.0)
        cosine = dr.abs(mi.Frame3f.cos_theta(wo))
        passes = 1.0 - self._cells.matt.coat(at.row, cosine, at.row > 0)
        base = dr.sum(at.matte) * cosine * passes
        whole = dr.maximum(dr.sum(response), 1e-20)
        return dr.select(at.row > 0, dr.clip(1.0 - base / whole, 0.0, 1.0), 1.0)

    def _scatter(self, path: SkyPath, at: Vertex):
        before = mi.Spectrum(path.throughput)
        bs, turned = super()._scatter(path, at)
        is_delta = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
        response = path.throughput / dr.maximum(before, 1e-20) * bs.pdf
        rest = dr.select(is_delta, 1.0, self._rest_of(at, bs.wo, response))
        path.throughput *= dr.select(at.is_readable, rest, 1.0)
        rest = dr.select(at.is_readable, 1.0, rest)
        path.rest = dr.select(turned, rest, path.rest)
        return bs, turned


def trace_sensors(
    scene, table: SkyTable, cells, si, passes, row, wavelengths, sampler, stream, samples, part=0
):
    """Follow one path of every lane's sensor, and put down what it finds.

    Parameters
    ----------
    si : SurfaceInteraction3f    Sensors, as of `gather.receiver`.
    passes : callable    What of the light at a cosine counts. [-]
    row : UInt32    Of the table.
    wavelengths : Spectrum or None    [nm]
    sampler : WavelengthSampler or None
    stream : PCG32
    samples : (Point2f, Point2f)    Well-distributed, for the world and for the ray.
    part : UInt32    Of the row, where the table has any.
    """
    part = mi.UInt32(part)

    def answer(direction, asked):
        facing = dr.select(dr.dot(direction, si.n) > 0.0, dr.dot(direction, si.sh_frame.n), 0.0)
        facing = dr.maximum(facing, 0.0)
        return facing * passes(facing), facing * dr.inv_pi

    active = mi.Bool(True)
    direct = SkyPathLoop(scene, table, cells, row, wavelengths, sampler, mi.Float(1.0), part)
    ds, value = sample_emitter(scene, si, samples[0], active)
    lit = active & (ds.pdf > 0.0) & dr.any(value != 0.0)
    response, density = answer(ds.d, lit)
    amount = response * value * power_heuristic(ds.pdf, density)
    lit &= dr.any(amount != 0.0)
    direct.put(ds.d, amount * transmittance(scene, si, ds, lit), mi.Float(0.0), lit)

    local = mi.warp.square_to_cosine_hemisphere(samples[1])
    direction = si.sh_frame.to_world(local)
    response, density = answer(direction, active)
    active = (density > 0.0) & (response > 0.0)
    ray = mi.Ray3f(spawn_ray(scene, si, direction))
    if wavelengths is not None:
        ray.wavelengths = wavelengths
    path = SkyPath(
        ray,
        mi.PCG32(stream),
        mi.Float(density),
        mi.Point3f(si.p),
        mi.UInt32(1),
        mi.Bool(active),
        rest=mi.Float(0.0),
    )
    scale = dr.select(active, response / density, 0.0)
    SkyPathLoop(scene, table, cells, row, wavelengths, sampler, scale, part).run(path)


def read_sums(sums, rows: int, width: int) -> np.ndarray:
    """Sums of a table as numbers. (rows, width) float32"""
    found = np.asarray(sums).reshape(rows, width)
    return np.multiply(found, np.float32(1.0 / UNIT), dtype=np.float32, casting="unsafe")
