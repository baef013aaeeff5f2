"""Scattering of any form: evaluated, integrated, and checked against what physics allows."""

from dataclasses import dataclass

import numpy as np

from ...scene.scattering import PatchMatrix, Scatter, ScatterTable, TensorTree
from .patches import albedo_of_patches, evaluate_patches, pairs_of, reciprocity_of
from .table import albedo_of, albedos_of, direct_share, evaluate_table, is_symmetric
from .tree import albedo_of_tree, evaluate_tree

CHECKED = 4096
"""Pairs of directions that reciprocity is measured with."""

STEEPEST = np.radians(80.0)
"""Directions farther from the normal do not count: division by their small cosine is all that is measured there."""

GOOD_RECIPROCITY = 0.1
"""Residual up to which a measurement is to be trusted. [-]"""


def evaluate(scatter: Scatter, wi, wo) -> np.ndarray:
    """Values for pairs of directions at the scatter's own wavelengths. (n, 3), (n, 3) -> (n, w) [1/sr]"""
    match scatter:
        case ScatterTable():
            return evaluate_table(scatter, wi, wo)
        case PatchMatrix():
            return evaluate_patches(scatter, wi, wo)
        case TensorTree():
            return evaluate_tree(scatter, wi, wo)
    raise TypeError(f"not a scatter: {scatter!r}")


def albedo(scatter: Scatter, incidence: float, rotation: float = 0.0) -> np.ndarray:
    """Share of light from one direction that is scattered, without a direct part. (w,) [-]"""
    match scatter:
        case ScatterTable():
            return albedo_of(scatter, incidence, rotation)
        case PatchMatrix():
            return albedo_of_patches(scatter, incidence, rotation)
        case TensorTree():
            return albedo_of_tree(scatter, incidence, rotation)
    raise TypeError(f"not a scatter: {scatter!r}")


def total(scatter: Scatter, incidence: float, rotation: float = 0.0) -> np.ndarray:
    """Hemispherical reflectance or transmittance for light from one direction, direct part included. (w,) [-]"""
    return totals(scatter, [incidence], [rotation])[0, 0]


def totals(scatter: Scatter, incidences, rotations) -> np.ndarray:
    """What `total` tells for all of some incidences and rotations. (s,), (p,) -> (p, s, w) [-]"""
    if not isinstance(scatter, ScatterTable):
        return np.array([[albedo(scatter, s, p) for s in incidences] for p in rotations])
    made = albedos_of(scatter, incidences, rotations)
    if scatter.direct is not None:
        turn, tilt = (axis.ravel() for axis in np.meshgrid(rotations, incidences, indexing="ij"))
        sine = np.sin(tilt)
        wi = np.stack([sine * np.cos(turn), sine * np.sin(turn), np.cos(tilt)], axis=1)
        made = made + direct_share(scatter, wi).reshape(made.shape)
    return made


def incidences_of(scatter: Scatter) -> np.ndarray:
    """Angles of incidence that the data are for: grid lines, or middles of patches; of a tree, every ten degrees. [rad]"""
    match scatter:
        case ScatterTable():
            return scatter.incidences
        case PatchMatrix():
            bounds = scatter.incoming.bounds
            middle = 0.5 * (bounds[1:] + bounds[:-1])
            return np.where(scatter.incoming.counts == 1, bounds[:-1], middle)
    return np.radians(np.arange(0.0, 90.0, 10.0))


def symmetry_of(scatter: Scatter) -> str:
    """Symmetry, for people."""
    if isinstance(scatter, ScatterTable) and scatter.is_orthotropic:
        return "anisotropic, orthotropic"
    if not scatter.is_isotropic:
        return "anisotropic"
    if isinstance(scatter, ScatterTable) and not is_symmetric(scatter):
        return "isotropic, sides of the plane of incidence differ"
    return "isotropic"


PEAK = 5.0
"""Times the mean value from which on a pair counts as part of a peak: of straight light, of a mirror's, of a lobe."""

LEAST_SHARE = 0.01
"""Share of the light below which what lies beside peaks does not count. [-]"""


@dataclass(frozen=True)
class Reciprocity:
    """How far f(i, o) and f(o, i) differ over random pairs of directions, both within 80 degrees of the normal.

    The squares of a peak hide all that lies beside it, which in a room is the light that is seen: so that counts alone too.

    Parameters
    ----------
    residual : float
        Root mean square of the difference over root mean square of the values, weighed by both cosines; of matrices over all
        pairs of patches. [-]
    largest : float    Largest difference over the largest value. [-]
    scattered : float
        Of the pairs beside peaks: mean of the absolute difference over the mean of the values; 0 where they have next to
        no light. [-]
    """

    residual: float
    largest: float
    scattered: float = 0.0

    @property
    def worst(self) -> float:
        """Residual or scattered, whichever is larger. [-]"""
        return max(self.residual, self.scattered)


def measure_reciprocity(scatter: Scatter, back: Scatter | None = None) -> Reciprocity:
    """Compare a scatter with itself seen the other way round.

    Parameters
    ----------
    scatter : Scatter    Reflection, or transmission from one side.
    back : Scatter or None    Of transmission: that from the other side; None: taken to be the same from both.
    """
    draw = np.random.default_rng(2).random((4, CHECKED))
    most = np.sin(STEEPEST) ** 2
    pair = []
    for u, v in (draw[:2], draw[2:]):
        sine, turn = np.sqrt(most * u), 2.0 * np.pi * v
        pair.append(np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1.0 - sine**2)], 1))
    # Half of the pairs lie near each other's mirror direction, where lobes are.
    mirror = pair[0] * np.array([-1.0, -1.0, 1.0])
    near = mirror + 0.15 * (draw[0] ** 2)[:, None] * (pair[1] - mirror)
    half = np.arange(CHECKED) % 2 == 0
    wo = np.where(half[:, None], near / np.linalg.norm(near, axis=1)[:, None], pair[1])
    wi = pair[0]
    forth = evaluate(scatter, wi, wo)
    back_again = evaluate(scatter if back is None else back, wo, wi)
    mean = np.sqrt((0.25 * (forth + back_again) ** 2).mean())
    difference = forth - back_again
    top = max(forth.max(), back_again.max())
    largest = float(np.abs(difference).max() / top) if top > 0.0 else 0.0
    if isinstance(scatter, PatchMatrix) and isinstance(back, PatchMatrix | None):
        return Reciprocity(
            reciprocity_of(scatter, back), largest, _beside_peaks(*pairs_of(scatter, back))
        )
    residual = float(np.sqrt((difference**2).mean()) / mean) if top > 0.0 else 0.0
    evenly = np.full(CHECKED - half.sum(), 1.0)
    return Reciprocity(residual, largest, _beside_peaks(forth[~half], back_again[~half], evenly))


def _beside_peaks(forth: np.ndarray, back: np.ndarray, weight: np.ndarray) -> float:
    """`Reciprocity.scattered` of values both ways (n, w) with weights (n,) by projected solid angle."""
    weight = np.broadcast_to(weight[:, None], forth.shape)
    both = 0.5 * (forth + back)
    light = weight * both
    rest = np.maximum(forth, back) <= PEAK * light.sum() / weight.sum()
    scattered = light[rest].sum()
    if scattered <= LEAST_SHARE * light.sum():
        return 0.0
    return float((weight * np.abs(forth - back))[rest].sum() / scattered)
