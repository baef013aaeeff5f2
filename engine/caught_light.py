"""What shadow catchers show, from sums over samples: the light behind them times a ratio of two illuminances, see 12.13.

The illuminance with all that stands there is that of all lights together, and so is the one that it is divided by. A light
group has its part of the first over the whole of the second, so groups add up to the picture, sample by sample.

References
----------
A. Voloboy: Software technologies that automate the making of realistic images, dissertation, Moscow 2012, 1.4.2.
"""

from dataclasses import dataclass

import numpy as np

from .photometry.colour import XYZ_TO_REC709

BEHIND, SHADED, OPEN, SQUARES = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 13)
"""Columns of a part: X, Y, Z behind catchers; X, Y, Z of the illuminance with and without what stands there; means of the
products of both, and of the square of the luminance behind, to tell how much they scatter."""

LENGTH = 13
"""Of a part without its bands."""


@dataclass(frozen=True)
class Shown:
    """What is seen of catchers by the two halves of the samples, whose mean is that of all samples together.

    Parameters
    ----------
    tristimulus : (2, n, 3) array    X, Y, Z by straight rays, in place of what is black without. [cd/m2]
    bands : (2, n, b) array    The same by band. [W/(m2 sr nm)]
    change : (2, n, 3) array    X, Y, Z that are taken from what mirrors, glass and gloss show of the ground. [cd/m2]
    band_change : (2, n, b) array
    """

    tristimulus: np.ndarray
    bands: np.ndarray
    change: np.ndarray
    band_change: np.ndarray

    @property
    def luminance(self) -> np.ndarray:
        """Luminance of both together. (2, n) [cd/m2]"""
        return (self.tristimulus + self.change)[..., 1]

    @property
    def difference(self) -> np.ndarray:
        """Half of what the luminances of the halves differ by: its error, with a sign. (n,) [cd/m2]"""
        return 0.5 * (self.luminance[1] - self.luminance[0])


@dataclass(frozen=True)
class CaughtLayout:
    """Columns that a picture keeps of its catchers, in this order: share of rays that meet one; those of a part each.

    Parameters
    ----------
    bands : int    Behind the other columns of every part.
    has_bounced : bool
        Whether there is a second part: of the ground behind mirrors, glass and gloss, beside what is seen straight.
    """

    bands: int
    has_bounced: bool

    @property
    def count(self) -> int:
        """Number of columns."""
        return 1 + (1 + self.has_bounced) * (LENGTH + self.bands)

    def straight(self, columns: np.ndarray) -> np.ndarray:
        """Columns of what is seen straight. (..., 13 + bands)"""
        return columns[..., 1 : 1 + LENGTH + self.bands]

    def bounced(self, columns: np.ndarray) -> np.ndarray | None:
        """Columns of what is seen over mirrors, glass and gloss, None without any. (..., 13 + bands)"""
        return columns[..., 1 + LENGTH + self.bands :] if self.has_bounced else None

    def shade(self, halves: np.ndarray) -> tuple[Shown, np.ndarray]:
        """What is seen of catchers, by the means of both halves.

        Parameters
        ----------
        halves : (2, n, count) array

        Returns
        -------
        (Shown, (2, n) array)
            And the share of pixels that stays open, which is that of all catchers where nothing is shaded.
        """
        shown, is_open = self.share_out([halves], [True])
        return shown[0], is_open

    def share_out(self, groups: list[np.ndarray], holds_world: list[bool]):
        """What light groups give to what is seen of catchers.

        Parameters
        ----------
        groups : list of (2, n, count) arrays    Means of the samples of every group, while it alone shines.
        holds_world : list of bool    Which of them the surroundings belong to.

        Returns
        -------
        (list of Shown, (2, n) array)    As of `shade`, for each group and of all together.
        """
        halves = [each.astype(np.float64) for each in groups]
        pooled = [each.mean(axis=0, keepdims=True) for each in halves]
        # What stays where there is no light at all is the surroundings', or else anybody's.
        owner = holds_world.index(True) if any(holds_world) else 0
        whole, of_halves = self.join(pooled), self.join(halves)
        shown = []
        for k, (mean, each) in enumerate(zip(pooled, halves, strict=True)):
            is_clipped, is_owner = len(groups) == 1, k == owner
            around = self._lit(mean, whole, is_owner, is_clipped)
            parts = self._lit(each, of_halves, is_owner, is_clipped)
            shown.append(Shown(*(_about(*pair) for pair in zip(around, parts, strict=True))))
        return shown, _about(self._open(whole), self._open(of_halves))

    def join(self, groups: list[np.ndarray]) -> np.ndarray:
        """Columns of all light together from those of the groups: all see the same behind catchers, and light adds up."""
        whole = sum(groups) / len(groups)
        for part in (self.straight(whole), self.bounced(whole)):
            if part is not None:
                part[..., SHADED] *= len(groups)
                part[..., OPEN] *= len(groups)
        return whole

    def scatter(self, group: np.ndarray, whole: np.ndarray, counts, white: float, number=1):
        """Variance of the luminance that is seen of catchers, by how single samples scatter, to first order.

        Parameters
        ----------
        group : (2, n, count) array    Means of a group's samples.
        whole : (n, count) array    Means of both halves of all groups together, see `join`.
        counts : (n,) array    Samples of the group in a half.
        white : float    Luminance that their alpha stands for, 0 where it is not wanted. [cd/m2]
        number : int    Of groups.

        Returns
        -------
        (2, n) array    [cd2/m4]
        """
        group = group.astype(np.float64)
        part = self.straight(whole)
        least = white * whole[:, 0]
        scatter = _scatter(self.straight(group), part, least, 0.0, number)
        if self.has_bounced:
            scatter = scatter + _scatter(self.bounced(group), self.bounced(whole), 0.0, 1.0, number)
        return scatter / (2 * np.maximum(counts - 1, 1))

    # ---- private ----

    def _lit(self, group, whole, is_owner: bool, is_clipped: bool) -> tuple:
        """Fields of `Shown` of a group."""
        seen = _lit(self.straight(group), self.straight(whole), is_owner, is_clipped)
        if not self.has_bounced:
            return *seen, np.zeros_like(seen[0]), np.zeros_like(seen[1])
        behind = self.bounced(whole)
        colour, bands = _lit(self.bounced(group), behind, is_owner, is_clipped)
        if is_owner:
            # Paths count it as if nothing stood there, as light of the surroundings.
            colour, bands = colour - behind[..., BEHIND], bands - behind[..., LENGTH:]
        return *seen, colour, bands

    def _open(self, whole: np.ndarray) -> np.ndarray:
        part = self.straight(whole)
        ratio = _ratio(part[..., SHADED][..., 1], part[..., OPEN][..., 1])
        return whole[..., 0] * np.clip(ratio, 0.0, 1.0)


