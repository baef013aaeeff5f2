"""What benchmarks of light that is hard to find compare with: closed forms, with no part of the engine in them.

Formulas: panes by the sum over their inner reflections, both polarisations apart (Born and Wolf, Principles of Optics,
section 1.6); closed rooms by the light that comes in and goes out; a disk that is cut by an edge by the vector of its
boundary (Moon, Scientific Basis of Illuminating Engineering, 1936).
"""

import numpy as np

NODES = 48
"""Of sums over angles."""


def pane_shares(cosine, index: float, internal: float):
    """Shares that a pane reflects and lets pass of both polarisations, all inner reflections summed.

    Parameters
    ----------
    cosine : (n,) array    Of the angle of incidence. [-]
    index, internal : float    Refractive index, and transmittance of the body straight through. [-]

    Returns
    -------
    ((2, n) array, (2, n) array)    Reflected, passed.
    """
    surface, inside = fresnel_shares(cosine, index)
    body = internal ** (1.0 / inside)
    rest = (1.0 - surface) ** 2 * body / (1.0 - (surface * body) ** 2)
    return surface + rest * surface * body, rest


def fresnel_shares(cosine, index: float):
    """Shares (2, n) that a boundary reflects of both polarisations, and the cosine (n,) behind it. [-]"""
    cosine = np.asarray(cosine, float)
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    s = (cosine - index * inside) / (cosine + index * inside)
    p = (index * cosine - inside) / (index * cosine + inside)
    return np.stack([s**2, p**2]), inside


def two_panes(cosine, index: float, internal: float):
    """Share (n,) of unpolarised light that two parallel panes let pass, with what goes to and fro between them."""
    reflected, passed = pane_shares(cosine, index, internal)
    return (passed**2 / (1.0 - reflected**2)).mean(axis=0)


def sun_through_panes(
    tilt: float, normal: float, index: float, internal: float, angle: float
) -> float:
    """Illuminance of a horizontal plane behind two horizontal panes.

    Parameters
    ----------
    tilt, angle : float    Of the sun from the zenith, and its diameter; 0: a point. [rad]
    normal : float    Illuminance of a plane that faces the sun. [lx]
    index, internal : float    Of the panes. [-]
    """
    if angle == 0.0:
        return float(normal * np.cos(tilt) * two_panes(np.cos(tilt), index, internal))
    radius = 0.5 * angle
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    # Even in the cosine to the middle is even in solid angle.
    solid_angle = 2.0 * np.pi * (1.0 - np.cos(radius))
    near = (1.0 - 0.5 * (1.0 - np.cos(radius)) * (nodes + 1.0))[:, None]
    around = 2.0 * np.pi * (np.arange(NODES) + 0.5) / NODES
    cosines = np.cos(tilt) * near + np.sin(tilt) * np.sqrt(1.0 - near**2) * np.cos(around)
    passed = two_panes(cosines.ravel(), index, internal).reshape(cosines.shape)
    mean = 0.5 * float(weights @ (cosines * passed).mean(axis=1))
    return normal / (np.pi * np.sin(radius) ** 2) * solid_angle * mean


def lamp_in_pane(place, normal, lamp, intensity: float, index: float, internal: float) -> float:
    """Illuminance by the image of a lamp in the endless pane z = 0. Places (3,) [m], intensity [cd]."""
    away = np.array([lamp[0], lamp[1], -lamp[2]]) - np.asarray(place, float)
    distance = np.linalg.norm(away)
    share = pane_shares(abs(away[2]) / distance, index, internal)[0].mean()
    return float(share * intensity * max(np.dot(normal, away) / distance, 0.0) / distance**2)


def closed_room(flux: float, reflectance: float, area: float, absorbing: float = 0.0) -> float:
    """Mean illuminance of a closed room: what comes in is what its walls and a small body take.

    Parameters
    ----------
    flux : float    [lm]
    reflectance, area : float    Of the walls. [-], [m2]
    absorbing : float    Area by which the body takes of even light all around. [m2]
    """
    return flux / ((1.0 - reflectance) * area + 4.0 * reflectance * absorbing)


