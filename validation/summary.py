"""The first page of the report: what was run, what came of it, and what others got."""

from collections.abc import Iterable

import numpy as np

from .cells import (
    OURS,
    OUTCOME,
    PICTURES,
    cut_percent,
    groups_of,
    lay_table,
    shorten_cases,
    signed_percent,
    table_results,
    tell_clause,
    tell_duration,
    tell_errors,
    tell_percent,
)
from .charts import family_of
from .determinism import CHI_SQUARE_RANGE, LEAST_VALUES
from .outcome import summarise, summarise_peer
from .published import PrintedTable, Published
from .reference import load_groups
from .runner import Run, choose_cases
from .texts import TEXTS
from .verdict import BANDS, BIAS_SHARE, CLASS_TOLERANCES

CLASS_USES = {
    "X": "exact evaluation: point sources, arithmetic",
    "A": "unshadowed area sources, tabulated photometry, transmittance, colorimetry",
    "B": "sky components, one reflection, partial visibility",
    "C": "multiple interreflection",
    "D": "points close to an edge of an opening, half shadows, grazing light through glass",
    "Z": "must vanish within an absolute value",
}
"""What each tolerance class is for."""


def compose_summary(run: Run, published: Published) -> str:
    """Text of the summary."""
    return "\n\n".join(
        part
        for part in [
            "# Validation report",
            "*Made by `lumenray validate`; do not edit by hand.*",
            _state_verdict(run),
            "## What was run",
            _describe_run(run),
            "## Result",
            _compose_result(run, published),
            "## Cases",
            _compose_cases(run),
            *_compose_failures(run),
            *_compose_peers(run),
            "## Beside published results",
            _compose_published(run, published),
            "## Seeds",
            _compose_seeds(run),
            "## How values are judged",
            _describe_rules(),
        ]
        if part
    )


def _state_verdict(run: Run) -> str:
    counts = summarise(run.groups, run.engine)
    done = (
        f"{OURS} {run.version} was compared with {counts.values} independent reference values in {counts.groups} groups "
        f"of {len(run.cases)} cases. "
    )
    if run.failed:
        passing = counts.groups - len(run.failed)
        verdict = f"**{len(run.failed)} of {counts.groups} groups FAIL**, {passing} pass."
    else:
        verdict = "**Every scored group passes.**"
    shares = (
        f" {cut_percent(counts.share(counts.inside))} of the values are inside their tolerance, "
        f"{cut_percent(counts.share(counts.within[1]))} less than 1 % off or inside a tolerance that is wider, "
        f"{cut_percent(counts.share(counts.bands[1]))} less than 1 % off whatever their tolerance."
    )
    part = ""
    if _is_part(run):
        part = "\n\nThis run is a part of the suite and does not replace the whole."
    return done + verdict + shares + part


def _describe_run(run: Run) -> str:
    machine = run.machine
    informative = sum(group.is_informative for group in run.groups.values())
    rows = [
        ("program", f"{OURS} {run.version}"),
        ("cases", f"{len(run.cases)}: {', '.join(shorten_cases(list(run.cases)))}"),
        (
            "groups",
            f"{len(run.groups)}, of which {informative} informative (reported, not scored)",
        ),
        ("subset", "quick" if run.is_quick else "all groups of these cases"),
        ("seed", str(run.seed)),
        (
            "standard error",
            "a third of each tolerance or less"
            + (f", and {tell_percent(run.error)} of the value or less" if run.error else ""),
        ),
        (
            "machine",
            f"{machine['cpu']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}",
        ),
        ("software", f"Python {machine['python']}, Mitsuba {machine['mitsuba']}"),
        (
            "time",
            f"{tell_duration(run.seconds)}, of which {tell_duration(run.engine.seconds)} for {OURS}'s values",
        ),
        ("peers", ", ".join(run.peers) or "none asked"),
        ("every value", f"[{OUTCOME}]({OUTCOME})"),
        ("to repeat it", f"`{_command(run)}`"),
    ]
    return lay_table(("", ""), rows)


def _command(run: Run) -> str:
    """The command that makes the same run."""
    words = ["lumenray validate"]
    whole = set(run.cases) == set(choose_cases(is_quick=run.is_quick))
    words += [] if whole else [f"--family {','.join(run.cases)}"]
    words += [f"--error {run.error:g}"] if run.error else []
    words += ["--peers"] if run.peers else []
    words += ["--quick"] if run.is_quick else []
    return " ".join([*words, f"--seed {run.seed}"])


def _is_part(run: Run) -> bool:
    """Whether the run leaves out groups of the suite."""
    return set(run.groups) != set(load_groups())


