"""Tables and numbers as the report writes them."""

from collections.abc import Iterable, Sequence

import numpy as np

from .published import Published
from .reference import Group
from .runner import Run
from .verdict import Verdict, is_nought

OURS = "Lumenray"

PICTURES = "pictures"
"""Folder of the pictures, inside the report's."""

OUTCOME = "validation.json"


def groups_of(run: Run, case: str) -> dict[str, Group]:
    """Groups of a case that were asked for, by id."""
    return {key: group for key, group in run.groups.items() if group.case == case}


def tell_errors(verdicts: Sequence[Verdict]) -> tuple[str, str]:
    """Largest and root mean square relative error of groups in percent."""
    relative = np.concatenate([v.relative for v in verdicts]) if verdicts else np.zeros(0)
    relative = relative[~np.isnan(relative)]
    if not relative.size:
        return "–", "–"
    return (
        plain_percent(float(np.abs(relative).max())),
        plain_percent(float(np.sqrt((relative**2).mean()))),
    )


def table_results(published: Published, results, ours: dict[str, float] | None = None) -> str:
    """Published results with their sources; ``ours``: a column of our largest errors by CIE section. [-]"""
    rows = []
    used = []
    for result in results:
        if result.source not in used:
            used.append(result.source)
        row = (
            result.test,
            result.subject,
            result.program + (f" ({result.year})" if result.year else ""),
            "–" if result.largest is None else plain_percent(result.largest),
            "–" if result.mean is None else plain_percent(result.mean),
            result.remark or "",
            result.source,
        )
        if ours is not None:
            mine = ours.get(result.test)
            row = (*row[:5], "–" if mine is None else plain_percent(mine), *row[5:])
        rows.append(row)
    columns = ["test", "subject", "program", "largest %", "mean %", "remark", "source"]
    if ours is not None:
        columns.insert(5, f"{OURS}, largest %")
    sources = "; ".join(f"{key}: {published.sources[key]}" for key in used)
    return f"{lay_table(columns, rows)}\n\nSources. {sources}."


def lay_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Markdown table."""
    lines = [f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    lines += [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join(lines)


def escape(text: str) -> str:
    """Text without meaning for Markdown."""
    return text.replace("|", "\\|").replace("*", "\\*")


def tell_number(value: float, digits: int = 5) -> str:
    """Significant digits, without an exponent where that is readable."""
    value = float(value)
    if not np.isfinite(value):
        return "no number"
    if value == 0.0:
        return "0"
    size = np.floor(np.log10(abs(value)))
    if -4 <= size < 7:
        return f"{value:.{max(int(digits - 1 - size), 0)}f}"
    return f"{value:.{digits}g}"


def tell_vector(vector: np.ndarray) -> str:
    """Components in brackets, or a dash where there are none."""
    if not np.isfinite(vector).all():
        return "–"
    return f"({', '.join(f'{x:.9g}' for x in np.round(vector, 6) + 0.0)})"


def tell_percent(share: float) -> str:
    """Percent with the sign for it."""
    return f"{100.0 * share:g} %"


def plain_percent(share: float) -> str:
    """Percent with three decimals."""
    return f"{100.0 * share:.3f}" if np.isfinite(share) else "no number"


def signed_percent(share: float) -> str:
    """Percent with three decimals and plus or minus."""
    return f"{100.0 * share:+.3f}" if np.isfinite(share) else "no number"


def tell_part(size: float, of: float, is_nought: bool, signed: bool = False) -> str:
    """A difference in percent of a value, or as it is where the value is nought."""
    if is_nought:
        return f"{size:{'+' if signed else ''}.2g} abs."
    share = size / abs(of)
    return signed_percent(share) if signed else plain_percent(share)


def largest_share(errors: np.ndarray, group: Group) -> str:
    """Largest standard error of a group in percent of its value."""
    sized = ~is_nought(group)
    if not sized.any():
        return "–"
    return plain_percent(float((errors[sized] / np.abs(group.values[sized])).max()))


def cut_percent(share: float) -> str:
    """Percent, cut and not rounded: 100 % means all."""
    return f"{np.floor(share * 1e4 + 1e-7) / 100.0:.2f} %"


def tell_clause(clause: str) -> str:
    """Section of CIE 171:2006; its chapter 6 suggests tests."""
    return f"{clause} (suggested)" if clause == "6" else clause


def tell_duration(seconds: float) -> str:
    """Time in words."""
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    if seconds < 3600.0:
        return f"{int(seconds // 60)} min {int(seconds % 60)} s"
    return f"{int(seconds // 3600)} h {int(seconds % 3600 // 60)} min"


def shorten_cases(keys: list[str]) -> list[str]:
    """Shorten runs of case numbers: C01 to C04."""
    numbers = [int(key[1:]) for key in keys]
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return [
        f"C{run[0]:02d} to C{run[-1]:02d}" if len(run) > 1 else f"C{run[0]:02d}" for run in runs
    ]
