"""Error over time: what was measured, and the forecasts that were made on the way."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Mark:
    """State after a pass.

    Parameters
    ----------
    seconds : float    Since the start of the bake, earlier parts of a resumed one included. [s]
    samples : float    Mean number per lumel.
    error : float    Relative standard error of everything. [-]
    forecast : float or None    Seconds from the start at which the rule will be met, as believed then. [s]
    """

    seconds: float
    samples: float
    error: float
    forecast: float | None


@dataclass(frozen=True)
class History:
    """Marks in order of time.

    Parameters
    ----------
    marks : tuple of Mark
    target : float or None    Relative error that was asked for, None where the rule names none. [-]
    setup_seconds : float    Spent before the first samples. [s]
    end_error : float or None    Relative error at the time of the last forecast, as far as it is known. [-]
    """

    marks: tuple[Mark, ...] = ()
    target: float | None = None
    setup_seconds: float = 0.0
    end_error: float | None = None
