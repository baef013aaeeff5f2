"""Facets that lie along a direction of the surface: anisotropic GGX, Smith's height-correlated masking, what is lost.

With widths a_x along the direction and a_y across it, and the half direction h,

    D(h) = 1 / (pi a_x a_y (h_x^2 / a_x^2 + h_y^2 / a_y^2 + h_z^2)^2)
    G2(i, o) / (4 cos_i cos_o) = 1 / (2 (cos_o r(i) + cos_i r(o))),    r(w)^2 = (a_x w_x)^2 + (a_y w_y)^2 + cos_w^2.

What single scattering reflects then depends on the azimuth too, so its tables have one row for each of a few azimuths. The
direction is that of U, or goes round an axis of the object through the middle m of its box: it is A (p - m), brought into
the plane of the surface, and the same from both ends.

References
----------
E. Heitz: Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs, JCGT 3, 2014 (stretched distributions).
J. Dupuy, A. Benyoub: Sampling Visible GGX Normals with Spherical Caps, HPG 2023.
"""

from functools import lru_cache

import numpy as np

from .facets import (
    MINIMUM_ALPHA,
    PLASTIC,
    cosines,
    fresnel,
    mean_reflectance,
    read_row,
)

AZIMUTHS = 13
"""Rows of a table over a quarter turn from along the direction to across it, see `azimuths`."""

POINTS = 2048
"""Visible normals of each entry of a table."""


def widths_of(alpha: float, stretch: float) -> tuple[float, float]:
    """Return the widths along the direction and across it. [-]"""
    along, across = (
        float(np.clip(a, MINIMUM_ALPHA, 1.0)) for a in (alpha * stretch, alpha / stretch)
    )
    return along, across


def azimuths(stretch: float) -> np.ndarray:
    """Return the azimuths of a table, whose tangents over the stretch are those of even steps. (`AZIMUTHS`,) [rad]

    So they are the closer the faster the width seen from there changes, at both ends.
    """
    even = np.linspace(0.0, 0.5 * np.pi, AZIMUTHS)
    return np.arctan2(np.sin(even) * stretch, np.cos(even))


@lru_cache(maxsize=512)
def grain_reflectance(alpha: float, stretch: float, eta: float = np.inf) -> np.ndarray:
    """Share of light that facets reflect once, by azimuth and cosine. (`AZIMUTHS`, 64) [-]

    ``eta``: refractive index of facets of a dielectric; infinite: they reflect everything.
    """
    widths = np.array([*widths_of(alpha, stretch), 1.0], dtype=np.float32)
    number = np.arange(POINTS) + 0.5
    u, v = ((number / PLASTIC**n % 1.0).astype(np.float32) for n in (1, 2))
    cosine = cosines()
    sine = np.sqrt(1.0 - cosine**2)
    rows = []
    for azimuth in azimuths(stretch):
        parts = sine * np.cos(azimuth), sine * np.sin(azimuth), cosine
        wi = np.stack(parts, axis=1).astype(np.float32)[:, None, :]
        stretched = wi * widths
        root_i = np.linalg.norm(stretched, axis=2)
        stretched /= root_i[..., None]
        z = (1.0 - u) * (1.0 + stretched[..., 2]) - stretched[..., 2]
        radius = np.sqrt(np.clip(1.0 - z**2, 0.0, None))
        cap = np.stack(
            [radius * np.cos(2.0 * np.pi * v), radius * np.sin(2.0 * np.pi * v), z], axis=2
        )
        normal = (cap + stretched) * widths
        normal /= np.linalg.norm(normal, axis=2, keepdims=True)
        dot = (wi * normal).sum(axis=2)
        wo = 2.0 * dot[..., None] * normal - wi
        cos_i, cos_o = wi[..., 2], wo[..., 2]
        root_o = np.linalg.norm(wo * widths, axis=2)
        seen = cos_o * (cos_i + root_i) / np.maximum(cos_o * root_i + cos_i * root_o, 1e-12)
        mirror = 1.0 if np.isinf(eta) else fresnel(np.clip(dot, 0.0, 1.0), eta)
        weight = np.where(cos_o > 0.0, mirror * seen, 0.0)
        rows.append(np.clip(weight.mean(axis=1, dtype=np.float64), 0.0, 1.0))
    return np.stack(rows)


def mean_over_azimuths(table: np.ndarray, stretch: float) -> float:
    """Hemispherical mean of a table by azimuth and cosine. [-]"""
    means = np.array([mean_reflectance(row) for row in table])
    steps = np.diff(azimuths(stretch))
    return float((0.5 * (means[1:] + means[:-1]) * steps).sum() / (0.5 * np.pi))