def _about(mean: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """Halves about another mean: ratios of halves are off by more than those of all samples."""
    return halves + (mean - halves.mean(axis=0))


def _lit(group, whole, is_owner: bool, is_clipped: bool) -> tuple[np.ndarray, np.ndarray]:
    """X, Y, Z and bands that the lights of a group give to what is seen of catchers, by columns of a part."""
    shaded, without = group[..., SHADED], whole[..., OPEN]
    ratio = _ratio(shaded[..., 1], without[..., 1], float(is_owner))
    by_colour = _ratio(*(each @ XYZ_TO_REC709.T for each in (shaded, without)), ratio[..., None])
    if is_clipped:
        # Light of colours that no screen shows may fall short of a component: of all together none is less than black.
        ratio, by_colour = np.maximum(ratio, 0.0), np.maximum(by_colour, 0.0)
    seen = ((whole[..., BEHIND] @ XYZ_TO_REC709.T) * by_colour) @ np.linalg.inv(XYZ_TO_REC709).T
    return seen, whole[..., LENGTH:] * ratio[..., None]


def _scatter(group: np.ndarray, whole: np.ndarray, least, taken: float, number: int) -> np.ndarray:
    """Variance of single samples of a part. ``taken``: ratio at which it adds nothing. (2, n)"""
    without = whole[:, OPEN][:, 1]
    ratio = _ratio(whole[:, SHADED][:, 1], without)
    with_all, both, alone, squared = np.moveaxis(group[..., SQUARES], -1, 0)
    # Means are apart from those of other groups.
    lit, open_light = group[..., SHADED][..., 1], group[..., OPEN][..., 1]
    around = with_all - 2.0 * ratio * both + ratio**2 * alone - (lit - ratio * open_light) ** 2
    # Every group tells of what is behind, and the mean of all counts.
    behind = np.maximum(squared - group[..., BEHIND][..., 1] ** 2, 0.0)
    amount = np.maximum(whole[:, BEHIND][:, 1], least)
    relative = np.divide(amount, without, out=np.zeros(len(amount)), where=without > 0.0)
    return np.maximum(around, 0.0) * relative**2 + ((ratio - taken) / number) ** 2 * behind


def _ratio(part: np.ndarray, whole: np.ndarray, otherwise=1.0) -> np.ndarray:
    """Part over whole; where there is no whole what stands for it."""
    stands_for = np.broadcast_to(otherwise, whole.shape).astype(np.float64)
    return np.divide(part, whole, out=stands_for, where=whole > 0.0)
