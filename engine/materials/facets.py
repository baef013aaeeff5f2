"""Surfaces of microfacets: GGX distribution, Smith's height-correlated masking, and what single scattering loses.

Directions are local, with the normal along +z.

References
----------
B. Walter et al.: Microfacet Models for Refraction through Rough Surfaces, EGSR 2007 (GGX).
J. Dupuy, A. Benyoub: Sampling Visible GGX Normals with Spherical Caps, HPG 2023.
M. Roberts: The Unreasonable Effectiveness of Quasirandom Sequences, 2018 (points for tables).
"""

from functools import cache, lru_cache

import numpy as np

COSINES = 64
"""Entries of a table over the cosine, evenly in its root from 0 to 1."""

MINIMUM_ALPHA = 1e-3
"""Narrowest lobe that single precision evaluates well."""

POINTS = 4096
"""Visible normals of each entry of a table."""

PLASTIC = 1.324717957244746
"""The root of x^3 = x + 1, by whose powers points are spread evenly."""


def fresnel(cosine, eta):
    """Reflectance of a dielectric boundary from outside, unpolarised. [-]"""
    g = np.sqrt(np.maximum(eta**2 - 1.0 + cosine**2, 0.0))
    a = (g - cosine) / np.maximum(g + cosine, 1e-12)
    b = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0)
    return 0.5 * a**2 * (1.0 + b**2)


def cosines() -> np.ndarray:
    """Return the cosines of a table; 0 is moved a little, where nothing would be seen. (64,) [-]"""
    cosine = np.linspace(0.0, 1.0, COSINES, dtype=np.float32) ** 2
    cosine[0] = 0.25 * cosine[1]
    return cosine


@cache
def _spread_samples() -> tuple[np.ndarray, np.ndarray]:
    """Two numbers for each of `POINTS` normals: one in 0 .. 1, and the cosine of an azimuth. (`POINTS`,) twice [-]"""
    number = np.arange(POINTS) + 0.5
    # Half a turn of the azimuth serves, by symmetry.
    azimuth = np.pi * (number / PLASTIC**2 % 1.0)
    return (number / PLASTIC % 1.0).astype(np.float32), np.cos(azimuth).astype(np.float32)


