"""Emitters that Mitsuba lacks, as its plug-ins: luminous surface, spot, surroundings with suns; luminaires are in `palette`.

Emitters give spectral radiance in W/(m2 sr nm), or luminance in cd/m2 in photometric variants.
"""

import drjit as dr
import mitsuba as mi

from .limb import Limb, darken
from .luminaire_plugin import luminaires_class
from .rectangle_plugin import rectangles_class
from .rectangles import find_rectangle_density, sample_rectangle
from .spread import narrow
from .tubes import find_tube_density, sample_tube

CHORD_ERROR = 3e-7
"""Largest error of the distance between two unit vectors in single precision; sampled directions to a narrow sun must be
found to lie on it. [-]"""


SUNS_ONLY = -1.0
"""Time of a receiver that only suns of the surroundings are to be sampled for."""


def register() -> None:
    """Register the plug-ins with the active Mitsuba variant. Doing it again is harmless."""
    for name, make in (
        ("lumenray_surface", _surface_class),
        ("lumenray_spot", _spot_class),
        ("lumenray_surroundings", _surroundings_class),
        ("lumenray_luminaires", luminaires_class),
        ("lumenray_rectangles", rectangles_class),
    ):
        made = make()
        mi.register_emitter(name, lambda props, made=made: made(props))


def _surface_class():
    class LuminousSurface(mi.Emitter):
        """Emission of a shape: Lambertian, or narrowed to Blender's spread; one or both sides; with a picture on it."""

        def __init__(self, props):
            mi.Emitter.__init__(self, props)
            self.radiance = props["radiance"]
            self.pattern = props["pattern"] if "pattern" in props else None
            self.two_sided = props.get("two_sided", False)
            self.ball = self.rectangle = self.tube = None
            self.is_narrow = props.get("tan_spread", 0.0) > 0.0
            self.tan_spread = mi.Float(props.get("tan_spread", 0.0))
            dr.make_opaque(self.tan_spread)
            self.m_flags = +mi.EmitterFlags.Surface

        def traverse(self, callback):
            callback.put("radiance", self.radiance, mi.ParamFlags.Differentiable)

        def _profile(self, cosine):
            """Directional factor; 0 behind a one-sided surface."""
            lit = cosine != 0.0 if self.two_sided else cosine > 0.0
            if not self.is_narrow:
                return dr.select(lit, mi.Float(1.0), 0.0)
            return dr.select(lit, narrow(cosine, self.tan_spread), 0.0)

        def _radiance(self, si, active):
            value = self.radiance.eval(si, active)
            if self.pattern is not None:
                value *= self.pattern.eval(si, active)
            return value

        def eval(self, si, active=True):
            profile = self._profile(mi.Frame3f.cos_theta(si.wi))
            return mi.Spectrum(self._radiance(si, active) * profile & active)

        def set_ball(self, centre, radius):
            """Say that the shape is a sphere: Mitsuba's density of a small one far away loses all its digits."""
            self.ball = (mi.Point3f(*centre), mi.Float(radius))
            dr.make_opaque(self.ball)

        def set_rectangle(self, centre, half_x, half_y):
            """Say that the shape is a rectangle without a picture; it shines along ``half_x`` x ``half_y``. (3,) each [m]"""
            self.rectangle = tuple(
                mi.Vector3f(*map(float, each)) for each in (centre, half_x, half_y)
            )
            dr.make_opaque(self.rectangle)

        def set_tube(self, start, along, radius):
            """Say that the shape is a cylinder's curved side. ``start``, ``along``: an end, and thence to the other. [m]"""
            self.tube = (
                mi.Point3f(*map(float, start)),
                mi.Vector3f(*map(float, along)),
                mi.Float(radius),
            )
            dr.make_opaque(self.tube)

        def _density(self, it, density):
            """Solid-angle density of sampling a shape, given Mitsuba's: even over the cap that a sphere fills."""
            if self.ball is None:
                return density
            centre, radius = self.ball
            square = dr.square(radius) / dr.squared_norm(it.p - centre)
            cap = square / (1.0 + dr.safe_sqrt(1.0 - square))
            return dr.select((density > 0.0) & (square < 1.0), dr.inv_two_pi / cap, density)

        def sample_direction(self, it, sample, active=True):
            if self.tube is not None:
                ds = sample_tube(self.tube, it.p, sample)
            elif self.rectangle is not None:
                ds = sample_rectangle(self.rectangle, it.p, sample)
            else:
                ds = self.get_shape().sample_direction(it, sample, active)
                ds.pdf = self._density(it, ds.pdf)
            ds.emitter = mi.EmitterPtr(self)
            active &= ds.pdf > 0.0
            return ds, mi.Spectrum(
                self.eval_direction(it, ds, active) / dr.maximum(ds.pdf, 1e-20) & active
            )

        def pdf_direction(self, it, ds, active=True):
            cosine = dr.dot(ds.d, ds.n)
            lit = cosine != 0.0 if self.two_sided else cosine < 0.0
            if self.tube is not None:
                density = find_tube_density(self.tube, it.p, ds)
            elif self.rectangle is not None:
                density = find_rectangle_density(self.rectangle, it.p, ds.dist, cosine)
            else:
                density = self._density(it, self.get_shape().pdf_direction(it, ds, active))
            return dr.select(lit & active, density, 0.0)

        def eval_direction(self, it, ds, active=True):
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.p, si.n, si.uv, si.t = ds.p, ds.n, ds.uv, 0.0
            si.wavelengths = it.wavelengths
            profile = self._profile(-dr.dot(ds.d, ds.n))
            return mi.Spectrum(self._radiance(si, active) * profile & active)

        def bbox(self):
            return self.get_shape().bbox()

        def to_string(self):
            return "LuminousSurface[]"

    return LuminousSurface


