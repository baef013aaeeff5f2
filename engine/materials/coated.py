"""A diffuse base under a clear microfacet coat, for many materials in one plug-in.

The reflectance distribution is

    f = s F(cos h) D(h) G2(i, o) / (4 cos_i cos_o)  +  rho / pi * (1 - s E(cos_i)) (1 - s E(cos_o)) / (1 - s E_mean)

with the GGX distribution D, Smith's height-correlated G2, the dielectric Fresnel term F, the scale s of the coat, the
coat's directional reflectance E and its hemispherical mean E_mean = 2 * integral of E cos. It is reciprocal, and a white
base (rho = 1) reflects all energy that the coat's single scattering does not lose, whatever the roughness. With s = 0 it
is Lambert's law exactly. A tint t of the coat puts 1 - (1 - F) (1 - F_0 t) / (1 - F_0) for F, F_0 being that along the
normal; E is then that of the largest t. Facets of a coat may lie along a direction, on which E depends too (see `grain`).
Under a thin film F and E depend on the wavelength (see `film`); where such facets lie along a direction, E is that of the
direction times the film's share of it where they lie along none.
Where a base is rough itself, 1 / pi has a factor more (see `rough_diffuse`).

Light transport in vectorised variants pays for every *kind* of surface that lanes of one packet meet, so all such materials
of a scene share one plug-in (a palette), which looks its parameters up by the shape that was hit, pictures included.

References
----------
C. Kelemen, L. Szirmay-Kalos: A Microfacet Based Coupled Specular-Matte BRDF Model, Eurographics 2001 (short).
"""

import numpy as np

from .facets import (
    MINIMUM_ALPHA,
    coat_reflectance,
    directional_reflectance,
    grazing,
    mean_reflectance,
    mirror_light,
    read_row,
    reflect_on_facet,
)
from .grain import grain_reflectance, mean_over_azimuths
from .rough_diffuse import aslant