def share_bands(run: Run, published: Published) -> dict[str, dict[int, float]]:
    """Shares of the values below each error, by program."""
    counts = summarise(run.groups, run.engine)
    series = {
        f"{OURS}, all {counts.values} scored values": {
            band: counts.share(count) for band, count in counts.bands.items()
        }
    }
    printed, total = _printed_bands(run, published)
    if total:
        series[f"{OURS}, {total} points of the printed CIE tables"] = printed
    series[f"reference system, {published.values} values of the CIE list"] = published.bands
    for name, peer in run.peers.items():
        counts = summarise_peer(run.groups, peer)
        if counts.values:
            series[f"{name}, this run, {counts.values} values that it could be asked for"] = {
                band: counts.share(count) for band, count in counts.bands.items()
            }
    return series


def _printed_bands(run: Run, published: Published) -> tuple[dict[int, float], int]:
    """Our shares over the points that the printed tables list, against the exact values; and how many these are."""
    hits, total = dict.fromkeys(BANDS, 0), 0
    for key, group in run.groups.items():
        printed = published.printed(key)
        chosen = np.array([label in printed for label in group.labels], dtype=bool)
        total += int(chosen.sum())
        if key in run.engine.verdicts:
            for band in BANDS:
                hits[band] += int(run.engine.verdicts[key].within(band)[chosen].sum())
    return {band: count / total if total else 1.0 for band, count in hits.items()}, total


def _compose_result(run: Run, published: Published) -> str:
    rows = [
        (name, *(cut_percent(shares[band]) for band in BANDS))
        for name, shares in share_bands(run, published).items()
    ]
    table = lay_table(("share of values", *(f"< {band} % off" for band in BANDS)), rows)
    return (
        f"![Shares of values by relative error]({PICTURES}/bands.png)\n\n{table}\n\n"
        "The bands count every value by its relative error, whatever its tolerance; a reference that its own "
        "tolerance does not tell from 0 counts when inside that. The reference system was judged by its makers "
        "on another, shorter list; the second row is the nearest to it."
    )


def _compose_cases(run: Run) -> str:
    rows = []
    for key, case in run.cases.items():
        groups = groups_of(run, key)
        scored = {k: g for k, g in groups.items() if not g.is_informative}
        counts = summarise(scored, run.engine)
        verdicts = [run.engine.verdicts[k] for k in scored if k in run.engine.verdicts]
        rows.append(
            (
                _thumbnail(run, key),
                f"[**{key}**]({key}.md) {case.title}",
                tell_clause(TEXTS[key].clause) or "–",
                str(counts.groups),
                str(counts.values),
                *tell_errors(verdicts),
                f"{max((v.used for v in verdicts), default=0.0):.2f}" if verdicts else "–",
                f"**{len(counts.failed)} FAIL**" if counts.failed else "pass",
            )
        )
    columns = (
        "",
        "case",
        "CIE 171",
        "groups",
        "values",
        "largest error %",
        "RMS error %",
        "tolerance used",
        "verdict",
    )
    return (
        lay_table(columns, rows)
        + "\n\nTolerance used: the largest part of its tolerance that the error of a value takes."
    )


def _thumbnail(run: Run, case: str) -> str:
    if case not in run.setups:
        return ""
    return f'<a href="{case}.md"><img src="{PICTURES}/{case}.png" width="120" alt="{case}"></a>'


def _compose_failures(run: Run) -> list[str]:
    if not run.failed:
        return []
    lines = []
    for key in run.failed:
        verdict = run.engine.verdicts.get(key)
        told = verdict.sentence if verdict else f"{key}: {run.engine.missing[key]}."
        lines.append(f"- [{run.groups[key].case}]({run.groups[key].case}.md) {told}")
    return ["## Groups that fail", "\n".join(lines)]


def _compose_peers(run: Run) -> list[str]:
    if not run.peers:
        return []
    columns = ["case", OURS, "", ""]
    under = ["", "values", "largest %", "RMS %"]
    for name in run.peers:
        columns += [name, "", ""]
        under += ["values", "largest %", "RMS %"]
    rows = [tuple(under)]
    for case in run.cases:
        row = [f"[{case}]({case}.md)"]
        for answer in (run.engine, *run.peers.values()):
            scored = [
                v
                for k, v in answer.verdicts.items()
                if v.group.case == case and not v.group.is_informative
            ]
            row += [
                str(sum(v.inside.size for v in scored)) if scored else "–",
                *tell_errors(scored),
            ]
        rows.append(tuple(row))
    parts = [
        "## Beside other programs in the same run",
        "The same scenes, sensors and reference values went to the other programs on the same machine, with settings "
        "for accuracy and a limited effort, so that their errors hold noise as well as bias. Numbers of values differ "
        "where a program has no means to state a case.",
        lay_table(columns, rows),
    ]
    for name, peer in run.peers.items():
        reasons: dict[str, list[str]] = {}
        for key, reason in peer.missing.items():
            reasons.setdefault(reason, []).append(key)
        if not reasons:
            continue
        rows = [
            (", ".join(_families(keys)), str(len(keys)), reason) for reason, keys in reasons.items()
        ]
        parts.append(f"What {name} could not be asked for:")
        parts.append(lay_table(("groups", "number", "reason"), rows))
    return parts


