"""From estimates per lumel to finished pages."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..analysis.denoiser import DenoiserError
from ..analysis.looking import denoise_charts
from ..atlas.gutters import fill
from ..atlas.layout import Atlas
from ..atlas.lumels import LumelTable
from ..atlas.seams import find_seams, join_pairs, match_seams, usable_pairs
from ..errors import Cancelled
from ..scene.provenance import Provenance
from .estimates import Estimates
from .files import scale_top, write_page
from .notes import Notes
from .order import AtlasPage, BakeOrder, Seams
from .surfaces import Ground

MOST_MATCHED = 1 << 27
"""Pixels of all pages up to which seams are matched: all pages have to be at hand together."""


def make_pages(
    ground: Ground,
    estimates: Estimates,
    order: BakeOrder,
    provenance: Provenance,
    cancelled,
    notes: Notes,
) -> tuple[list[AtlasPage], Seams]:
    """Make all pages, and write those that the order names a folder for.

    Raises
    ------
    Cancelled    When ``cancelled`` answered true.
    """
    atlas, table = ground.atlas, ground.table
    folder = None if order.folder is None else Path(order.folder)
    high = scale_top(estimates.illuminance)
    is_whole = int(np.prod(atlas.sizes, axis=1).sum()) <= MOST_MATCHED
    attributes = {
        "sceneHash": provenance.scene_hash,
        "seed": str(order.seed),
        "samples": str(provenance.samples),
        "replicates": str(estimates.replicates),
        "freedom": f"{estimates.freedom:g}",
    }
    pages, owners = [], []

    def finish(page: AtlasPage) -> AtlasPage:
        if order.denoise and page.exitance is not None:
            page = _denoised(page, order.margin, notes)
        if folder is not None:
            page = write_page(folder, page, attributes, high, order.isolux, order.arrays)
        return page if order.keep_pages else _emptied(page)

    for number in range(len(atlas.sizes)):
        if cancelled():
            raise Cancelled("cancelled")
        page, owner = lay_out_page(number, atlas, table, estimates, order.margin)
        pages.append(page if is_whole else finish(page))
        owners.append(owner)
    if is_whole:
        seams = match_pages(pages, owners, [each.mesh for each in ground.surfaces], atlas)
        return [finish(page) for page in pages], seams
    notes.depart("atlas", "the pages are too many to be at hand together", "seams are not matched")
    return pages, Seams(0, 0.0, 0.0, 0.0)


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
        facts = table.facts(block)
        for row, column in zip(values, columns, strict=True):
            row[facts.index] = column[part]
        area[facts.index], known[facts.index] = facts.area, facts.valid
        owner[facts.index], chart[facts.index] = facts.layout, facts.chart
    shape = (height, width)
    filled, rims = fill(
        values.reshape(count, *shape), known.reshape(shape), chart.reshape(shape), margin
    )
    exitance = None
    if estimates.exitance is not None:
        exitance = np.ascontiguousarray(np.moveaxis(filled[-3:], 0, -1))
    page = AtlasPage(
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
    return page, rims


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


def _denoised(page: AtlasPage, margin: int, notes: Notes) -> AtlasPage:
    """Denoise the exitance of a page; where that cannot be done it stays, and is noted."""
    try:
        made = denoise_charts(page.exitance, page.covered, page.chart)
    except DenoiserError as error:
        notes.depart("atlas", str(error), "the exitance is as computed")
        return page
    filled, _ = fill(np.moveaxis(made, -1, 0), page.covered, page.chart, margin)
    exitance = np.ascontiguousarray(np.moveaxis(filled, 0, -1))
    return replace(page, exitance=exitance, is_denoised=True)


def _emptied(page: AtlasPage) -> AtlasPage:
    names = ("illuminance", "standard_error", "covered", "area", "object", "chart", "exitance")
    return replace(page, layers={}, **dict.fromkeys(names))
