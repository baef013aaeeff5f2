"""How much light a luminaire gives, and every factor on the way from the file to it."""

import math
from dataclasses import dataclass

from ..errors import SceneError
from .formats.record import TiltTable

LAMP_STAYS_HORIZONTAL = 2
"""Lamp geometry of LM-63 TILT in which the position of the lamp does not follow the luminaire's tilt."""


@dataclass(frozen=True)
class Step:
    """One factor and what it makes of the flux.

    Parameters
    ----------
    label : str
    factor : float    [-]
    luminous_flux : float    After it. [lm]
    """

    label: str
    factor: float
    luminous_flux: float


@dataclass(frozen=True)
class Amount:
    """The luminous flux of a luminaire in a scene.

    Parameters
    ----------
    file_flux : float    Of the file's distribution. [lm]
    stated_flux : float or None    Flux of the whole luminaire that the user states in its place. [lm]
    lamp_factor : float    Lumens of the lamps in use over those of the file, at least 0. [-]
    tilt_factor : float    For the tilt of the luminaire, see `tilt_factor`; at least 0. [-]
    dimming, maintenance_factor : float    0 to 1. [-]

    Raises
    ------
    SceneError    A number is out of its range.
    """

    file_flux: float
    stated_flux: float | None = None
    lamp_factor: float = 1.0
    tilt_factor: float = 1.0
    dimming: float = 1.0
    maintenance_factor: float = 1.0

    def __post_init__(self):
        _check("the flux of the file", self.file_flux, math.inf)
        if self.stated_flux is not None:
            _check("the stated flux", self.stated_flux, math.inf)
        _check("the lamp factor", self.lamp_factor, math.inf)
        _check("the tilt factor", self.tilt_factor, math.inf)
        _check("the dimming", self.dimming, 1.0)
        _check("the maintenance factor", self.maintenance_factor, 1.0)

    @property
    def luminous_flux(self) -> float:
        """After all factors. [lm]"""
        return self.steps()[-1].luminous_flux

    def steps(self) -> list[Step]:
        """Return the flux that everything starts from, with a factor of 1, and the effect of each factor in turn."""
        if self.stated_flux is None:
            steps = [Step("Photometric file", 1.0, self.file_flux)]
        else:
            steps = [Step("Stated instead of the file's", 1.0, self.stated_flux)]
        for label, factor in (
            ("Lamp factor", self.lamp_factor),
            ("Tilt factor", self.tilt_factor),
            ("Dimming", self.dimming),
            ("Maintenance factor", self.maintenance_factor),
        ):
            steps.append(Step(label, factor, steps[-1].luminous_flux * factor))
        return steps


def _check(name: str, value: float, high: float) -> None:
    if not (math.isfinite(value) and 0.0 <= value <= high):
        expected = "a number of at least 0" if math.isinf(high) else f"a number from 0 to {high:g}"
        raise SceneError(f"{name} is {value:g}, expected {expected}")


def tilt_factor(table: TiltTable | None, tilt: float) -> float:
    """Factor on the flux of a luminaire tilted by an angle [degree], 1 without a table.

    A lamp that stays horizontal while the luminaire tilts burns as it was measured, so its table is not applied.
    """
    if table is None or table.geometry == LAMP_STAYS_HORIZONTAL:
        return 1.0
    return table.factor(tilt)
