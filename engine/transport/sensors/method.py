"""Whether sensors read cells: where their light takes less time to find than full paths, and is right within what is asked.

What cells are off by is known no better than by a few tenths of a per cent, so whoever asks for less gets full paths.
"""

import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.stopping import Clock, StopRule, excess_of
from ...errors import SceneError
from ..lux_maps.bands import TOLERANCE, interpolation_error

METHODS = ("auto", "cells", "paths")

FEWEST_PATHS = 1 << 22
"""Full paths still to go, of all sensors together, in about the time that finding the light of cells takes."""

FEWEST_SECONDS = 30.0
"""Time below which it would take too much of it. [s]"""

BUDGET = 0.003
"""What cells may be off by beyond chance, relative. [-]"""

HELD_SHARE = 0.7
"""Of the error that is asked for, most that may stand for what is not known of that; the rest is for the samples. [-]"""

LEAST_ERROR = 0.005
"""Error below which full paths are asked. [-]"""

FEWEST_SENSORS = 32
"""Fewer cannot tell what cells change without taking as long as full paths."""

BELIEVED = 1 << 10
"""Samples of a sensor by which is decided how many there will be."""

CELLS = "the light of matt surfaces is read from cells"
PATHS = "full paths"
"""Words for people."""


class Choice:
    """Decides between cells and full paths.

    Parameters
    ----------
    scene : CompiledScene    With its bright spots.
    rule : StopRule
    count : int    Sensors.
    method : str    One of `METHODS`.
    reflections : int or None    Most that light may have had.

    Attributes
    ----------
    uses_cells : bool or None    None: not before some paths have told what is needed, see `leaves`.
    reason : str    For people.
    paths : float    Full paths of all sensors that would be needed; 0 while it is not known.
    error : float    Relative error that a sensor will have; infinite while it is not known. [-]

    Raises
    ------
    SceneError    The method is none of the three.
    """

    def __init__(self, scene, rule: StopRule, count: int, method: str, reflections: int | None):
        if method not in METHODS:
            raise SceneError(f"method is '{method}', expected {' or '.join(METHODS)}")
        self.rule, self._count, self.paths, self.error = rule, count, 0.0, np.inf
        self.uses_cells, self.reason = self._begin(scene, method, reflections)

    def leaves(self, brightness: Estimate, clock: Clock) -> bool:
        """Whether cells are better than going on with paths, as `illuminance.compute` asks."""
        if self.uses_cells is not None or brightness.samples < BELIEVED:
            return False
        needed = clock.samples_needed
        if needed is None:
            needed = self._about_needed(brightness)
        if needed is not None:
            if (needed - brightness.samples) * self._count < FEWEST_PATHS:
                return False
            self.error = self._expected_error(brightness, needed)
            if self.error < LEAST_ERROR:
                self.uses_cells = False
                self.reason = f"an error below {100.0 * LEAST_ERROR:g} % is more than cells can promise: {PATHS}"
                return False
            self.paths = needed * self._count
        self.uses_cells, self.reason = True, f"{CELLS}; the bias is measured"
        return True

    @property
    def most_held(self) -> float:
        """Most that errors may hold for what cells are off by. [-]"""
        return HELD_SHARE * self.error

    def refuse(self, bias) -> None:
        """Take note that cells are off by more than is allowed, or may be. ``bias``: a `cell_job.Bias`."""
        self.uses_cells = False
        if bias.beyond > BUDGET:
            told = f"would be off by {100.0 * bias.beyond:.2g} %, more than the {100.0 * BUDGET:g} % allowed"
        else:
            told = (
                f"may be off by {100.0 * bias.held:.2g} % for all that could be told, too much of an error of "
                f"{100.0 * self.error:.2g} %"
            )
        self.reason = f"cells {told}: {PATHS}"

    # ---- private ----

    def _begin(self, scene, method: str, reflections) -> tuple[bool | None, str]:
        if method == "paths":
            return False, f"{PATHS} are asked for"
        if reflections is not None:
            return False, f"cells do not know how often light was reflected: {PATHS}"
        if method == "cells":
            return True, f"{CELLS}, as asked for"
        spectra = [] if not scene.requirements.spectral else scene.light_spectra
        error = interpolation_error(scene.mean_light, spectra)
        if error > TOLERANCE:
            return False, (
                f"the lights' spectra are so unlike that cells would be wrong by up to {100.0 * error:.2g} %: {PATHS}"
            )
        if self._count < FEWEST_SENSORS:
            return (
                False,
                f"there are so few sensors that the bias of cells could not be told: {PATHS}",
            )
        if scene.spots is not None:
            return False, f"small bright spots are aimed at: {PATHS}"
        if self.rule.seconds is not None and self.rule.seconds < FEWEST_SECONDS:
            return False, f"there is so little time that cells would not pay: {PATHS}"
        return None, f"so few are needed that cells would not pay: {PATHS}"

    def _about_needed(self, brightness: Estimate) -> float | None:
        """Samples of a sensor by errors of single ones, which the clock does not believe yet; None: no such end."""
        excess = excess_of(self.rule, brightness)
        return None if excess is None else brightness.samples * max(excess, 1.0) ** 2

    def _expected_error(self, brightness: Estimate, samples: float) -> float:
        """Least relative error of a sensor that is asked for, or that so many samples give. [-]"""
        rule, mean = self.rule, np.maximum(brightness.mean, 1e-30)
        asked = [each for each in (rule.error, rule.each) if each is not None]
        if rule.limits:
            asked.append(float((np.array(rule.limits) / mean).min()))
        if rule.samples is not None:
            fall = np.sqrt(brightness.samples / samples)
            asked = [max([brightness.relative_error() * fall, *asked])]
        return min(asked, default=np.inf)
