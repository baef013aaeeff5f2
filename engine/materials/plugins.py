"""Models that Mitsuba lacks, as its plug-ins: coats, rough metal, sheet, fabric, panes, glass, transparency, mixtures.

Mitsuba's base classes belong to a variant, so the classes are made by `register` after the variant is active.
Directions are local, with the normal along +z; ``wi`` points to where the path came from.
"""

import drjit as dr
import mitsuba as mi

from ..arrays import average
from .absorption import body_of
from .blend import blend_class
from .coated import coated_class
from .fabric import fabric_class
from .picture_texture import picture_class
from .refraction import refraction_class, rough_refraction_class
from .relief import relief_class
from .rough_glass import rough_glass_class
from .rough_metal import rough_metal_class
from .sheen import sheen_class
from .specular import pane_components, sample_pane, specular
from .tabulated_pane import tabulated_pane_class
from .toon import toon_class
from .varnish import varnish_class

DISPERSED_COMPONENT = 16
"""`sampled_component` of a refraction whose direction belongs to the first wavelength only."""


def pane_optics(cos_theta, ior, internal):
    """Reflectance and transmittance of a plane-parallel pane with all internal reflections, unpolarised.

    Parameters
    ----------
    cos_theta : Float    Cosine to the normal outside. [-]
    ior : float    Refractive index. [-]
    internal : Spectrum    Transmittance of the glass body at normal incidence, without surface losses. [-]

    Returns
    -------
    (Spectrum, Spectrum)    Reflectance and transmittance. [-]

    References
    ----------
    J. A. Duffie, W. A. Beckman: Solar Engineering of Thermal Processes, 5.1-5.3: the sums over both polarisations.
    """
    cos_i = dr.clip(cos_theta, 1e-4, 1.0)
    cos_t = dr.sqrt(1.0 - (1.0 - cos_i * cos_i) / (ior * ior))
    r_s = dr.square((cos_i - ior * cos_t) / (cos_i + ior * cos_t))
    r_p = dr.square((ior * cos_i - cos_t) / (ior * cos_i + cos_t))
    body = dr.select(internal > 0.0, dr.power(dr.maximum(internal, 1e-20), 1.0 / cos_t), 0.0)
    reflectance, transmittance = 0.0, 0.0
    for r in (r_s, r_p):
        round_trip = 1.0 - dr.square(r * body)
        reflectance += 0.5 * (r + r * dr.square((1.0 - r) * body) / round_trip)
        transmittance += 0.5 * dr.square(1.0 - r) * body / round_trip
    return mi.Spectrum(reflectance), mi.Spectrum(transmittance)


def register() -> None:
    """Register the plug-ins with the active Mitsuba variant. Doing it again is harmless."""
    for name, make in (
        ("lumenray_coated", coated_class),
        ("lumenray_rough_glass", rough_glass_class),
        ("lumenray_rough_metal", rough_metal_class),
        ("lumenray_sheet", _sheet_class),
        ("lumenray_fabric", fabric_class),
        ("lumenray_pane", _pane_class),
        ("lumenray_tabulated_pane", tabulated_pane_class),
        ("lumenray_glass", _glass_class),
        ("lumenray_transparent", _transparent_class),
        ("lumenray_mix", _mix_class),
        ("lumenray_varnish", varnish_class),
        ("lumenray_sheen", sheen_class),
        ("lumenray_blend", blend_class),
        ("lumenray_toon", toon_class),
        ("lumenray_refraction", refraction_class),
        ("lumenray_rough_refraction", rough_refraction_class),
        ("lumenray_relief", relief_class),
    ):
        made = make()
        mi.register_bsdf(name, lambda props, made=made: made(props))
    mi.register_texture("lumenray_laid_picture", picture_class())


