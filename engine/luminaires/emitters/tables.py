"""Intensity distributions on the device: evaluated exactly, sampled exactly, as many as a scene has.

All distributions lie behind each other in a few arrays, and which of them is meant is a number, so a kernel is the same
however many there are. Intensities are divided by the distribution's flux: what is evaluated is a density over the sphere
[1/sr], with which directions are also drawn, so that a direction's weight is the flux itself.
"""

import hashlib
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.distribution import IntensityDistribution
from ..distribution import TURN
from .distribution_arrays import IMPORTANCE, PreparedDistribution, prepare

HEADER = (
    "azimuth_bins", "azimuth_cells", "polar_bins", "polar_cells",
    "azimuth_guide", "polar_guide", "azimuth_nodes", "polar_nodes",
    "cells", "rows", "columns", "sums", "importance",
)  # fmt: skip
"""Whole numbers known of each distribution: lengths, and where its parts begin."""


@dataclass
class Part:
    """Cells of a distribution, from ``column`` and ``row`` up to before the ends, and their ``share`` of its flux."""

    number: object
    column: object
    column_end: object
    row: object
    row_end: object
    share: object


def distribution_digest(distribution: IntensityDistribution) -> bytes:
    """SHA-256 of the grid and its values, the frame aside."""
    digest = hashlib.sha256()
    for part in (distribution.azimuth, distribution.polar, distribution.intensity):
        digest.update(np.ascontiguousarray(part, dtype=np.float64).tobytes())
        digest.update(b"|")
    if distribution.colours is not None:
        digest.update(np.ascontiguousarray(distribution.colours, dtype=np.float32).tobytes())
    return digest.digest()


