"""Light that one flake reflects straight out of a paint: the sharp part of its scattering, in closed form.

In a layer of the thickness H with the extinction sig, between directions with the cosines mu and mu',

    f = S / (n2 mu mu') (1 - exp(-A H)) / A,    A = sig / mu + sig' / mu'

times what the layers and faces above let through both ways. Faces polarise what goes through them, and flakes reflect it by
its polarisation; unpolarised light of unit power becomes, by Stokes's first three numbers in the planes of the face, of the
flake and of the face again, with T and D half the sum and difference of each pair of shares, and a, g the angles between
these planes,

    T_o (r T_i + d D_i cos 2a) + D_o [(d T_i + r D_i cos 2a) cos 2g + c D_i sin 2a sin 2g]

where c is the real part of the flake's one amplitude times the other's conjugate.
"""

from dataclasses import dataclass

import numpy as np

from .fresnel import face_shares
from .matter import LayerMatter
from .orientation import density

CHUNK = 1 << 20
"""Values (pairs of directions times bands) that are computed in one go."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of directions of incidence and of exit, outside.

    Parameters
    ----------
    incident, leaving : (n,) float64 arrays    Sines of their angles to the normal.
    turn : (n,) float64 array    Cosine of the azimuth of the leaving one from forward, where a mirror's light goes.
    """

    incident: np.ndarray
    leaving: np.ndarray
    turn: np.ndarray


def pairs_of(wi, wo) -> Pairs:
    """Pairs of unit vectors that both point away from the surface. (n, 3), (n, 3)"""
    wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
    level = [np.hypot(each[:, 0], each[:, 1]) for each in (wi, wo)]
    both = level[0] * level[1]
    across = -(wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1])
    turn = np.where(both > 1e-12, across / np.maximum(both, 1e-12), 1.0)
    return Pairs(*(np.minimum(each, 1.0) for each in level), np.clip(turn, -1.0, 1.0))


def single_reflection(
    layers: tuple[LayerMatter, ...], extinctions, pairs: Pairs, is_polarised: bool = True
) -> np.ndarray:
    """BRDF of light that is reflected by one flake.

    Parameters
    ----------
    layers : tuple of LayerMatter    The outermost first.
    extinctions : function    Of the number of a layer and sines outside: (n,) -> (n, w). [1/um]
    is_polarised : bool    Whether faces and flakes count by polarisation; if not, by means.

    Returns
    -------
    (n, w) float64 array    [1/sr]
    """
    bands = len(layers[0].index)
    total = np.zeros((len(pairs.turn), bands))
    step = max(CHUNK // bands, 1)
    for k in range(0, len(total), step):
        part = Pairs(*(each[k : k + step] for each in (pairs.incident, pairs.leaving, pairs.turn)))
        total[k : k + step] = _reflected(layers, extinctions, part, is_polarised)
    return total


def _reflected(layers, extinctions, pairs: Pairs, is_polarised: bool) -> np.ndarray:
    total = 0.0
    above = np.ones(1)
    sides = (pairs.incident, pairs.leaving)
    # Shares of both polarisations that faces let through, and what matter above takes, on both ways.
    passed = [[1.0, 1.0], [1.0, 1.0]]
    taken = 0.0
    for number, layer in enumerate(layers):
        for way, sines in zip(passed, sides, strict=True):
            for k, share in enumerate(face_shares(sines[:, None], above, layer.face_index)):
                way[k] = way[k] * (1.0 - share)
        cosines = [np.sqrt(1.0 - (sines / layer.mean_index) ** 2) for sines in sides]
        rates = sum(
            extinctions(number, sines) / cosine[:, None]
            for sines, cosine in zip(sides, cosines, strict=True)
        )
        if layer.flakes:
            depth = layer.thickness * -np.expm1(-rates * layer.thickness)
            depth /= np.maximum(rates * layer.thickness, 1e-300)
            depth = np.where(rates * layer.thickness < 1e-12, layer.thickness, depth)
            scale = 1.0 / (4.0 * layer.mean_index**2 * cosines[0] * cosines[1])
            own = _flakes(layer, pairs, cosines, passed, is_polarised)
            total = total + scale[:, None] * depth * np.exp(-taken) * own
        taken = taken + rates * layer.thickness
        above = layer.face_index
    return np.zeros((len(pairs.turn), len(layers[0].index))) + total


def _flakes(layer: LayerMatter, pairs: Pairs, cosines, passed, is_polarised: bool) -> np.ndarray:
    """Sum over flakes of a D(h) times what becomes of unit power. (n, w) [1/um]"""
    sines = [each / layer.mean_index for each in (pairs.incident, pairs.leaving)]
    half = sines[0] * sines[1] * pairs.turn - cosines[0] * cosines[1]  # cosine between both ways
    met = np.sqrt(0.5 * np.maximum(1.0 - half, 0.0))
    upright = (cosines[0] + cosines[1]) / np.maximum(2.0 * met, 1e-12)
    first, last = ((0.5 * (s + p), 0.5 * (s - p)) for s, p in passed)
    if is_polarised:
        turned = _turns(sines, cosines, pairs.turn)
    total = 0.0
    for each in layer.flakes:
        across, within, both = each.curves.read(met)
        mean, half = 0.5 * (across + within), 0.5 * (across - within)
        share = first[0] * mean * last[0]
        if is_polarised:
            cos_in, sin_in, cos_out, sin_out = (angle[:, None] for angle in turned)
            share = share + last[0] * half * first[1] * cos_in
            share += last[1] * (half * first[0] + mean * first[1] * cos_in) * cos_out
            # The basis within the plane turns over at the flake, so the sign of the amplitude does.
            share -= last[1] * both * first[1] * sin_in * sin_out
        weight = each.area * density(np.minimum(upright, 1.0), each.slope)
        total = total + weight[:, None] * np.maximum(share, 0.0)
    return total


def _turns(sines, cosines, turn) -> tuple[np.ndarray, ...]:
    """Cosine and sine of twice the angle between the faces' plane and the flake's, before and after it."""
    side = np.sqrt(np.maximum(1.0 - turn**2, 0.0))
    zero = np.zeros_like(turn)
    down = np.stack([sines[0], zero, -cosines[0]], axis=1)
    up = np.stack([sines[1] * turn, sines[1] * side, cosines[1]], axis=1)
    normal = np.cross(down, up)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    level = np.stack([zero, np.ones_like(turn), zero], axis=1)
    normal = np.where(length > 1e-9, normal / np.maximum(length, 1e-9), level)
    turned = []
    for way, own in ((down, level), (up, np.stack([-side, turn, zero], axis=1))):
        along = (own * normal).sum(axis=1)
        beside = (own * np.cross(way, normal)).sum(axis=1)
        turned += [along**2 - beside**2, 2.0 * along * beside]
    return tuple(turned)
