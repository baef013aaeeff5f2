"""What the benchmark of luminaires has to show, and whether it does."""

from ..common.bars import Bar
from . import agreement as luminaire_agreement
from . import speed as luminaire_speed
from . import variance as luminaire_variance

FEWEST_FILES = 20
"""Fewest files that have to be compared with Radiance."""


def check_bars(result: dict) -> list[Bar]:
    """Judge results of `luminaires.run`."""
    return [
        *_check_agreement(result["agreement"]),
        *_check_speed(result["speed"]),
        *_check_noise(result["noise"]),
    ]


def _check_agreement(agreement: dict) -> list[Bar]:
    files, bound = agreement["files"], luminaire_agreement.BOUND
    limit = f"{100 * bound:.1f} %"
    alike = [row["max"] for row in files if not row["reason"]]
    cured = [row["without_reason"] for row in files if row["reason"]]
    return [
        Bar(
            "files compared with Radiance",
            f"{FEWEST_FILES}",
            f"{len(files)}",
            len(files) >= FEWEST_FILES,
        ),
        _most("where Radiance interpolates alike, largest deviation", limit, alike, bound),
        _most("where it does not, with the reason taken away", limit, cured, bound),
    ]


def _most(demand: str, limit: str, values: list[float], bound: float) -> Bar:
    if not values:
        return Bar(demand, limit, "-", None)
    return Bar(
        demand, limit, f"{100 * max(values):.3f} % ({len(values)} files)", max(values) <= bound
    )


def _check_speed(rows: list[dict]) -> list[Bar]:
    made = []
    for way, what in luminaire_speed.WAYS.items():
        if way in {"vectorised", "one thread"}:
            continue
        found = [
            row["rates"]["vectorised"] / row["rates"][way] for row in rows if row["rates"][way]
        ]
        demand = f"vectorised over {way} ({what})"
        limit = f"x {luminaire_speed.BOUND:g}"
        if not found:
            made.append(Bar(demand, limit, "-", None))
            continue
        measured = f"x {luminaire_speed.times(min(found))} to {luminaire_speed.times(max(found))}"
        made.append(Bar(demand, limit, measured, min(found) > luminaire_speed.BOUND))
    return made


def _check_noise(rows: list[dict]) -> list[Bar]:
    bound = luminaire_variance.BOUND
    made = []
    for title in dict.fromkeys(row["title"] for row in rows):
        mine = [row for row in rows if row["title"] == title]
        worst = max(mine, key=lambda row: row["ratio"])
        measured = f"{worst['ratio']:.3f} ± {worst['error']:.3f} ({worst['opening']})"
        # Within its error a ratio cannot be told from the bound.
        passed = worst["ratio"] <= bound + 2.0 * worst["error"]
        made.append(Bar(f"variance over ideal, {title}", f"{bound:g}", measured, passed))
    return made
