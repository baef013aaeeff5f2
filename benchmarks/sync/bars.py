"""What the times have to be, and whether they are."""

from dataclasses import dataclass
from statistics import median

from ..common import bars as common
from .edits import OBJECTS, PARAMETERS

PARAMETER_SHARE = 0.02
"""Most that an edit of a parameter may take of a full sync of the largest scene."""

OBJECT_SHARE = 0.03
"""Most that an edit of one object may take, from the second time on."""

FIRST_SHARE = 1.10
"""Most that the first edit of an object may take."""

GROWTH = 1.5
"""Most that an edit may grow from the smallest scene to the largest and still count as independent of the size."""

COLUMNS = ("demand", "edit", "limit", "measured", "verdict")
"""Of the table of all bars."""


@dataclass(frozen=True)
class Bar(common.Bar):
    """A demand on an edit."""

    edit: str


def check_bars(
    result: dict, small: str = "10k", large: str = "3M", objects: int = 1000
) -> list[Bar]:
    """Judge results of `sync.run` by all bars."""
    bars = [
        _check_share(result, edit, large, count) for count in _counts(result) for edit in PARAMETERS
    ]
    bars += [
        _check_growth(result, edit, small, large, n) for n in _counts(result) for edit in PARAMETERS
    ]
    for edit in OBJECTS:
        title, rows = f"{edit}, {large}, {objects} objects", _rows(result, edit, large, objects)
        first = [row["ratio"] for row in rows if row["nth"] == 1]
        later = [row["ratio"] for row in rows if row["nth"] > 1]
        bars.append(
            _compare(
                "one object, nth >= 2", title, median(later) if later else None, OBJECT_SHARE, later
            )
        )
        bars.append(
            _compare("one object, nth = 1", title, first[0] if first else None, FIRST_SHARE)
        )
    bars += [_check_silence(result, edit) for edit in ("rename", "select")]
    return bars


def _counts(result) -> list[int]:
    return sorted({row["objects"] for row in result["edits"]})


def _rows(result, edit: str, scene: str, objects: int) -> list[dict]:
    return [
        row
        for row in result["edits"]
        if (row["edit"], row["scene"], row["objects"]) == (edit, scene, objects)
    ]


def _compare(demand: str, title: str, value: float | None, limit: float, spread=()) -> Bar:
    if value is None:
        return Bar(demand, f"{100 * limit:.0f} %", "-", None, title)
    measured = f"{100 * value:.1f} %"
    if spread:
        measured += f" ({100 * min(spread):.1f} to {100 * max(spread):.1f} %)"
    return Bar(demand, f"{100 * limit:.0f} %", measured, value <= limit, title)


def _check_share(result, edit: str, scene: str, objects: int) -> Bar:
    ratios = [row["ratio"] for row in _rows(result, edit, scene, objects)]
    value = median(ratios) if ratios else None
    title = f"{edit}, {scene}, {objects} objects"
    return _compare("parameter", title, value, PARAMETER_SHARE, ratios)


def _check_growth(result, edit: str, small: str, large: str, objects: int) -> Bar:
    """Compare scenes by what is not chance: without the wait for the end of the engine's slice."""
    demand, title = "independent of triangles", f"{edit}, {small} to {large}, {objects} objects"
    low, high = (_rows(result, edit, scene, objects) for scene in (small, large))
    if not low or not high:
        return Bar(demand, f"x {GROWTH}", "-", None, title)
    (work_low, rest_low), (work_high, rest_high) = _work_and_rest(low), _work_and_rest(high)
    growth = work_high / work_low
    measured = f"x {growth:.2f} ({work_low:.0f} to {work_high:.0f} ms; rest {rest_low:.0f} and {rest_high:.0f} ms)"
    return Bar(demand, f"x {GROWTH}", measured, growth <= GROWTH, title)


def _work_and_rest(rows) -> tuple[float, float]:
    """Median time of all parts but the rest, and of the rest. [ms]"""
    work = median(row["seconds"] - row["parts"]["rest"] for row in rows)
    return 1e3 * work, 1e3 * median(row["parts"]["rest"] for row in rows)


def _check_silence(result, edit: str) -> Bar:
    sent = [row["sent"] for row in result["edits"] if row["edit"] == edit]
    passed = not any(sent) if sent else None
    measured = f"{max(sent)} items in {len(sent)} edits" if sent else "-"
    return Bar("nothing is sent", "0 items", measured, passed, f"{edit}, all scenes")
