"""Charts of a mesh for pictures that lie on it: every part of the surface has a place of its own on one page."""

import math
from dataclasses import dataclass, field

import numpy as np

from ..scene.mesh import Mesh
from .arrange import arrange
from .charts import ChartLimits, find_charts
from .texels import Texels, find_texels

SMALLEST, LARGEST = 64, 1024
"""Sides of the page that charts are laid on; pictures have a whole multiple of its texels. [texel]"""

ROOM = 16
"""Texels of a page's side for every chart along it."""

FILLED = 0.7
"""Share of the page that the charts are to fill at first. [-]"""

MARGIN = 2
"""Texels about a chart that belong to no other."""

CONE = 1.0
"""Largest angle between a chart's direction and its triangles. [rad]"""


@dataclass(frozen=True, eq=False)
class PictureCharts:
    """Where triangles lie on a page.

    Parameters
    ----------
    uv : (t, 3, 2) float64 array    v upwards. [texel]
    width, height : int    Of the page. [texel]
    """

    uv: np.ndarray
    width: int
    height: int
    _kept: dict[int, Texels] = field(default_factory=dict)

    @property
    def texture_coordinates(self) -> np.ndarray:
        """Places on the page, 0..1. (t, 3, 2) float32"""
        return (self.uv / (self.width, self.height)).astype(np.float32)

    def forget(self) -> None:
        """Give up all texels, and what was worked out at them; they are found anew when they are asked for."""
        self._kept.clear()

    def texels(self, factor: int) -> Texels:
        """Return the texels of a picture with ``factor`` times the page's texels along each side.

        Of those that are finer than the page only the latest are kept.
        """
        if factor not in self._kept:
            for other in [each for each in self._kept if each > 1]:
                del self._kept[other]
            made = find_texels(self.uv * factor, self.width * factor, self.height * factor)
            self._kept[factor] = made
        return self._kept[factor]


def lay_charts(mesh: Mesh) -> PictureCharts | None:
    """Lay the charts of a mesh on a page; None if it has no area. No polygon is cut.

    Raises
    ------
    SceneError    A triangle names a vertex that is not there, or a vertex lies nowhere.
    """
    area = float(mesh.areas().sum())
    if not area > 0.0:
        return None
    density = math.sqrt(FILLED * SMALLEST**2 / area)
    charts = find_charts(mesh, cone=CONE, density=density, limits=ChartLimits(faces=0))
    wanted = ROOM * math.sqrt(max(len(charts.size), 1))
    side = int(np.clip(2 ** math.ceil(math.log2(wanted)), SMALLEST, LARGEST))
    density = math.sqrt(FILLED * side**2 / area)
    atlas = arrange([mesh], [charts], [density], largest=side, pages=1, margin=MARGIN)
    width, height = (int(each) for each in atlas.sizes[0])
    return PictureCharts(atlas.layouts[0].uv, width, height)
