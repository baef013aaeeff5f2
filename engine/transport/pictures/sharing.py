"""Light that pixels of a tile share: where it is even over a surface, each pixel's own few samples are not all there is.

The light that a matt surface gets varies little over the few pixels of a tile, but for its reflectance, which is known. So
in each half of the samples the means Y of a tile's pixels are fitted by what they see: for each surface a plane over the
pixels, times the reflectance of what of it a pixel shows. A pixel then has Z = Y + D with D = l (fit - Y). The share l is
up to twice the part of the residuals that is noise, so that edges of shadows, which no plane fits, stay where they are as
soon as they stand out of the noise (W. James, C. Stein: Estimation with quadratic loss, 1961); with more samples l goes to
0. It is then shared once more in larger tiles.

Half a and half b know nothing of each other. So, whatever D is, the square of the error of the mean of both is expected to
be that of

    (Za - Zb)^2 / 4 + Da Db

where the first term is the noise that is left and the second the square of what was smoothed away that was no noise: if the
expected value of both D differs from that of the noise by b, the product of the two is b^2 on the average. It holds pixel by
pixel, without any supposition on the light, and is stated as the error, where products that are mostly chance are drawn
towards what is likely (see `theory.md`, pictures).
"""

import math
import os
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import average
from ..compiled.diffuse import DiffuseTable
from ..compiled.textures import is_spectral
from ..paths import gather
from ..paths.film import Film, sees
from ..paths.sampler import hash_words
from ..paths.visibility import closest_hit
from .allocation import TILE
from .pixel_light import VIEW

SIDES = (TILE, 2 * TILE)
"""Sides of tiles, by stage of sharing: what is even over smaller ones may be over larger ones. [pixel]"""

SHIFTS = (0.0, 0.5)
"""Part of a side by which tiles begin before the picture: every pixel lies in two, and not at the edge of both. [-]"""

SURFACES = 3
"""Surfaces of a tile whose light is fitted; pixels that show more of others keep their own."""

LOOKS, LANES = 16, 1 << 21
"""Rays of a pixel that tell what it shows; and of a launch."""

STRANGE = 0.01
"""Part of what a pixel shows that may belong to none of the fitted surfaces. [-]"""

NEW = 1e-4
"""Share of the square of a function beside others from which on it is no rounding. [-]"""

FACINGS = 27
"""Directions into which a surface is parted by where it faces."""

SURFACE_BITS = 36
"""Bits of a surface's number, with a facing."""

LEAST = 0.01
"""Part of all errors from which on a kind of samples is worth its fit. [-]"""

LEAST_RATIO = 0.1
"""Variance of well-distributed points over that of independent ones, at least. [-]"""

TRUST = 2.0
"""How far pixels are drawn towards the fit, relative to what is best if the noise of a tile is known. [-]

2 is the most with which none is worse than by its own samples. Of few samples noise is mostly found too small, and to leave
a tenth of it costs more than to smooth some light away, which is told in any case."""

CHUNK = 1 << 17
"""Pixels that are fitted at once, about."""

WAVES = (2, 4)
"""Most half waves over a tile along both its sides together of which the products of the halves' changes are taken as they
are, and of which next."""

LIKELY, LIKELY_SPREAD, UNLIKELY = (0.4, 0.1), (0.8, 0.2), 4.0
"""What was smoothed away in the waves that come next, and in all other ones, relative to longer ones: what is supposed and
its standard deviation; and the square of a distance from it, in standard deviations, at which it is half as sure. [-]"""

AROUND = 2
"""Tiles to each side over which it is averaged what was smoothed away."""