def largest_by_clause(run: Run) -> dict[str, float]:
    """Our largest relative error over the scored values of the cases of each CIE section. [-]"""
    largest: dict[str, float] = {}
    for key, verdict in run.engine.verdicts.items():
        clause = TEXTS[run.groups[key].case].clause
        if clause.startswith("5.") and verdict.is_scored:
            largest[clause] = max(largest.get(clause, 0.0), verdict.largest)
    return dict(sorted(largest.items(), key=lambda item: int(item[0].partition(".")[2])))


def _compose_published(run: Run, published: Published) -> str:
    ours = largest_by_clause(run)
    parts = []
    if ours:
        parts.append(f"![Largest errors by CIE test]({PICTURES}/published.png)")
        parts.append(
            "Largest relative error on each test of CIE 171:2006, as published, and ours over all scored values of the "
            "cases with the same subject; ours include points, skies and variants beyond the printed list. Published "
            "figures are relative to the printed tables, of which some are in error (below)."
        )
    parts.append(table_results(published, published.results, ours))
    parts.append("### The printed tables")
    parts.append(published.remark)
    rows = [_compare_printed(table) for table in published.tables]
    parts.append(
        lay_table(
            (
                "table",
                "points",
                "largest difference from the exact value",
                "at",
                "points more than 1 % and more than the rounding off",
            ),
            rows,
        )
    )
    return "\n\n".join(parts)


def _compare_printed(table: PrintedTable) -> tuple[str, ...]:
    """How far a printed table is from the exact values."""
    groups = load_groups()
    count, off, worst, place = 0, 0, 0.0, ""
    for key, row in table.rows.items():
        exact = dict(zip(groups[key].labels, groups[key].values, strict=True))
        for label, value in row.items():
            count += 1
            if exact[label] == 0.0:
                continue
            relative = value / exact[label] - 1.0
            is_rounding = abs(value - exact[label]) <= table.rounding * (1.0 + 1e-9)
            off += abs(relative) > 0.01 and not is_rounding
            if not is_rounding and abs(relative) > abs(worst):
                worst, place = relative, f"`{key}` {label}"
    told = signed_percent(worst) + " %" if place else "within the rounding"
    return table.table, str(count), told, place, str(off)


def _compose_seeds(run: Run) -> str:
    if not run.determinism:
        return "No group with random values was repeated in this run."
    low, high = CHI_SQUARE_RANGE
    good = sum(check.passes for check in run.determinism)
    rows = [
        (
            f"`{check.group}`",
            "yes" if check.is_identical else "**NO**",
            "–" if check.chi_square is None else f"{check.chi_square:.2f}",
            str(check.degrees) if check.degrees else "–",
            "pass" if check.passes else "**FAIL**",
        )
        for check in run.determinism
    ]
    table = lay_table(
        (
            "group",
            "same seed, same numbers",
            "chi-square per degree of freedom",
            "degrees of freedom",
            "verdict",
        ),
        rows,
    )
    return (
        "With the same seed a group must give the same numbers to the last bit. With other seeds it must differ by as "
        f"much as its standard errors say: chi-square per degree of freedom between {low:g} and {high:g}, where the "
        f"group has at least {LEAST_VALUES} random values. {good} of {len(run.determinism)} groups pass.\n\n{table}"
    )


def _describe_rules() -> str:
    rows = [
        (key, "absolute only" if not share else f"{100.0 * share:g} %", CLASS_USES[key])
        for key, share in CLASS_TOLERANCES.items()
    ]
    table = lay_table(("class", "relative tolerance", "for"), rows)
    return (
        f"{table}\n\n"
        "1. A value passes when it differs from the reference by no more than the larger of the relative tolerance of "
        "its class and the absolute one stated with its group.\n"
        "2. The standard error of every value must be at most a third of its tolerance; noise is not added to the "
        "tolerance.\n"
        "3. In groups of five and more values other than 0 the mean signed relative error must be smaller than "
        f"{BIAS_SHARE:g} of the relative tolerance of the class, so that a program that is a little low everywhere "
        "fails.\n"
        "4. No limit of the product is changed for a case: no clamping, no number of reflections, no threshold.\n"
        "5. Informative groups are reported and not scored."
    )


def _families(keys: Iterable[str]) -> list[str]:
    return [f"`{name}`" for name in dict.fromkeys(family_of(key) for key in keys)]