def _sheet_class():
    class Sheet(mi.BSDF):
        """Lambertian reflection on both sides and Lambertian transmission."""

        is_matt = True

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.reflectance = props["reflectance"]
            self.transmittance = props["transmittance"] if "transmittance" in props else None
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.DiffuseReflection | sides]
            if self.transmittance is not None:
                self.m_components.append(mi.BSDFFlags.DiffuseTransmission | sides)
            flags = self.m_components[0]
            for component in self.m_components[1:]:
                flags = flags | component
            self.m_flags = flags

        def traverse(self, callback):
            callback.put("reflectance", self.reflectance, mi.ParamFlags.Differentiable)
            if self.transmittance is not None:
                callback.put("transmittance", self.transmittance, mi.ParamFlags.Differentiable)

        def _shares(self, si, active):
            """Reflectance, transmittance and the probability of choosing transmission."""
            reflectance = self.reflectance.eval(si, active)
            if self.transmittance is None:
                return reflectance, mi.Spectrum(0.0), mi.Float(0.0)
            transmittance = self.transmittance.eval(si, active)
            r, t = average(reflectance), average(transmittance)
            return (
                reflectance,
                transmittance,
                dr.select(r + t > 0.0, t / dr.maximum(r + t, 1e-8), 0.0),
            )

        def sample(self, ctx, si, sample1, sample2, active=True):
            reflectance, transmittance, through = self._shares(si, active)
            cos_i = mi.Frame3f.cos_theta(si.wi)
            wo = mi.warp.square_to_cosine_hemisphere(sample2)
            goes_through = sample1 < through
            probability = dr.select(goes_through, through, 1.0 - through)
            pdf = mi.warp.square_to_cosine_hemisphere_pdf(wo) * probability
            upwards = (cos_i > 0.0) != goes_through
            wo.z = dr.select(upwards, wo.z, -wo.z)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = wo
            bs.pdf = pdf
            bs.eta = 1.0
            bs.sampled_component = dr.select(goes_through, mi.UInt32(1), mi.UInt32(0))
            bs.sampled_type = dr.select(
                goes_through,
                mi.UInt32(+mi.BSDFFlags.DiffuseTransmission),
                mi.UInt32(+mi.BSDFFlags.DiffuseReflection),
            )
            valid = active & (cos_i != 0.0) & (pdf > 0.0)
            weight = dr.select(goes_through, transmittance, reflectance) / dr.maximum(
                probability, 1e-8
            )
            return bs, mi.Spectrum(dr.select(valid, weight, 0.0))

        def eval_pdf(self, ctx, si, wo, active=True):
            reflectance, transmittance, through = self._shares(si, active)
            cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
            goes_through = cos_i * cos_o < 0.0
            valid = active & (cos_i * cos_o != 0.0)
            cosine = dr.abs(cos_o) * dr.inv_pi
            value = dr.select(goes_through, transmittance, reflectance) * cosine
            pdf = dr.select(goes_through, through, 1.0 - through) * cosine
            return mi.Spectrum(dr.select(valid, value, 0.0)), dr.select(valid, pdf, 0.0)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_diffuse_reflectance(self, si, active=True):
            return self.reflectance.eval(si, active)

        def to_string(self):
            return "Sheet[]"

    return Sheet


def _null_sample(si, weight, active):
    """Straight on, as a BSDF sample."""
    bs = dr.zeros(mi.BSDFSample3f)
    bs.wo = -si.wi
    bs.pdf = 1.0
    bs.eta = 1.0
    bs.sampled_type = mi.UInt32(+mi.BSDFFlags.Null)
    bs.sampled_component = mi.UInt32(0)
    return bs, mi.Spectrum(dr.select(active, weight, 0.0))


def _transparent_class():
    @specular
    class Transparent(mi.BSDF):
        """Lets light pass straight on, times a transmittance."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.transmittance = props["transmittance"]
            flag = mi.BSDFFlags.Null | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [flag]
            self.m_flags = flag

        def traverse(self, callback):
            callback.put("transmittance", self.transmittance, mi.ParamFlags.Differentiable)

        def sample(self, ctx, si, sample1, sample2, active=True):
            return _null_sample(si, self.transmittance.eval(si, active), active)

        def eval_null_transmission(self, si, active=True):
            return self.transmittance.eval(si, active)

        def to_string(self):
            return "Transparent[]"

    return Transparent


def _pane_class():
    @specular
    class Pane(mi.BSDF):
        """A pane of glass as one surface: mirror reflection and straight transmission."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.ior = mi.Float(props["ior"])
            dr.make_opaque(self.ior)
            self.internal = props["transmittance"]
            self.m_components = pane_components()
            self.m_flags = self.m_components[0] | self.m_components[1]

        def traverse(self, callback):
            callback.put("transmittance", self.internal, mi.ParamFlags.Differentiable)

        def _optics(self, si, active):
            cosine = dr.abs(mi.Frame3f.cos_theta(si.wi))
            return pane_optics(cosine, self.ior, self.internal.eval(si, active))

        def sample(self, ctx, si, sample1, sample2, active=True):
            return sample_pane(si, *self._optics(si, active), sample1, active)

        def eval_null_transmission(self, si, active=True):
            return self._optics(si, active)[1]

        def to_string(self):
            return "Pane[]"

    return Pane