def visible_facets(alpha: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return `cosines` (64, 1), and of facets seen from there cosines to them and to the normal. (64, `POINTS`) [-]"""
    u, turn = _spread_samples()
    cosine = cosines()[:, None]
    sine = np.sqrt(1.0 - cosine**2)
    # By spherical caps: reflect a cap sample on the stretched view direction, which lies in the plane y = 0.
    length = np.sqrt((alpha * sine) ** 2 + cosine**2)
    x, z = np.float32(alpha) * sine / length, cosine / length
    height = (1.0 - u) * (1.0 + z) - z
    radius = np.sqrt(np.maximum(1.0 - height**2, 0.0))
    along = radius * turn
    across = radius**2 - along**2
    along += x
    height += z
    width = np.float32(alpha)
    length = np.sqrt(width**2 * (along**2 + across) + height**2)
    height /= length
    return cosine, sine * width * along / length + cosine * height, height


@lru_cache(maxsize=512)
def directional_reflectance(alpha: float, eta: float = np.inf) -> np.ndarray:
    """Share of light that facets reflect once, E(cosine), at `COSINES` steps even in the root. (64,) [-]

    Quadrature over the distribution of visible normals. ``eta``: refractive index of facets of a dielectric; infinite: they
    reflect everything.
    """
    dot, ratio = seen_facets(alpha)
    mirror = 1.0 if np.isinf(eta) else fresnel(dot, eta)
    return np.clip((mirror * ratio).mean(axis=1, dtype=np.float64), 0.0, 1.0)


def seen_facets(alpha: float) -> tuple[np.ndarray, np.ndarray]:
    """Return cosines to facets that are seen from `cosines`, and how much of what they reflect no other facet stops.

    (64, `POINTS`), (64, `POINTS`) [-]
    """
    cos_i, dot, height = visible_facets(alpha)
    cos_o = 2.0 * dot * height - cos_i
    root_i, root_o = smith_root(cos_i, alpha), smith_root(cos_o, alpha)
    # G2 / G1 of the height-correlated Smith term.
    ratio = cos_o * (cos_i + root_i) / np.maximum(cos_o * root_i + cos_i * root_o, 1e-12)
    return np.clip(dot, 0.0, 1.0), np.where(cos_o > 0.0, ratio, 0.0)


def coat_reflectance(alpha: float, eta: float, scale: float, tint: float = 1.0) -> np.ndarray:
    """Share of light that a coat reflects once, as `directional_reflectance`.

    ``scale``: on all of it; ``tint``: on what it reflects along the normal, of which grazing light keeps less.
    """
    own = directional_reflectance(alpha, eta)
    if tint < 1.0:
        whole = directional_reflectance(alpha)
        own = whole - grazing(eta, tint) * (whole - own)
    return scale * own


def grazing(eta, tint):
    """Factor on what does not reflect, 1 - F, of facets whose reflectance along the normal is tinted. [-]"""
    normal = ((eta - 1.0) / (eta + 1.0)) ** 2
    return (1.0 - normal * tint) / (1.0 - normal)


@lru_cache(maxsize=512)
def kept_by_glass(alpha: float, eta: float) -> np.ndarray:
    """Share of light that the first facet of a boundary reflects or lets in, as Mitsuba has it. (64,) [-]

    By cosines as `directional_reflectance`. What would meet another facet is not in it. ``eta``: index of the other side
    over that of this one.
    """
    dot, reflected, refracted = seen_of_glass(alpha, eta)
    mirror = fresnel(dot, eta)
    kept = mirror * reflected + (1.0 - mirror) * refracted
    return kept.mean(axis=1, dtype=np.float64)


def seen_of_glass(alpha: float, eta: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return cosines to facets that are seen from `cosines`, and how much of what each reflects and lets in no other stops.

    (64, `POINTS`) each [-]. ``eta`` as in `kept_by_glass`.
    """
    cosine, dot, height = visible_facets(alpha)
    dot = np.clip(dot, 0.0, 1.0)
    reflected = 2.0 * dot * height - cosine
    inner = np.sqrt(np.maximum(1.0 - (1.0 - dot**2) / eta**2, 0.0))
    refracted = (dot / eta - inner) * height - cosine / eta

    def seen(cosine):
        """Smith's shadowing; Mitsuba takes it as independent of masking."""
        root = smith_root(cosine, alpha)
        return np.where(cosine > 0.0, 2.0 * cosine / np.maximum(cosine + root, 1e-12), 0.0)

    return dot, seen(reflected), seen(-refracted)


def smith_root(cosine, alpha):
    """Root in Smith's masking of GGX. [-]"""
    return np.sqrt(alpha**2 + (1.0 - alpha**2) * cosine**2)


def mean_reflectance(table: np.ndarray) -> float:
    """Hemispherical mean 2 * integral of E cos of a table, exactly for its linear interpolant. [-]"""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    root = np.linspace(0.0, 1.0, len(table))
    step = root[1]
    places = root[:-1, None] + 0.5 * step * (nodes + 1.0)
    return float(4.0 * (0.5 * step * weights * np.interp(places, root, table) * places**3).sum())


def mirror_light(wi, wo, alpha):
    """Evaluate facets that reflect everything.

    Parameters
    ----------
    wi, wo : Vector3f    On the same side of the surface.
    alpha : Float    Width of the distribution. [-]

    Returns
    -------
    value : Float    D G2 / (4 cos_i), the distribution of reflectance times cos_o.
    density : Float    Of visible normals over reflected directions, D G1 / (4 cos_i). [1/sr]
    cosine : Float    Between a direction and the facet. [-]
    """
    import drjit as dr
    import mitsuba as mi

    cos_i, cos_o = dr.abs(mi.Frame3f.cos_theta(wi)), dr.abs(mi.Frame3f.cos_theta(wo))
    half = dr.normalize(wi + wo)
    a2 = dr.square(alpha)
    # 1 - (1 - a2) cos^2 without cancellation for narrow lobes.
    spread = dr.square(half.x) + dr.square(half.y) + a2 * dr.square(half.z)
    facets = a2 * dr.inv_pi / dr.maximum(dr.square(spread), 1e-30)
    root_i = dr.sqrt(a2 + (1.0 - a2) * dr.square(cos_i))
    root_o = dr.sqrt(a2 + (1.0 - a2) * dr.square(cos_o))
    visibility = 0.5 / dr.maximum(cos_o * root_i + cos_i * root_o, 1e-12)
    density = facets * 0.5 / dr.maximum(cos_i + root_i, 1e-12)
    return facets * visibility * cos_o, density, dr.abs(dr.dot(wi, half))


def reflect_on_facet(wi, alpha, sample):
    """Reflect on a visible normal; ``wi`` above the surface. ``sample``: Point2f in [0, 1)."""
    import drjit as dr
    import mitsuba as mi

    stretched = dr.normalize(mi.Vector3f(alpha * wi.x, alpha * wi.y, wi.z))
    z = (1.0 - sample.x) * (1.0 + stretched.z) - stretched.z
    radius = dr.safe_sqrt(1.0 - z * z)
    sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.y)
    cap = mi.Vector3f(radius * cos_phi, radius * sin_phi, z) + stretched
    normal = dr.normalize(mi.Vector3f(alpha * cap.x, alpha * cap.y, dr.maximum(cap.z, 1e-12)))
    return mi.reflect(wi, mi.Normal3f(normal))


def read_row(table, row, cosine, active):
    """Interpolate a row of a table over the cosine, of `COSINES` entries each."""
    import drjit as dr
    import mitsuba as mi

    place = dr.sqrt(dr.clip(cosine, 0.0, 1.0)) * (COSINES - 1)
    below = dr.minimum(mi.UInt32(place), COSINES - 2)
    index = row * COSINES + below
    low = dr.gather(mi.Float, table, index, active)
    high = dr.gather(mi.Float, table, index + 1, active)
    return dr.lerp(low, high, place - mi.Float(below))
