"""A ray file made ready as a light of a scene: rays for what is near, a distribution of intensity for what is far."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..luminaires.record import Remark
from ..photometry.spectra import GRID, luminous_efficiency
from ..scene.distribution import IntensityDistribution
from ..scene.ray_emission import GROUP, HULL, PLANE, SPHERE, RayBody, RayEmission
from .body import Hull, Plane, Sphere
from .cloud import Drawn, Fluctuation, RayCloud, direction_weight, hold_rays, make_cloud
from .neighbourhoods import GROUP as SHARED_BY
from .reader import read_rayset
from .record import RayFile, Rays
from .reduction import TO_LUMINAIRE, choose_step, is_rotational, reduce_rays
from .survey import Survey, luminous_rays, survey_rays

HELD = 1 << 18
"""Rays that a light of a scene holds at most, 10 MB; of larger files a selection by chance is."""

GENERATED = 1 << 22
"""Rays that make the distribution of intensity."""

PIECE = 1 << 19
"""Rays that are generated at a time."""

PLANES = 72
"""C-planes of a distribution that is not the same all around."""

FAR = (1.0, 2.0, 5.0, 10.0, 20.0)
"""Distances over the size of the source at which the error of the distribution is told."""

BANDS, SECTORS = 16, 24
"""Cells of the sphere by which it is told, all of one size."""

SPARE = 1e-6
"""Share of the size by which the sphere around the points is larger than needed. [-]"""


@dataclass(frozen=True, eq=False)
class RayLight:
    """A ray file as a light.

    Parameters
    ----------
    emission : RayEmission    In the luminaire's axes, about ``centre``.
    distribution : IntensityDistribution    [cd]
    centre : (3,) float64 array    Flux-weighted middle of the starting points, in the luminaire's axes, from the file's
        origin. [m]
    luminous_flux : float or None    None where the file tells no lumens. [lm]
    spectrum : ((k,), (k,)) arrays or None    Wavelengths [nm] and relative spectral power.
    rays : int    Of the file.
    body : str    What they start from, for people.
    remarks : tuple of Remark
    """

    emission: RayEmission
    distribution: IntensityDistribution
    centre: np.ndarray
    luminous_flux: float | None
    spectrum: tuple[np.ndarray, np.ndarray] | None
    rays: int
    body: str
    remarks: tuple[Remark, ...]


def prepare_light(
    path: str | Path,
    fluctuation: Fluctuation | None = None,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> RayLight:
    """Read a ray file and prepare it as a light.

    Parameters
    ----------
    path : str or Path
    fluctuation : Fluctuation or None    None: as the set tells.
    seed : int
    progress : callable or None    Told the share that is done.
    cancelled : callable

    Raises
    ------
    FileFormatError
    Cancelled
    """
    told = progress or (lambda share: None)
    file = read_rayset(path)
    survey = survey_rays(file, lambda s: told(0.1 * s), cancelled)
    held, flux, remarks = _lumens(file, survey, hold_rays(file, HELD, seed, cancelled=cancelled))
    if survey.rays > HELD:
        text = f"{len(held)} of its {survey.rays} rays are held, chosen at random"
        remarks = (*remarks, Remark(text))
    held = _with_wavelengths(file, held, seed)
    cloud = make_cloud(held, 1.0, fluctuation, seed, lambda s: told(0.1 + 0.6 * s), cancelled)
    rng = np.random.default_rng(seed + 1)
    pieces = []
    for number in range(GENERATED // PIECE):
        pieces.append(cloud.draw(PIECE, rng))
        told(0.7 + 0.2 * (number + 1) / (GENERATED // PIECE))
    distribution = _reduce(pieces, flux or 1.0)
    centre = held.weight.astype(np.float64) @ held.position / held.weight.sum(dtype=np.float64)
    distances = np.array(FAR) * cloud.size
    errors = far_errors(pieces, centre, distances)
    told(1.0)
    return RayLight(
        make_emission(cloud, centre, distances, errors),
        distribution,
        TO_LUMINAIRE @ centre,
        flux,
        survey.spectrum if survey.spectrum and len(survey.spectrum[0]) > 1 else None,
        survey.rays,
        cloud.body.describe(),
        remarks,
    )


def make_emission(
    cloud: RayCloud, centre: np.ndarray, distances: np.ndarray, errors: np.ndarray
) -> RayEmission:
    """Turn a cloud into the luminaire's axes, about a centre. (3,), (k,) [m], (k,) [-]"""
    spread, turn = cloud.spread, TO_LUMINAIRE
    if SHARED_BY != GROUP:
        raise ValueError("clouds and lights share fluctuations among different numbers of rays")
    factor = spread.factor.copy()
    # A turn of both halves of a lower triangular factor about x changes signs of rows only.
    factor *= np.array([1.0, -1.0, -1.0] * 2, dtype=np.float32)[None, :, None]
    position = (spread.position - centre) @ turn
    drawn = cloud.draw(PIECE, np.random.default_rng(0))
    axis = cloud.axis
    return RayEmission(
        position=position.astype(np.float32),
        direction=(spread.direction @ turn).astype(np.float32),
        factor=factor,
        threshold=cloud.threshold,
        other=cloud.other,
        wavelength=None if cloud.colour is None else cloud.colour.astype(np.float32),
        body=_turn_body(cloud.body, centre),
        axis=None
        if axis is None
        else np.stack([turn @ (axis.centre - centre), turn @ axis.direction]),
        moments=_turn_moments(cloud.moments),
        mean_weight=float(direction_weight(drawn.direction, cloud.moments).mean()),
        size=cloud.size,
        radius=float(np.linalg.norm(drawn.position - centre, axis=1).max() * (1.0 + SPARE)),
        information_error=cloud.information_error if np.isfinite(cloud.information_error) else 1.0,
        far_distances=np.asarray(distances, dtype=np.float64),
        far_errors=np.asarray(errors, dtype=np.float64),
    )


