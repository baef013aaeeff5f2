"""Measured surfaces as a Mitsuba plug-in: up to four lobes, of what each side reflects and lets through.

Paths from the eye meet surfaces backwards: see `seen_from_the_eye`. How far data are reciprocal is measured where files are
read.
"""

from dataclasses import replace

import drjit as dr
import mitsuba as mi

from ...arrays import average, upload
from ...scene.material import Measured
from ...scene.scattering import PatchMatrix, Scatter, ScatterTable, TensorTree
from ..data.flake_field import parts_of
from ..data.patches import transposed
from ..data.tree import transposed_tree
from .flake_field import Eyed, FlakeField
from .patch_lobe import PatchLobe
from .table_lobe import DirectShares, TableLobe, TableValues
from .tree_lobe import TreeLobe

NAME = "lumenray_measured"


def register() -> None:
    """Register the plug-in with the active Mitsuba variant. Doing it again is harmless."""
    mi.register_bsdf(NAME, _measured_class())


def make_lobe(scatter: Scatter, weigh, factor: float):
    """Make the lobe of a scatter for the active variant. ``weigh``: see `TableLobe`."""
    match scatter:
        case ScatterTable():
            return TableLobe(scatter, weigh, factor)
        case PatchMatrix():
            return PatchLobe(scatter, weigh, factor)
        case TensorTree():
            return TreeLobe(scatter, weigh, factor)
    raise TypeError(f"not a scatter: {scatter!r}")


def seen_from_the_eye(surface: Measured) -> Measured:
    """Return a surface whose parts tell, by where the eye is, how much light comes from elsewhere to it.

    What passes to an eye in front came from behind. Matrices and trees of rank 4 are turned round; tables, and trees of
    rank 3, are read with the eye's direction as the incidence, which is the same as far as they are reciprocal.
    """

    def turned_round(scatter):
        match scatter:
            case PatchMatrix():
                return transposed(scatter)
            case TensorTree() if scatter.rank == 4:
                return transposed_tree(scatter)
        return scatter

    made: dict[int, Scatter] = {}

    def once(scatter):
        if scatter is None:
            return None
        return made.setdefault(id(scatter), turned_round(scatter))

    return replace(
        surface,
        front_reflection=once(surface.front_reflection),
        back_reflection=once(surface.back_reflection),
        front_transmission=once(surface.back_transmission),
        back_transmission=once(surface.front_transmission),
    )


def _key(scatter: Scatter) -> tuple:
    """What is the same for scatters that hold the same arrays, as those of both sides do behind a process's border."""
    return tuple((a.__array_interface__["data"][0], a.shape) for a in scatter.arrays())


class _Part:
    """What one side reflects or lets through: the lobe and the direct shares, either may be missing."""

    def __init__(self, scatter: Scatter, weigh, factor: float):
        self.lobe, self.direct = None, None
        if (
            isinstance(scatter, ScatterTable)
            and scatter.direct is not None
            and scatter.direct.any()
        ):
            self.direct = DirectShares(scatter, weigh, factor)
        if scatter.values.any():
            self.lobe = make_lobe(scatter, weigh, factor)


class _Sides:
    """The parts for light on both sides, reflected or transmitted."""

    def __init__(self, front: _Part | None, back: _Part | None):
        self.front, self.back = front, back

    def _each(self, name: str, is_front, active):
        """Things of a name with the lanes that they serve; once where both sides share a part."""
        if self.front is self.back:
            pairs = ((self.front, active),)
        else:
            pairs = ((self.front, active & is_front), (self.back, active & ~is_front))
        for part, lanes in pairs:
            thing = None if part is None else getattr(part, name)
            if thing is not None:
                yield thing, lanes

    def has(self, name: str) -> bool:
        """Whether any side has a thing of a name."""
        return any(p is not None and getattr(p, name) is not None for p in (self.front, self.back))

    def evaluate(self, wi, wo, is_front, wavelengths, active):
        """Value times cosine, and density."""
        value, density = mi.Spectrum(0.0), mi.Float(0.0)
        for lobe, lanes in self._each("lobe", is_front, active):
            f, pdf = lobe.evaluate(wi, wo, wavelengths, lanes)
            value, density = dr.select(lanes, f, value), dr.select(lanes, pdf, density)
        return value, density

    def sample(self, wi, is_front, sample, active):
        """Draw a direction."""
        wo = mi.Vector3f(0.0, 0.0, 1.0)
        for lobe, lanes in self._each("lobe", is_front, active):
            wo = dr.select(lanes, lobe.sample(wi, sample, lanes), wo)
        return wo

    def albedo(self, wi, is_front, active):
        """Scattered share, mean over the bands."""
        found = mi.Float(0.0)
        for lobe, lanes in self._each("lobe", is_front, active):
            found = dr.select(lanes, lobe.albedo(wi, lanes), found)
        return found

    def reflectance(self, wi, is_front, wavelengths, active):
        """Scattered share by wavelength."""
        found = mi.Spectrum(0.0)
        for lobe, lanes in self._each("lobe", is_front, active):
            found = dr.select(lanes, lobe.reflectance(wi, wavelengths, lanes), found)
        return found

    def direct(self, wi, is_front, wavelengths, active):
        """Direct share."""
        found = mi.Spectrum(0.0)
        for shares, lanes in self._each("direct", is_front, active):
            found = dr.select(lanes, shares.evaluate(wi, wavelengths, lanes), found)
        return found