def coated_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import average, upload

    class Coated(mi.BSDF):
        """One row of parameters per material; ``reflectance`` is a texture that replaces the rows' own spectra."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.texture = props["reflectance"] if "reflectance" in props else None
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [
                mi.BSDFFlags.GlossyReflection | sides,
                mi.BSDFFlags.DiffuseReflection | sides,
            ]
            self.m_flags = self.m_components[0] | self.m_components[1]
            self.rows = self.grain = self.film = None

        def set_palette(
            self, alpha, eta, specular, sigma, tints, spectra, pictures=None, picture_table=None
        ):
            """Set the materials' parameters: (m,) each, ``spectra`` (m, w) even over 360..830 nm.

            ``sigma``: diffuse roughness of the base; ``tints``: as ``spectra``, of the coat. ``pictures`` holds rows of
            ``picture_table`` plus 1; 0: the spectrum holds all over.
            """
            alpha = np.maximum(alpha, MINIMUM_ALPHA)
            tables = np.stack(
                [
                    coat_reflectance(round(float(a), 4), round(float(e), 4), s, t)
                    for a, e, s, t in zip(alpha, eta, specular, tints.max(axis=1), strict=True)
                ]
            )
            self.alpha = upload(mi.Float, alpha)
            self.eta = upload(mi.Float, eta)
            self.scale = upload(mi.Float, specular)
            self.table = upload(mi.Float, tables)
            self.mean = upload(mi.Float, [mean_reflectance(t) for t in tables])
            self.width = spectra.shape[1]
            self.spectra = upload(mi.Float, spectra)
            self.single = len(alpha) == 1
            # Where there are none, kernels do not look for them.
            has_pictures = pictures is not None and np.any(pictures)
            self.pictures = upload(mi.UInt32, pictures) if has_pictures else None
            self.picture_table = picture_table if has_pictures else None
            self.sigma = upload(mi.Float, sigma) if np.any(sigma) else None
            dr.eval(self.alpha, self.eta, self.scale, self.table, self.mean, self.spectra)
            self.tints = upload(mi.Float, tints) if np.any(tints < 1.0) else None
            dr.eval(self.pictures, self.sigma, self.tints)

        def set_grain(self, grain, alpha, eta, scale, tint, stretch):
            """Lay the facets of a single row along a direction.

            Parameters
            ----------
            grain : GrainOfFacets
            alpha, eta, scale, tint, stretch : float    Of the coat; ``tint``: the largest of it. [-]
            """
            self.grain = grain
            own = grain_reflectance(round(alpha, 6), round(stretch, 6), round(eta, 4))
            if tint < 1.0:
                whole = grain_reflectance(round(alpha, 6), round(stretch, 6))
                own = whole - grazing(eta, tint) * (whole - own)
            table = scale * own
            self.table = upload(mi.Float, table)
            self.mean = upload(mi.Float, [mean_over_azimuths(table, stretch)])
            dr.eval(self.table, self.mean)

        def set_film(self, film, scale):
            """Lay a film on the coat of a single row. ``film``: `FilmOnPaint`; ``scale``: on all that it reflects. [-]"""
            self.film = film
            self.scale = upload(mi.Float, [scale])
            dr.eval(self.scale)

        def set_grain_of_film(self, grain, alpha, index, stretch):
            """Lay the facets of a film along a direction; parameters as of `set_grain`.

            What they reflect once is the film's share times what the direction makes of that of a plain boundary.
            """
            self.grain = grain
            own = grain_reflectance(round(alpha, 6), round(stretch, 6), round(index, 4))
            even = directional_reflectance(round(alpha, 4), round(index, 4))
            self.table = upload(mi.Float, own / np.maximum(even, 1e-6))
            self.mean = upload(
                mi.Float, [mean_over_azimuths(own, stretch) / mean_reflectance(even)]
            )
            dr.eval(self.table, self.mean)

        def set_ways(self, ways):
            """Set the ways of the grain's directions, as `GrainOfFacets` has them."""
            if self.grain is not None:
                self.grain.set_ways(ways)

        def set_rows(self, rows):
            """Set the table from shape id to row."""
            self.rows = upload(mi.UInt32, rows)
            dr.eval(self.rows)

        def traverse(self, callback):
            if self.texture is not None:
                callback.put("reflectance", self.texture, mi.ParamFlags.Differentiable)

        def _row(self, si, active):
            if self.single:
                return mi.UInt32(0)
            ids = dr.reinterpret_array(mi.UInt32, si.shape)
            return dr.gather(mi.UInt32, self.rows, ids, active)

        def _reflectance(self, si, row, active):
            if self.texture is not None:
                return self.texture.eval(si, active)
            value = self._spectrum(self.spectra, si, row, active)
            if self.pictures is None:
                return value
            picture = dr.gather(mi.UInt32, self.pictures, row, active)
            # Most surfaces have none, and a packet without any does not wait for those that do.
            return dr.if_stmt(
                (mi.Point2f(si.uv), si.wavelengths, picture, value),
                mi.Bool(active) & (picture > 0),
                lambda uv, wavelengths, picture, value: self.picture_table.eval(
                    uv, wavelengths, picture - 1, mi.Bool(True)
                ),
                lambda uv, wavelengths, picture, value: value,
            )

        def _spectrum(self, spectra, si, row, active):
            if self.width == 1:
                return mi.Spectrum(dr.gather(mi.Float, spectra, row, active))
            value = mi.Spectrum(0.0)
            for k in range(len(value)):
                place = (si.wavelengths[k] - 360.0) * ((self.width - 1) / 470.0)
                below = dr.clip(mi.Int32(place), 0, self.width - 2)
                index = row * self.width + mi.UInt32(below)
                low = dr.gather(mi.Float, spectra, index, active)
                high = dr.gather(mi.Float, spectra, index + 1, active)
                value[k] = dr.lerp(low, high, place - mi.Float(below))
            return value

        def _coat(self, si, facets, row, w, active):
            """Directional reflectance of the coat, its scale included."""
            cosine = dr.abs(mi.Frame3f.cos_theta(w))
            if self.film is not None:
                once = self.film.once(si, cosine, active)
                if self.grain is None:
                    return once
                return dr.minimum(once * facets.read(self.table, row, w, active), 1.0)
            if self.grain is not None:
                return facets.read(self.table, row, w, active)
            return read_row(self.table, row, cosine, active)

        def _mean(self, si, row, active):
            """Mean of the coat's reflectance over the hemisphere."""
            if self.film is not None and self.grain is None:
                return self.film.mean(si, active)
            mean = dr.gather(mi.Float, self.mean, row, active)
            return mean if self.film is None else mean * self.film.mean(si, active)

        def _facets(self, si, row, active):
            """Width of the coat's facets, or how they lie."""
            alpha = dr.gather(mi.Float, self.alpha, row, active)
            return alpha if self.grain is None else self.grain.lay(si, alpha, active)

        def _prepare(self, si, active):
            row = self._row(si, active)
            cos_i = dr.abs(mi.Frame3f.cos_theta(si.wi))
            reflectance = self._reflectance(si, row, active)
            facets = self._facets(si, row, active)
            coat = self._coat(si, facets, row, si.wi, active)
            own = coat if self.film is None else average(coat)
            base = (1.0 - own) * average(reflectance)
            share = dr.select(own + base > 0.0, own / dr.maximum(own + base, 1e-8), 0.0)
            return row, facets, cos_i, reflectance, coat, share

        def _gloss(self, si, wo, prepared, active):
            """What the coat mirrors, and the density by which it is drawn."""
            row, facets, *_ = prepared
            eta = dr.gather(mi.Float, self.eta, row, active)
            scale = dr.gather(mi.Float, self.scale, row, active)
            if self.grain is None:
                light, density, cosine = mirror_light(si.wi, wo, facets)
            else:
                light, density, cosine = facets.mirror_light(si.wi, wo)
            if self.film is not None:
                return scale * self.film.mirror(si, cosine, active) * light, density
            mirror = mi.fresnel(cosine, eta)[0]
            if self.tints is not None:
                tint = self._spectrum(self.tints, si, row, active)
                mirror = 1.0 - grazing(eta, tint) * (1.0 - mirror)
            mirror *= light
            return scale * mirror, density

        def _base(self, si, wo, prepared, active):
            """What the base sends on, and the density by which it is drawn."""
            row, facets, cos_i, reflectance, coat, _ = prepared
            cos_o = dr.abs(mi.Frame3f.cos_theta(wo))
            mean = self._mean(si, row, active)
            lambert = cos_o * dr.inv_pi
            matte = (
                (1.0 - coat)
                * (1.0 - self._coat(si, facets, row, wo, active))
                / dr.maximum(1.0 - mean, 1e-6)
            )
            if self.sigma is not None:
                sigma = dr.gather(mi.Float, self.sigma, row, active)
                matte *= aslant(cos_i, cos_o, dr.dot(si.wi, wo), sigma, reflectance)
            return reflectance * matte * lambert, lambert

        def _evaluate(self, si, wo, prepared, active):
            share = prepared[-1]
            valid = active & (mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(wo) > 0.0)
            gloss, density = self._gloss(si, wo, prepared, active)
            base, lambert = self._base(si, wo, prepared, active)
            value = gloss + base
            pdf = share * density + (1.0 - share) * lambert
            return mi.Spectrum(dr.select(valid, value, 0.0)), dr.select(valid, pdf, 0.0)

        def eval_parts(self, si, mirrored, spread, active):
            """Light of the coat towards one direction and of the base towards another, and parts of the density of each.

            Where both are the same, their sums are what `eval_pdf` gives. (Spectrum, Float, Spectrum, Float)
            """
            prepared = self._prepare(si, active)
            share = prepared[-1]
            gloss, density = self._gloss(si, mirrored, prepared, active)
            base, lambert = self._base(si, spread, prepared, active)
            cos_i = mi.Frame3f.cos_theta(si.wi)
            shines, lies = (
                active & (cos_i * mi.Frame3f.cos_theta(w) > 0.0) for w in (mirrored, spread)
            )
            return (
                mi.Spectrum(dr.select(shines, gloss, 0.0)),
                dr.select(shines, share * density, 0.0),
                mi.Spectrum(dr.select(lies, base, 0.0)),
                dr.select(lies, (1.0 - share) * lambert, 0.0),
            )

        def sample(self, ctx, si, sample1, sample2, active=True):
            prepared = self._prepare(si, active)
            _, facets, *_, share = prepared
            below = mi.Frame3f.cos_theta(si.wi) < 0.0
            wi = mi.Vector3f(si.wi)
            wi.z = dr.abs(wi.z)
            if self.grain is None:
                mirrored = reflect_on_facet(wi, facets, sample2)
            else:
                mirrored = facets.reflect(wi, sample2)
            glossy = sample1 < share
            wo = dr.select(
                glossy,
                mirrored,
                mi.warp.square_to_cosine_hemisphere(sample2),
            )
            valid = active & (wo.z > 0.0) & (wi.z > 0.0)
            wo.z = dr.select(below, -wo.z, wo.z)
            value, pdf = self._evaluate(si, wo, prepared, valid)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = wo
            bs.pdf = pdf
            bs.eta = 1.0
            bs.sampled_component = dr.select(glossy, mi.UInt32(0), mi.UInt32(1))
            bs.sampled_type = dr.select(
                glossy,
                mi.UInt32(+mi.BSDFFlags.GlossyReflection),
                mi.UInt32(+mi.BSDFFlags.DiffuseReflection),
            )
            valid &= pdf > 0.0
            return bs, mi.Spectrum(dr.select(valid, value / dr.maximum(pdf, 1e-20), 0.0))

        def eval_pdf(self, ctx, si, wo, active=True):
            return self._evaluate(si, wo, self._prepare(si, active), active)

        def eval_diffuse_reflectance(self, si, active=True):
            return self._reflectance(si, self._row(si, active), active)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def to_string(self):
            return "Coated[]"

    return Coated
