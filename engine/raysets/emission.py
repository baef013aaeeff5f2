"""A ray file made ready as a light of a scene: rays for what is near, a distribution of intensity for what is far."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..photometry.spectra import GRID, luminous_efficiency
from ..reading.remarks import Remark
from ..scene.distribution import IntensityDistribution
from ..scene.ray_emission import HULL, PLANE, SPHERE, DirectionWeight, RayBody, RayEmission
from .beam_cells import BeamCells
from .body import Hull, Plane, Sphere
from .cloud import Drawn, Fluctuation, RayCloud, extent, hold_rays, make_cloud
from .reader import read_rayset
from .record import RayFile, Rays
from .reduction import TO_LUMINAIRE, choose_step, is_rotational, reduce_rays
from .survey import Survey, hold_luminous, survey_rays
from .text import Assumed

READ = 1 << 21
"""Rays that a light is made of at most; of larger files a selection by chance is."""

HELD = 1 << 18
"""Rays that it holds at most, 10 MB, each of them for some that are next to it in larger files."""

GENERATED = 1 << 21
"""Rays that make the distribution of intensity."""

PIECE = 1 << 19
"""Rays that are generated at a time."""

PLANES = 36
"""C-planes of a distribution that is not the same all around."""

FAR = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""Distances over the size of the source at which the error of the distribution is told."""

BANDS, SECTORS = 16, 24
"""Cells of the sphere by which it is told, all with as much light."""

NEAR = 5.0
"""Distance over the size of a source below which no source is taken for a point: photometry's five-times rule."""

POINT_ERROR = 0.01
"""Error of the illuminance of a point that is put up with: light of narrow beams is near much farther out. [-]"""

FOCUS_PRIOR = 1e-3
"""Weight of the middle of the starting points beside the rays. [-]"""

SPARE = 1e-6
"""Share of the size by which the box around the points is larger than needed. [-]"""


@dataclass(frozen=True)
class Wish:
    """How a ray file is to be prepared.

    Parameters
    ----------
    fluctuation : Fluctuation
    assumed : Assumed    What is taken of texts that do not tell their units.
    seed : int
    """

    fluctuation: Fluctuation = Fluctuation()
    assumed: Assumed = Assumed()
    seed: int = 0


