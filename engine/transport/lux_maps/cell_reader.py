"""What paths read of cells that they meet: the part of the path loop that ends most of them."""

import drjit as dr
import mitsuba as mi

from ...arrays import average
from ..paths.next_event import power_heuristic
from ..paths.path_loop import Path, Vertex

NEAR = 2.0
"""Distance within which cells are not read, in their sizes."""

MIXED, NEARBY = 0.25, 1e6
"""Width of a ray's way, relative to that by the cosine law, from which on it mixes the light of many places; and what stands
for the width of the next such scattering, by which cells are read however near. [-]"""

MIRRORED = 2.0
"""Share of what is asked for the light that a coat mirrors, in its reflectances."""


class CellReader:
    """Reads what matt surfaces send where paths meet them: the part of a `PathLoop` that ends most paths.

    Of a vertex it sets ``is_readable``, whether the base of the surface there is read; ``row`` of the table of matt
    surfaces, 0 where it is none; ``coat``, the reflectance of its coat; ``matte``, what its base sends for the irradiance
    that passes the coat [sr-1]; and ``glossy``, the share of scattered rays that the coat takes.

    Parameters
    ----------
    scene, cells : CompiledScene, CellSet or None
    reads : bool    Whether cells are read, and not only light that was traced to them.
    mirrored_ratio : Float    Next-event samples of the receivers over mirrors for every ray.
    rival : (Guide, Point3f, Float) or None    What competes with rays of the receivers: a guide, where they are, and samples
        of it for every ray; None: nothing does.
    leaves_matt : bool    Whether paths end at a matt surface that they meet first, as what it sends is found otherwise.
    """

    def __init__(
        self, scene, cells, reads: bool, mirrored_ratio, rival=None, leaves_matt: bool = False
    ):
        self._scene, self._cells, self._reads = scene, cells, reads
        self._leaves_matt = leaves_matt
        self._mirrored_ratio, self._rival = mirrored_ratio, rival
        self._has_traced = cells is not None and bool(cells) and cells.traced is not None
        self._spots = cells.spots if self._has_traced else None
        self._has_coat = reads and cells.matt.has_coat

    def begin(self, path: Path) -> None:
        """Prepare paths of a camera, which read nothing before they have been spread out."""
        path.ratio, path.read, path.spread = mi.Float(1.0), mi.Spectrum(0.0), mi.Float(0.0)
        path.is_read, path.is_asked = mi.Bool(False), mi.Bool(False)

    def read(self, path: Path, at: Vertex) -> None:
        """Count what a matt surface sends; of those that are read only coats send paths on."""
        at.is_readable, at.row = mi.Bool(False), mi.UInt32(0)
        if not (self._reads or self._has_traced):
            return
        cells, si = self._cells, at.si
        at.row, at.coat, side, local, readable = locate(
            cells, at.hit, si, path.reference, path.active, path.spread
        )
        is_matt = at.row > 0
        at.matte = matt_response(cells, at.bsdf, si, at.row, at.coat, is_matt)
        if self._leaves_matt:
            path.active &= (path.steps > 0) | ~is_matt | at.is_hidden
            at.row, is_matt = dr.select(path.active, at.row, 0), is_matt & path.active
            readable &= path.active
        if self._has_traced:
            self._read_traced(path, at, side, local, is_matt)
        # What was read before is so, whatever rounding says here.
        at.is_readable = (readable & self._reads) | path.is_read
        value = cells.value(side, si.wavelengths, at.is_readable)
        value *= self._against_rival(path, at, side, local, at.is_readable)
        read = path.read + path.throughput * at.matte * value
        path.read = dr.select(at.is_readable & ~path.is_read, read, path.read)
        if self._reads:
            path.active &= ~at.is_readable | (at.coat > 0.0)

    def _read_traced(self, path: Path, at: Vertex, side, local, is_matt) -> None:
        """Count what a matt surface sends of light that was traced to it."""
        value = self._cells.traced_value(side, local, at.si.wavelengths, is_matt)
        value *= self._against_rival(path, at, side, local, is_matt)
        if self._spots is not None:
            rival, first = (self._spots, path.reference, 1.0), is_matt & path.is_asked
            value *= weigh_against_guide(*rival, at.si, side, local, path.pdf, first)
        lit = is_matt & ~path.is_read
        radiance = path.radiance + path.throughput * at.matte * value
        path.radiance = dr.select(lit, radiance, path.radiance)

    def _against_rival(self, path: Path, at: Vertex, side, local, active):
        """Weight of what is read beside points that the guide chooses."""
        if self._rival is None:
            return 1.0
        # Only what a straight line from the receiver meets could have been chosen.
        first = active & (path.depth == 1)
        return weigh_against_guide(*self._rival, at.si, side, local, path.pdf, first)

    def keep_coat(self, path: Path, at: Vertex) -> None:
        """Leave of a surface whose base is read the coat alone, and ask only some of them what light it mirrors."""
        if not self._has_coat:
            return
        # A coat mirrors little, so few are asked. What has none has ended; a chance of 0 would make its nothing no number.
        share = dr.minimum(MIRRORED * at.coat, 1.0)
        at.chance = dr.select(at.is_readable & ~path.is_read & (share > 0.0), share, 1.0)
        at.smooth &= path.stream.next_float32() < at.chance
        # The least number chooses the coat.
        at.choice = dr.select(at.is_readable, 0.0, at.choice)
        reflectance = at.bsdf.eval_diffuse_reflectance(at.si, at.is_readable)
        base = (1.0 - at.coat) * average(reflectance)
        at.glossy = at.coat / dr.maximum(at.coat + base, 1e-8)
        respond = at.respond

        def respond_by_coat(direction, asked):
            return self._of_coat(at, at.si.to_local(direction), *respond(direction, asked))

        at.respond = respond_by_coat

    def _of_coat(self, at: Vertex, wo, response, density):
        """Response and density of the coat, where the base is read."""
        cosine = dr.abs(mi.Frame3f.cos_theta(wo))
        passes = 1.0 - self._cells.matt.coat(at.row, cosine, at.is_readable)
        part = dr.maximum(response - at.matte * cosine * passes, 0.0)
        own = density - (1.0 - at.glossy) * cosine * dr.inv_pi
        own = dr.maximum(own, 0.0) / dr.maximum(at.glossy, 1e-8)
        return dr.select(at.is_readable, part, response), dr.select(at.is_readable, own, density)

    def ask_spots(self, path: Path, at: Vertex) -> None:
        """Count traced light on small spots: rays would meet it by chance only, once in thousands of paths."""
        if self._spots is None:
            return
        stream = path.stream
        which = stream.next_float32()
        where = mi.Point2f(stream.next_float32(), stream.next_float32())
        light = self._spots.traced_light(self._scene, at.si, which, where, at.respond, at.smooth)
        path.radiance = path.radiance + path.throughput * light / at.chance

    def scatter(self, at: Vertex, bs, scattered):
        """Correct the density of a sample, and return its weight."""
        if not self._has_coat:
            return scattered
        response, density = self._of_coat(at, bs.wo, scattered * bs.pdf, bs.pdf)
        found = dr.select(density > 0.0, response / dr.maximum(density, 1e-20), 0.0)
        bs.pdf = density
        return dr.select(at.is_readable, found, scattered)

    def see_mirror(self, path: Path, is_mirrored) -> None:
        """Note that next-event of the receiver over mirrors has its own number of samples."""
        own = is_mirrored & (path.depth == 1)
        path.ratio = dr.select(own, self._mirrored_ratio, path.ratio)

    def leave(self, path: Path, anew, turned, is_delta) -> None:
        """Note what a path that goes on competes with."""
        path.ratio = dr.select(anew, 1.0, path.ratio)
        if path.spread is not None:
            # Where in a corner a cell is read does not matter to what two wide scatterings have mixed.
            spread = dr.select(path.spread > MIXED, NEARBY, spread_of(path.pdf))
            path.spread = dr.select(anew & ~is_delta, spread, path.spread)
        path.is_asked = dr.select(turned, ~is_delta, path.is_asked)
        path.is_read = mi.Bool(False)


