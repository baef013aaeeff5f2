"""Surfaces with a relief: a surface model that is asked in the frame of another normal.

Directions are local, with the normal of the mesh along +z. What spreads light evenly (the matt part) answers by the normal
n of the relief; it is lit by n . o as a facet of that slope is, times the shadow that such facets throw near the horizon,

    S = 2 / (1 + sqrt(1 + min(tan^2 a / 8, 1) tan^2 b)),

a being the angle of n, b that of o to the surface's normal: so no light comes from below the surface and none ends in a
sharp edge. What mirrors would send light into the surface where it is seen at a flat angle; there n is raised in the plane
of itself and the surface's normal until what a mirror would reflect leaves the surface. From the back of a surface both hold
with the signs turned.

References
----------
A. Conty Estevez, P. Lecocq, C. Stein: A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem, Ray
Tracing Gems, 2019, ch. 12.
"""

import drjit as dr
import mitsuba as mi

from ..arrays import upload
from ..scene.relief import Axes, Heights

LEAST, NOT_MORE = 0.01, 0.9
"""Height over the surface that mirror directions are raised to, and the share of the eye's own that this is at most. [-]"""

STEEPNESS = 0.125
"""Square of the width of the facets' distribution over that of the tangent of the slope. [-]"""

GRAZING = 1e-4
"""Least cosine by which shares of flux are divided. [-]"""

TINY = 1e-12


