"""From estimates per lumel to finished pages."""

from dataclasses import dataclass

import numpy as np

from ..atlas.gutters import fill
from ..atlas.layout import Atlas
from ..atlas.lumels import LumelTable
from ..atlas.seams import find_seams, join_pairs, match_seams, usable_pairs
from .order import AtlasPage, Seams


@dataclass(frozen=True)
class Estimates:
    """Values of all lumels of a table, in its order.

    Parameters
    ----------
    illuminance, standard_error : (n,) array    [lx]
    layers : dict of str to (n,) array    [lx]
    exitance : (n, 3) array or None    X, Y, Z. [lm/m2]
    replicates : int
    freedom : float    Of the errors. [-]
    surplus : (k,) array
        By layout, what the squares of the errors of its lumels, times their areas, are above those that the passes show:
        single ones are stated with care, of which means of many need none. [lx2 m2]
    """

    illuminance: np.ndarray
    standard_error: np.ndarray
    layers: dict[str, np.ndarray]
    exitance: np.ndarray | None
    replicates: int
    freedom: float
    surplus: np.ndarray


def lay_out_page(
    number: int, atlas: Atlas, table: LumelTable, estimates: Estimates, margin: int
) -> tuple[AtlasPage, np.ndarray]:
    """Put the lumels of a page in their places and fill what is unknown, the rims of charts included.

    Returns
    -------
    (AtlasPage, (h, w) int32)    The page, and the chart that every pixel's value belongs to, rims included.
    """
    width, height = (int(side) for side in atlas.sizes[number])
    names = ["illuminance", "standard_error", *estimates.layers]
    count = len(names) + (0 if estimates.exitance is None else 3)
    values = np.zeros((count, height * width), dtype=np.float32)
    area = np.zeros(height * width, dtype=np.float32)
    known = np.zeros(height * width, dtype=bool)
    owner = np.full(height * width, -1, dtype=np.int32)
    chart = np.full(height * width, -1, dtype=np.int32)
    columns = [estimates.illuminance, estimates.standard_error, *estimates.layers.values()]
    columns += [] if estimates.exitance is None else list(estimates.exitance.T)
    first = 0
    for block, lumels in enumerate(table.counts):
        part = slice(first, first + lumels)
        first += lumels
        if table.page(block) != number:
            continue
        made = table.facts(block)
        for row, column in zip(values, columns, strict=True):
            row[made.index] = column[part]
        area[made.index], known[made.index] = made.area, made.valid
        owner[made.index], chart[made.index] = made.layout, made.chart
    shape = (height, width)
    filled, rims = fill(
        values.reshape(count, *shape), known.reshape(shape), chart.reshape(shape), margin
    )
    exitance = None
    if estimates.exitance is not None:
        exitance = np.ascontiguousarray(np.moveaxis(filled[-3:], 0, -1))
    made = AtlasPage(
        number=number,
        width=width,
        height=height,
        illuminance=filled[0],
        standard_error=filled[1],
        covered=known.reshape(shape),
        area=area.reshape(shape),
        object=owner.reshape(shape),
        chart=chart.reshape(shape),
        layers={name: filled[2 + k] for k, name in enumerate(estimates.layers)},
        exitance=exitance,
        replicates=estimates.replicates,
        freedom=estimates.freedom,
    )
    return made, rims


def match_pages(pages: list[AtlasPage], owners, meshes, atlas: Atlas) -> Seams:
    """Make charts of smooth surfaces agree where they meet. Pages are changed in place; ``owners`` as of `lay_out_page`."""
    pairs = join_pairs(
        [
            find_seams(m, layout, atlas.sizes)
            for m, layout in zip(meshes, atlas.layouts, strict=True)
        ]
    )
    pairs = usable_pairs(pairs, owners)
    changes, steps = match_seams(
        [page.illuminance for page in pages],
        [page.standard_error for page in pages],
        [page.covered for page in pages],
        pairs,
    )
    for page, (index, change) in zip(pages, changes, strict=True):
        before = page.illuminance.reshape(-1)[index]
        scale = np.where(before > 0.0, (before + change) / np.where(before > 0.0, before, 1.0), 1.0)
        page.illuminance.reshape(-1)[index] += change
        for layer in page.layers.values():
            layer.reshape(-1)[index] *= scale
        if page.exitance is not None:
            page.exitance.reshape(-1, 3)[index] *= scale[:, None]
    return Seams(steps.pairs, steps.before, steps.after, steps.noise)