def spread_of(pdf):
    """Width of the light's way along a ray of such density, relative to that by the cosine law, at most 1. [-]"""
    return dr.minimum(dr.rsqrt(dr.maximum(pdf, 1e-20) * dr.pi), 1.0)


def locate(cells, hit, si, reference, active, spread=None):
    """Row of the matt table (0: not matt), reflectance of the coat, side of the cell, where in it, whether it is read.

    ``spread``: width of the light's way to the reference, relative to that by the cosine law; None: 1. [-]
    """
    row = dr.select(active, cells.matt.row(si.shape, active), 0)
    is_matt = row > 0
    cosine = mi.Frame3f.cos_theta(si.wi)
    coat = mi.Float(cells.matt.coat(row, cosine, is_matt))
    side, local = cells.locate(si.shape, hit.prim_index, hit.prim_uv, cosine < 0.0, is_matt)
    width = dr.norm(si.p - reference)
    if spread is not None:
        width *= spread
    readable = is_matt & (width > NEAR * cells.near(si.shape, is_matt))
    # However mixed the light: behind a wall that runs through a cell there may be a thousand times more.
    readable &= ~dr.gather(mi.Bool, cells.uneven, side, readable)
    return row, coat, side, local, readable


def matt_response(cells, bsdf, si, row, coat, active):
    """Radiance that a matt surface sends for the irradiance that passes its coat. [sr-1]"""
    return bsdf.eval_diffuse_reflectance(si, active) * (
        (1.0 - coat) * cells.matt.scale(row, active) * dr.inv_pi
    )


def weigh_against_guide(guide, reference, ratio, si, side, local, pdf, active):
    """Weight of what a ray has found on a cell, beside so many points that the guide chooses for every ray. [-]"""
    away = si.p - reference
    facing = dr.abs(dr.dot(dr.normalize(away), si.n))
    found = guide.density(side, local, active) * dr.squared_norm(away)
    found *= ratio / dr.maximum(facing, 1e-9)
    return dr.select(active, power_heuristic(pdf, found), 1.0)
