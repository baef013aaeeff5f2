"""How surfaces lie on an atlas: charts of meshes, and pages with the charts of many meshes."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Charts:
    """Connected groups of a mesh's triangles, each laid flat.

    Parameters
    ----------
    uv : (t, 3, 2) float64 array    Places of the corners in their chart, true to scale, from 0 on. [m]
    chart : (t,) int32 array    Number of every triangle's chart; -1 for triangles without area, which get no place.
    size : (c, 2) float64 array    Width and height of the charts. [m]
    notes : tuple of str    What was done otherwise than asked for, for people.
    """

    uv: np.ndarray
    chart: np.ndarray
    size: np.ndarray
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class SurfaceLayout:
    """Where the triangles of one mesh lie.

    Parameters
    ----------
    uv : (t, 3, 2) float64 array    On their page, v upwards. [lumel]
    page : (t,) int32 array    -1: nowhere.
    chart : (t,) int32 array    Number over all charts of the atlas; -1: nowhere.
    density : float    Lumels per metre that were reached on the whole.
    requested_density : float
    is_back : bool    Whether it is the back side of a mesh that is laid out, with normals turned round.
    mesh : int    Place of the mesh among those that were given.
    """

    uv: np.ndarray
    page: np.ndarray
    chart: np.ndarray
    density: float
    requested_density: float
    is_back: bool = False
    mesh: int = 0


@dataclass(frozen=True)
class Atlas:
    """Pages and what lies on them.

    Parameters
    ----------
    sizes : (p, 2) int array    Width and height of every page. [lumel]
    layouts : tuple of SurfaceLayout    One for each mesh that was given, then one for each back side.
    chart_count : int
    shrink : float    Factor by which all densities were lowered to keep to the number of pages; 1: none. [-]
    notes : tuple of (str, str)    Name of the mesh, and what was done otherwise than asked for.
    """

    sizes: np.ndarray
    layouts: tuple[SurfaceLayout, ...]
    chart_count: int
    shrink: float
    notes: tuple[tuple[str, str], ...] = ()
