"""What a bake is asked for and what it gives: plain data."""

from dataclasses import dataclass, field

import numpy as np

from ..accuracy.extremes import Extreme, divide
from ..accuracy.history import History
from ..accuracy.stopping import StopRule
from ..errors import SceneError
from ..scene.light_groups import LightGroup
from ..scene.provenance import Provenance


@dataclass(frozen=True)
class BakeOrder:
    """What a bake is asked for.

    Parameters
    ----------
    objects : tuple of str    Ids of objects of the scene.
    rule : StopRule    The error is that of all maps together.
    density : float    Lumels per metre; ``densities`` by object id where it is another.
    from_textures : bool    Whether the density is at least that of each surface's own pictures.
    largest : int    Side of an atlas page. [lumel]
    pages : int    Most pages; all charts shrink alike to fit. 0: as many as it takes.
    margin : int    Free rim of charts. [lumel]
    cone : float    Largest angle between a chart's direction and its triangles' normals. [rad]
    detail : float    Charts whose neighbouring lumels differ by less than this share of the mean illuminance are halved
        after a first pass, as often as that holds; 0: none.
    two_sided : tuple of str    Ids of objects whose back sides get charts of their own.
    groups : tuple of LightGroup    Layers; lights in none of them share a last layer.
    exitance : bool    Whether the light that leaves the surface is wanted too, in colour.
    denoise : bool    Whether the exitance, which is for looking, is denoised, by Open Image Denoise.
    method : str    ``auto``, ``cells`` or ``paths``: what stands for the radiance beyond the first bounce.
    caustics : str    ``auto``, ``on`` or ``off``: whether light is also traced from the lights.
    folder : str or None    Where pages and report are written; None: nowhere.
    isolux : bool    Whether pages are also drawn with lines of equal illuminance, as pixels and as shapes.
    arrays : bool    Whether pages are also written as plain arrays of NumPy, which programs without OpenEXR read.
    keep_pages : bool    Whether the result holds the pages' arrays; else they are in the folder only.
    witness : bool    Whether a pilot from the lights tells what the objects receive, so that the errors cover what it finds.
    pass_seed : int or None    Of the passes, where they are a part of a bake's, whose layout goes by ``seed``; None: that.
    checkpoint : str or None    File from which an interrupted bake of the same order goes on, and to which its state is
        written from time to time.
    file, scene : str    Names of the scene's file and of the scene in it, for the report.
    conversion : tuple of dict    Rows of the conversion report, for the report.
    """

    objects: tuple[str, ...]
    rule: StopRule
    density: float = 8.0
    densities: dict[str, float] = field(default_factory=dict)
    from_textures: bool = False
    largest: int = 2048
    pages: int = 0
    margin: int = 4
    cone: float = 1.0
    detail: float = 0.0
    two_sided: tuple[str, ...] = ()
    groups: tuple[LightGroup, ...] = ()
    exitance: bool = False
    denoise: bool = False
    method: str = "auto"
    caustics: str = "auto"
    seed: int = 0
    transport: str = "auto"
    folder: str | None = None
    isolux: bool = False
    arrays: bool = False
    keep_pages: bool = True
    checkpoint: str | None = None
    file: str = ""
    scene: str = ""
    conversion: tuple[dict, ...] = ()
    witness: bool = True
    pass_seed: int | None = None


@dataclass(frozen=True)
class Layout:
    """Where an object's triangles lie on the atlas: texture coordinates by corner, and which corner is which.

    Parameters
    ----------
    uv : (t, 3, 2) float32    In 0..1 of the page, v upwards.
    page : (t,) int32    -1 where a triangle has no area and so no place.
    triangles : (t, 3) int32    Vertex indices.
    polygon : (t,) int32 or None    Polygon of every triangle.
    vertex_count : int
    """

    uv: np.ndarray
    page: np.ndarray
    triangles: np.ndarray
    polygon: np.ndarray | None
    vertex_count: int


@dataclass(frozen=True)
class LuxMap:
    """Illuminance of one object; its lumels lie on the pages of the result.

    Parameters
    ----------
    id, name : str    Of the object.
    number : int    By which the pages' ``object`` knows it.
    lumels, charts : int    How many.
    mean : float    Area-weighted. [lx]
    least, largest : Extreme    Over the lumels, freed of what noise adds to extremes. [lx]
    relative_standard_error : float
        Area-weighted root mean square of the lumels' errors over the mean. What noisy single ones state with care, above
        what the passes show of all, is not in it. [-]
    mean_standard_error : float    Of ``mean``. [lx]
    bias, bias_error : float    What the cells add to the mean on the whole, and the standard error of that. [lx]
    samples : float    Mean number per lumel.
    density, requested_density : float    Lumels per metre, reached and asked for.
    area : float    Surface on the maps. [m2]
    invalid : int    Lumels inside solids, which were filled from their neighbours.
    """

    id: str
    name: str
    number: int
    lumels: int
    charts: int
    mean: float
    least: Extreme
    largest: Extreme
    relative_standard_error: float
    mean_standard_error: float
    bias: float
    bias_error: float
    samples: float
    density: float
    requested_density: float
    area: float
    invalid: int
    provenance: Provenance
    layout: Layout

    @property
    def uniformity(self) -> Extreme:
        """Least illuminance over the mean. [-]"""
        return divide(self.least, self.mean, self.mean_standard_error)