class GrainOfFacets:
    """How facets lie, on the device.

    Parameters
    ----------
    stretch : float    Width along the direction over that without one. [-]
    rotation : mi.Texture    Turns of the direction about the normal. [-]
    axis : int or None    Of the object about which the direction goes round; None: it goes along U.
    """

    def __init__(self, stretch: float, rotation, axis: int | None):
        import drjit as dr
        import mitsuba as mi

        self.stretch, self.rotation, self.axis = mi.Float(stretch), rotation, axis
        self.ways = None
        dr.make_opaque(self.stretch)

    def set_ways(self, ways: np.ndarray) -> None:
        """Set what leads from places to directions. ``ways``: (n, 3, 4, 3) A and m by axis and number of the shape."""
        import drjit as dr
        import mitsuba as mi

        from ..arrays import upload

        if self.axis is not None:
            self.ways = upload(mi.Float, ways[:, self.axis].reshape(-1))
            dr.eval(self.ways)

    def lay(self, si, alpha, active):
        """Return the `LaidFacets` at a place. ``alpha``: width without a direction."""
        import drjit as dr
        import mitsuba as mi

        turn = dr.two_pi * self.rotation.eval_1(si, active)
        # Blender turns about the normal of the side that is seen.
        sine, cosine = dr.sincos(dr.select(si.wi.z < 0.0, -turn, turn))
        x, y = mi.Float(1.0), mi.Float(0.0)
        if self.ways is not None:
            number = dr.reinterpret_array(mi.UInt32, si.shape)
            rows = [
                mi.Vector3f(
                    *(
                        dr.gather(mi.Float, self.ways, number * 12 + 3 * k + n, active)
                        for n in range(3)
                    )
                )
                for k in range(4)
            ]
            away = mi.Vector3f(si.p) - rows[3]
            along = si.to_local(mi.Vector3f(*(dr.dot(row, away) for row in rows[:3])))
            length = dr.sqrt(dr.square(along.x) + dr.square(along.y))
            is_known = length > 1e-12
            x = dr.select(is_known, along.x / dr.maximum(length, 1e-12), x)
            y = dr.select(is_known, along.y / dr.maximum(length, 1e-12), y)
        along, across = (
            dr.clip(a, MINIMUM_ALPHA, 1.0) for a in (alpha * self.stretch, alpha / self.stretch)
        )
        return LaidFacets(self.stretch, along, across, x * cosine - y * sine, x * sine + y * cosine)


class LaidFacets:
    """Facets at a place: widths along and across, and the direction in the local frame, (x, y)."""

    def __init__(self, stretch, along, across, x, y):
        self.stretch, self.along, self.across, self.x, self.y = stretch, along, across, x, y

    def turn(self, w):
        """Bring a local direction into the frame of the facets."""
        import mitsuba as mi

        return mi.Vector3f(w.x * self.x + w.y * self.y, w.y * self.x - w.x * self.y, w.z)

    def _root(self, w):
        import drjit as dr

        parts = dr.square(self.along * w.x) + dr.square(self.across * w.y) + dr.square(w.z)
        return dr.sqrt(parts)

    def mirror_light(self, wi, wo):
        """Evaluate facets that reflect everything, as `facets.mirror_light`."""
        import drjit as dr
        import mitsuba as mi

        middle = dr.normalize(wi + wo)
        half = self.turn(middle)
        cos_i, cos_o = dr.abs(mi.Frame3f.cos_theta(wi)), dr.abs(mi.Frame3f.cos_theta(wo))
        root_i, root_o = self._root(self.turn(wi)), self._root(self.turn(wo))
        spread = (
            dr.square(half.x * self.across)
            + dr.square(half.y * self.along)
            + dr.square(half.z * self.along * self.across)
        )
        area = self.along * self.across
        facets = area * dr.square(area) * dr.inv_pi / dr.maximum(dr.square(spread), 1e-30)
        visibility = 0.5 / dr.maximum(cos_o * root_i + cos_i * root_o, 1e-12)
        density = facets * 0.5 / dr.maximum(cos_i + root_i, 1e-12)
        return facets * visibility * cos_o, density, dr.abs(dr.dot(wi, middle))

    def reflect(self, wi, sample):
        """Reflect on a visible normal, as `facets.reflect_on_facet`."""
        import drjit as dr
        import mitsuba as mi

        own = self.turn(wi)
        stretched = dr.normalize(mi.Vector3f(self.along * own.x, self.across * own.y, own.z))
        z = (1.0 - sample.x) * (1.0 + stretched.z) - stretched.z
        radius = dr.safe_sqrt(1.0 - z * z)
        sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.y)
        cap = mi.Vector3f(radius * cos_phi, radius * sin_phi, z) + stretched
        normal = dr.normalize(
            mi.Vector3f(self.along * cap.x, self.across * cap.y, dr.maximum(cap.z, 1e-12))
        )
        turned = mi.Normal3f(
            normal.x * self.x - normal.y * self.y, normal.x * self.y + normal.y * self.x, normal.z
        )
        return mi.reflect(wi, turned)

    def read(self, table, row, w, active):
        """Interpolate a table of `AZIMUTHS` rows for each ``row``, at the azimuth and cosine of a local direction."""
        import drjit as dr
        import mitsuba as mi

        own = self.turn(w)
        angle = dr.atan2(dr.abs(own.y), dr.abs(own.x) * self.stretch)
        place = angle * (2.0 * dr.inv_pi * (AZIMUTHS - 1))
        below = dr.minimum(mi.UInt32(place), AZIMUTHS - 2)
        first = row * AZIMUTHS + below
        low, high = (read_row(table, n, dr.abs(w.z), active) for n in (first, first + 1))
        return dr.lerp(low, high, place - mi.Float(below))