def _spot_class():
    class Spot(mi.Emitter):
        """Point, or disk facing the receiver, of given intensity inside a cone with a smoothstep edge."""

        def __init__(self, props):
            mi.Emitter.__init__(self, props)
            self.intensity = props["intensity"]
            self.position = mi.Point3f(props["position"])
            self.axis = dr.normalize(mi.Vector3f(props["direction"]))
            # 1 - cos of the half angle.
            self.cap = mi.Float(props["cap"])
            self.blend = mi.Float(props["blend"])
            self.radius = mi.Float(props["radius"])
            dr.make_opaque(self.position, self.axis, self.cap, self.blend, self.radius)
            self.m_flags = +mi.EmitterFlags.DeltaPosition

        def traverse(self, callback):
            callback.put("intensity", self.intensity, mi.ParamFlags.Differentiable)

        def _edge(self, direction):
            # By the chord, since cosines of narrow cones have no digits left.
            inside = self.cap - 0.5 * dr.squared_norm(direction - self.axis)
            t = dr.clip(inside / dr.maximum(self.cap * self.blend, 1e-14), 0.0, 1.0)
            return dr.select(inside > 0.0, t * t * (3.0 - 2.0 * t), 0.0)

        def sample_direction(self, it, sample, active=True):
            frame = mi.Frame3f(dr.normalize(it.p - self.position))
            disk = mi.warp.square_to_uniform_disk_concentric(sample) * self.radius
            ds = dr.zeros(mi.DirectionSample3f)
            ds.p = self.position + frame.s * disk.x + frame.t * disk.y
            ds.n = frame.n
            ds.d = ds.p - it.p
            ds.dist = dr.norm(ds.d)
            ds.d /= ds.dist
            ds.pdf = 1.0
            ds.delta = True
            ds.emitter = mi.EmitterPtr(self)
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wavelengths = it.wavelengths
            value = self.intensity.eval(si, active) * self._edge(-ds.d)
            return ds, mi.Spectrum(value / dr.square(ds.dist) & active)

        def pdf_direction(self, it, ds, active=True):
            return mi.Float(0.0)

        def eval_direction(self, it, ds, active=True):
            return mi.Spectrum(0.0)

        def eval(self, si, active=True):
            return mi.Spectrum(0.0)

        def bbox(self):
            return mi.BoundingBox3f()

        def to_string(self):
            return "Spot[]"

    return Spot