@dataclass(frozen=True)
class AtlasPage:
    """One page. Row 0 is the bottom row. Gutters and lumels inside solids are filled from their neighbours.

    Parameters
    ----------
    number : int    From 0.
    width, height : int    [lumel]
    illuminance, standard_error : (h, w) float32    [lx]
    covered : (h, w) bool    Lumels that lie on a surface and were computed.
    area : (h, w) float32    Surface in each lumel. [m2]
    object : (h, w) int32    Number of the object, -1 where there is none.
    chart : (h, w) int32    Number of the chart over the whole atlas, -1 where there is none.
    layers : dict of str to (h, w) float32    Illuminance by light group. [lx]
    exitance : (h, w, 3) float32 or None    X, Y, Z of the light that leaves, Y the luminous exitance. [lm/m2]
    replicates : int    Independent repetitions that the errors come from.
    freedom : float    Degrees of freedom of the errors: those of the repetitions and of the lumels around. [-]
    files : tuple of str    Where it was written.
    is_denoised : bool    Whether the exitance was denoised; all else is as computed.

    The arrays are None where the order kept them in files only.
    """

    number: int
    width: int
    height: int
    illuminance: np.ndarray | None
    standard_error: np.ndarray | None
    covered: np.ndarray | None
    area: np.ndarray | None
    object: np.ndarray | None
    chart: np.ndarray | None
    layers: dict[str, np.ndarray]
    exitance: np.ndarray | None
    replicates: int
    freedom: float
    files: tuple[str, ...] = ()
    is_denoised: bool = False


@dataclass(frozen=True)
class Departure:
    """Something that a bake could not do as ordered: where, what, and what was done instead."""

    name: str
    message: str
    remedy: str
    is_error: bool = False


@dataclass(frozen=True)
class Seams:
    """How well charts meet at their common edges.

    Parameters
    ----------
    pairs : int    Places on edges of smooth surfaces where two charts meet.
    before, after : float    Root mean square of the steps there, before and after they were matched. [lx]
    noise : float    Root mean square of the steps' standard errors. [lx]
    """

    pairs: int
    before: float
    after: float
    noise: float


@dataclass(frozen=True)
class BakeResult:
    """Finished maps.

    Parameters
    ----------
    maps : tuple of LuxMap    One for each object.
    pages : tuple of AtlasPage
    departures : tuple of Departure
    files : tuple of str    All that was written.
    history : History    Error over time, with the forecasts that were made.
    relative_standard_error : float    Of everything: root mean square over the mean, area-weighted. [-]
    quadratic_relative_error : float    The same over the root mean square illuminance. [-]
    mean : float    Of everything. [lx]
    shrink : float    Factor by which all densities were lowered to fit the pages. [-]
    seams : Seams
    balance : dict or None    Energy of the whole by the pilot from the lights, see `WitnessReport.balance`. [lm]
    shortfall : str    Empty, or what of the rule is not met because the bake was stopped: for people.
    """

    maps: tuple[LuxMap, ...]
    pages: tuple[AtlasPage, ...]
    departures: tuple[Departure, ...]
    files: tuple[str, ...]
    history: History
    relative_standard_error: float
    quadratic_relative_error: float
    mean: float
    shrink: float
    seams: Seams
    balance: dict | None = None
    shortfall: str = ""

    def lumels(self, number: int) -> "Values":
        """Values of the computed lumels of an object, by its number."""
        found = [(page, page.covered & (page.object == number)) for page in self.pages]
        return Values(
            *(
                np.concatenate([getattr(page, name)[mask] for page, mask in found])
                for name in ("illuminance", "standard_error", "area")
            )
        )


@dataclass(frozen=True)
class Values:
    """Lumels of one object in a row: (n,) each. [lx, lx, m2]"""

    illuminance: np.ndarray
    standard_error: np.ndarray
    area: np.ndarray


METHODS = ("auto", "cells", "paths")
SWITCH = ("auto", "on", "off")


def check_order(order: BakeOrder) -> None:
    """Raise a `SceneError` for an order that makes no sense."""
    for name, value, known in (
        ("method", order.method, METHODS),
        ("caustics", order.caustics, SWITCH),
    ):
        if value not in known:
            raise SceneError(f"{name} is '{value}', expected {', '.join(known)}")
    if not order.density > 0.0 or any(not value > 0.0 for value in order.densities.values()):
        raise SceneError("lumels per metre must be above 0")
    if order.largest < 16 or order.margin < 0 or order.pages < 0:
        raise SceneError(
            "pages need a side of 16 lumels at least, and margin and number of pages must not be negative"
        )