def _measured_class():
    class MeasuredSurface(mi.BSDF):
        """Scattering by measured data."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)

        def set_surface(self, surface: Measured, weigh):
            """Set what it scatters. ``weigh``: see `TableLobe`."""
            surface = seen_from_the_eye(surface)
            parts: dict[tuple, _Part] = {}

            def part(scatter):
                if scatter is None:
                    return None
                key = _key(scatter)
                if key not in parts:
                    parts[key] = _Part(scatter, weigh, surface.factor)
                return parts[key]

            self.reflection = _Sides(part(surface.front_reflection), part(surface.back_reflection))
            self.transmission = _Sides(
                part(surface.front_transmission), part(surface.back_transmission)
            )
            self.sparkles = []
            if surface.sparkles:
                tables = parts_of(surface.sparkles, surface.front_reflection)
                self.sparkles = [
                    (TableValues(table, weigh, surface.factor), FlakeField(sparkle, number))
                    for number, (table, sparkle) in enumerate(
                        zip(tables, surface.sparkles, strict=True)
                    )
                ]
            self.coordinates = mi.Float(0.0)
            self.turn = mi.Vector2f(dr.cos(surface.rotation), dr.sin(surface.rotation))
            dr.make_opaque(self.turn)
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            flags = [
                flag
                for is_there, flag in (
                    (self.reflection.has("lobe"), mi.BSDFFlags.GlossyReflection),
                    (self.transmission.has("lobe"), mi.BSDFFlags.GlossyTransmission),
                    (self.reflection.has("direct"), mi.BSDFFlags.DeltaReflection),
                    (self.transmission.has("direct"), mi.BSDFFlags.Null),
                )
                if is_there
            ] or [mi.BSDFFlags.GlossyReflection]
            self.m_components = [flag | sides for flag in flags]
            self.m_flags = self.m_components[0]
            for component in self.m_components[1:]:
                self.m_flags = self.m_flags | component

        def set_coordinates(self, coordinates):
            """Set what leads from places to those of their objects. (n, 4, 3): rows of the turn, and the origin [m]"""
            if self.sparkles:
                self.coordinates = upload(mi.Float, coordinates)
                dr.eval(self.coordinates)

        def _turned(self, v, sign):
            """A direction in the frame of the sample (sign -1) or back in that of the surface (1), z as it is."""
            c, s = self.turn.x, sign * self.turn.y
            return mi.Vector3f(c * v.x - s * v.y, s * v.x + c * v.y, v.z)

        def _upright(self, v):
            """As `_turned` into the frame of the sample, z turned up."""
            v = self._turned(v, -1.0)
            v.z = dr.abs(v.z)
            return v

        def _shares(self, si, wi, is_front, active):
            """Shares of reflected, transmitted, mirrored and undeviated light, and the last two as spectra."""
            mirrored = self.reflection.direct(wi, is_front, si.wavelengths, active)
            straight = self.transmission.direct(wi, is_front, si.wavelengths, active)
            shares = [
                self.reflection.albedo(wi, is_front, active),
                self.transmission.albedo(wi, is_front, active),
                average(mirrored),
                average(straight),
            ]
            total = dr.maximum(shares[0] + shares[1] + shares[2] + shares[3], 1e-12)
            return [share / total for share in shares], mirrored, straight

        def _evaluate(self, si, wi, wo, shares, active):
            is_front, through = si.wi.z > 0.0, si.wi.z * wo.z < 0.0
            upright = self._upright(wo)
            active = active & (wo.z != 0.0) & (wi.z > 0.0)
            value, density = self.reflection.evaluate(
                wi, upright, is_front, si.wavelengths, active & ~through
            )
            density *= shares[0]
            if self.sparkles:
                value += self._sparkle(si, wi, wo, upright, active & ~through)
            if self.transmission.has("lobe"):
                passed, pdf = self.transmission.evaluate(
                    wi, upright, is_front, si.wavelengths, active & through
                )
                value = dr.select(through, passed, value)
                density = dr.select(through, pdf * shares[1], density)
            else:
                value = dr.select(through, 0.0, value)
                density = dr.select(through, 0.0, density)
            return dr.select(active, value, 0.0), dr.select(active, density, 0.0)

        def _sparkle(self, si, wi, wo, upright, active):
            """What single flakes in sight of the camera add to the mean of all, or lack of it."""
            eyed, added = Eyed(si, self.coordinates, active), mi.Spectrum(0.0)
            own = [mi.Vector3f(w.x, w.y, dr.abs(w.z)) for w in (si.wi, wo)]
            for table, field in self.sparkles:
                factor = field.evaluate(eyed, *own)
                added += table.value(wi, upright, si.wavelengths, eyed.is_seen) * (factor - 1.0)
            return dr.select(eyed.is_seen, added, 0.0)

        def sample(self, ctx, si, sample1, sample2, active=True):
            active = mi.Bool(active)
            wi, is_front = self._upright(si.wi), si.wi.z > 0.0
            shares, mirrored, straight = self._shares(si, wi, is_front, active)
            reflected, passed = shares[0], shares[0] + shares[1]
            is_reflected, is_lobe = sample1 < reflected, sample1 < passed
            is_mirrored = ~is_lobe & (sample1 < passed + shares[2])
            wo = self.reflection.sample(wi, is_front, sample2, active & is_reflected)
            if self.transmission.has("lobe"):
                other = self.transmission.sample(
                    wi, is_front, sample2, active & is_lobe & ~is_reflected
                )
                wo = dr.select(is_reflected, wo, other)
            is_above = wo.z > 0.0
            wo = self._turned(wo, 1.0)
            wo.z = dr.select(is_front == is_reflected, wo.z, -wo.z)
            value, density = self._evaluate(si, wi, wo, shares, active & is_lobe & is_above)
            weight = dr.select(density > 0.0, value / dr.maximum(density, 1e-20), 0.0)
            probability = dr.select(is_mirrored, shares[2], shares[3])
            single = dr.select(is_mirrored, mirrored, straight) / dr.maximum(probability, 1e-12)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = dr.select(is_lobe, wo, dr.select(is_mirrored, mi.reflect(si.wi), -si.wi))
            bs.pdf = dr.select(is_lobe, density, probability)
            bs.eta = 1.0
            bs.sampled_component = mi.UInt32(0)
            bs.sampled_type = dr.select(
                is_lobe,
                dr.select(
                    is_reflected,
                    mi.UInt32(+mi.BSDFFlags.GlossyReflection),
                    mi.UInt32(+mi.BSDFFlags.GlossyTransmission),
                ),
                dr.select(
                    is_mirrored,
                    mi.UInt32(+mi.BSDFFlags.DeltaReflection),
                    mi.UInt32(+mi.BSDFFlags.Null),
                ),
            )
            valid = active & (wi.z > 0.0) & (bs.pdf > 0.0)
            return bs, mi.Spectrum(dr.select(valid, dr.select(is_lobe, weight, single), 0.0))

        def eval_pdf(self, ctx, si, wo, active=True):
            active = mi.Bool(active)
            wi, is_front = self._upright(si.wi), si.wi.z > 0.0
            shares = self._shares(si, wi, is_front, active)[0]
            return self._evaluate(si, wi, wo, shares, active)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_null_transmission(self, si, active=True):
            active = mi.Bool(active)
            wi, is_front = self._upright(si.wi), si.wi.z > 0.0
            return self.transmission.direct(wi, is_front, si.wavelengths, active)

        def eval_diffuse_reflectance(self, si, active=True):
            active = mi.Bool(active)
            wi, is_front = self._upright(si.wi), si.wi.z > 0.0
            return self.reflection.reflectance(wi, is_front, si.wavelengths, active)

        def to_string(self):
            return "MeasuredSurface[]"

    return MeasuredSurface
