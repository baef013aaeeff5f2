"""Fabric, net or perforated sheet: some light passes straight by its openings, the rest is spread evenly.

The share that passes straight at the angle theta to the normal is, by measurements of roller blinds,

    V(theta) = o cos(pi / 2 * theta / c) ** b,    c = 90 - 25 cos(pi / 2 * o) degrees,    b = 0.6 cos(pi / 2 * o) ** 0.3

with the openness o; beyond the cut-off angle c it is 0. What meets the yarns is reflected and let through by

    f = a / pi * (1 - V_i) (1 - V_o) / ((1 - o) (1 - V_mean))

with the whole fabric's reflectance or transmittance a along the normal and the hemispherical mean V_mean of V. It is
reciprocal, and where all shares add up to 1 no light is lost at any angle.

References
----------
N. A. Kotey, J. L. Wright, M. R. Collins: Determining Off-Normal Solar Optical Properties of Roller Blinds, ASHRAE
Transactions 115(1), 2009.
"""

import numpy as np

MEAN_STEPS = 4096
"""Of the quadrature of the mean."""


def cutoff(openness: float) -> tuple[float, float]:
    """Angle from which on nothing passes straight [rad], and exponent of the law. [-]"""
    cosine = max(float(np.cos(0.5 * np.pi * openness)), 0.0)
    return float(np.radians(90.0 - 25.0 * cosine)), 0.6 * cosine**0.3


def open_share(openness: float, angles) -> np.ndarray:
    """Share of light that passes straight, by its angles to the normal. (n,) [rad] -> (n,) [-]"""
    end, exponent = cutoff(openness)
    angles = np.asarray(angles, dtype=np.float64)
    height = np.cos(0.5 * np.pi * np.minimum(angles / end, 1.0))
    return np.where(angles < end, openness * np.maximum(height, 0.0) ** exponent, 0.0)


def mean_open_share(openness: float) -> float:
    """Share of light from everywhere that passes straight, 2 * integral of V sin cos. [-]"""
    end = cutoff(openness)[0]
    # Steps that close up to the cut-off angle, where the law is steep.
    place = (np.arange(MEAN_STEPS) + 0.5) / MEAN_STEPS
    angles, width = end * place * (2.0 - place), 2.0 * end * (1.0 - place) / MEAN_STEPS
    return float((open_share(openness, angles) * np.sin(2.0 * angles) * width).sum())


def fabric_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import average

    class Fabric(mi.BSDF):
        """Even reflection and transmission, and straight transmission."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.reflectance = props["reflectance"]
            self.transmittance = props["transmittance"]
            openness = float(props["openness"])
            end, exponent = cutoff(openness)
            mean = mean_open_share(openness)
            scale = 1.0 / max((1.0 - openness) * (1.0 - mean), 1e-9)
            even = (1.0 - mean) / max(1.0 - openness, 1e-9)
            self.openness, self.end, self.exponent, self.scale, self.even = (
                dr.opaque(mi.Float, value) for value in (openness, end, exponent, scale, even)
            )
            self.whole = dr.opaque(mi.Float, max(1.0 - openness, 1e-9))
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            kinds = mi.BSDFFlags.DiffuseReflection, mi.BSDFFlags.DiffuseTransmission
            self.m_components = [kind | sides for kind in (*kinds, mi.BSDFFlags.Null)]
            self.m_flags = self.m_components[0] | self.m_components[1] | self.m_components[2]

        def traverse(self, callback):
            callback.put("reflectance", self.reflectance, mi.ParamFlags.Differentiable)
            callback.put("transmittance", self.transmittance, mi.ParamFlags.Differentiable)

        def _open_share(self, direction):
            sine = dr.sqrt(dr.square(direction.x) + dr.square(direction.y))
            place = dr.atan2(sine, dr.abs(direction.z)) / self.end
            height = dr.maximum(dr.cos(0.5 * dr.pi * place), 1e-9)
            return dr.select(place < 1.0, self.openness * dr.power(height, self.exponent), 0.0)

        def _prepare(self, si, active):
            """Share that passes straight, both spectra, and probabilities of going straight and, else, through."""
            passed = self._open_share(si.wi)
            reflectance = self.reflectance.eval(si, active)
            transmittance = self.transmittance.eval(si, active)
            r, t = average(reflectance), average(transmittance)
            met = (r + t) * (1.0 - passed) / self.whole
            straight = dr.select(passed > 0.0, passed / dr.maximum(passed + met, 1e-9), 0.0)
            through = dr.select(r + t > 0.0, t / dr.maximum(r + t, 1e-9), 0.0)
            return passed, reflectance, transmittance, straight, through

        def _evaluate(self, si, wo, prepared, active):
            passed, reflectance, transmittance, straight, through = prepared
            cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
            valid = active & (cos_i * cos_o != 0.0)
            goes_through = cos_i * cos_o < 0.0
            lambert = dr.abs(cos_o) * dr.inv_pi
            met = (1.0 - passed) * (1.0 - self._open_share(wo)) * self.scale
            value = dr.select(goes_through, transmittance, reflectance) * met * lambert
            share = dr.select(goes_through, through, 1.0 - through)
            pdf = (1.0 - straight) * share * lambert
            return mi.Spectrum(dr.select(valid, value, 0.0)), dr.select(valid, pdf, 0.0)

        def sample(self, ctx, si, sample1, sample2, active=True):
            prepared = self._prepare(si, active)
            passed, _, _, straight, through = prepared
            goes_straight = sample1 < straight
            rest = (sample1 - straight) / dr.maximum(1.0 - straight, 1e-9)
            goes_through = rest < through
            spread = mi.warp.square_to_cosine_hemisphere(sample2)
            upwards = (mi.Frame3f.cos_theta(si.wi) > 0.0) != goes_through
            spread.z = dr.select(upwards, spread.z, -spread.z)
            value, pdf = self._evaluate(si, spread, prepared, active & ~goes_straight)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = dr.select(goes_straight, -si.wi, spread)
            bs.pdf = dr.select(goes_straight, straight, pdf)
            bs.eta = 1.0
            component = dr.select(goes_through, mi.UInt32(1), mi.UInt32(0))
            bs.sampled_component = dr.select(goes_straight, mi.UInt32(2), component)
            kind = dr.select(
                goes_through,
                mi.UInt32(+mi.BSDFFlags.DiffuseTransmission),
                mi.UInt32(+mi.BSDFFlags.DiffuseReflection),
            )
            bs.sampled_type = dr.select(goes_straight, mi.UInt32(+mi.BSDFFlags.Null), kind)
            weight = dr.select(
                goes_straight,
                mi.Spectrum(passed / dr.maximum(straight, 1e-9)),
                value / dr.maximum(pdf, 1e-20),
            )
            return bs, mi.Spectrum(dr.select(active & (bs.pdf > 0.0), weight, 0.0))

        def eval_pdf(self, ctx, si, wo, active=True):
            return self._evaluate(si, wo, self._prepare(si, active), active)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_null_transmission(self, si, active=True):
            return mi.Spectrum(self._open_share(si.wi))

        def eval_diffuse_reflectance(self, si, active=True):
            # Of even light, of which more meets the yarns than of light along the normal.
            return self.reflectance.eval(si, active) * self.even

        def to_string(self):
            return "Fabric[]"

    return Fabric