def relief_class():
    """Return the plug-in for the active Mitsuba variant."""

    class Relief(mi.BSDF):
        """``nested``: the surface model that lies on the relief.

        A model whose ``is_matt`` is true spreads all light evenly; one with ``eval_parts`` has a matt part, its second
        component, and one that mirrors; all others mirror.
        """

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.nested = props["nested"]
            self.is_matt = getattr(self.nested, "is_matt", False)
            self.has_parts = hasattr(self.nested, "eval_parts")
            count = self.nested.component_count()
            self.m_components = [self.nested.flags(i) for i in range(count)]
            self.m_flags = self.nested.flags()
            self.layers, self.table, self.frames = [], None, None

        def set_layers(self, table, layers, rows):
            """Set the relief.

            Parameters
            ----------
            table : PictureTable    Holds its pictures; it has to be committed before they are looked up.
            layers : list of relief.Relief    The one next to the surface first.
            rows : list of int    Of their pictures.
            """
            self.table = table
            self.layers = [_Layer(*each) for each in zip(layers, rows, strict=True)]

        def set_frames(self, frames):
            """Set axes of the objects by the number of their shapes: columns are what x, y, z become. (n, 3, 3)"""
            if any(layer.follows_object for layer in self.layers):
                self.frames = upload(mi.Float, frames)
                dr.eval(self.frames)

        def traverse(self, callback):
            callback.put("nested", self.nested, mi.ParamFlags.Differentiable)

        # ---- normals ----

        def _normal(self, si, active):
            """Normals of the relief as it is seen, of the shape that it lies on and of the face, and the side of the eye."""
            side = dr.select(mi.Frame3f.cos_theta(si.wi) < 0.0, -1.0, 1.0)
            normal = own = ground = mi.Vector3f(0.0, 0.0, 1.0)
            for layer in self.layers:
                turned = layer.turn(self.table, self.frames, si, normal, side, active)
                turned = dr.lerp(normal, turned, layer.strength)
                length = dr.norm(turned)
                is_usable = dr.isfinite(length) & (length > TINY)
                normal = dr.select(is_usable, turned / dr.maximum(length, TINY), normal)
                if layer.is_shape:
                    # The mesh may be displaced, so that only its faces tell what lies behind them.
                    own, ground = normal, si.to_local(mi.Vector3f(si.n))
            return normal, own, ground, side

        def _frames_at(self, si, active):
            """Frames of what is matt and of what mirrors, the surface as its model sees it, normals of shape and face."""
            normal, own, ground, side = self._normal(si, active)
            matt, shiny = _frame_of(normal), _frame_of(_raised(normal, si.wi, side))
            inner = mi.SurfaceInteraction3f(si)
            inner.wi = shiny.to_local(si.wi)
            # Of matt parts and of rounding: the model is always asked from the side that is seen.
            inner.wi.z = side * dr.maximum(dr.abs(inner.wi.z), 1e-6)
            return matt, shiny, inner, own, ground

        # ---- light ----

        def sample(self, ctx, si, sample1, sample2, active=True):
            matt, shiny, inner, shape, ground = self._frames_at(si, active)
            is_from_light = ctx.mode == mi.TransportMode.Importance
            if is_from_light:
                # What is matt is seen from all sides of the face, whichever way its normal leans.
                matt = _frame_of(ground)
            frames = matt, shiny, inner, shape, ground
            bs, weight = self.nested.sample(ctx, inner, sample1, sample2, active)
            is_matt = mi.Bool(self.is_matt)
            if self.has_parts:
                is_matt = bs.sampled_component == 1
            wo = dr.select(is_matt, matt.to_world(bs.wo), shiny.to_world(bs.wo))
            lit = mi.Bool(active) & (bs.wo.z * dr.dot(wo, ground) > 0.0)
            bs.wo = wo
            if self.has_parts or self.is_matt:
                # The other part may send light that way too, and facets throw shadows.
                value, bs.pdf = self._evaluate(ctx, frames, wo, lit)
                weight = dr.select(bs.pdf > 0.0, value / dr.maximum(bs.pdf, 1e-20), 0.0)
            if is_from_light:
                weight = self._from_light(si, bs, weight, shiny.n, ground, lit)
            return bs, mi.Spectrum(dr.select(lit, weight, 0.0))

        def _from_light(self, si, bs, weight, mirror, ground, lit):
            """Share of the flux of a path from a light, which comes from ``si.wi``: what would be seen the other way."""
            leaves, comes = dr.abs(dr.dot(bs.wo, ground)), dr.abs(dr.dot(si.wi, ground))
            ratio = leaves / dr.maximum(comes, GRAZING)
            is_delta = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
            bent = dr.abs(dr.dot(mirror, si.wi)) / dr.maximum(
                dr.abs(dr.dot(mirror, bs.wo)), GRAZING
            )
            back = mi.SurfaceInteraction3f(si)
            back.wi = bs.wo
            value, _ = self.eval_pdf(mi.BSDFContext(), back, si.wi, lit & ~is_delta)
            # Who asks takes the square of the index back, of which nothing is in this.
            spread = value / dr.maximum(bs.pdf * dr.square(bs.eta), 1e-20)
            return ratio * dr.select(is_delta, bent * weight, spread)

        def _evaluate(self, ctx, frames, wo, active):
            matt, shiny, inner, shape, ground = frames
            own, raised = matt.to_local(wo), shiny.to_local(wo)
            shadow = _shadow(matt.n, shape, wo)
            height = dr.dot(wo, ground)
            stays, passes = own.z * height > 0.0, raised.z * height > 0.0
            if self.has_parts:
                gloss, gloss_pdf, base, base_pdf = self.nested.eval_parts(
                    inner, raised, own, active
                )
                value = dr.select(passes, gloss, 0.0) + dr.select(stays, base * shadow, 0.0)
                return mi.Spectrum(value), gloss_pdf + base_pdf
            if self.is_matt:
                value, pdf = self.nested.eval_pdf(ctx, inner, own, active)
                return mi.Spectrum(dr.select(stays, value * shadow, 0.0)), pdf
            value, pdf = self.nested.eval_pdf(ctx, inner, raised, active)
            return mi.Spectrum(dr.select(passes, value, 0.0)), pdf

        def eval_pdf(self, ctx, si, wo, active=True):
            return self._evaluate(ctx, self._frames_at(si, active), wo, active)

        def eval_diffuse_reflectance(self, si, active=True):
            return self.nested.eval_diffuse_reflectance(si, active)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def to_string(self):
            return "Relief[]"

    return Relief