def body_in_bulb(radius: float, bulb: float, index: float) -> tuple[float, float]:
    """What a black ball in the middle of a ball of clear glass takes.

    Whatever leaves the body comes back to it after every reflection at the glass, since it keeps its distance from the
    middle; the same holds for light from without that is once refracted towards it.

    Parameters
    ----------
    radius, bulb : float    Of the body and of the glass; their ratio times the index is below 1. [m]
    index : float

    Returns
    -------
    (float, float)    Share of the light that it emits that it takes back; its cross-section for light from without. [m2]
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    # Even in the square of the sine is even in the flux of a Lambertian body and in the cross-section alike.
    squares, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    outside = np.sqrt(1.0 - (index * radius / bulb) ** 2 * squares)
    back = float(weights @ fresnel_shares(outside, index)[0].mean(axis=0))
    return back, float(np.pi * (index * radius) ** 2 * (1.0 - back))


def in_sphere(place, lamp, flux: float, reflectance: float, radius: float, absorbing: float = 0.0):
    """Illuminance (n,) of the wall of a sphere about the origin at places (n, 3), by an even lamp in it. [lx]"""
    place = np.asarray(place, float)
    away = np.asarray(lamp, float) - place
    distance = np.linalg.norm(away, axis=1)
    inwards = -place / np.linalg.norm(place, axis=1, keepdims=True)
    straight = flux / (4.0 * np.pi) * (away * inwards).sum(axis=1) / distance**3
    # What any point of a matt sphere sends is even all over it.
    return straight + reflectance * closed_room(
        flux, reflectance, 4.0 * np.pi * radius**2, absorbing
    )


def keyhole(width: float, horizontal: float, towards, reflectance: float) -> float:
    """Flux on the surfaces of a box of 1 m whose lid has a square hole in its middle.

    Parameters
    ----------
    width : float    Of the hole. [m]
    horizontal : float    Illuminance by the sun in the hole. [lx]
    towards : (3,) array    The way light travels.
    reflectance : float

    Notes
    -----
    Some light leaves by the hole again: from the patch on the floor by its form factor, later as the hole's share of the
    surface, which is good to a few per cent of what leaves.
    """
    direction = np.asarray(towards, float)
    across = direction[:2] / -direction[2]
    first = width**2 / (np.pi * (1.0 + across @ across) ** 2)
    later = width**2 / 6.0
    reflected = reflectance * (1.0 - first) / (1.0 - reflectance * (1.0 - later))
    return float(horizontal * width**2 * (1.0 + reflected))


def disk_behind_edge(elevation: float, angle: float, normal: float, tilt: float) -> float:
    """Illuminance of a horizontal plane by an even disk of which a horizontal edge across hides a part.

    Parameters
    ----------
    elevation, angle : float    Of the disk's middle, and its diameter. [rad]
    normal : float    Illuminance of a plane that faces the whole disk. [lx]
    tilt : float    Elevation of the edge as it is seen from the place; what is below it is seen. [rad]

    Notes
    -----
    Illuminance is the luminance times the vector of the boundary, half the sum of r x dr along it: an arc of the disk's
    rim and a piece of the great circle that holds the edge.
    """
    radius = 0.5 * angle
    middle = np.array([np.cos(elevation), 0.0, np.sin(elevation)])
    up, side = np.array([-np.sin(elevation), 0.0, np.cos(elevation)]), np.array([0.0, 1.0, 0.0])
    # Normal of the plane of edge and place, towards what is seen; the rim, run through from side to up, meets it twice.
    edge = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    height = np.clip(np.tan(tilt - elevation) / np.tan(radius), -1.0, 1.0)
    start, end = np.pi - np.arcsin(height), 2.0 * np.pi + np.arcsin(height)
    sweep = end - start
    arc = np.sin(radius) ** 2 * sweep * middle
    arc -= (
        np.sin(radius)
        * np.cos(radius)
        * ((np.sin(end) - np.sin(start)) * side - (np.cos(end) - np.cos(start)) * up)
    )
    # Both ends lie as far to one side as to the other, and are seen from a place within the plane.
    chord = 2.0 * np.arcsin(np.sin(radius) * np.cos(start + np.pi))
    vector = 0.5 * (arc + chord * edge)
    return float(normal / (np.pi * np.sin(radius) ** 2) * vector[2])