def far_errors(pieces: list[Drawn], centre: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """Relative error of taking a source for a point, at some distances from its centre.

    Rays are counted in cells of spheres around the centre, by where they cross them and by where they go: the second is
    what the distribution of intensity says of the first.

    Parameters
    ----------
    pieces : list of Drawn
    centre : (3,) array    [m]
    distances : (k,) array    [m]

    Returns
    -------
    (k,) float64 array    Root mean square of the difference over that of the light, without the part of chance.
    """
    count = sum(len(piece.flux) for piece in pieces)
    cells = BANDS * SECTORS
    directions = sum(_cells(piece.direction, piece.flux) for piece in pieces)
    found = []
    for distance in distances:
        crossings, moved = np.zeros(cells), 0.0
        for piece in pieces:
            away = piece.position - centre
            along = (away * piece.direction).sum(axis=1)
            inside = along**2 - (away * away).sum(axis=1) + distance**2
            way = np.sqrt(np.maximum(inside, 0.0)) - along
            crossing = (away + way[:, None] * piece.direction) / distance
            crossings += _cells(crossing, piece.flux)
            moved += float((_cell(crossing) != _cell(piece.direction)).mean()) / len(pieces)
        square = ((crossings - directions) ** 2).mean()
        # Rays that change cells do so by chance: that many are taken from one and put into another.
        chance = 2.0 * moved / count / cells * directions.sum() ** 2
        found.append(np.sqrt(max(square - chance, 0.0) / (directions**2).mean()))
    return np.array(found)


# ---- private ----


def _lumens(file: RayFile, survey: Survey, held: Rays):
    """Rays with lumens for weights where they can be known, the luminous flux, and remarks."""
    if file.quantity != "luminous" and survey.luminous_flux is None and held.wavelength is None:
        text = "it carries watts and tells no wavelengths: set the luminous flux of the light"
        return held, None, (*survey.remarks, Remark(text))
    held = luminous_rays(file, survey, held)
    if not held.weight.any():
        raise FileFormatError(
            file.path, "has no visible light, expected wavelengths within 360 to 830 nm"
        )
    flux = survey.luminous_flux
    if flux is None:
        flux = float(held.weight.sum(dtype=np.float64))
    return held, flux, survey.remarks


def _with_wavelengths(file: RayFile, rays: Rays, seed: int) -> Rays:
    """Give rays of files with several spectra a wavelength each, drawn as the eye weighs their spectrum."""
    if rays.wavelength is not None:
        if np.ptp(rays.wavelength) == 0.0:
            return Rays(rays.position, rays.direction, rays.weight)
        return Rays(rays.position, rays.direction, rays.weight, rays.wavelength)
    if rays.spectrum is None or len(file.spectra) < 2:
        return Rays(rays.position, rays.direction, rays.weight)
    drawn = np.random.default_rng(seed).random(len(rays))
    wavelength = np.full(len(rays), 555.0, np.float32)
    for number, (nanometres, values) in enumerate(file.spectra):
        seen = np.interp(GRID, nanometres, values, left=0.0, right=0.0) * luminous_efficiency()
        own = rays.spectrum == number
        if seen.sum() > 0.0:
            steps = np.cumsum(seen) / seen.sum()
            wavelength[own] = GRID[np.minimum(np.searchsorted(steps, drawn[own]), len(GRID) - 1)]
    return Rays(rays.position, rays.direction, rays.weight, wavelength)


def _reduce(pieces: list[Drawn], flux: float) -> IntensityDistribution:
    """Distribution of intensity for a flux. [lm] -> [cd]"""
    share = flux / len(pieces)
    lit = [(piece.direction, piece.flux * share) for piece in pieces]
    step = choose_step(lit)
    reduced = reduce_rays(lit, step, PLANES)
    return (reduce_rays(lit, step, 1) if is_rotational(reduced) else reduced).distribution


def _turn_body(body: Plane | Sphere | Hull, centre: np.ndarray) -> RayBody:
    turn, nowhere = TO_LUMINAIRE, np.zeros(3)
    match body:
        case Sphere():
            place = turn @ (body.centre - centre)
            return RayBody(SPHERE, place, nowhere, False, body.radius, np.zeros((0, 5), np.float32))
        case Plane():
            place, normal = turn @ (body.centre - centre), turn @ body.normal
            return RayBody(PLANE, place, normal, body.is_one_sided, 0.0, _slabs(body.edge, centre))
    return RayBody(HULL, nowhere, nowhere, False, 0.0, _slabs(body, centre))


def _slabs(hull: Hull, centre: np.ndarray) -> np.ndarray:
    """Normals and bounds of a hull about a centre. (k, 5)"""
    offset = hull.normals @ centre
    rows = [hull.normals @ TO_LUMINAIRE, hull.low - offset, hull.high - offset]
    return np.column_stack(rows).astype(np.float32)


def _turn_moments(moments: np.ndarray) -> np.ndarray:
    """Coefficients of `direction_basis` for directions in the luminaire's axes: y and z change their signs."""
    return moments * np.array([1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0])


def _cell(unit: np.ndarray) -> np.ndarray:
    """Cell of the sphere that a unit vector points to. (n, 3) -> (n,)"""
    band = np.clip((0.5 * BANDS * (1.0 + unit[:, 2])).astype(np.int64), 0, BANDS - 1)
    turn = np.arctan2(unit[:, 1], unit[:, 0]) / (2.0 * np.pi) + 0.5
    return band * SECTORS + np.minimum((SECTORS * turn).astype(np.int64), SECTORS - 1)


def _cells(unit: np.ndarray, flux: np.ndarray) -> np.ndarray:
    return np.bincount(_cell(unit), flux, BANDS * SECTORS)