class _Layer:
    """One part of a relief on the device: what differs between those of a kind is data."""

    def __init__(self, layer, row: int):
        self.row = upload(mi.UInt32, [row])
        self.strength = mi.Float(max(float(layer.strength), 0.0))
        self.is_heights = isinstance(layer, Heights)
        self.axes = None if self.is_heights else layer.axes
        self.in_object = self.is_heights and layer.in_object
        self.is_shape = self.is_heights and layer.is_shape
        dr.make_opaque(self.strength)
        dr.eval(self.row)

    @property
    def follows_object(self) -> bool:
        """Whether it depends on how the object stands."""
        return self.in_object or self.axes == Axes.OBJECT

    def turn(self, table, frames, si, normal, side, active):
        """Local normal where the one below is ``normal``, of any length; 0 where there is none."""
        active = mi.Bool(active)
        if self.is_heights:
            return self._of_slope(table.slope(si.uv, self.row, active), frames, si, normal, side)
        vector = table.vector(si.uv, self.row, active)
        if self.axes == Axes.TANGENT:
            return self._of_tangents(vector, si)
        if self.axes == Axes.OBJECT:
            x, y, z = _axes_of(frames, si, active)
            # Normals go with the inverse of what moves points.
            whole = dr.dot(dr.cross(x, y), z)
            vector = (
                dr.cross(y, z) * vector.x + dr.cross(z, x) * vector.y + dr.cross(x, y) * vector.z
            )
            vector *= dr.select(whole < 0.0, -1.0, 1.0)
        return si.to_local(dr.normalize(vector))

    def _of_tangents(self, vector, si):
        along = si.to_local(si.dp_du)
        along.z = 0.0
        length = dr.norm(along)
        along /= dr.maximum(length, 1e-30)
        across = mi.Vector3f(-along.y, along.x, 0.0)
        across *= dr.select(dr.dot(dr.cross(si.dp_du, si.dp_dv), si.n) < 0.0, -1.0, 1.0)
        found = along * vector.x + across * vector.y + mi.Vector3f(0.0, 0.0, 1.0) * vector.z
        return dr.select(length > 0.0, found, 0.0)

    def _of_slope(self, slope, frames, si, normal, side):
        flat = mi.Vector3f(si.n)
        whole = dr.dot(dr.cross(si.dp_du, si.dp_dv), flat)
        share = dr.select(whole != 0.0, 1.0 / whole, 0.0)
        # The gradient in the plane of the face, and of the same rise across the normal that it turns.
        rise = (dr.cross(si.dp_dv, flat) * slope[0] + dr.cross(flat, si.dp_du) * slope[1]) * share
        if self.in_object:
            x, y, z = _axes_of(frames, si, mi.Bool(True))
            up = mi.Vector3f(si.sh_frame.n)
            own = dr.normalize(mi.Vector3f(dr.dot(x, up), dr.dot(y, up), dr.dot(z, up)))
            rise *= dr.dot(x * own.x + y * own.y + z * own.z, up)
        rise, flat = si.to_local(rise), si.to_local(flat)
        facing = dr.dot(flat, normal)
        rise -= flat * (dr.dot(rise, normal) / dr.select(dr.abs(facing) > 1e-3, facing, 1.0))
        return dr.normalize(normal - rise * side)


def _axes_of(frames, si, active):
    number = dr.reinterpret_array(mi.UInt32, si.shape)
    return [
        mi.Vector3f(
            *(dr.gather(mi.Float, frames, number * 9 + 3 * k + axis, active) for k in range(3))
        )
        for axis in range(3)
    ]


def _frame_of(normal):
    """Frame about a local normal whose first axis stays over the mesh's own."""
    along = mi.Vector3f(1.0, 0.0, 0.0) - normal * normal.x
    length = dr.norm(along)
    other = dr.normalize(mi.Vector3f(0.0, 1.0, 0.0) - normal * normal.y)
    along = dr.select(length > 1e-3, along / dr.maximum(length, 1e-3), other)
    return mi.Frame3f(along, dr.cross(normal, along), normal)


def _shadow(normal, shape, wo):
    """Share of light that facets of a slope leave to those behind them, S of this module's head. [-]

    ``shape``: normal of what the facets lie on.
    """
    slope, light = dr.dot(normal, shape), dr.dot(wo, shape)
    steepness = dr.minimum(STEEPNESS * _squared_tangent(slope), 1.0)
    found = 2.0 / (1.0 + dr.sqrt(1.0 + steepness * _squared_tangent(light)))
    return dr.select(slope * light * dr.dot(normal, wo) > 0.0, found, 0.0)


def _squared_tangent(cosine):
    return dr.maximum(dr.rcp(dr.maximum(dr.square(cosine), TINY)) - 1.0, 0.0)


def _raised(normal, wi, side):
    """Normal raised until a mirror of it reflects what is looked along, ``wi``, away from the surface."""
    seen = mi.Vector3f(normal.x, normal.y, normal.z) * side
    eye = dr.abs(wi.z)
    least = dr.minimum(NOT_MORE * eye, LEAST)
    cosine = dr.dot(seen, wi)
    is_fine = 2.0 * cosine * seen.z * side - eye >= least
    across = mi.Vector3f(seen.x, seen.y, 0.0)
    across /= dr.maximum(dr.norm(across), 1e-30)
    # Of n = (sin a, cos a) in this plane: 2 (n . wi) cos a - eye = least, squared, is quadratic in the square of cos a.
    away = dr.dot(wi, across)
    whole = dr.square(away) + dr.square(eye)
    middle = whole + eye * least
    root = dr.safe_sqrt(dr.square(middle) - whole * dr.square(least + eye))
    squared = 0.5 * (middle + dr.select(away < 0.0, root, -root)) / dr.maximum(whole, 1e-30)
    found = across * dr.safe_sqrt(1.0 - squared)
    found.z = side * dr.safe_sqrt(squared)
    return dr.select(is_fine, normal, found * side)