def _surroundings_class():
    class Surroundings(mi.Emitter):
        """Everything at infinity: the world (nested emitter ``world``) and suns as disks.

        A receiver whose time is `SUNS_ONLY` asks for samples of the suns alone, if there are any, and never aims at portals.

        ``sun_i`` is a sun's mean radiance, ``limb_i`` its limb darkening, ``towards_i`` the direction to it, ``cap_i`` =
        1 - cos(angular radius), ``share_i`` the probability of sampling it; ``world_share`` that of the nested emitter
        ``world``.
        """

        def __init__(self, props):
            mi.Emitter.__init__(self, props)
            self.world = props["world"] if "world" in props else None
            count = int(props.get("suns", 0))
            self.suns = []
            for i in range(count):
                towards = dr.normalize(mi.Vector3f(props[f"towards_{i}"]))
                cap = mi.Float(props[f"cap_{i}"])
                share = mi.Float(props[f"share_{i}"])
                reach = dr.square(dr.sqrt(2.0 * cap) + CHORD_ERROR)
                dr.make_opaque(towards, cap, reach, share)
                limb = Limb.of(float(props.get(f"limb_{i}", 0.0)), float(props[f"cap_{i}"]))
                self.suns.append((props[f"sun_{i}"], towards, cap, reach, share, limb))
            self.world_share = float(props.get("world_share", 1.0))
            if self.world is not None and self.suns:
                # As data, or each strength of a sun would need a kernel of its own.
                self.world_share = dr.opaque(mi.Float, self.world_share)
            self._plain_share = self.world_share
            self._left_out = frozenset()
            self.portals = None
            self.portal_share = 0.0
            self.centre, self.extent = mi.Point3f(0.0), mi.Float(1.0)
            self.m_flags = +mi.EmitterFlags.Infinite

        def set_portals(self, portals, share):
            """Aim a share of the world's samples at a `PortalSet`."""
            self.portals = portals
            self.portal_share = share if portals is not None else 0.0

        def leave_out(self, suns):
            """Give no light of some suns, by their numbers; samples go to the others."""
            self._left_out = frozenset(suns)
            shines = len(self._left_out) < len(self.suns)
            self.world_share = self._plain_share if shines or self.world is None else 1.0

        def _shining(self):
            """Suns that are not left out, each with its share of the samples."""
            kept = [sun for k, sun in enumerate(self.suns) if k not in self._left_out]
            if len(kept) == len(self.suns):
                return kept
            total = sum((sun[4] for sun in kept[1:]), kept[0][4]) if kept else 1.0
            factor = (1.0 - self.world_share) / total
            return [(*sun[:4], sun[4] * factor, sun[5]) for sun in kept]

        def traverse(self, callback):
            if self.world is not None:
                callback.put("world", self.world, mi.ParamFlags.Differentiable)

        def set_scene(self, scene):
            box = scene.bbox()
            self.set_bounds(mi.Point3f(box.center()), mi.Float(dr.norm(box.extents()) * 0.5))
            if self.world is not None:
                self.world.set_scene(scene)

        def set_bounds(self, centre, radius):
            """Sphere that everything lies in. [m]"""
            self.centre, self.extent = centre, dr.maximum(radius, 1.0) * 1.5
            dr.make_opaque(self.centre, self.extent)

        @staticmethod
        def _inside(direction, towards, reach):
            """Whether a direction lies on a sun's disk; chord lengths keep single precision, cosines would not."""
            return dr.squared_norm(direction - towards) <= reach

        def sun_value(self, direction, wavelengths, active):
            """Radiance of the suns that are not left out."""
            return self._sum(self._shining(), direction, wavelengths, active)

        def left_out_value(self, direction, wavelengths, active):
            """Radiance of the suns that are."""
            suns = [self.suns[k] for k in sorted(self._left_out)]
            return self._sum(suns, direction, wavelengths, active)

        def _sum(self, suns, direction, wavelengths, active):
            value = mi.Spectrum(0.0)
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wavelengths = wavelengths
            for radiance, towards, cap, reach, _, limb in suns:
                inside = self._inside(direction, towards, reach)
                given = darken(radiance.eval(si, active), limb, direction, towards, cap)
                value += mi.Spectrum(dr.select(inside, given, 0.0))
            return value

        def _shares(self, it):
            """Share of the world, share of that for portals, factor on shares of the suns, and who asks for portals."""
            asks = it.time != SUNS_ONLY
            world, suns = mi.Float(self.world_share), mi.Float(1.0)
            if self.suns:
                world = dr.select(asks, world, 0.0)
                suns = dr.select(asks, suns, 1.0 / dr.maximum(1.0 - self.world_share, 1e-9))
            if self.portals is not None:
                asks &= self.portals.has_ahead(it.p)
            return world, dr.select(asks, mi.Float(self.portal_share), 0.0), suns, asks

        def _density(self, it, ds, active):
            pdf = mi.Float(0.0)
            world_share, portal_share, sun_factor, asks = self._shares(it)
            if self.world is not None:
                pdf += world_share * (1.0 - portal_share) * self.world.pdf_direction(it, ds, active)
            if self.portals is not None:
                # Many portals take long, so who does not ask must not wait for them.
                aimed = dr.if_stmt(
                    (mi.Point3f(it.p), mi.Vector3f(ds.d)),
                    mi.Bool(active) & asks,
                    self.portals.density,
                    lambda point, direction: mi.Float(0.0),
                )
                pdf += world_share * portal_share * aimed
            for _, towards, cap, reach, share, _ in self._shining():
                inside = self._inside(ds.d, towards, reach)
                pdf += dr.select(inside, share * sun_factor * dr.inv_two_pi / cap, 0.0)
            return pdf

        def eval(self, si, active=True):
            value = self.sun_value(-si.wi, si.wavelengths, active)
            if self.world is not None:
                value += self.world.eval(si, active)
            return mi.Spectrum(value & active)

        def sample_direction(self, it, sample, active=True):
            # One number chooses the part and is stretched to serve again.
            u, start = sample.x, mi.Float(0.0)
            direction = mi.Vector3f(0.0, 0.0, 1.0)
            world_share, portal_share, sun_factor, _ = self._shares(it)
            if self.world is not None:
                stretched = dr.clip(u / dr.maximum(world_share, 1e-9), 0.0, 0.9999999)
                aims = stretched < portal_share
                if self.portals is not None:
                    direction = dr.if_stmt(
                        (
                            mi.Point3f(it.p),
                            dr.minimum(stretched / dr.maximum(portal_share, 1e-9), 0.9999999),
                            mi.Float(sample.y),
                        ),
                        mi.Bool(active) & aims,
                        self.portals.direction,
                        lambda point, u, v: mi.Vector3f(0.0, 0.0, 1.0),
                    )
                    stretched = (stretched - portal_share) / (1.0 - portal_share)
                    stretched = dr.clip(stretched, 0.0, 0.9999999)
                plain, _ = self.world.sample_direction(it, mi.Point2f(stretched, sample.y), active)
                direction = dr.select(aims, direction, plain.d)
                start = world_share
            for _, towards, cap, _, plain_share, _ in self._shining():
                share = plain_share * sun_factor
                height = dr.clip((u - start) / share, 0.0, 0.9999999) * cap
                sine = dr.safe_sqrt(height * (2.0 - height))
                sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.y)
                local = mi.Vector3f(sine * cos_phi, sine * sin_phi, 1.0 - height)
                direction = dr.select(u >= start, mi.Frame3f(towards).to_world(local), direction)
                start += share
            ds = dr.zeros(mi.DirectionSample3f)
            ds.d = direction
            ds.dist = 2.0 * self.extent
            ds.p = it.p + ds.d * ds.dist
            ds.n = -ds.d
            ds.emitter = mi.EmitterPtr(self)
            ds.pdf = self._density(it, ds, active)
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wi, si.wavelengths, si.p = -ds.d, it.wavelengths, it.p
            value = self.eval(si, active) / dr.maximum(ds.pdf, 1e-20)
            return ds, mi.Spectrum(value & (active & (ds.pdf > 0.0)))

        def pdf_direction(self, it, ds, active=True):
            return dr.select(active, self._density(it, ds, active), 0.0)

        def eval_direction(self, it, ds, active=True):
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wi, si.wavelengths, si.p = -ds.d, it.wavelengths, it.p
            return self.eval(si, active)

        def bbox(self):
            return mi.BoundingBox3f()

        def to_string(self):
            return "Surroundings[]"

    return Surroundings
