"""All that a layer of a bake needs to go on, and whether it is to end."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..accuracy.forecast import Forecaster
from ..accuracy.replicates import ReplicateSums
from ..accuracy.stopping import StopRule
from ..transport.lux_maps.levels import Levels
from ..transport.lux_maps.losses import Losses

FEWEST_PASSES = 2
"""From which an error can be told; then the others are planned anew."""

SMALLEST_TIME_SHARE = 0.02
"""Part of a bake's time that is not worth another pass."""


@dataclass
class Ending:
    """Whether work is to end: a cancel counts at once, a stop as soon as there is a result with an error.

    Parameters
    ----------
    cancelled, stopped : callable
    has_result : bool
    """

    cancelled: Callable[[], bool]
    stopped: Callable[[], bool] = lambda: False
    has_result: bool = False

    def __call__(self) -> bool:
        """Whether the present pass is given up."""
        return self.cancelled() or self.is_stopped

    @property
    def is_stopped(self) -> bool:
        """Whether what there is is wanted."""
        return self.has_result and self.stopped()


@dataclass
class LayerState:
    """All that a layer needs to go on.

    Parameters
    ----------
    sums : ReplicateSums
    levels : Levels    Of the passes to come.
    passes : int    Made so far.
    cells : dict of str to array
    forecaster : Forecaster
    bias_sums : (5, m) array
        By object, of what the cells add: number, sum, sum of squares, number of passes with some, and the sum over these
        of the square of their sum over their number. [-, lx, lx2, -, lx2]
    object_passes : (passes, 1 + m) array    Samples of every pass, and the mean that it gave each object. [-, lx]
    is_done : bool
    pilot : dict of str to array    State of the pilot until passes have shown what it could only guess; empty then.
    losses : Losses    Of all passes.
    """

    sums: ReplicateSums
    levels: Levels
    passes: int
    cells: dict[str, np.ndarray]
    forecaster: Forecaster
    bias_sums: np.ndarray
    object_passes: np.ndarray
    is_done: bool = False
    pilot: dict[str, np.ndarray] = field(default_factory=dict)
    losses: Losses = field(default_factory=Losses)

    def arrays(self, goes_on: bool = True) -> dict[str, np.ndarray]:
        """Everything as arrays. ``goes_on``: whether cells and pilot are wanted too, which only more passes need."""
        made = {f"sums.{name}": value for name, value in self.sums.state().items()}
        made |= {f"forecast.{name}": value for name, value in self.forecaster.state().items()}
        if goes_on:
            made |= {f"cells.{name}": value for name, value in self.cells.items()}
            made |= {f"pilot.{name}": value for name, value in self.pilot.items()}
        made |= {f"losses.{name}": value for name, value in self.losses.state().items()}
        made |= {"levels": self.levels.columns}
        made |= {"bias": self.bias_sums, "objects": self.object_passes}
        return made | {"state": np.array([self.passes, int(self.is_done)], dtype=np.int64)}

    @classmethod
    def from_arrays(cls, rule: StopRule, arrays: dict[str, np.ndarray]) -> "LayerState":
        """Read what `arrays` wrote."""

        def part(name: str) -> dict[str, np.ndarray]:
            head = f"{name}."
            return {key[len(head) :]: v for key, v in arrays.items() if key.startswith(head)}

        passes, is_done = arrays["state"].tolist()
        return cls(
            ReplicateSums.from_state(part("sums")),
            Levels(arrays["levels"]),
            passes,
            part("cells"),
            Forecaster.from_state(rule, part("forecast")),
            arrays["bias"],
            arrays["objects"],
            bool(is_done),
            part("pilot"),
            Losses(**part("losses")),
        )

    def join(self, other: "LayerState") -> None:
        """Take in passes of the same layer that owe nothing to these."""
        self.sums.join(other.sums)
        self.losses.join(other.losses)
        self.bias_sums = self.bias_sums + other.bias_sums
        self.object_passes = np.vstack([self.object_passes, other.object_passes])
        self.passes += other.passes

    def review(self) -> None:
        """Find anew whether the rule is met, which may be another one than before."""
        marks = self.forecaster.history.marks
        # Where there is no light, an error tells nothing.
        is_dark = self.is_done and not (marks and marks[-1].error < math.inf)
        self.is_done = self.sums.passes >= FEWEST_PASSES and (
            is_dark or self.forecaster.is_done() or self.is_out_of_time()
        )

    def is_out_of_time(self) -> bool:
        """Whether the time that is left is not worth another pass."""
        limit = self.forecaster.rule.seconds
        if limit is None:
            return False
        return limit - self.forecaster.history.marks[-1].seconds < SMALLEST_TIME_SHARE * limit
