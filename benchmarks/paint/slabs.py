"""Slabs of grains alone, in closed matter and in air, from the same matrices that paints are solved with."""

import numpy as np

from ...engine.paint.directions import place_directions
from ...engine.paint.fresnel import face_reflectance
from ...engine.paint.matter import LayerMatter, PigmentMatter, scattering
from ...engine.paint.slab import add_below, find_rates, find_slab, under_face


def make_slab(albedo, depth, asymmetry=0.0, index=1.0, count=64):
    """Directions of a slab, its reflection and its transmission (n, n)."""
    directions = place_directions([index], count)
    cosines, flux = directions.cosines(index), directions.weights / index**2
    count = len(cosines)
    one = np.ones(1)
    series = (asymmetry ** np.arange(300.0 if asymmetry else 1.0))[None]
    pigment = PigmentMatter(one, albedo * one, series).cut(count)
    matter = LayerMatter(depth, index * one, index, 0.0 * one, (), (pigment,))
    back, forth = (each[0] for each in scattering(matter, cosines, 1))
    rates = find_rates(np.full(count, pigment.extinction[0]), back, forth, cosines, flux)
    return directions, *(each[0] for each in find_slab(rates, depth))


def shares_of(albedo, depth, asymmetry=0.0, index=1.0, count=64) -> list[float]:
    """UR1, UT1, URU and UTU of a slab in air, with smooth faces where its index is not 1."""
    directions, reflected, passed = make_slab(albedo, depth, asymmetry, index, count)
    face = face_reflectance(np.minimum(directions.sines, 2.0), 1.0, index)
    out, flux = 1.0 - face, directions.weights
    root, normal = np.sqrt(flux), directions.interpolation([0.0])[0]
    # What comes up below the upper face for what goes down there, and what comes to the lower one.
    up = under_face(add_below(reflected, passed, np.diag(face)), face)
    loop = np.eye(len(face)) - reflected * face
    down = np.linalg.solve(loop, passed @ (np.eye(len(face)) + face[:, None] * up))
    leaving = slice(directions.leaving)
    found = []
    for kernel, is_mirrored in ((up, True), (down, False)):
        share = kernel.T @ (out * root) / root
        whole = (flux * out * share).sum()
        one = (share * out)[leaving] @ normal
        mirrored = face_reflectance(np.zeros(1), 1.0, index)[0]
        found.append(
            (one + is_mirrored * mirrored, whole + is_mirrored * (flux * face)[leaving].sum())
        )
    (ur1, uru), (ut1, utu) = found
    return [float(each) for each in (ur1, ut1, uru, utu)]
