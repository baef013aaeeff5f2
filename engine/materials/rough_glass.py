"""Rough boundaries of glass that keep the light which passes from facet to facet.

Mitsuba's rough dielectric follows light to one facet only. What it sends on is divided by the share E(cos_i) that it keeps
of light from a direction, so that with colourless glass all light goes on. This is the answer to a direction that is looked
along, as paths from eyes and sensors ask for; the reverse would differ a little.

References
----------
E. Turquin: Practical Multiple Scattering Compensation for Microfacet Models, Industrial Light & Magic, 2019.
"""

import numpy as np

from .absorption import body_of
from .facets import kept_by_glass, read_row


def rough_glass_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import average, upload

    class RoughGlass(mi.BSDF):
        """``nested``: the boundary by single scattering; ``alpha`` and ``index``: numbers that it was made with.

        `set_film` lays a thin film on its facets.

        ``internal`` and ``thickness``: as of `absorption.Body`, if light is absorbed inside.
        """

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.nested = props["nested"]
            self.body = body_of(props)
            alpha, index = float(props["alpha"]), float(props["index"])
            kept = np.stack([kept_by_glass(alpha, index), kept_by_glass(alpha, 1.0 / index)])
            self.table = upload(mi.Float, kept)
            self.film = None
            dr.eval(self.table)
            count = self.nested.component_count()
            self.m_components = [self.nested.flags(i) for i in range(count)]
            self.m_flags = self.nested.flags()

        def set_film(self, film):
            """Lay a film on the facets. ``film``: `FilmOnGlass` of the same width and index."""
            self.film, self.index = film, dr.opaque(mi.Float, film.index)

        def traverse(self, callback):
            callback.put("nested", self.nested, mi.ParamFlags.Differentiable)
            if self.body is not None:
                callback.put("internal", self.body.internal, mi.ParamFlags.Differentiable)

        def _scale(self, si, active):
            cosine = mi.Frame3f.cos_theta(si.wi)
            if self.film is None:
                side = dr.select(cosine > 0.0, mi.UInt32(0), mi.UInt32(1))
                kept = read_row(self.table, side, dr.abs(cosine), active)
            else:
                kept = self.film.kept(si, cosine, active)
            scale = 1.0 / dr.maximum(kept, 0.05)
            return scale if self.body is None else scale * self.body.passed(si, active)

        def sample(self, ctx, si, sample1, sample2, active=True):
            if self.film is not None:
                return self._sample_film(si, sample1, sample2, active)
            # Radiance in whichever way light goes, as all surfaces here.
            bs, weight = self.nested.sample(mi.BSDFContext(), si, sample1, sample2, active)
            return bs, weight * self._scale(si, active)

        def _met(self, si, wo, is_mirrored, active):
            """Reflectance under the film of the facet that sends light from ``wi`` to ``wo``, and that without the film."""
            cosine = mi.Frame3f.cos_theta(si.wi)
            eta = dr.select(cosine > 0.0, self.index, 1.0 / self.index)
            facet = dr.normalize(si.wi + wo * dr.select(is_mirrored, 1.0, eta))
            facet = dr.mulsign(facet, mi.Frame3f.cos_theta(facet))
            inner = dr.dot(si.wi, facet)
            fresnel = mi.fresnel(inner, self.index)
            return self.film.mirror(si, inner, fresnel, active), fresnel[0]

        def _sample_film(self, si, sample1, sample2, active):
            """Draw a facet, and whether it reflects by what it does under the film."""
            active, context = mi.Bool(active), mi.BSDFContext()
            mirrored, weight = self.nested.sample(context, si, mi.Float(0.0), sample2, active)
            under, plain = self._met(si, mirrored.wo, mi.Bool(True), active)
            chance = average(under)
            is_mirrored = sample1 < chance
            # What is refracted by the same facet.
            bent, through = self.nested.sample(
                context, si, mi.Float(1.0 - 1e-7), sample2, active & ~is_mirrored
            )
            bs = dr.select(is_mirrored, mirrored, bent)
            bs.pdf *= dr.select(
                is_mirrored,
                chance / dr.maximum(plain, 1e-12),
                (1.0 - chance) / dr.maximum(1.0 - plain, 1e-6),
            )
            reflected = weight * under / dr.maximum(chance, 1e-8)
            passed = through * (1.0 - under) / dr.maximum(1.0 - chance, 1e-8)
            weight = dr.select(is_mirrored, reflected, passed) * self._scale(si, active)
            valid = active & (is_mirrored | (plain < 1.0))
            return bs, mi.Spectrum(dr.select(valid, weight, 0.0))

        def _eval_film(self, ctx, si, wo, active):
            value, pdf = self.nested.eval_pdf(ctx, si, wo, active)
            is_mirrored = mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(wo) > 0.0
            under, plain = self._met(si, wo, is_mirrored, active)
            chance = average(under)
            more, less = 1.0 / dr.maximum(plain, 1e-12), 1.0 / dr.maximum(1.0 - plain, 1e-6)
            value *= dr.select(is_mirrored, under * more, (1.0 - under) * less)
            pdf *= dr.select(is_mirrored, chance * more, (1.0 - chance) * less)
            return mi.Spectrum(value * self._scale(si, active)), pdf

        def eval_pdf(self, ctx, si, wo, active=True):
            if self.film is not None:
                return self._eval_film(ctx, si, wo, active)
            value, pdf = self.nested.eval_pdf(ctx, si, wo, active)
            return value * self._scale(si, active), pdf

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            if self.film is not None:
                return self._eval_film(ctx, si, wo, active)[1]
            return self.nested.pdf(ctx, si, wo, active)

        def to_string(self):
            return "RoughGlass[]"

    return RoughGlass
