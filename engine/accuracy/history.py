"""Error over time: what was measured, and the forecasts that were made on the way."""

from dataclasses import dataclass, replace


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


def join_histories(histories: list[History]) -> History:
    """Histories one after the other; that of a single layer as it is."""
    if len(histories) == 1:
        return histories[0]
    marks, offset = [], 0.0
    for history in histories:
        marks += [
            replace(mark, seconds=mark.seconds + offset, forecast=None) for mark in history.marks
        ]
        offset = marks[-1].seconds if marks else offset
    return History(tuple(marks), histories[0].target, histories[0].setup_seconds)


def ended(history: History, error: float) -> History:
    """With what is stated in the end, where that is more than passes knew of. ``error``: relative. [-]"""
    last = history.marks[-1] if history.marks else None
    if last is None or not last.error * (1.0 + 1e-3) < error < float("inf"):
        return history
    return replace(history, marks=(*history.marks, replace(last, error=error, forecast=None)))
