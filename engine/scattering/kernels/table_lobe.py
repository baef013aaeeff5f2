"""A table of scattering in kernels: its interpolation exactly as stated, and directions drawn from its cells."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.scattering import ScatterTable
from ..data.table import is_symmetric
from .cells import prepare_cells, reach_around

MOST_BINS = 4096
"""Bins by which places on an axis are found."""

LARGEST = 60000.0
"""Largest value as kernels hold it: with the 11 bits of half precision, as files do, since memory is what they wait for."""


class Axis:
    """An irregular axis: even bins tell the interval, or the one before it, with a single memory access where they are fine.

    Parameters
    ----------
    values : (n,) array    Strictly ascending.
    """

    def __init__(self, values: np.ndarray):
        values = np.asarray(values, dtype=np.float64)
        self.single = len(values) == 1
        if self.single:
            return
        low, length = values[0], values[-1] - values[0]
        bins = int(min(MOST_BINS, 2 ** np.ceil(np.log2(1.01 * length / np.diff(values).min()))))
        edges = low + length * np.arange(bins) / bins
        first = np.clip(np.searchsorted(values, edges, side="right") - 1, 0, len(values) - 2)
        last = np.searchsorted(values, edges + length / bins, side="left") - 1
        # Where more than one grid line lies in a bin, a few steps find the interval.
        self.steps = max(int((last - first).max()), 1)
        self.first = upload(mi.UInt32, first)
        self.values = upload(mi.Float, values)
        if self.steps == 1:
            # In one place what a bin needs: an interval and the next one. The last bins begin with the last but one; where
            # there is a single interval, one is thought before it.
            start = np.minimum(first, len(values) - 3)
            ends = np.append(values[0] - 1.0, values)
            corners = [ends[start + 1 + k] for k in range(3)]
            self.bins = upload(mi.Float, np.stack([start, *corners], axis=1))
            dr.eval(self.bins)
        self.low, self.scale = mi.Float(low), mi.Float(bins / length)
        self.last_bin = mi.Int32(bins - 1)
        self.last = mi.UInt32(len(values) - 2)
        dr.make_opaque(self.low, self.scale, self.last_bin, self.last)
        dr.eval(self.first, self.values)

    def place(self, value, active):
        """Interval that a value lies in and the share of its upper end; the ends hold beyond. (UInt32, Float)"""
        if self.single:
            return mi.UInt32(0), mi.Float(0.0)
        number = dr.clip(mi.Int32((value - self.low) * self.scale), 0, self.last_bin)
        if self.steps == 1:
            start, low, middle, high = dr.gather(mi.Vector4f, self.bins, mi.UInt32(number), active)
            is_second = dr.maximum(value, self.low) >= middle
            below = mi.UInt32(start + dr.select(is_second, 1.0, 0.0))
            low, high = dr.select(is_second, middle, low), dr.select(is_second, high, middle)
            return below, dr.clip((value - low) / (high - low), 0.0, 1.0)
        below = dr.gather(mi.UInt32, self.first, mi.UInt32(number), active)
        high = dr.gather(mi.Float, self.values, below + 1, active)
        for _ in range(self.steps):
            below = dr.minimum(dr.select(value >= high, below + 1, below), self.last)
            high = dr.gather(mi.Float, self.values, below + 1, active)
        low = dr.gather(mi.Float, self.values, below, active)
        return below, dr.clip((value - low) / (high - low), 0.0, 1.0)

    def ends(self, below, active):
        """Both ends of an interval."""
        return (dr.gather(mi.Float, self.values, below + k, active) for k in (0, 1))


class _Incidences:
    """Grid points about the direction that light comes from."""

    def __init__(self, table: ScatterTable):
        self.count = len(table.incidences)
        self.turns = len(table.rotations)
        self.incidences = Axis(table.incidences)
        self.rotations = None
        self.is_orthotropic = table.is_orthotropic
        if table.is_orthotropic:
            self.rotations = Axis(table.rotations)
        elif self.turns > 1:
            self.rotations = Axis(np.append(table.rotations, table.rotations[0] + 2.0 * np.pi))
            self.first_rotation = mi.Float(table.rotations[0])
            dr.make_opaque(self.first_rotation)

    def _fold(self, wi, v):
        """A direction as it is in the quarter that stands for that of ``wi``, or brought back from there."""
        if not self.is_orthotropic:
            return v
        return mi.Vector3f(dr.mulsign(v.x, wi.x), dr.mulsign(v.y, wi.y), v.z)

    def _frame(self, wi):
        """Sine and cosine of the incidence, and those of the azimuth of ``wi``."""
        wi = self._fold(wi, wi)
        sine = dr.hypot(wi.x, wi.y)
        is_inclined = sine > 0.0
        cos_r = dr.select(is_inclined, wi.x / sine, 1.0)
        sin_r = dr.select(is_inclined, wi.y / sine, 0.0)
        return sine, wi.z, cos_r, sin_r

    def _nodes(self, frame, active):
        """Grid points about an incidence: (number, weight) pairs that sum up to 1."""
        sine, cosine, cos_r, sin_r = frame
        s, s_share = self.incidences.place(dr.atan2(sine, cosine), active)
        count = self.count
        steps = [(s, 1.0 - s_share), (s + 1, s_share)] if count > 1 else [(s, mi.Float(1.0))]
        if self.rotations is None:
            return steps
        turn = dr.atan2(sin_r, cos_r)
        if not self.is_orthotropic:
            turn = dr.select(turn < 0.0, turn + dr.two_pi, turn)
            turn = dr.select(turn < self.first_rotation, turn + dr.two_pi, turn)
        p, p_share = self.rotations.place(turn, active)
        following = p + 1
        if not self.is_orthotropic:
            following = dr.select(following >= self.turns, 0, following)
        return [
            (row * count + each, w_row * weight)
            for row, w_row in ((p, 1.0 - p_share), (following, p_share))
            for each, weight in steps
        ]


class TableValues(_Incidences):
    """Values of a table.

    Parameters
    ----------
    table : ScatterTable
    weigh : callable
        Takes values (..., w) and wavelengths (w,); returns them as they are, or summed up to one band where the variant
        carries no wavelengths.
    factor : float    On all values. [-]
    """

    def __init__(self, table: ScatterTable, weigh, factor: float = 1.0):
        super().__init__(table)
        table = reach_around(table)
        values = weigh(table.values * np.float32(factor), table.wavelengths)
        self.shape = values.shape
        self.is_symmetric = is_symmetric(table)
        self.radials, self.azimuths = Axis(table.radials), Axis(table.azimuths)
        self.wavelengths = Axis(table.wavelengths) if values.shape[-1] > 1 else None
        largest = float(values.max(initial=0.0))
        scale = largest / LARGEST if largest > 0.0 else 1.0
        self.scale = mi.Float(scale)
        dr.make_opaque(self.scale)
        self.quad = dr.float16_array_t(mi.Vector4f)
        quads = quads_of((values / np.float32(scale)).astype(np.float16))
        self.quads = upload(dr.float16_array_t(mi.Float), quads)
        dr.eval(self.quads)

    def value(self, wi, wo, wavelengths, active):
        """Value times the cosine of ``wo``. (Spectrum) [1/sr]"""
        frame = self._frame(wi)
        nodes = self._nodes(frame, active)
        place = self._cell(frame, self._fold(wi, wo), active)
        return self._look_up(nodes, place, wavelengths, active) * (wo.z * self.scale)

    def _cell(self, frame, wo, active):
        """Radial interval, its share, azimuth interval, its share."""
        sin_s, cos_s, cos_r, sin_r = frame
        x, y = cos_r * wo.x + sin_r * wo.y, cos_r * wo.y - sin_r * wo.x
        centre, outward = cos_s * wo.z - sin_s * x, -cos_s * x - sin_s * wo.z
        radial = dr.atan2(dr.hypot(outward, y), centre)
        azimuth = dr.atan2(dr.abs(y) if self.is_symmetric else y, outward)
        if not self.is_symmetric:
            azimuth = dr.select(azimuth < 0.0, azimuth + dr.two_pi, azimuth)
        return *self.radials.place(radial, active), *self.azimuths.place(azimuth, active)

    def _look_up(self, nodes, place, wavelengths, active):
        """Values at a place of `_cell`, without scale. (Spectrum)"""
        t, t_share, a, a_share = place
        _, _, radials, azimuths, bands = self.shape
        cells = (radials - 1) * (azimuths - 1)
        cell = t * (azimuths - 1) + a
        shares = mi.Vector4f(
            (1.0 - t_share) * (1.0 - a_share),
            (1.0 - t_share) * a_share,
            t_share * (1.0 - a_share),
            t_share * a_share,
        )

        def look_up(band):
            total = mi.Float(0.0)
            for node, weight in nodes:
                number = (node * cells + cell) * bands + band
                quad = mi.Vector4f(dr.gather(self.quad, self.quads, number, active))
                total = dr.fma(weight, dr.dot(quad, shares), total)
            return total

        if self.wavelengths is None:
            return mi.Spectrum(look_up(0))
        value = mi.Spectrum(0.0)
        for k in range(len(value)):
            band, share = self.wavelengths.place(wavelengths[k], active)
            value[k] = dr.lerp(look_up(band), look_up(band + 1), share)
        return value


class TableLobe(TableValues):
    """What a table scatters, its direct part aside. Parameters as of `TableValues`."""

    def __init__(self, table: ScatterTable, weigh, factor: float = 1.0):
        super().__init__(table, weigh, factor)
        table = reach_around(table)
        cells = prepare_cells(table)
        albedos = weigh(cells.albedo * factor, table.wavelengths)
        self.density = upload(mi.Float, cells.density)
        self.ring_shares = upload(mi.Float, cells.radial)
        self.cell_shares = upload(mi.Float, cells.azimuth)
        self.albedos = upload(mi.Float, albedos.mean(axis=-1))
        self.albedos_by_band = upload(mi.Float, albedos)
        # 1 - cos, which tells small angles apart.
        self.versines = upload(mi.Float, 2.0 * np.sin(0.5 * table.radials) ** 2)
        dr.eval(
            self.density,
            self.ring_shares,
            self.cell_shares,
            self.albedos,
            self.albedos_by_band,
            self.versines,
        )

    # ---- what the plug-in asks ----

    def evaluate(self, wi, wo, wavelengths, active):
        """Value times the cosine of ``wo`` [1/sr], and the density of `sample` over solid angle [1/sr]."""
        frame = self._frame(wi)
        nodes = self._nodes(frame, active)
        place = self._cell(frame, self._fold(wi, wo), active)
        t, _, a, _ = place
        _, _, radials, azimuths, _ = self.shape
        cells = (radials - 1) * (azimuths - 1)
        cell = t * (azimuths - 1) + a
        density = mi.Float(0.0)
        for node, weight in nodes:
            cell_density = dr.gather(mi.Float, self.density, node * cells + cell, active)
            density = dr.fma(weight, cell_density, density)
        value = self._look_up(nodes, place, wavelengths, active)
        return value * (wo.z * self.scale), density

    def sample(self, wi, sample, active):
        """Draw a direction; it may lie below the horizon, where nothing is scattered. ``sample``: Point2f"""
        frame = self._frame(wi)
        first, second = mi.Float(sample.x), mi.Float(sample.y)
        node, passed = mi.UInt32(0), mi.Float(0.0)
        chosen, share_before, share_of = mi.UInt32(0), mi.Float(0.0), mi.Float(1.0)
        for number, (node, weight) in enumerate(self._nodes(frame, active)):
            is_this = (first >= passed) if number else mi.Bool(True)
            chosen = dr.select(is_this, node, chosen)
            share_before = dr.select(is_this, passed, share_before)
            share_of = dr.select(is_this, weight, share_of)
            passed = passed + weight
        first = dr.clip(
            (first - share_before) / dr.maximum(share_of, 1e-12),
            0.0,
            dr.one_minus_epsilon(mi.Float),
        )
        _, _, radials, azimuths, _ = self.shape
        t, first = _draw(self.ring_shares, chosen * (radials - 1), radials - 1, first, active)
        row = (chosen * (radials - 1) + t) * (azimuths - 1)
        if self.is_symmetric:
            is_left = second >= 0.5
            second = 2.0 * second - dr.select(is_left, 1.0, 0.0)
        a, second = _draw(self.cell_shares, row, azimuths - 1, second, active)
        versine = dr.lerp(
            *(dr.gather(mi.Float, self.versines, t + k, active) for k in (0, 1)), first
        )
        cos_t, sin_t = 1.0 - versine, dr.safe_sqrt(versine * (2.0 - versine))
        azimuth = dr.lerp(*self.azimuths.ends(a, active), second)
        if self.is_symmetric:
            azimuth = dr.select(is_left, -azimuth, azimuth)
        sin_a, cos_a = dr.sincos(azimuth)
        sin_s, cos_s, cos_r, sin_r = frame
        x = -sin_s * cos_t - cos_s * sin_t * cos_a
        y = sin_t * sin_a
        z = cos_s * cos_t - sin_s * sin_t * cos_a
        return self._fold(wi, mi.Vector3f(cos_r * x - sin_r * y, sin_r * x + cos_r * y, z))

    def albedo(self, wi, active):
        """Share of light that is scattered, mean over the bands. [-]"""
        found = mi.Float(0.0)
        for node, weight in self._nodes(self._frame(wi), active):
            found = dr.fma(weight, dr.gather(mi.Float, self.albedos, node, active), found)
        return found

    def reflectance(self, wi, wavelengths, active):
        """Share of light that is scattered, by wavelength. (Spectrum)"""
        nodes = self._nodes(self._frame(wi), active)
        return _by_wavelength(
            self.albedos_by_band, nodes, self.shape[-1], self.wavelengths, wavelengths, active
        )


def quads_of(values: np.ndarray) -> np.ndarray:
    """Values at the four corners of each cell side by side, as one memory access takes them.

    (p, s, t, a, w) -> (p, s, t - 1, a - 1, w, 4)
    """
    return np.stack(
        [
            values[:, :, :-1, :-1],
            values[:, :, :-1, 1:],
            values[:, :, 1:, :-1],
            values[:, :, 1:, 1:],
        ],
        axis=-1,
    )


class DirectShares(_Incidences):
    """What a table reflects as a mirror or lets pass straight, by incidence."""

    def __init__(self, table: ScatterTable, weigh, factor: float = 1.0):
        super().__init__(table)
        direct = weigh(table.direct * np.float32(factor), table.wavelengths)
        self.bands = direct.shape[-1]
        self.wavelengths = Axis(table.wavelengths) if self.bands > 1 else None
        self.values = upload(mi.Float, direct)
        dr.eval(self.values)

    def evaluate(self, wi, wavelengths, active):
        """Share of light from ``wi``. (Spectrum)"""
        nodes = self._nodes(self._frame(wi), active)
        return _by_wavelength(self.values, nodes, self.bands, self.wavelengths, wavelengths, active)


def _by_wavelength(values, nodes, bands: int, axis, wavelengths, active):
    """Spectrum of values (nodes, bands) between grid points. ``axis``: of the bands; None: there is one."""
    made = mi.Spectrum(0.0)
    for k in range(len(made)):
        band, share = (mi.UInt32(0), None)
        if axis is not None:
            band, share = axis.place(wavelengths[k], active)
        found = mi.Float(0.0)
        for node, weight in nodes:
            value = dr.gather(mi.Float, values, node * bands + band, active)
            if share is not None:
                above = dr.gather(mi.Float, values, node * bands + band + 1, active)
                value = dr.lerp(value, above, share)
            found = dr.fma(weight, value, found)
        made[k] = found
    return made


def _draw(shares, start, count: int, sample, active):
    """Draw an entry from cumulative shares that begin at ``start``; also the sample, spread out again over [0, 1)."""
    found = dr.binary_search(
        0, count - 1, lambda i: dr.gather(mi.Float, shares, start + i, active) <= sample
    )
    found = mi.UInt32(found)
    above = dr.gather(mi.Float, shares, start + found, active)
    below = dr.gather(mi.Float, shares, start + found - 1, active & (found > 0))
    left = (sample - below) / dr.maximum(above - below, 1e-12)
    return found, dr.clip(left, 0.0, dr.one_minus_epsilon(mi.Float))
