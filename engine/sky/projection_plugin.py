"""Surroundings that are not all at infinity, as Mitsuba's emitter: a ground below, and a photo in the view of its camera.

Both change what is seen in a direction and from a place, not how directions are sampled: densities stay those of the world
itself, so joint weights of samples stay valid, and what the world's density misses scattered rays find alone.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import upload
from .far_light import far_light_class
from .picture import clean, find_luminances
from .picture_plugin import make_colours, sigmoid

FADE = 0.5
"""Share of the ground's radius from which on it passes into what lies at infinity. [-]"""

LEAST_FALL = 1e-6
"""Slope of rays that are taken to reach the ground. [-]"""


MARGIN = 0.01
"""How far a photo goes on beyond its border, as it is there: filters of pixels reach over that of the film. [film side]"""


def register() -> None:
    """Register the plug-in with the active Mitsuba variant. Doing it again is harmless."""
    made = _projection_class()
    mi.register_emitter("lumenray_projection", lambda props, made=made: made(props))


def make_projection(world, ground, photo, origin, white: dict):
    """Return the emitter of a world with a ground or a photo, or both.

    Parameters
    ----------
    world : mi.Emitter or None    None: it is black.
    ground : Ground or None
    photo : Photo or None
    origin : (3,) array    Of the scene's frame, in the world. [m]
    white : dict    Texture of a luminance of 1 cd/m2 with the spectrum of `picture_plugin.WHITE`.
    """
    plugin = {"type": "lumenray_projection", "radiance": white}
    if world is not None:
        plugin["world"] = world
    made = mi.load_dict(plugin)
    if ground is not None:
        made.set_ground(ground, origin)
    if photo is not None:
        made.set_photo(photo)
    return made


def _projection_class():
    class Projection(far_light_class()):
        """A world as it is seen from places near by: receivers are told by their place, ``p``."""

        def __init__(self, props):
            super().__init__(props)
            self.world = props["world"] if "world" in props else None
            self.ground = self.photo = None

        def traverse(self, callback):
            super().traverse(callback)
            if self.world is not None:
                callback.put("world", self.world, mi.ParamFlags.Differentiable)

        def set_ground(self, ground, origin) -> None:
            """Lay what is below on a plane."""
            centre = mi.Point3f(*map(float, np.asarray(ground.centre) - origin))
            level = mi.Float(float(ground.level - origin[2]))
            radius = mi.Float(float(ground.radius))
            self.ground = centre, level, radius
            dr.make_opaque(self.ground)

        def set_photo(self, photo) -> None:
            """Show a photo where it lies in the view of its camera."""
            pixels = clean(photo.image.pixels)
            luminances = find_luminances(pixels)
            height, width = luminances.shape
            size = mi.Vector2f(width, height)
            axes = [mi.Vector3f(*map(float, axis)) for axis in np.asarray(photo.frame).T]
            extent = mi.Vector2f(float(photo.extent_x), float(photo.extent_y))
            shift = mi.Vector2f(float(photo.shift_x), float(photo.shift_y))
            level = mi.Float(float(photo.luminance_per_unit))
            values = upload(mi.Float, luminances)
            colours = make_colours(pixels, luminances)
            dr.eval(values, colours)
            self.photo = axes, extent, shift, size, level, values, colours
            dr.make_opaque(axes, extent, shift, size, level)

        # ---- what is seen ----

        def _redirect(self, place, direction):
            """Direction from the map's centre to where a ray from a place meets the ground, fading into its own."""
            centre, level, radius = self.ground
            falls = (direction.z < -LEAST_FALL) & (place.z > level)
            way = (level - place.z) / dr.select(falls, direction.z, -1.0)
            away = place + direction * way - centre
            share = dr.norm(mi.Vector2f(away.x, away.y)) / radius
            rest = dr.clip((share - FADE) / (1.0 - FADE), 0.0, 1.0)
            rest = rest * rest * (3.0 - 2.0 * rest)
            turned = dr.normalize(dr.lerp(dr.normalize(mi.Vector3f(away)), direction, rest))
            return dr.select(falls & (share < 1.0), turned, direction)

        def _seen_in_photo(self, direction):
            """Place in the photo where a direction shows, (0..1, 0..1), and whether it does."""
            axes, extent, shift = self.photo[:3]
            ahead = -dr.dot(direction, axes[2])
            reach = dr.select(ahead > 0.0, ahead, 1.0)
            u = (dr.dot(direction, axes[0]) / reach - shift.x) / extent.x + 0.5
            v = (dr.dot(direction, axes[1]) / reach - shift.y) / extent.y + 0.5
            off = dr.maximum(dr.abs(u - 0.5), dr.abs(v - 0.5))
            inside = (ahead > 0.0) & (off <= 0.5 + MARGIN)
            return u, v, inside

        def _photo_value(self, u, v, wavelengths, active):
            """Radiance of the photo, linear between the middles of its pixels."""
            _, _, _, size, level, values, colours = self.photo
            white_si = dr.zeros(mi.SurfaceInteraction3f)
            white_si.wavelengths = wavelengths
            white = self.radiance.eval(white_si, active)
            total = mi.Spectrum(0.0)
            x, y = (dr.clip(each * n - 0.5, 0.0, n - 1.0) for each, n in ((u, size.x), (v, size.y)))
            width = mi.UInt32(size.x)
            column, row = mi.UInt32(x), mi.UInt32(y)
            s, t = x - mi.Float(column), y - mi.Float(row)
            right = dr.minimum(column + 1, mi.UInt32(size.x - 1.0))
            above = dr.minimum(row + 1, mi.UInt32(size.y - 1.0))
            for across, up, weight in (
                (column, row, (1.0 - s) * (1.0 - t)),
                (right, row, s * (1.0 - t)),
                (column, above, (1.0 - s) * t),
                (right, above, s * t),
            ):
                number = up * width + across
                if colours is None:
                    total += weight * dr.gather(mi.Float, values, number, active)
                else:
                    c0, c1, c2, scale = dr.gather(mi.Vector4f, colours, number, active)
                    total += weight * scale * sigmoid(c0, c1, c2, wavelengths)
            return total * white * level

        def eval(self, si, active=True):
            direction = -si.wi
            if self.ground is not None:
                direction = self._redirect(si.p, direction)
            value = mi.Spectrum(0.0)
            if self.world is not None:
                away = dr.zeros(mi.SurfaceInteraction3f)
                away.wi, away.wavelengths, away.p = -direction, si.wavelengths, si.p
                value = self.world.eval(away, active)
            if self.photo is not None:
                u, v, inside = self._seen_in_photo(direction)
                inside &= active
                shown = self._photo_value(u, v, si.wavelengths, inside)
                value = dr.select(inside, shown, value)
            return mi.Spectrum(value & active)

        # ---- sampling ----

        def eval_direction(self, it, ds, active=True):
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wi, si.wavelengths, si.p = -ds.d, it.wavelengths, it.p
            return self.eval(si, active)

        def sample_direction(self, it, sample, active=True):
            if self.world is not None:
                ds, _ = self.world.sample_direction(it, sample, active)
                return ds, mi.Spectrum(0.0)
            ds = dr.zeros(mi.DirectionSample3f)
            ds.d = mi.warp.square_to_uniform_sphere(sample)
            ds.pdf = mi.Float(dr.inv_four_pi)
            return ds, mi.Spectrum(0.0)

        def pdf_direction(self, it, ds, active=True):
            if self.world is not None:
                return self.world.pdf_direction(it, ds, active)
            return dr.select(active, mi.Float(dr.inv_four_pi), 0.0)

    return Projection