class Tiles:
    """Pixels by tile.

    Parameters
    ----------
    width, height : int
    shift : int    Pixels by which the tiles begin before the picture.
    side : int    Of a tile. [pixel]

    Attributes
    ----------
    shape : (int, int)    Tiles up and across.
    pixels : (t, side^2) int array    Numbers of a tile's pixels, -1 where there is no picture.
    """

    def __init__(self, width: int, height: int, shift: int = 0, side: int = TILE):
        self.shape = -(-(height + shift) // side), -(-(width + shift) // side)
        self._size, self._shift, self.side = (height, width), shift, side
        numbers = self.lay_out(np.arange(1, width * height + 1)[None, :, None])
        self.pixels = numbers[0, ..., 0] - 1

    def lay_out(self, values: np.ndarray) -> np.ndarray:
        """Values of pixels by tile, 0 where there is no picture. (h, n, c) to (h, t, side^2, c)"""
        (up, across), side = self.shape, self.side
        (height, width), shift = self._size, self._shift
        laid = np.zeros((len(values), up * side, across * side, values.shape[2]), values.dtype)
        inside = laid[:, shift : shift + height, shift : shift + width]
        inside[:] = values.reshape(inside.shape)
        laid = laid.reshape(len(values), up, side, across, side, -1).swapaxes(2, 3)
        return laid.reshape(len(values), up * across, side * side, -1)

    def lay_back(self, laid: np.ndarray) -> np.ndarray:
        """What `lay_out` has laid out."""
        (up, across), side = self.shape, self.side
        (height, width), shift = self._size, self._shift
        laid = laid.reshape(len(laid), up, across, side, side, -1).swapaxes(2, 3)
        laid = laid.reshape(len(laid), up * side, across * side, -1)
        inside = laid[:, shift : shift + height, shift : shift + width]
        return inside.reshape(len(laid), height * width, -1)

    def average_around(self, values: np.ndarray) -> np.ndarray:
        """Mean over the tiles around each. (t, c) to (t, c)"""
        up, across = self.shape
        padded = np.pad(
            values.reshape(up, across, -1),
            ((AROUND, AROUND), (AROUND, AROUND), (0, 0)),
            "symmetric",
        )
        for axis in (0, 1):
            sums = np.cumsum(np.insert(padded, 0, 0.0, axis=axis), axis=axis)
            count = sums.shape[axis]
            wide = 2 * AROUND + 1
            high = np.take(sums, range(wide, count), axis=axis)
            padded = (high - np.take(sums, range(count - wide), axis=axis)) / wide
        return padded.reshape(up * across, -1)


@dataclass(frozen=True, eq=False)
class Shared:
    """What sharing makes of means.

    Parameters
    ----------
    change : (2, n, c) float32 array    To be added to the means of both halves.
    left : dict    By kind of samples: part of the variance of pixels that is left, (n,). [-]
    """

    change: np.ndarray
    left: dict[int, np.ndarray]


@dataclass(frozen=True, eq=False)
class Parts:
    """What the most seen surfaces of tiles have of what their pixels show.

    Parameters
    ----------
    amounts : (t, p, `SURFACES`) float32 array
    is_fitted : (t, p) bool array    Which pixels show nothing else.
    """

    amounts: np.ndarray
    is_fitted: np.ndarray

    @cached_property
    def largest(self) -> np.ndarray:
        """Which of the surfaces pixels show most of. (t, p)"""
        return self.amounts.argmax(axis=2)

    def surfaces(self, part: slice) -> np.ndarray:
        """1 where pixels of some tiles are fitted and show most of a surface, else 0. (`SURFACES`, t, p) float32"""
        numbers = np.arange(SURFACES)[:, None, None]
        return ((self.largest[part] == numbers) & self.is_fitted[part]).astype(np.float32)

    def fit(self, part: slice, counts: np.ndarray) -> "Fit":
        """How the light of pixels of some tiles is fitted. ``counts``: what each counts, (t, p); 0 where none is fitted."""
        amount = np.where(self.is_fitted[part], self.amounts[part].sum(axis=2), 0.0)
        shows = (amount > 0.0) & (counts > 0.0)
        inverse = 1.0 / np.where(shows, amount, 1.0)
        root = np.sqrt(np.where(shows, counts * inverse, 0.0)).astype(np.float32)
        basis = self._basis(part, root)
        # Noise is taken to be proportional to what pixels show.
        spread = (root * amount)[..., None] * basis
        each = 1.0 / np.where(shows, root * amount, 1.0)
        kept = ((basis @ (spread.swapaxes(1, 2) @ spread)) * basis).sum(axis=2) * each**2
        return Fit(basis, root, np.einsum("tpk,tpk->tp", basis, basis), kept)

    def _basis(self, part: slice, root: np.ndarray) -> np.ndarray:
        """Orthonormal functions over the pixels of tiles that span the planes of surfaces times a root. (t, p, k)"""
        count = math.isqrt(self.amounts.shape[1])
        side = ((np.arange(count) - 0.5 * (count - 1)) / count).astype(np.float32)
        y, x = np.meshgrid(side, side, indexing="ij")
        made: list[np.ndarray] = []
        for surface in range(SURFACES):
            amounts = self.amounts[part, :, surface] * root
            if not amounts.any():
                break
            for plane in (1.0, x.ravel(), y.ravel()):
                made.append(_orthonormal(amounts * plane, made))
        if not made:
            return np.zeros((*self.is_fitted[part].shape, 1), dtype=np.float32)
        return np.stack(made, axis=2)


def _orthonormal(feature: np.ndarray, before: list[np.ndarray]) -> np.ndarray:
    """What of a function over the pixels of tiles is new beside others, of length 1; 0 where nothing is. (t, p)"""
    size = np.einsum("tp,tp->t", feature, feature)
    for each in before:
        feature = feature - np.einsum("tp,tp->t", feature, each)[:, None] * each
    left = np.einsum("tp,tp->t", feature, feature)
    is_new = left > NEW * size
    return feature * np.where(is_new, 1.0 / np.sqrt(np.where(is_new, left, 1.0)), 0.0)[
        :, None
    ].astype(np.float32)


@dataclass(frozen=True, eq=False)
class Fit:
    """Planes over the pixels of tiles by least squares, which count each by a weight.

    The weight of a pixel is what it gets of these tiles over what it shows. So what is added to the pixels of a surface sums
    up to 0 as it is blended with that of other tiles: light is moved within a tile, and none is lost, but for what pixels
    that show several surfaces or would fall below 0 make of it.

    Parameters
    ----------
    basis : (t, p, k) array    Orthonormal functions: planes of surfaces times the root of the weight.
    root : (t, p) array    Of the weight; 0 where nothing is fitted.
    leverage : (t, p) array    What a pixel's own value counts in its fit. [-]
    kept : (t, p) array    Variance of the fit over that of a pixel. [-]
    """

    basis: np.ndarray
    root: np.ndarray
    leverage: np.ndarray
    kept: np.ndarray

    def residual(self, own: np.ndarray) -> np.ndarray:
        """What parts the fits from the means that they are made of. (2, t, p, c)"""
        root = self.root[..., None]
        made = self.basis @ (self.basis.swapaxes(1, 2) @ (root * own))
        return made / np.where(root > 0.0, root, 1.0) - own


@dataclass(frozen=True, eq=False)
class Tiling:
    """Tiles of a picture and what they show.

    Parameters
    ----------
    tiles : Tiles
    of_matt, of_view : Parts    Of matt surfaces, for light that they get; of all that `VIEW` has the light of.
    weight : (n,) float32 array    Of what pixels get by these tiles, beside others. [-]
    """

    tiles: Tiles
    of_matt: Parts
    of_view: Parts
    weight: np.ndarray

    def finding_changes(self, means, variances, left):
        """What these tiles change of means, and what part of the variance that is left they take away; in steps, by kind.

        ``means``: by kind, of the light alone, and ``variances``: as of `PixelSharing.share`; ``left``: by kind, part of the
        variance of pixels that is left of it, (n,). It gives (2, n, c) and (n,) by kind.
        """
        tiles = self.tiles
        weight = tiles.lay_out(self.weight[None, :, None])
        changes, gone = {}, {}
        for parts, kinds in (
            (self.of_view, [kind for kind in means if kind == VIEW]),
            (self.of_matt, [kind for kind in means if kind != VIEW]),
        ):
            if not kinds or not parts.is_fitted.any():
                continue
            fitted, own, noise, taken, before, change = parts.is_fitted, {}, {}, {}, {}, {}
            for kind in kinds:
                before[kind] = tiles.lay_out(left[kind][None, :, None])[0, ..., 0]
                own[kind] = tiles.lay_out(means[kind]) * fitted[..., None]
                noise[kind] = tiles.lay_out(variances[kind][..., None])[..., 0] * fitted
                noise[kind] *= before[kind]
                noise[kind] *= _find_ratio(own[kind], noise[kind])
                taken[kind] = np.zeros(weight.shape, np.float32)
                change[kind] = np.zeros_like(own[kind])
            many = max(CHUNK // tiles.side**2, 1)

            def shrink(
                begin,
                parts=parts,
                own=own,
                noise=noise,
                taken=taken,
                before=before,
                change=change,
                many=many,
            ):
                part = slice(begin, begin + many)
                counts = parts.is_fitted[part] * weight[0, part, :, 0]
                fit, surfaces = parts.fit(part, counts), parts.surfaces(part) * counts
                for kind in own:
                    # What is left of noise has pixels in common. And of a surface that one pixel shows the fit is exact but
                    # for rounding, which may be either way.
                    there = np.maximum(before[kind][part], 1e-6)
                    spared = np.maximum(1.0 - (2.0 * fit.leverage - fit.kept) / there, 0.0)
                    changed, share = _shrink(
                        fit, spared, surfaces, own[kind][:, part], noise[kind][:, part]
                    )
                    change[kind][:, part] = changed * counts[..., None]
                    gain = 1.0 - np.minimum(fit.kept / there, 1.0)
                    taken[kind][0, part, :, 0] = share.mean(axis=0) * gain * counts

            with ThreadPoolExecutor(os.cpu_count()) as pool:
                list(pool.map(shrink, range(0, len(fitted), many)))
            for kind in kinds:
                gone[kind] = tiles.lay_back(taken[kind])[0, :, 0]
                changes[kind] = tiles.lay_back(change[kind])
            yield None
        return changes, gone


def _find_ratio(own: np.ndarray, noise: np.ndarray) -> np.float32:
    """Variance of means as both halves differ over that by which single samples scatter. [-]

    ``own``, ``noise``: of pixels that are fitted, 0 elsewhere; as of `_shrink`.
    """
    expected = float(noise.sum(dtype=np.float64))
    luminance = own[..., _luminance_of(own)]
    found = float(((luminance[0] - luminance[1]) ** 2).sum(dtype=np.float64))
    return np.float32(np.clip(found / expected, LEAST_RATIO, 1.0) if expected > 0.0 else 0.0)


def _luminance_of(own: np.ndarray) -> int:
    """Which column of light is the luminance: the one there is, or Y."""
    return min(own.shape[-1] - 1, 1)


class PixelSharing:
    """Shares light between pixels of a picture.

    Parameters
    ----------
    stages : list of list of Tiling
        One after the other. The weights of a stage add up to 1; its first tiling begins with the picture.
    columns : list of int    Channels of light.
    colour : (c,) array or None    What these are for each unit of luminance where all light has one colour, else None.
    """

    def __init__(self, stages: list[list[Tiling]], columns: list[int], colour=None):
        self._stages, self._columns = stages, columns
        self._colour = None if colour is None else np.asarray(colour, dtype=np.float32)

    def share(self, means: dict[int, np.ndarray], variances: dict[int, np.ndarray]) -> Shared:
        """Share the light of all kinds, each for itself.

        Parameters
        ----------
        means, variances : dict    As of `sharing`.
        """
        return last_of(self.sharing(means, variances))

    def sharing(self, means: dict[int, np.ndarray], variances: dict[int, np.ndarray]):
        """Share the light of all kinds in steps; a generator, in the end of a `Shared`.

        Parameters
        ----------
        means : dict    By kind: (2, n, c), the luminance as channel 1.
        variances : dict    By kind: of the means of the luminance, as single samples scatter. (2, n)
        """
        first = next(iter(means.values()))
        change = np.zeros(first.shape, dtype=np.float32)
        left = {kind: np.ones(first.shape[1], dtype=np.float32) for kind in means}
        # Errors and not their squares, which single bright samples of one kind may make alone.
        errors = {
            kind: float(np.sqrt(each).sum(dtype=np.float64)) for kind, each in variances.items()
        }
        least = LEAST * sum(errors.values())
        # Where all light has one colour, its luminance tells all.
        wanted = self._columns if self._colour is None else [1]
        light = {
            kind: np.ascontiguousarray(means[kind][..., wanted], dtype=np.float32)
            for kind, error in errors.items()
            if error > least
        }
        variances = {kind: variances[kind].astype(np.float32) for kind in light}
        whole = np.zeros((*first.shape[:2], len(wanted)), dtype=np.float32)
        for tilings in self._stages if light else ():
            made = []
            for tiling in tilings:
                made.append((yield from tiling.finding_changes(light, variances, left)))
            for kind in light:
                changes = [changed[kind] for changed, _ in made if kind in changed]
                if not changes:
                    continue
                changed = sum(changes[1:], changes[0])
                light[kind] += changed
                whole += changed
                left[kind] *= 1.0 - sum(gone[kind] for _, gone in made if kind in gone)
        if light:
            # Without any light its colour is no number.
            change[..., self._columns] = whole if self._colour is None else whole * self._colour
        yield Shared(change, left)

    def smoothed_away(self, change: np.ndarray, scale: np.ndarray) -> np.ndarray:
        """Squares of what was no noise, as far as it is known of tiles and their neighbours. (n, c)

        ``change``: as of `Shared`. ``scale``: what errors of pixels are relative to, (n,).
        """
        tiles = self._stages[0][0].tiles
        count = (tiles.pixels >= 0).sum(axis=1)[:, None]
        # Sums of a tile are short enough for single precision.
        inverse = (1.0 / scale).astype(np.float32)[:, None]
        halves = (each * inverse for each in change)
        sums, whole = _find_common(*(tiles.lay_out(each[None])[0] for each in halves))
        each = np.maximum(tiles.average_around(sums / count), 0.0)
        # Chance makes it negative here and there, which must not be counted on the other side only.
        each *= np.maximum(whole, 0.0) / np.maximum((each * count).sum(axis=0), 1e-300)
        made = tiles.lay_back(np.repeat(each[None, :, None], tiles.side**2, axis=2))[0]
        return made * scale[:, None] ** 2


def _find_common(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the changes of both halves have in common: the sum over the pixels of their products, with little chance.

    Noise is alike in all waves over a tile, but what planes miss of light lies mostly in long ones. So the products of those
    are taken as they are, and those of shorter ones, where chance is more, as far as they stand out of it: else they are
    supposed to be a share of the longer ones, the less surely the farther from it they are found.

    Parameters
    ----------
    first, second : (t, p, c) float32 array    Changes of the pixels of tiles, 0 where there is no picture.

    Returns
    -------
    (t, c), (c,) array    Sums of tiles, which tell where it is, and of all of them.
    """
    apart = first - second
    rest = [
        np.einsum("tpc,tpc->tc", *each).astype(np.float64)
        for each in ((first, second), (apart, apart))
    ]
    count = first.shape[1]
    classes = []
    for waves in _find_waves(math.isqrt(count)):
        of_first, of_second = (np.tensordot(each, waves, axes=(1, 0)) for each in (first, second))
        own = [of_first * of_second, (of_first - of_second) ** 2]
        own = [each.sum(axis=2, dtype=np.float64) for each in own]
        rest = [each - mine for each, mine in zip(rest, own, strict=True)]
        classes.append((waves.shape[1], *own))
        count -= waves.shape[1]
    (few, tiles, noise), *shorter = *classes, (count, *rest)
    whole, chance = tiles.sum(axis=0), ((0.5 * noise) ** 2).sum(axis=0) / few
    for (many, products, noise), share, spread in zip(shorter, LIKELY, LIKELY_SPREAD, strict=True):
        # Squares of standard errors of their sum, and of what is supposed of it.
        own_chance = ((0.5 * noise) ** 2).sum(axis=0) / many
        longer = np.maximum(whole, 0.0)
        unsure = spread**2 * (longer**2 + chance)
        both = np.maximum(own_chance + unsure, 1e-300)
        away = (products.sum(axis=0) - share * longer) ** 2 / both
        trust = 1.0 - own_chance / both / (1.0 + away / UNLIKELY)
        tiles = tiles + trust * products
        whole = whole + trust * products.sum(axis=0) + (1.0 - trust) * share * longer
        chance = chance + own_chance
    return tiles, whole


def _find_waves(side: int) -> list[np.ndarray]:
    """Orthonormal cosines over the pixels of a tile, by how many half waves they have along both sides. (side^2, k) each"""
    place = np.pi * (np.arange(side) + 0.5) / side
    along = [np.cos(number * place) for number in range(WAVES[-1] + 1)]
    along = [each / np.linalg.norm(each) for each in along]
    made, least = [], 0
    for most in WAVES:
        each = [
            np.outer(along[n], along[k - n]) for k in range(least, most + 1) for n in range(k + 1)
        ]
        made.append(np.stack([wave.ravel() for wave in each], axis=1).astype(np.float32))
        least = most + 1
    return made


def _shrink(fit, spared, surfaces, own, noise) -> tuple[np.ndarray, np.ndarray]:
    """Draw the pixels of tiles towards what fits them, as far as what parts those of a surface from it is noise.

    Parameters
    ----------
    fit : Fit
    spared : (t, p) array    What of a pixel's noise parts it from its fit. [-]
    surfaces : (`SURFACES`, t, p) array    What a pixel counts of the surface that it shows most of, else 0.
    own : (2, t, p, c) array    Means of the halves, 0 where nothing is fitted.
    noise : (2, t, p) array    Variances of their luminance, alike.

    Returns
    -------
    (2, t, p, c) array, (2, t, p) array    What is added to the means where they are fitted, and how far they are drawn. [-]
    """
    residual = fit.residual(own)
    squares = residual[..., _luminance_of(own)] ** 2
    expected = noise * spared
    share = np.zeros_like(squares)
    for mine in surfaces:
        found = np.einsum("htp,tp->ht", squares, mine)
        # In the mean of both halves there is half of their noise, but all of what is no noise.
        half = 0.5 * np.einsum("htp,tp->ht", expected, mine)
        part = half / np.maximum(found - half, np.maximum(half, 1e-30))
        share += np.where(found > 0.0, np.minimum(TRUST * part, 1.0), 0.0)[..., None] * (mine > 0.0)
    # A plane may fall below 0 beside an edge, light may not.
    return np.maximum(share[..., None] * residual, -own), share


def last_of(steps):
    """What a generator gives in the end."""
    return deque(steps, maxlen=1).pop()


def find_sharing(scene, film: Film, channels, is_apart: bool) -> PixelSharing:
    """Find out which pixels of a picture show the same surfaces; as `finding_sharing`."""
    return last_of(finding_sharing(scene, film, channels, is_apart))


def finding_sharing(scene, film: Film, channels, is_apart: bool, lanes: int = LANES):
    """Find out which pixels of a picture show the same surfaces, in steps; a generator, in the end of a `PixelSharing`.

    Parameters
    ----------
    scene : CompiledScene
    film : Film
    channels : Channels
    is_apart : bool    Whether the light of matt surfaces is sampled by kinds of its own, and `VIEW` is all other light.
    lanes : int    Rays of a step.
    """
    camera = film.camera
    looks = []
    for each in _look(scene, film, DiffuseTable(scene), lanes):
        looks.append(each)
        yield None
    looks = zip(*looks, strict=True)
    pixel, surface, amount, is_matt, is_pure = (np.concatenate(each) for each in looks)
    # Light in view is mostly exact but at edges, where a pixel's own samples know best how much of it is seen.
    is_inner = is_pure & _is_inner(pixel, np.where(is_pure, surface, -1), camera)[pixel]
    wanted = is_matt, is_inner & ~is_matt if is_apart else is_inner
    stages = []
    for side in SIDES:
        tilings = []
        for shift, weight in zip(
            SHIFTS, weigh_tilings(camera.width, camera.height, side), strict=True
        ):
            tiles = Tiles(camera.width, camera.height, int(shift * side), side)
            of_matt, of_view = (
                _find_parts(tiles, pixel[some], surface[some], amount[some]) for some in wanted
            )
            tilings.append(Tiling(tiles, of_matt, of_view, weight))
            yield None
        stages.append(tilings)
    yield PixelSharing(stages, channels.light_columns, channels.light_colour)


def _is_inner(pixel, surface, camera) -> np.ndarray:
    """Which pixels show the same surface as all pixels around them. (n,) bool

    Few looks may miss a sliver of another one within the filter of a pixel; then a neighbour shows more of it.
    ``pixel``, ``surface``: of looks, (m,) each; the latter -1 where the pixel shows more than one.
    """
    shape = camera.height, camera.width
    shown = np.full(shape[0] * shape[1], -1, dtype=np.int64)
    shown[pixel] = surface
    shown = shown.reshape(shape)
    padded = np.pad(shown, 1, "edge")
    inner = shown >= 0
    for down in range(3):
        for across in range(3):
            around = padded[down : down + shape[0], across : across + shape[1]]
            inner &= around == shown
    return inner.ravel()


def weigh_tilings(width: int, height: int, side: int = TILE) -> np.ndarray:
    """Weights of pixels in the tilings by `SHIFTS`. (2, n)

    They fall to 0 at the edges of tiles, so that none is seen, but steeply: the fewer pixels count, the noisier are fits.
    """
    weights = []
    for shift in SHIFTS:
        x, y = (
            1.0 - np.abs((np.arange(size) + shift * side) % side + 0.5 - 0.5 * side) / (0.5 * side)
            for size in (width, height)
        )
        weights.append(np.sqrt(y[:, None] * x).ravel())
    weights = np.stack(weights)
    return (weights / weights.sum(axis=0)).astype(np.float32)


def _find_parts(tiles: Tiles, pixel, surface, amount) -> Parts:
    """Find what is seen most in tiles. ``pixel``, ``surface``, ``amount``: of looks, (m,) each."""
    inside = tiles.pixels >= 0
    count = int(inside.sum())
    parts = np.zeros((*tiles.pixels.shape, SURFACES), dtype=np.float32)
    is_fitted = np.zeros(tiles.pixels.shape, dtype=bool)
    if not len(pixel):
        return Parts(parts, is_fitted)
    tile, place = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    tile[tiles.pixels[inside]], place[tiles.pixels[inside]] = np.nonzero(inside)
    pairs, number = np.unique(tile[pixel] << SURFACE_BITS | surface, return_inverse=True)
    order = np.lexsort((-np.bincount(number, amount), pairs >> SURFACE_BITS))
    begins = np.flatnonzero(np.diff(pairs[order] >> SURFACE_BITS, prepend=-1))
    rank = np.zeros(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order)) - np.repeat(begins, np.diff(np.append(begins, len(order))))
    slot = rank[number]
    known = slot < SURFACES
    np.add.at(parts, (tile[pixel[known]], place[pixel[known]], slot[known]), amount[known])
    strange = np.bincount(pixel[~known], amount[~known], minlength=count)
    whole = np.bincount(pixel, amount, minlength=count)
    is_fitted[inside] = ((whole > 0.0) & (strange <= STRANGE * whole))[tiles.pixels[inside]]
    return Parts(parts, is_fitted)


def _look(scene, film: Film, matt, lanes: int):
    """Yield what pixels show, launch by launch: (m,) each.

    Pixels, surfaces, how much of these is seen, whether they are matt, and whether the pixel shows nothing else.
    """
    count = film.camera.width * film.camera.height
    each = max(lanes // LOOKS, 1)
    for first in range(0, count, each):
        many = min(each, count - first)
        surface, amount, is_matt = _launch(scene, film, matt, first, many)
        # Most pixels show one surface.
        same = (surface == surface[:, :1]).all(axis=1)
        pixel = np.arange(first, first + many)
        pixel = np.concatenate([pixel[same], np.repeat(pixel[~same], LOOKS)])
        surface, is_matt = (
            np.concatenate([values[same, 0], values[~same].ravel()])
            for values in (surface, is_matt)
        )
        amount = np.concatenate([amount[same].sum(axis=1), amount[~same].ravel()])
        is_pure = np.repeat([True, False], [same.sum(), LOOKS * (~same).sum()])
        seen = amount > 0.0
        yield pixel[seen], surface[seen], amount[seen], is_matt[seen], is_pure[seen]


def _launch(scene, film: Film, matt, first: int, many: int) -> tuple:
    """Surfaces that rays of pixels meet first, how much of these counts, and whether they are matt. (many, `LOOKS`) each

    Of matt ones it is their reflectance, of others the place alone, and of what lets see something else nothing.
    """
    lane = dr.arange(mi.UInt32, many * LOOKS)
    pixel = dr.opaque(mi.UInt32, first) + lane // LOOKS
    ray = film.ray_of(pixel, lane % LOOKS, hash_words(pixel, mi.UInt32(2)))
    if is_spectral():
        ray.wavelengths = gather.typical_wavelengths()
    si = closest_hit(scene, ray, sees(ray), coherent=True, looks=mi.Bool(True))
    seen = si.is_valid()
    number = dr.reinterpret_array(mi.UInt32, si.shape)
    if scene.hidden is not None:
        # Behind it anything may be seen, which is not taken for matt.
        seen &= ~dr.gather(mi.Bool, scene.hidden, number, seen)
    is_matt = seen & (matt.row(si.shape, seen) > 0)
    bsdf = scene.bsdf(si, seen)
    reflectance = average(bsdf.eval_diffuse_reflectance(si, is_matt))
    # What is seen in mirrors and behind glass has edges of its own.
    flags = bsdf.flags()
    shows_more = mi.has_flag(flags, mi.BSDFFlags.Null) | mi.has_flag(flags, mi.BSDFFlags.Delta)
    amount = dr.select(is_matt, reflectance, dr.select(seen & ~shows_more, 1.0, 0.0)) / LOOKS
    normal = mi.Vector3f(si.sh_frame.n) * dr.select(dr.dot(si.n, ray.d) < 0.0, 1.0, -1.0)
    facing = mi.UInt32(0)
    for each in (normal.x, normal.y, normal.z):
        facing = 3 * facing + mi.UInt32(dr.round(each) + 1.0)
    surface = number * FACINGS + facing
    amount += mi.Float(lane) * 0.0
    is_matt &= lane >= 0
    dr.eval(surface, amount, is_matt)
    shape = many, LOOKS
    surface = np.array(surface).astype(np.int64)
    return tuple(each.reshape(shape) for each in (surface, np.array(amount), np.array(is_matt)))
