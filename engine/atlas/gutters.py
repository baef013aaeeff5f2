"""Pixels without a value of their own: lumels that could not be computed, and the rims of charts that filters reach into."""

import numpy as np

NOBODY = -1
"""Chart of pixels that belong to none."""


def fill(values: np.ndarray, known: np.ndarray, chart: np.ndarray, margin: int):
    """Fill unknown lumels inside charts, then extend charts over free pixels.

    Every pixel takes the mean of its neighbours of one and the same chart, ring by ring from what is known. A free pixel
    between charts goes to the one that reaches it first; of several at once to that with the most neighbours there, then
    to the one with the lowest number.

    Parameters
    ----------
    values : (k, h, w) float array    Maps that are filled alike.
    known : (h, w) bool array    Lumels that were computed.
    chart : (h, w) int array    Number of the chart, -1 on free pixels.
    margin : int    Rings on free pixels.

    Returns
    -------
    values : (k, h, w) array    Of the kind that was given; 0 where nothing is known near by.
    owner : (h, w) int32 array    Chart that every value belongs to, -1 where there is none: outside the margin, and in
        charts of which nothing is known.
    """
    height, width = known.shape
    page = _Page(values, np.where(known, chart, NOBODY))
    inside = page.lay_out(chart, NOBODY)
    page.grow(inside != NOBODY, inside, height * width)
    page.grow(page.lay_out(chart == NOBODY, False), None, margin)
    return page.finish()


class _Page:
    """Maps with a free rim of one pixel, laid flat so that neighbours are at fixed distances.

    Parameters
    ----------
    values : (k, h, w) array
    owner : (h, w) int array    Chart of the pixels that are known, `NOBODY` on others.
    """

    def __init__(self, values: np.ndarray, owner: np.ndarray):
        self._shape = (owner.shape[0] + 2, owner.shape[1] + 2)
        self.owner = self.lay_out(owner.astype(np.int32), NOBODY)
        known = owner != NOBODY
        self._values = [self.lay_out(np.where(known, each, 0), 0) for each in values]
        wide = self._shape[1]
        self._around = np.array([-wide - 1, -wide, -wide + 1, -1, 1, wide - 1, wide, wide + 1])

    def lay_out(self, layer: np.ndarray, rim) -> np.ndarray:
        """Put a rim round a layer (h, w) and lay it flat."""
        return np.pad(layer, 1, constant_values=rim).reshape(-1)

    def finish(self):
        """Return values and owners without the rim."""
        made = [each.reshape(self._shape)[1:-1, 1:-1] for each in self._values]
        owner = self.owner.reshape(self._shape)[1:-1, 1:-1]
        return np.stack(made) if made else np.zeros((0, *owner.shape)), owner.copy()

    def grow(self, open_to: np.ndarray, wanted: np.ndarray | None, rings: int) -> None:
        """Fill pixels ring by ring.

        Parameters
        ----------
        open_to : bool array    Pixels that may be filled, as `lay_out` makes it.
        wanted : int array or None    The only chart that each may be filled from; None: any.
        rings : int    At most.
        """
        pixels = np.flatnonzero(open_to & (self.owner == NOBODY))
        near = np.zeros(len(pixels), dtype=bool)
        for step in self._around:
            near |= self.owner[pixels + step] != NOBODY
        front = pixels[near]
        for _ in range(rings):
            charts = self.owner[front[:, None] + self._around]
            chosen = _choose(charts) if wanted is None else wanted[front]
            agree = (charts == chosen[:, None]) & (charts != NOBODY)
            count = agree.sum(axis=1)
            reached = count > 0
            front, agree, count = front[reached], agree[reached], count[reached]
            if len(front) == 0:
                return
            for layer in self._values:
                around = layer[front[:, None] + self._around].astype(np.float64)
                layer[front] = np.where(agree, around, 0.0).sum(axis=1) / count
            self.owner[front] = chosen[reached]
            beyond = np.unique((front[:, None] + self._around).reshape(-1))
            front = beyond[open_to[beyond] & (self.owner[beyond] == NOBODY)]


def _choose(charts: np.ndarray) -> np.ndarray:
    """The most frequent chart of every row (n, 8), of equal ones the lowest; `NOBODY` only where there is no other."""
    charts = np.sort(charts, axis=1)
    best, most = np.full(len(charts), NOBODY, dtype=charts.dtype), np.zeros(len(charts), dtype=int)
    run = np.zeros(len(charts), dtype=int)
    for i in range(charts.shape[1]):
        same = i > 0 and charts[:, i] == charts[:, i - 1]
        run = np.where(same, run + 1, 1)
        better = (run > most) & (charts[:, i] != NOBODY)
        best, most = np.where(better, charts[:, i], best), np.where(better, run, most)
    return best