class DistributionTables:
    """The distributions of a scene.

    `commit` takes those in use; `density`, `draw` and `importance` work inside kernels on their numbers.
    """

    def __init__(self):
        self._prepared: dict[bytes, PreparedDistribution] = {}
        self._numbers: dict[bytes, int] = {}
        self._upload()

    def commit(
        self, distributions: list[IntensityDistribution], digests: list[bytes] | None = None
    ) -> list[int]:
        """Hold these distributions and return their numbers; equal ones are held once.

        Parameters
        ----------
        digests : list of bytes or None    Their `distribution_digest`, if known.

        Raises
        ------
        SceneError    One has no flux.
        """
        if digests is None:
            digests = [distribution_digest(distribution) for distribution in distributions]
        wanted = dict(zip(digests, distributions, strict=True))
        order = sorted(wanted)
        if order != list(self._numbers):
            known = self._prepared
            self._prepared = {k: known.get(k) or prepare(wanted[k]) for k in order}
            self._numbers = {key: number for number, key in enumerate(order)}
            self._upload()
        return [self._numbers[digest] for digest in digests]

    def _upload(self) -> None:
        parts = list(self._prepared.values())
        header = np.zeros((max(len(parts), 1), len(HEADER)), dtype=np.int64)
        stores = {
            "azimuth_guide": "_guides", "polar_guide": "_guides",
            "azimuth_nodes": "_nodes", "polar_nodes": "_nodes",
            "cells": "_cells", "rows": "_running", "columns": "_running",
            "sums": "_sums", "importance": "_importance",
        }  # fmt: skip
        pieces: dict[str, list[np.ndarray]] = {name: [] for name in stores.values()}
        lengths = dict.fromkeys(pieces, 0)
        for line, part in zip(header, parts, strict=False):
            for name, count in part.header.items():
                line[HEADER.index(name)] = count
            for name, store in stores.items():
                values = getattr(part, name)
                line[HEADER.index(name)] = lengths[store]
                lengths[store] += len(values)
                pieces[store].append(values.reshape(-1))
        for store, values in pieces.items():
            whole = np.concatenate(values) if values else np.zeros(4)
            setattr(self, store, upload(mi.Float, whole))
        self._header = upload(mi.UInt32, header)
        ranges = np.concatenate([part.ranges for part in parts]) if parts else np.zeros(4)
        self._ranges = upload(mi.Float, ranges)
        # Scalars are read once for all lanes; what is gathered is read lane by lane.
        self._single = None
        if len(parts) == 1:
            numbers = {
                n: dr.opaque(mi.UInt32, int(v)) for n, v in zip(HEADER, header[0], strict=True)
            }
            span = [dr.opaque(mi.Float, float(value)) for value in parts[0].ranges]
            self._single = numbers, mi.Vector4f(*span)
        self._is_even = all(part.is_even for part in parts)
        self._crowding = max((part.crowding for part in parts), default=1)
        counts = [max(p.header["polar_cells"], p.header["azimuth_cells"]) for p in parts]
        # A power of two, so that kernels seldom change.
        self._steps = max(int(max(counts, default=1)).bit_length(), 8)

    def contrast(self, number: int) -> float:
        """Peak of a distribution over its mean over the sphere; 4 if it is Lambertian."""
        return list(self._prepared.values())[number].contrast

    def sharpness(self, number: int) -> float:
        """How sharp the features of a distribution are, see `distribution_arrays`."""
        return list(self._prepared.values())[number].sharpness

    # ---- inside kernels ----

    def _entry(self, number, name: str, active):
        if self._single is not None:
            return self._single[0][name]
        return dr.gather(mi.UInt32, self._header, number * len(HEADER) + HEADER.index(name), active)

    def _range(self, number, active):
        if self._single is not None:
            return self._single[1]
        return dr.gather(mi.Vector4f, self._ranges, number, active)

    def _locate(self, number, axis: str, value, start, end, active):
        """Cell of a value and the place in it, 0..1."""
        if self._is_even:
            count = self._entry(number, f"{axis}_cells", active)
            place = dr.maximum((value - start) / dr.maximum(end - start, 1e-12), 0.0) * mi.Float(
                count
            )
            cell = dr.minimum(mi.UInt32(place), count - 1)
            return cell, dr.clip(place - mi.Float(cell), 0.0, 1.0)
        bins = self._entry(number, f"{axis}_bins", active)
        share = (value - start) / dr.maximum(end - start, 1e-12)
        bin_ = dr.minimum(mi.UInt32(dr.maximum(share, 0.0) * mi.Float(bins)), bins - 1)
        base = self._entry(number, f"{axis}_guide", active)
        guide = dr.gather(mi.Vector2f, self._guides, base + bin_, active)
        cell = mi.UInt32(guide.x)
        last = self._entry(number, f"{axis}_cells", active) - 1
        nodes = self._entry(number, f"{axis}_nodes", active)
        cell = dr.select((value >= guide.y) & (cell < last), cell + 1, cell)
        for _ in range(self._crowding - 1 if self._crowding <= 4 else 0):
            following = dr.gather(
                mi.Vector2f, self._nodes, nodes + dr.minimum(cell + 1, last), active
            )
            cell = dr.select((value >= following.x) & (cell < last), cell + 1, cell)
        if self._crowding > 4:
            cell = self._search(
                lambda i: dr.gather(mi.Vector2f, self._nodes, nodes + i, active).x <= value,
                last + 1,
            )
        node = dr.gather(mi.Vector2f, self._nodes, nodes + cell, active)
        return cell, dr.clip((value - node.x) * node.y, 0.0, 1.0)

    def _search(self, is_reached, count):
        """Return the last of ``count`` places that is reached; the first always is."""
        low, size = mi.UInt32(0), mi.UInt32(count)
        for _ in range(self._steps):
            half = size // 2
            middle = low + half
            goes = (half > 0) & is_reached(middle)
            low = dr.select(goes, middle, low)
            size = dr.select(goes, size - half, dr.select(half > 0, half, size))
        return low

    @staticmethod
    def _angles(direction, ranges):
        """Azimuth within the grid's range, where that can be, and polar angle. [rad]"""
        azimuth = dr.atan2(direction.y, direction.x)
        azimuth = dr.select(azimuth < 0.0, azimuth + TURN, azimuth)
        # Grids may begin below 0 or end beyond a turn.
        azimuth = dr.select(azimuth > ranges.y + 1e-5, azimuth - TURN, azimuth)
        azimuth = dr.select(azimuth < ranges.x - 1e-5, azimuth + TURN, azimuth)
        flat = dr.sqrt(dr.square(direction.x) + dr.square(direction.y))
        return azimuth, dr.atan2(flat, -direction.z)

    def density(self, number, direction, active=True):
        """Intensity over flux in a direction of the grid's own axes, which need not be of unit length. [1/sr]"""
        active = mi.Bool(active)
        ranges = self._range(number, active)
        azimuth, polar = self._angles(direction, ranges)
        slack = 1e-5
        inside = (
            active
            & (azimuth >= ranges.x - slack)
            & (azimuth <= ranges.y + slack)
            & (polar >= ranges.z - slack)
            & (polar <= ranges.w + slack)
        )
        column, u = self._locate(number, "azimuth", azimuth, ranges.x, ranges.y, inside)
        row, v = self._locate(number, "polar", polar, ranges.z, ranges.w, inside)
        cell = column * self._entry(number, "polar_cells", inside) + row
        place = (self._entry(number, "cells", inside) + cell) * 4
        quad = mi.Vector4f(*(dr.gather(mi.Float, self._cells, place + k, inside) for k in range(4)))
        low = dr.fma(quad.y - quad.x, v, quad.x)
        high = dr.fma(quad.w - quad.z, v, quad.z)
        return dr.select(inside, dr.fma(high - low, u, low), 0.0)

    def draw(self, number, sample, active=True):
        """Draw a direction in the grid's own axes with the probability density `density`.

        Parameters
        ----------
        number : UInt32    Of the distribution.
        sample : Point2f    Two numbers in [0, 1).
        """
        active = mi.Bool(active)
        polar_cells = self._entry(number, "polar_cells", active)
        azimuth_cells = self._entry(number, "azimuth_cells", active)
        row, first = self._pick(self._entry(number, "rows", active), polar_cells, sample.x, active)
        base = self._entry(number, "columns", active) + row * (azimuth_cells + 1)
        column, second = self._pick(base, azimuth_cells, sample.y, active)
        return self._draw_in_cell(number, column, row, first, second, active)

    def surround(self, number, direction, sine, active=True):
        """Find the part of a distribution that holds a cone of directions.

        Parameters
        ----------
        direction : Vector3f    The cone's axis in the grid's own axes, of any length.
        sine : Float    Of half the cone's angle; 1 or more: every direction.

        Returns
        -------
        Part
        """
        active = mi.Bool(active)
        ranges = self._range(number, active)
        azimuth, polar = self._angles(direction, ranges)
        half = dr.safe_asin(dr.minimum(sine, 1.0))
        # A little more, so that rounding leaves nothing out.
        half += 1e-4
        low, high = polar - half, polar + half
        aside = dr.safe_asin(dr.minimum(dr.sin(half) / dr.maximum(dr.sin(polar), 1e-6), 1.0)) + 1e-4
        left, right = azimuth - aside, azimuth + aside
        is_whole = (low <= 0.0) | (high >= dr.pi) | (sine >= 1.0)
        is_whole |= (left < ranges.x) | (right > ranges.y)
        low = dr.select(sine >= 1.0, ranges.z, dr.clip(low, ranges.z, ranges.w))
        high = dr.select(sine >= 1.0, ranges.w, dr.clip(high, ranges.z, ranges.w))
        left = dr.select(is_whole, ranges.x, left)
        right = dr.select(is_whole, ranges.y, right)
        first_row, _ = self._locate(number, "polar", low, ranges.z, ranges.w, active)
        last_row, _ = self._locate(number, "polar", high, ranges.z, ranges.w, active)
        first_column, _ = self._locate(number, "azimuth", left, ranges.x, ranges.y, active)
        last_column, _ = self._locate(number, "azimuth", right, ranges.x, ranges.y, active)
        part = Part(number, first_column, last_column + 1, first_row, last_row + 1, mi.Float(0.0))
        part.share = self._before(part, part.row_end, active) - self._before(part, part.row, active)
        return part

    def draw_in(self, part, sample, active=True):
        """Draw a direction as `draw` does, but in a part: its density is that of all directions over the part's share."""
        active = mi.Bool(active)
        start = self._before(part, part.row, active)
        wanted = start + sample.x * part.share
        count = part.row_end - part.row
        chosen = self._search(lambda i: self._before(part, part.row + i, active) <= wanted, count)
        row = part.row + chosen
        low, high = self._before(part, row, active), self._before(part, row + 1, active)
        first = dr.clip((wanted - low) / dr.maximum(high - low, 1e-12), 0.0, 0.9999999)
        cells = self._entry(part.number, "azimuth_cells", active)
        base = self._entry(part.number, "columns", active) + row * (cells + 1)

        def running(column):
            return dr.gather(mi.Float, self._running, base + column, active)

        start, end = running(part.column), running(part.column_end)
        wanted = start + sample.y * (end - start)
        count = part.column_end - part.column
        chosen = self._search(lambda i: running(part.column + i) <= wanted, count)
        column = part.column + chosen
        low, high = running(column), running(column + 1)
        second = dr.clip((wanted - low) / dr.maximum(high - low, 1e-12), 0.0, 0.9999999)
        return self._draw_in_cell(part.number, column, row, first, second, active)

    def _before(self, part, row, active):
        """Share of the flux in a part's columns and in the rows before one."""
        rows = self._entry(part.number, "polar_cells", active) + 1
        base = self._entry(part.number, "sums", active) + row
        end = dr.gather(mi.Float, self._sums, base + part.column_end * rows, active)
        return end - dr.gather(mi.Float, self._sums, base + part.column * rows, active)

    def _draw_in_cell(self, number, column, row, first, second, active):
        """Draw a direction in a cell, polar angle by ``first``, azimuth by ``second``."""
        ranges = self._range(number, active)
        polar_cells = self._entry(number, "polar_cells", active)
        cell = self._entry(number, "cells", active) + column * polar_cells + row
        quad = dr.gather(mi.Vector4f, self._cells, cell, active)
        nodes = self._entry(number, "polar_nodes", active)
        node = dr.gather(mi.Vector2f, self._nodes, nodes + row, active)
        half = 0.5 / node.y
        middle = node.x + half
        sine, cosine = dr.sincos(middle)
        # Weights of the cell's two polar nodes, from which the density over the azimuth follows, a linear one.
        squared = dr.square(half)
        total = sine * 2.0 * half * (1.0 - squared / 6.0)
        lever = cosine * squared * (2.0 / 3.0) * (1.0 - squared / 10.0)
        low = quad.x * (total - lever) + quad.y * (total + lever)
        high = quad.z * (total - lever) + quad.w * (total + lever)
        u = _draw_linear(low, high, second)
        begin, end = dr.lerp(quad.x, quad.z, u), dr.lerp(quad.y, quad.w, u)
        polar = middle + half * _draw_polar(begin, end, half, sine, cosine, first)
        nodes = self._entry(number, "azimuth_nodes", active)
        node = dr.gather(mi.Vector2f, self._nodes, nodes + column, active)
        azimuth = node.x + u / node.y
        sine, cosine = dr.sincos(dr.clip(polar, ranges.z, ranges.w))
        around, across = dr.sincos(azimuth)
        return mi.Vector3f(sine * across, sine * around, -cosine)

    def _pick(self, base, count, u, active):
        """Choose an entry by its running shares; returns it and the stretched remainder."""
        chosen = self._search(
            lambda i: dr.gather(mi.Float, self._running, base + i, active) <= u, count
        )
        low = dr.gather(mi.Float, self._running, base + chosen, active)
        high = dr.gather(mi.Float, self._running, base + chosen + 1, active)
        return chosen, dr.clip((u - low) / dr.maximum(high - low, 1e-12), 0.0, 0.9999999)

    def importance(self, number, direction, active=True):
        """Coarse intensity relative to its mean in a direction of the grid's own axes, at least `FLOOR`."""
        size = dr.abs(direction.x) + dr.abs(direction.y) + dr.abs(direction.z)
        d = direction / dr.maximum(size, 1e-20)
        # Below the equator of the map the corners are folded out.
        x = (1.0 - dr.abs(d.y)) * dr.sign(d.x)
        y = (1.0 - dr.abs(d.x)) * dr.sign(d.y)
        x, y = dr.select(d.z < 0.0, x, d.x), dr.select(d.z < 0.0, y, d.y)
        last = mi.UInt32(IMPORTANCE - 1)
        column = dr.minimum(mi.UInt32((x * 0.5 + 0.5) * IMPORTANCE), last)
        row = dr.minimum(mi.UInt32((y * 0.5 + 0.5) * IMPORTANCE), last)
        base = self._entry(number, "importance", active)
        return dr.gather(mi.Float, self._importance, base + row * IMPORTANCE + column, active)


