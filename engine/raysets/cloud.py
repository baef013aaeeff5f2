"""A ray set ready to send out light without end: rays that differ from those of the file as those differ from each other.

A file holds as many rays as it holds; sent out again and again they give spots instead of light. So a ray is picked by its
power, and its position and direction fluctuate by as much as those of its neighbours differ (see `neighbourhoods`), which
keeps the total flux. What the fluctuation blurs at large is put right by a weight that depends on the direction (see
`direction_weight`). Then the ray is put where it leaves the source's body (see `body`).

Of a source that is the same all around an axis, every ray stands for a ring of them (see `symmetry`).

How far neighbours reach is chosen by comparison: light from one half of the rays against the other half.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..errors import Cancelled, FileFormatError
from ..scene.ray_emission import DirectionWeight
from .beam_cells import BeamCells
from .blur import find_blur
from .body import Hull, Plane, Sphere, find_body
from .direction_weight import fit_weight
from .neighbourhoods import GROUP, Spread, order_rays, spread_rays
from .reader import read_rays
from .record import RayFile, Rays
from .symmetry import Axis, find_axis

MOST_HELD = 1 << 22
"""Rays that are held at most; of larger files a selection by chance is. About 39 bytes each."""

SHARES = (0.01, 0.03, 0.12, 0.42)
"""Shares of all rays that may be neighbours of one, for `REFERENCE_COUNT` rays. [-]"""

REFERENCE_COUNT = 8192
"""Rays for which these shares are meant: the best share falls about as the root of the number."""

COMPARED = 1 << 14
"""Rays that the share is chosen with, at most."""

MADE = 1 << 17
"""Rays that are made for a comparison."""

WEIGHED = 1 << 20
"""Rays that are made, at most, to find the weight by direction of a set: their chance must not show in large sets."""

BANDS, SECTORS = 12, 16
"""Cells of the spheres around the source where halves are compared, all with as much light."""

DISTANCES = (1.0, 4.0)
"""Radii of these spheres, over the size of the source. [-]"""


@dataclass(frozen=True)
class Fluctuation:
    """How wide generated rays fluctuate.

    Parameters
    ----------
    share : float or None    Share of all rays that are neighbours of one; None: chosen by comparison.
    position, direction : float or None    Widths (standard deviations) given by the user, which take the place of those
        that the set tells. [m], [rad]
    is_symmetric : bool or None    Whether rays are turned about the source's axis; None: where the set is even around
        one and no width is given.
    """

    share: float | None = None
    position: float | None = None
    direction: float | None = None
    is_symmetric: bool | None = None


@dataclass(frozen=True, eq=False)
class RayCloud:
    """Rays that are held in memory, ready to generate from.

    Parameters
    ----------
    spread : Spread    n rays, in an order that keeps neighbours together.
    threshold : (n,) float32 array    Alias table: share of the choices of a place that it keeps.
    other : (n,) uint32 array    Who gets the rest.
    colour : (n,) float32 or int32 array or None    Wavelength [nm], or number of the file's spectrum.
    body : Plane, Sphere or Hull
    axis : Axis or None    About which every ray stands for a ring of them.
    size : float    Largest extent of the starting points. [m]
    weight : DirectionWeight
    flux : float    Of all, in the file's quantity. [lm or W]
    share : float    Of rays that are neighbours of one. [-]
    information_error : float    Relative error of the light in a cell with a 192nd of it that comes from the file's having
        no more rays, and of what is seen to be blurred, as root mean square over cells. [-]
    """

    spread: Spread
    threshold: np.ndarray
    other: np.ndarray
    colour: np.ndarray | None
    body: Plane | Sphere | Hull
    axis: Axis | None
    size: float
    weight: DirectionWeight
    flux: float
    share: float
    information_error: float

    def __len__(self) -> int:
        return len(self.threshold)

    @property
    def bytes_per_ray(self) -> float:
        """Memory that is held. [byte]"""
        held = [self.threshold, self.other, *vars(self.spread).values()]
        held += [] if self.colour is None else [self.colour]
        return sum(array.nbytes for array in held) / len(self)

    def draw(self, count: int, rng: np.random.Generator) -> "Drawn":
        """Generate rays."""
        picked, position, direction = self.generate(count, rng)
        weight = self.weight.of(direction)
        # The mean weight is 1 but for chance, which need not spoil the flux.
        weight *= count / weight.sum()
        colour = None if self.colour is None else self.colour[picked]
        return Drawn(position, direction, weight * (self.flux / count), colour)

    def generate(self, count: int, rng: np.random.Generator):
        """Rays without their weights: numbers of the set's own (n,), (n, 3) [m], (n, 3) unit vectors."""
        place = rng.random(count) * len(self)
        number = np.minimum(place.astype(np.int64), len(self) - 1)
        picked = np.where(place - number < self.threshold[number], number, self.other[number])
        noise = rng.standard_normal((count, 6), dtype=np.float32)
        position, direction = scatter(self.spread, picked, noise)
        if self.axis is not None:
            angle = 2.0 * np.pi * rng.random(count)
            position, direction = self.axis.turn(position, direction, angle)
        return picked, *self.body.place(position, direction)


