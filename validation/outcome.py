"""The machine-readable outcome of a run: counts first, then every group and value."""

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path

from .reference import Group
from .runner import Answer, Run, failed_groups
from .verdict import BANDS

DEFINITIONS = {
    "values": "scored reference values that were asked for; one without an answer counts as outside everything",
    "within_1_percent": (
        "share of the values that are less than 1 % off, or inside their own tolerance where that is wider"
    ),
    "within_3_percent": "the same with 3 %",
    "bands": (
        "share of the values that are less than so many percent off, whatever their tolerance; "
        "a reference that its absolute tolerance does not tell from 0 counts when inside that"
    ),
    "inside_tolerance": "share of the values that are inside their own tolerance",
    "groups": "scored groups that were asked for",
    "groups_failed": "those that break a pass rule, or have no answer",
}
"""What the counts mean."""

POINT_COLUMNS = (
    "label",
    "reference",
    "value",
    "standard_error",
    "allowed",
    "relative_error",
    "inside",
)
"""Columns of a group's ``points``."""


@dataclass(frozen=True)
class Summary:
    """Counts over scored values and groups; what each means is told by `DEFINITIONS`.

    Parameters
    ----------
    values, groups : int
    within : dict of int    Values within so many percent, or inside their own tolerance where that is wider.
    bands : dict of int    Values within so many percent, whatever their tolerance.
    inside : int    Values inside their own tolerance.
    failed : tuple of str    Groups.
    """

    values: int
    groups: int
    within: dict[int, int]
    bands: dict[int, int]
    inside: int
    failed: tuple[str, ...]

    def share(self, count: int) -> float:
        """Part of all values, 0 to 1; 1 of none."""
        return count / self.values if self.values else 1.0


def summarise(groups: dict[str, Group], answer: Answer) -> Summary:
    """Count an instrument's scored values. Values that it has no answer for count as outside everything."""
    scored = {key: group for key, group in groups.items() if not group.is_informative}
    verdicts = [answer.verdicts[key] for key in scored if key in answer.verdicts]
    return Summary(
        values=sum(group.values.size for group in scored.values()),
        groups=len(scored),
        within={band: sum(int(v.within_or_inside(band).sum()) for v in verdicts) for band in BANDS},
        bands={band: sum(int(v.within(band).sum()) for v in verdicts) for band in BANDS},
        inside=sum(int(verdict.inside.sum()) for verdict in verdicts),
        failed=failed_groups(scored, answer),
    )


def summarise_peer(groups: dict[str, Group], answer: Answer) -> Summary:
    """Count a peer's scored values among those that it can be asked for."""
    return summarise({k: g for k, g in groups.items() if k in answer.verdicts}, answer)


def compose_outcome(run: Run) -> dict:
    """Put the outcome of a run together as plain data; numbers that are not finite become None.

    Returns
    -------
    dict
        ``values``, ``within_1_percent``, ``within_3_percent``, ``inside_tolerance``, ``groups``, ``groups_failed``,
        ``bands``, ``definitions``; ``cases``, ``is_quick``, ``seed``, ``error``, ``seconds``, ``version``, ``machine``;
        ``determinism``: list of checks; ``detail``: list of groups (``points`` as `POINT_COLUMNS` says);
        ``peers``: by name, the same counts over what they answered, ``groups_missing`` and ``detail``.
    """
    return _plain(
        {
            **_counts(summarise(run.groups, run.engine)),
            "definitions": DEFINITIONS,
            "cases": list(run.cases),
            "is_quick": run.is_quick,
            "seed": run.seed,
            "error": run.error,
            "seconds": round(run.seconds, 1),
            "version": run.version,
            "machine": run.machine,
            "determinism": [
                asdict(check) | {"passes": check.passes, "sentence": check.sentence}
                for check in run.determinism
            ],
            "point_columns": POINT_COLUMNS,
            "detail": _detail(run.groups, run.engine),
            "peers": {
                name: {
                    **_counts(summarise_peer(run.groups, peer)),
                    "groups_missing": peer.missing,
                    "seconds": round(peer.seconds, 1),
                    "detail": _detail(run.groups, peer),
                }
                for name, peer in run.peers.items()
            },
        }
    )


