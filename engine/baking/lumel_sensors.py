"""Lumels of objects as sensors: the layout of a bake, and a place on the surface for every lumel of it."""

import numpy as np

from ..atlas.lumel_blocks import LumelBlock
from ..errors import SceneError
from .host import Host
from .lumel_sheet import LumelSheet, SheetSurface
from .maps import layout_of
from .notes import Notes
from .order import BakeOrder, check_order
from .surfaces import arrange_charts, find_charts, find_lumels, find_surfaces

MOST_LUMELS = 50_000
"""More are refused: each keeps about 80 kB of daylight coefficients."""

FLAT = 1e-6
"""Cosine, less than 1 by so much, up to which normals are the same."""


def find_lumel_sensors(host: Host, order: BakeOrder, progress=None) -> LumelSheet:
    """Unwrap objects and find the places of their lumels.

    Parameters
    ----------
    host : Host
    order : BakeOrder    Of which objects, densities, pages and charts count.
    progress : callable or None    Gets a `Progress`.

    Raises
    ------
    SceneError    None of the objects has a surface, or there are too many lumels.
    Cancelled    The host said so.
    """
    check_order(order)
    notes = Notes(progress)
    surfaces = find_surfaces(order, host.scene, notes)
    charts = find_charts(surfaces, order, host.cancelled, notes)
    atlas = arrange_charts(surfaces, charts, order)
    for name, message in atlas.notes:
        notes.depart(name, message, "laid out like that")
    lumels = sum(float(each.mesh.areas().sum()) * each.density**2 for each in surfaces)
    if lumels > MOST_LUMELS:
        raise SceneError(
            f"the objects have about {lumels:.0f} lumels, at most {MOST_LUMELS} can be sensors of a year; take fewer lumels "
            "per metre"
        )
    with host.engine(order.transport) as compiled:
        ground = find_lumels(surfaces, atlas, compiled, order.seed, host.cancelled, notes)
        table = ground.table
        blocks = [table.block(number) for number in range(len(table.counts))]
    rows = [_Rows(block) for block in blocks]
    columns = {name: np.concatenate([getattr(row, name) for row in rows]) for name in _Rows.NAMES}
    order_of = np.argsort(columns["owner"], kind="stable")
    each = zip(ground.surfaces, atlas.layouts, strict=True)
    return LumelSheet(
        np.asarray(atlas.sizes, dtype=np.int64),
        tuple(
            SheetSurface(
                surface.key,
                surface.mesh.name + (" (back)" if surface.is_back else ""),
                layout_of(surface, layout, atlas.sizes),
                layout.density,
            )
            for surface, layout in each
        ),
        **{name: column[order_of] for name, column in columns.items()},
        departures=tuple(notes.departures),
    )


class _Rows:
    """Lumels of a block in the columns of a sheet."""

    NAMES = ("owner", "page", "index", "chart", "area", "is_valid", "sensors")

    def __init__(self, block: LumelBlock):
        count = len(block.index)
        self.owner = np.full(count, block.layout, dtype=np.int32)
        self.page = np.full(count, block.page, dtype=np.int32)
        self.index, self.chart = block.index, block.chart
        self.area, self.is_valid = block.area, block.valid
        held = block.receivers
        row = np.repeat(np.arange(count), held.count)
        middle = np.add.reduceat(held.positions, held.start, axis=0) / held.count[:, None]
        away = ((held.positions - middle[row]) ** 2).sum(axis=1)
        # The nearest place of each lumel comes first.
        nearest = np.lexsort((away, row))[held.start]
        facing = held.geometric_normals
        turned = 1.0 - np.einsum("kx,kx->k", facing, facing[nearest][row])
        is_flat = np.maximum.reduceat(turned, held.start) < FLAT
        # All places lie on the surface, which the middle does where that is flat.
        places = np.where(is_flat[:, None], middle, held.positions[nearest])
        self.sensors = np.concatenate([places, held.normals[nearest]], axis=1)