@dataclass(frozen=True, eq=False)
class Drawn:
    """Generated rays: where they start [m], unit vectors, flux [lm or W], wavelength or number of spectrum."""

    position: np.ndarray
    direction: np.ndarray
    flux: np.ndarray
    colour: np.ndarray | None


def hold_rays(
    file: RayFile,
    limit: int = MOST_HELD,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Rays:
    """Read rays into memory, of files with more than ``limit`` a selection by chance.

    Raises
    ------
    FileFormatError
    Cancelled
    """
    rng = np.random.default_rng(seed)
    chance = min(1.0, limit / max(file.count, 1))
    held: list[Rays] = []
    for rays in read_rays(file, progress=progress, cancelled=cancelled):
        held.append(_take(rays, rng.random(len(rays)) < chance) if chance < 1.0 else rays)
    if not sum(map(len, held)):
        raise FileFormatError(file.path, "has no ray that carries light, expected one at least")
    columns = (
        [getattr(rays, name) for rays in held]
        for name in ("position", "direction", "weight", "wavelength", "spectrum")
    )
    return Rays(*(None if each[0] is None else np.concatenate(each) for each in columns))


def make_cloud(
    rays: Rays,
    flux: float,
    fluctuation: Fluctuation | None = None,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
    most: int | None = None,
) -> RayCloud:
    """Prepare rays for generation.

    Parameters
    ----------
    rays : Rays
    flux : float    Of all. [lm or W]
    fluctuation : Fluctuation or None    None: as the set tells.
    seed : int
    progress : callable or None    Told the share that is done.
    cancelled : callable
    most : int or None    Rays of the cloud: of more, each stands for some that are next to it, see `thin_rays`.

    Raises
    ------
    Cancelled
    """
    fluctuation = fluctuation or Fluctuation()
    told = progress or (lambda share: None)
    size = extent(rays.position)
    body = find_body(rays.position, rays.direction)
    is_given = fluctuation.position is not None or fluctuation.direction is not None
    axis = None
    if fluctuation.is_symmetric or (fluctuation.is_symmetric is None and not is_given):
        axis = find_axis(rays, body, is_sure=bool(fluctuation.is_symmetric))
    shape = _Shape(size, body, axis)
    share, error = choose_share(rays, shape, fluctuation, seed, cancelled)
    told(0.3)
    given, rays = rays, _take(rays, order_rays(rays.position, rays.direction, size))
    if cancelled():
        raise Cancelled("cancelled")
    whole = rays
    if most is not None and len(rays) > most:
        rays = thin_rays(rays, most, seed)
    weighed = int(np.clip(4 * len(rays), MADE, WEIGHED))
    cloud = _prepare(
        rays,
        flux,
        shape,
        fluctuation,
        share,
        error,
        seed,
        lambda s: told(0.3 + 0.6 * s),
        cancelled,
        weighed,
        whole,
    )
    made = cloud.draw(weighed, np.random.default_rng([seed & 0xFFFFFFFF, 9]))
    blur = find_blur(made, given, [size * distance for distance in DISTANCES], BANDS, SECTORS)
    told(1.0)
    return replace(cloud, information_error=float(np.hypot(error, blur)))


def thin_rays(rays: Rays, most: int, seed: int = 0) -> Rays:
    """Let each of fewer rays stand for some that are next to each other: one of them by chance, with the light of all.

    What is made of them fluctuates by as much as many more rays than these differ, so next to nothing is lost, whereas a
    selection by chance from all would have the error of a file of so few rays.

    Parameters
    ----------
    rays : Rays    In the order of `order_rays`.
    most : int
    """
    starts = np.arange(0, len(rays), -(-len(rays) // most))
    weight = rays.weight.astype(np.float64)
    total = np.add.reduceat(weight, starts)
    steps = np.cumsum(weight)
    drawn = np.random.default_rng([seed & 0xFFFFFFFF, 8]).random(len(starts))
    chosen = np.searchsorted(steps, steps[starts] - weight[starts] + drawn * total, side="right")
    chosen = np.clip(chosen, starts, np.append(starts[1:], len(rays)) - 1)
    return replace(_take(rays, chosen), weight=total.astype(np.float32))


def extent(position: np.ndarray) -> float:
    """Largest extent of starting points along an axis; a millionth of a metre for a point. (n, 3) -> [m]"""
    return max(float(np.ptp(position.astype(np.float64), axis=0).max()), 1e-6)


def scatter(spread: Spread, picked: np.ndarray, noise: np.ndarray):
    """Let rays fluctuate. (n,) numbers of rays, (n, 6) standard normal -> (n, 3) [m], (n, 3) unit vectors, float64"""
    moved = np.einsum("nij,nj->ni", spread.factor[picked // GROUP], noise)
    position = spread.position[picked].astype(np.float64) + moved[:, :3]
    direction = spread.direction[picked].astype(np.float64) + moved[:, 3:]
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    return position, direction / np.maximum(length, 1e-12)


def choose_share(
    rays: Rays,
    shape: "_Shape",
    fluctuation: Fluctuation,
    seed: int,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[float, float]:
    """Choose how many rays are neighbours of one, and estimate what error is left for want of rays.

    Light made from one half is compared with the rays of the other half, which are right in the mean, where it crosses two
    spheres around the source; then with light made from the other half, which differs by the error of both.

    Returns
    -------
    (float, float)    Share, and relative error of the intensity.
    """
    rng = np.random.default_rng(seed)
    size = shape.size
    order = rng.permutation(len(rays))[:COMPARED]
    halves = [_take(rays, half) for half in np.array_split(order, 2)]
    if len(halves[1]) < 2:
        return 1.0, float("inf")
    middle = rays.position.astype(np.float64).mean(axis=0)
    scale = np.sqrt(REFERENCE_COUNT / len(halves[0]))
    if fluctuation.share is not None:
        shares = (fluctuation.share,)
    else:
        shares = tuple(share * scale for share in SHARES if share * scale < 0.75) or (0.5,)
    asked = _take(rays, order)
    spheres = [
        (
            BeamCells(asked.position, asked.direction, asked.weight, middle, r, BANDS, SECTORS),
            r,
        )
        for r in (size * distance for distance in DISTANCES)
    ]

    def shares_of(position, direction, weight):
        return np.concatenate(
            [cells.shares(position, direction, weight, r) for cells, r in spheres]
        )

    expected = [shares_of(half.position, half.direction, half.weight) for half in halves]
    scores, made = [], []
    for share in shares:
        light = []
        for half in halves:
            if cancelled():
                raise Cancelled("cancelled")
            own = _take(half, order_rays(half.position, half.direction, size))
            cloud = _prepare(own, 1.0, shape, fluctuation, share, 0.0, seed)
            drawn = cloud.draw(MADE, np.random.default_rng(seed))
            light.append(shares_of(drawn.position, drawn.direction, drawn.flux))
        made.append(light)
        apart = [((a - b) ** 2).sum() for a, b in zip(light, expected[::-1], strict=True)]
        scores.append(np.mean(apart))
    best = int(np.argmin(scores))
    first, second = made[best]
    # The difference of two halves has the variance of both, the whole half of that of one.
    far = slice(-BANDS * SECTORS, None)
    error = 0.5 * np.sqrt(((first[far] - second[far]) ** 2).mean())
    mean = np.sqrt(((0.5 * (first[far] + second[far])) ** 2).mean())
    # Of large sets a part was compared.
    error *= np.sqrt(len(order) / len(rays))
    share = shares[best] * (1.0 if fluctuation.share else np.sqrt(len(halves[0]) / len(rays)))
    return float(np.clip(share, 1e-6, 1.0)), float(error / max(mean, 1e-30))


# ---- private ----


@dataclass(frozen=True, eq=False)
class _Shape:
    """What is found of a whole set, and holds for a part of it."""

    size: float
    body: Plane | Sphere | Hull
    axis: Axis | None


def _take(rays: Rays, which: np.ndarray) -> Rays:
    columns = (rays.position, rays.direction, rays.weight, rays.wavelength, rays.spectrum)
    return Rays(*(None if column is None else column[which] for column in columns))


def _prepare(
    rays: Rays,
    flux: float,
    shape: _Shape,
    fluctuation: Fluctuation,
    share: float,
    error: float,
    seed: int,
    progress: Callable[[float], None] | None = None,
    cancelled: Callable[[], bool] = lambda: False,
    weighed: int = 0,
    whole: Rays | None = None,
) -> RayCloud:
    """Make the cloud of rays that stand in order.

    ``weighed``: rays that find its weight by direction, `MADE` if 0; ``whole``: all rays, if ``rays`` are some of them.
    """
    size = shape.size
    spread = spread_rays(rays.position, rays.direction, size, share, seed, progress, cancelled)
    spread = _override(spread, rays, fluctuation)
    threshold, other = alias_table(rays.weight)
    colour = rays.spectrum if rays.wavelength is None else rays.wavelength
    cloud = RayCloud(
        spread,
        threshold,
        other,
        colour,
        shape.body,
        shape.axis,
        size,
        DirectionWeight.even(),
        flux,
        share,
        error,
    )
    made = cloud.generate(weighed or MADE, np.random.default_rng(seed))[2]
    asked = whole or rays
    axis = shape.body.normal if isinstance(shape.body, Plane) else None
    return replace(cloud, weight=fit_weight(made, asked.direction, asked.weight, axis))


def _override(spread: Spread, rays: Rays, fluctuation: Fluctuation) -> Spread:
    """Put the user's widths in the place of the set's own."""
    factor, position, direction = spread.factor, spread.position, spread.direction
    if fluctuation.position is None and fluctuation.direction is None:
        return spread
    factor = factor.copy()
    # A width of its own has no part in what the other does.
    factor[:, 3:, :3] = 0.0
    if fluctuation.position is not None:
        factor[:, :3, :3] = fluctuation.position * np.eye(3)
        position = rays.position
    if fluctuation.direction is not None:
        factor[:, 3:, 3:] = fluctuation.direction * np.eye(3)
        direction = rays.direction
    return Spread(position, direction, factor)


def alias_table(weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Make the table by which a number is drawn with a chance in proportion to its weight, in constant time.

    M. D. Vose, A linear algorithm for generating random numbers with a given distribution, IEEE Trans. Software Eng. 17,
    1991.

    Returns
    -------
    ((n,) float32, (n,) uint32)    Share that a place keeps, and who gets the rest.
    """
    count = len(weight)
    share = weight.astype(np.float64) * (count / weight.sum(dtype=np.float64))
    other = np.arange(count, dtype=np.uint32)
    low, high = np.flatnonzero(share < 1.0), np.flatnonzero(share >= 1.0)
    kept = share.copy()
    # A donor gives to one after the other until it has less than its place holds; then it asks the next one itself.
    lacks, donors = list(low), list(high)
    while lacks and donors:
        poor, rich = lacks.pop(), donors[-1]
        other[poor] = rich
        kept[rich] -= 1.0 - kept[poor]
        if kept[rich] < 1.0:
            lacks.append(donors.pop())
    kept[donors] = 1.0
    kept[lacks] = 1.0
    return kept.astype(np.float32), other