@dataclass(frozen=True, eq=False)
class RayLight:
    """A ray file as a light.

    Parameters
    ----------
    emission : RayEmission    In the luminaire's axes, about ``centre``.
    distribution : IntensityDistribution    [cd]
    centre : (3,) float64 array    Where light seems to come from, see `find_focus`, in the luminaire's axes, from the file's
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
    wish: Wish | None = None,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> RayLight:
    """Read a ray file and prepare it as a light.

    Parameters
    ----------
    path : str or Path
    wish : Wish or None    None: as the set tells.
    progress : callable or None    Told the share that is done.
    cancelled : callable

    Raises
    ------
    FileFormatError
    Cancelled
    """
    told = progress or (lambda share: None)
    wish = wish or Wish()
    seed = wish.seed
    file = read_rayset(path, wish.assumed)
    survey = survey_rays(file, lambda s: told(0.1 * s), cancelled)
    held, flux, remarks = _lumens(file, survey, hold_rays(file, READ, seed, cancelled=cancelled))
    if survey.rays > READ:
        text = f"{len(held)} of its {survey.rays} rays are used, chosen at random"
        remarks = (*remarks, Remark(text))
    held = _with_wavelengths(file, held, seed)
    cloud = make_cloud(
        held, 1.0, wish.fluctuation, seed, lambda s: told(0.1 + 0.6 * s), cancelled, HELD
    )
    rng = np.random.default_rng(seed + 1)
    pieces = []
    for number in range(GENERATED // PIECE):
        pieces.append(cloud.draw(PIECE, rng))
        told(0.7 + 0.2 * (number + 1) / (GENERATED // PIECE))
    distribution = _reduce(pieces, flux or 1.0)
    centre = find_focus(held)
    distances = np.array(FAR) * cloud.size
    errors = settle_errors(distances, far_errors(pieces, centre, distances))
    told(1.0)
    return RayLight(
        replace(
            make_emission(cloud, centre, distances, errors), near=near_distance(distances, errors)
        ),
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
        weight=_turn_weight(cloud.weight),
        size=cloud.size,
        near=NEAR * cloud.size,
        half=np.abs(drawn.position - centre).max(axis=0) + SPARE * cloud.size,
        information_error=cloud.information_error if np.isfinite(cloud.information_error) else 1.0,
        far_distances=np.asarray(distances, dtype=np.float64),
        far_errors=np.asarray(errors, dtype=np.float64),
    )


def find_focus(rays: Rays) -> np.ndarray:
    """Point that all rays pass as closely as possible, weighted by flux: from afar their light seems to come from there. [m]

    Rays that are nearly parallel do not tell it along their direction; there the middle of the starting points does. The
    point stays within a size of these.
    """
    weight = rays.weight.astype(np.float64)
    weight /= weight.sum()
    position, direction = rays.position.astype(np.float64), rays.direction.astype(np.float64)
    middle = weight @ position
    away = position - middle
    along = (away * direction).sum(axis=1)
    system = np.eye(3) * (1.0 + FOCUS_PRIOR) - direction.T @ (weight[:, None] * direction)
    shift = np.linalg.solve(system, weight @ away - (weight * along) @ direction)
    size = extent(position)
    low, high = position.min(axis=0) - size, position.max(axis=0) + size
    return np.clip(middle + shift, low, high)


def near_distance(distances: np.ndarray, errors: np.ndarray) -> float:
    """Distance from which on a source is taken for a point. (k,) of `FAR` [m], (k,) [-] -> [m]

    It is five times the size, or farther out the first distance with a small error, on lines through the logarithms.
    """
    first = FAR.index(NEAR)
    distances, errors = distances[first:], settle_errors(distances[first:], errors[first:])
    small = np.flatnonzero(errors <= POINT_ERROR)
    if not len(small):
        return float(distances[-1])
    if small[0] == 0:
        return float(distances[0])
    last = small[0]
    pair = slice(last - 1, last + 1)
    rate = np.log(errors[pair][0] / POINT_ERROR) / np.log(errors[pair][0] / errors[pair][1])
    return float(distances[pair][0] * (distances[pair][1] / distances[pair][0]) ** rate)


def settle_errors(distances: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Errors of a point that fall no faster than with the square of the distance; smaller ones are chance. (k,), (k,)"""
    settled = np.array(errors, dtype=np.float64)
    for i in range(1, len(settled)):
        settled[i] = max(settled[i], settled[i - 1] * (distances[i - 1] / distances[i]) ** 2)
    return settled


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
    first = pieces[0]
    far = np.inf
    cells = BeamCells(first.position, first.direction, first.flux, centre, far, BANDS, SECTORS)
    ways = [cells.numbers(piece.position, piece.direction, far) for piece in pieces]
    directions = sum(
        np.bincount(way, piece.flux, len(cells)) for way, piece in zip(ways, pieces, strict=True)
    )
    found = []
    for distance in distances:
        crossings, moved = np.zeros(len(cells)), 0.0
        for way, piece in zip(ways, pieces, strict=True):
            crossing = cells.numbers(piece.position, piece.direction, distance)
            crossings += np.bincount(crossing, piece.flux, len(cells))
            moved += float((crossing != way).mean()) / len(pieces)
        square = ((crossings - directions) ** 2).mean()
        # Rays that change cells do so by chance: that many are taken from one and put into another.
        chance = 2.0 * moved / count / len(cells) * directions.sum() ** 2
        found.append(np.sqrt(max(square - chance, 0.0) / (directions**2).mean()))
    return np.array(found)


# ---- private ----


def _lumens(file: RayFile, survey: Survey, held: Rays):
    """Rays with lumens for weights where they can be known, the luminous flux, and remarks."""
    if file.quantity != "luminous" and survey.luminous_flux is None and held.wavelength is None:
        text = "it carries watts and tells no wavelengths: set the luminous flux of the light"
        return held, None, (*survey.remarks, Remark(text))
    return *hold_luminous(file, survey, held), survey.remarks


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


def _turn_weight(weight: DirectionWeight) -> DirectionWeight:
    """For directions in the luminaire's axes: y and z change their signs."""
    signs = np.array([1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0])
    return replace(weight, axis=TO_LUMINAIRE @ weight.axis, moments=weight.moments * signs)