def tell(run: Run) -> str:
    """Table for a terminal: a row per family, one for all, one per peer, and what failed."""
    columns = ("", "groups", "failed", "values", "in class", *(f"< {band} %" for band in BANDS))
    rows = []
    for name in dict.fromkeys(case.family for case in run.cases.values()):
        groups = {k: g for k, g in run.groups.items() if run.cases[g.case].family == name}
        rows.append(_row(name, summarise(groups, run.engine)))
    rows.append(_row("all", summarise(run.groups, run.engine)))
    for name, peer in run.peers.items():
        rows.append(_row(name, summarise_peer(run.groups, peer)))
    widths = [max(len(row[i]) for row in [columns, *rows]) for i in range(len(columns))]
    lines = [
        "  ".join(
            text.ljust(width) if i == 0 else text.rjust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in [columns, *rows]
    ]
    lines.append("")
    for key in run.failed:
        verdict = run.engine.verdicts.get(key)
        lines.append(verdict.sentence if verdict else f"{key}: {run.engine.missing[key]}.")
    lines += [check.sentence for check in run.determinism if not check.passes]
    if not run.failed:
        lines.append("Every scored group passes.")
    return "\n".join(lines)


def _row(name: str, counts: Summary) -> tuple[str, ...]:
    shares = [counts.inside, *counts.bands.values()]
    return (
        name,
        str(counts.groups),
        str(len(counts.failed)),
        str(counts.values),
        *(f"{100.0 * counts.share(count):.1f} %" for count in shares),
    )


def write_outcome(outcome: dict, path: Path) -> Path:
    """Write an outcome as JSON, making its folder if need be."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(_lay_out(outcome) + "\n", encoding="utf-8")
    return path


def _counts(summary: Summary) -> dict:
    return {
        "values": summary.values,
        "within_1_percent": summary.share(summary.within[1]),
        "within_3_percent": summary.share(summary.within[3]),
        "inside_tolerance": summary.share(summary.inside),
        "groups": summary.groups,
        "groups_failed": list(summary.failed),
        "bands": {str(band): summary.share(count) for band, count in summary.bands.items()},
    }


def _detail(groups: dict[str, Group], answer: Answer) -> list[dict]:
    rows = []
    for key, group in groups.items():
        head = {
            "id": key,
            "case": group.case,
            "quantity": group.quantity,
            "unit": group.unit,
            "class": group.tolerance_class,
            "is_scored": not group.is_informative,
        }
        if key in answer.missing:
            rows.append({**head, "passes": False, "missing": answer.missing[key]})
            continue
        found, verdict = answer.findings[key], answer.verdicts[key]
        columns = (
            group.labels,
            group.values,
            found.values,
            found.errors,
            group.allowed,
            verdict.relative,
            verdict.inside,
        )
        rows.append(
            {
                **head,
                "passes": verdict.passes,
                "faults": verdict.faults,
                "largest_relative_error": verdict.largest,
                "mean_relative_error": verdict.mean,
                "mean_standard_error": verdict.mean_error,
                "rms_relative_error": verdict.rms,
                "tolerance_used": verdict.used,
                "seconds": round(found.seconds, 2),
                "points": [list(row) for row in zip(*columns, strict=True)],
            }
        )
    return rows


def _plain(item):
    """Data as JSON knows it."""
    if isinstance(item, dict):
        return {key: _plain(value) for key, value in item.items()}
    if isinstance(item, list | tuple):
        return [_plain(value) for value in item]
    if hasattr(item, "item"):
        item = item.item()
    if isinstance(item, float) and not math.isfinite(item):
        return None
    # Nine digits: more than any reference has.
    return float(f"{item:.9g}") if isinstance(item, float) else item


def _lay_out(item, depth: int = 0) -> str:
    """JSON text in which what holds only plain values takes one line, so that people can read it."""
    inner = list(item.values()) if isinstance(item, dict) else item
    if not isinstance(item, dict | list) or not any(isinstance(x, dict | list) for x in inner):
        return json.dumps(item, ensure_ascii=False, allow_nan=False)
    texts = [_lay_out(x, depth + 1) for x in inner]
    if isinstance(item, dict):
        texts = [f"{json.dumps(key)}: {text}" for key, text in zip(item, texts, strict=True)]
    opening, closing = "{}" if isinstance(item, dict) else "[]"
    rim = "\n" + " " * (depth + 1)
    return opening + rim + f",{rim}".join(texts) + rim[:-1] + closing
