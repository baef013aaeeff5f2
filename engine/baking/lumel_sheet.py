"""Lumels as sensors: where they lie on objects and on the pages of an atlas, as plain data."""

from dataclasses import dataclass

import numpy as np

from .order import Departure, Layout


@dataclass(frozen=True)
class SheetSurface:
    """One object whose lumels are sensors.

    Parameters
    ----------
    id, name : str    Of the object.
    layout : Layout    Where its triangles lie.
    density : float    Lumels per metre that were reached.
    """

    id: str
    name: str
    layout: Layout
    density: float


@dataclass(frozen=True, eq=False)
class LumelSheet:
    """All lumels of some objects, surface by surface.

    Parameters
    ----------
    sizes : (p, 2) int array    Width and height of every page. [lumel]
    surfaces : tuple of SheetSurface
    owner : (n,) int32 array    Number of every lumel's surface, ascending.
    page : (n,) int32 array
    index : (n,) int64 array    Flat pixel index on the page, row 0 at the bottom.
    chart : (n,) int32 array    Number over all charts of the atlas.
    area : (n,) array    Surface in each lumel. [m2]
    is_valid : (n,) bool array    False: inside a solid or covered all over, to be filled from the neighbours.
    sensors : (n, 6) array    A place on the surface next to the middle of the lumel, and the normal there. [m, -]
    departures : tuple of Departure    What is not as ordered.
    """

    sizes: np.ndarray
    surfaces: tuple[SheetSurface, ...]
    owner: np.ndarray
    page: np.ndarray
    index: np.ndarray
    chart: np.ndarray
    area: np.ndarray
    is_valid: np.ndarray
    sensors: np.ndarray
    departures: tuple[Departure, ...] = ()
