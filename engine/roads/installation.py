"""Straight roads with equal luminaires in rows: where luminaires, points of the road and drivers' eyes are.

x runs along the road the way that drivers go, y to their left from the right edge of the carriageway, z up. [m]
"""

import math
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError

ARRANGEMENTS = ("right", "left", "opposite", "staggered", "middle")
"""Rows of luminaires: at one edge, at both side by side or in turn, over the middle of the carriageway."""

BEYOND = 12.0
"""How far luminaires count, in mounting heights; tables end there. (EN 13201-3, 8.4)"""

FARTHEST = 500.0
"""Distance up to which luminaires dazzle. [m] (EN 13201-3, 8.5)"""

NEAR_SPACING, LEAST_COUNT, LARGEST_STEP = 30.0, 10, 3.0
"""Up to this spacing of luminaires [m] a field has so many points along the road; beyond, none are farther apart. [m]"""

ACROSS = 3
"""Points across a lane."""

EYE = 1.5
"""Height of a driver's eye above the road. [m]"""

DRIVER = 60.0
"""Distance of the driver who looks at the field from its beginning. [m]"""

ROOF = math.radians(20.0)
"""Above this slope the roof of the car hides luminaires. [rad]"""

LIMITS = {
    "width": (1.0, 100.0, "m"),
    "lanes": (1, 12, ""),
    "spacing": (2.0, 200.0, "m"),
    "height": (2.0, 60.0, "m"),
    "overhang": (-50.0, 50.0, "m"),
    "tilt": (-90.0, 90.0, "degrees"),
    "turn": (-360.0, 360.0, "degrees"),
}
"""Least and largest values of a road, with their units."""


@dataclass(frozen=True)
class Road:
    """A carriageway and the rows of luminaires along it.

    Parameters
    ----------
    width : float    Of the carriageway. [m]
    lanes : int    Of equal widths.
    spacing : float    Of the luminaires of a row. [m]
    height : float    Of their photometric centres over the road. [m]
    arrangement : str    One of `ARRANGEMENTS`.
    overhang : float    Of the photometric centres over the carriageway, below 0 beside it. [m]
    tilt : float    By which the side towards the road is lifted. [degree]
    turn : float    About the vertical, counter-clockwise seen from above; 0: C0 along the road, C90 across it. [degree]
    """

    width: float
    lanes: int
    spacing: float
    height: float
    arrangement: str = "right"
    overhang: float = 0.0
    tilt: float = 0.0
    turn: float = 0.0

    def __post_init__(self):
        """Refuse what is no road.

        Raises
        ------
        SceneError    It names the value and what was expected.
        """
        for name, (least, most, unit) in LIMITS.items():
            value = getattr(self, name)
            if not least <= value <= most:
                words = f"{least:g} to {most:g} {unit}".strip()
                raise SceneError(f"the road's {name} is {value:g}, expected {words}")
        if self.arrangement not in ARRANGEMENTS:
            raise SceneError(
                f"the luminaires stand '{self.arrangement}', expected {', '.join(ARRANGEMENTS)}"
            )

    @property
    def lane_width(self) -> float:
        """Of each lane. [m]"""
        return self.width / self.lanes

    @property
    def lane_middles(self) -> np.ndarray:
        """Places of the middles of the lanes across the road. (lanes,) [m]"""
        return self.lane_width * (np.arange(self.lanes) + 0.5)

    @property
    def stations(self) -> np.ndarray:
        """Places of the points of the field along the road. (n,) [m]

        The field lies between two luminaires of a row. (EN 13201-3, 8.2)
        """
        if self.spacing <= NEAR_SPACING:
            count = LEAST_COUNT
        else:
            count = math.ceil(self.spacing / LARGEST_STEP - 1e-9)
        return self.spacing * (np.arange(count) + 0.5) / count

    def grid(self, low: float = 0.0, high: float | None = None, count: int | None = None):
        """Points of the road between two places across it, by station and across. (n, count, 3) [m]

        Without arguments: those of the field, `ACROSS` on each lane, from the right edge on.
        """
        high = self.width if high is None else high
        count = ACROSS * self.lanes if count is None else count
        across = low + (high - low) * (np.arange(count) + 0.5) / count
        x, y = np.meshgrid(self.stations, across, indexing="ij")
        return np.stack([x, y, np.zeros_like(x)], axis=-1)

    def luminaires(self) -> tuple[np.ndarray, np.ndarray]:
        """Photometric centres (k, 3) [m] and axes (k, 3, 3, columns) of all luminaires that may count."""
        reach = max(BEYOND * self.height, FARTHEST) + self.spacing
        count = math.ceil(reach / self.spacing)
        numbers = np.arange(-count, count + 1)
        places, axes = [], []
        for side, shift in _ROWS[self.arrangement]:
            x = self.spacing * (numbers + shift)
            y = {
                "right": self.overhang,
                "left": self.width - self.overhang,
                "middle": 0.5 * self.width + self.overhang,
            }[side]
            places.append(np.column_stack([x, np.full_like(x, y), np.full_like(x, self.height)]))
            axes.append(np.broadcast_to(self._axes(side == "left"), (len(x), 3, 3)))
        return np.concatenate(places), np.concatenate(axes)

    def _axes(self, is_left: bool) -> np.ndarray:
        tilt, turn = math.radians(self.tilt), math.radians(self.turn + 180.0 * is_left)
        lifted = np.array(
            [
                [1.0, 0.0, 0.0],
                [0.0, math.cos(tilt), -math.sin(tilt)],
                [0.0, math.sin(tilt), math.cos(tilt)],
            ]
        )
        about = np.array(
            [
                [math.cos(turn), -math.sin(turn), 0.0],
                [math.sin(turn), math.cos(turn), 0.0],
                [0.0, 0.0, 1.0],
            ]
        )
        return about @ lifted


_ROWS = {
    "right": (("right", 0.0),),
    "left": (("left", 0.0),),
    "opposite": (("right", 0.0), ("left", 0.0)),
    "staggered": (("right", 0.0), ("left", 0.5)),
    "middle": (("middle", 0.0),),
}
"""Rows of each arrangement: the side, and by what part of the spacing it is shifted."""