def _glass_class():
    @specular
    class SmoothGlass(mi.BSDF):
        """Smooth boundary of a body.

        Where the index depends on the wavelength (``disperses``), the direction of refraction is that of the first one;
        the path loop then drops the other three and gives their share to the first (see `DISPERSED_COMPONENT`).
        Reflection keeps all four.
        """

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.ior = props["ior"]
            self.tint = props["tint"]
            self.body = body_of(props)
            # Where there is none, kernels do not look for it.
            self.mirror_tint = props["mirror_tint"] if "mirror_tint" in props else None
            self.film = None
            self.refraction = DISPERSED_COMPONENT if props.get("disperses", False) else 1
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [
                mi.BSDFFlags.DeltaReflection | sides,
                mi.BSDFFlags.DeltaTransmission | sides | mi.BSDFFlags.NonSymmetric,
            ]
            self.m_flags = self.m_components[0] | self.m_components[1]

        def set_film(self, film):
            """Lay a film on the boundary. ``film``: `FilmOnGlass`."""
            self.film = film

        def traverse(self, callback):
            callback.put("ior", self.ior, mi.ParamFlags.NonDifferentiable)
            callback.put("tint", self.tint, mi.ParamFlags.Differentiable)
            if self.body is not None:
                callback.put("internal", self.body.internal, mi.ParamFlags.Differentiable)
            if self.mirror_tint is not None:
                callback.put("mirror_tint", self.mirror_tint, mi.ParamFlags.Differentiable)

        def sample(self, ctx, si, sample1, sample2, active=True):
            cos_i = mi.Frame3f.cos_theta(si.wi)
            index = self.ior.eval(si, active)
            reflectance = mi.Spectrum(0.0)
            for k in range(len(reflectance)):
                reflectance[k] = mi.fresnel(cos_i, index[k])[0]
            hero_r, cos_t, eta_it, eta_ti = mi.fresnel(cos_i, index[0])
            passing = 1.0 - hero_r
            if self.film is not None:
                reflectance = self.film.mirror(si, cos_i, (hero_r, cos_t), active)
                hero_r, passing = average(reflectance), 1.0 - reflectance
            if self.mirror_tint is not None:
                reflectance *= self.mirror_tint.eval(si, active)
            reflects = sample1 < hero_r
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = dr.select(reflects, mi.reflect(si.wi), mi.refract(si.wi, cos_t, eta_ti))
            bs.pdf = dr.select(reflects, hero_r, 1.0 - hero_r)
            bs.eta = dr.select(reflects, 1.0, eta_it)
            bs.sampled_component = dr.select(reflects, mi.UInt32(0), mi.UInt32(self.refraction))
            bs.sampled_type = dr.select(
                reflects,
                mi.UInt32(+mi.BSDFFlags.DeltaReflection),
                mi.UInt32(+mi.BSDFFlags.DeltaTransmission),
            )
            through = self.tint.eval(si, active) * passing * dr.square(eta_ti)
            weight = dr.select(reflects, reflectance, through) / dr.maximum(bs.pdf, 1e-8)
            if self.body is not None:
                weight *= self.body.passed(si, active)
            return bs, mi.Spectrum(dr.select(active, weight, 0.0))

        def to_string(self):
            return "SmoothGlass[]"

    return SmoothGlass


def _mix_class():
    class Mix(mi.BSDF):
        """Two surfaces in a proportion that may vary by place."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.first = props["first"]
            self.second = props["second"]
            self.factor = props["factor"]
            self.m_components = [
                bsdf.flags(i)
                for bsdf in (self.first, self.second)
                for i in range(bsdf.component_count())
            ]
            self.m_flags = self.first.flags() | self.second.flags()

        def traverse(self, callback):
            callback.put("factor", self.factor, mi.ParamFlags.Differentiable)
            callback.put("first", self.first, mi.ParamFlags.Differentiable)
            callback.put("second", self.second, mi.ParamFlags.Differentiable)

        def _factor(self, si, active):
            return dr.clip(self.factor.eval_1(si, active), 0.0, 1.0)

        def sample(self, ctx, si, sample1, sample2, active=True):
            factor = self._factor(si, active)
            second = sample1 < factor
            bs, weight = dr.zeros(mi.BSDFSample3f), mi.Spectrum(0.0)
            reused = dr.select(
                second,
                sample1 / dr.maximum(factor, 1e-8),
                (sample1 - factor) / dr.maximum(1.0 - factor, 1e-8),
            )
            bs0, weight0 = self.first.sample(ctx, si, reused, sample2, active & ~second)
            bs1, weight1 = self.second.sample(ctx, si, reused, sample2, active & second)
            bs = dr.select(second, bs1, bs0)
            weight = dr.select(second, weight1, weight0)
            # Where the direction is spread out, the density of both parts counts.
            spread = ~mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta) & ~mi.has_flag(
                bs.sampled_type, mi.BSDFFlags.Null
            )
            value, pdf = self.eval_pdf(ctx, si, bs.wo, active & spread)
            combined = dr.select(pdf > 0.0, value / dr.maximum(pdf, 1e-20), 0.0)
            bs.pdf = dr.select(spread, pdf, bs.pdf * dr.select(second, factor, 1.0 - factor))
            return bs, mi.Spectrum(dr.select(spread, combined, weight))

        def eval_pdf(self, ctx, si, wo, active=True):
            factor = self._factor(si, active)
            value0, pdf0 = self.first.eval_pdf(ctx, si, wo, active)
            value1, pdf1 = self.second.eval_pdf(ctx, si, wo, active)
            return dr.lerp(value0, value1, factor), dr.lerp(pdf0, pdf1, factor)

        def eval_diffuse_reflectance(self, si, active=True):
            return dr.lerp(
                self.first.eval_diffuse_reflectance(si, active),
                self.second.eval_diffuse_reflectance(si, active),
                self._factor(si, active),
            )

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_null_transmission(self, si, active=True):
            return dr.lerp(
                self.first.eval_null_transmission(si, active),
                self.second.eval_null_transmission(si, active),
                self._factor(si, active),
            )

        def to_string(self):
            return "Mix[]"

    return Mix