def _draw_linear(low, high, u):
    """Draw a place in 0..1 from a density that runs straight from ``low`` to ``high``."""
    root = dr.sqrt(dr.lerp(dr.square(low), dr.square(high), u))
    return dr.clip(u * (low + high) / dr.maximum(low + root, 1e-20), 0.0, 1.0)


def _draw_polar(begin, end, half, sine, cosine, u):
    """Draw t in -1..1 from the density (linear from ``begin`` to ``end``) times sin(middle + half t).

    The sine is its series about the middle of the cell, which is exact to 1e-8 in cells of up to `WIDEST_CELL`, so that
    the running integral is a polynomial and loses no digits in narrow cells; it is inverted by Newton's method.
    """
    mean, slope = 0.5 * (begin + end), 0.5 * (end - begin)
    a = (
        sine,
        cosine * half,
        -0.5 * sine * dr.square(half),
        cosine * half * dr.square(half) / -6.0,
        sine * dr.square(dr.square(half)) / 24.0,
    )
    zero = 0.0 * sine
    product = [
        mean * (a[i] if i < len(a) else zero) + slope * (a[i - 1] if i > 0 else zero)
        for i in range(len(a) + 1)
    ]

    def integral(t):
        value = zero
        for i in reversed(range(len(product))):
            value = dr.fma(value, t, product[i] / (i + 1))
        return value * t

    def value_at(t):
        value = zero
        for coefficient in reversed(product):
            value = dr.fma(value, t, coefficient)
        return value

    low = integral(mi.Float(-1.0))
    wanted = u * (integral(mi.Float(1.0)) - low)
    t = 2.0 * _draw_linear(dr.maximum(value_at(-1.0), 0.0), dr.maximum(value_at(1.0), 0.0), u) - 1.0
    for _ in range(4):
        t = dr.clip(t - (integral(t) - low - wanted) / dr.maximum(value_at(t), 1e-20), -1.0, 1.0)
    return t
