"""The report of a run: a summary, a page per case, pictures and plots, and the outcome for machines."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from .canvas import save_picture
from .charts import draw_bands, draw_errors, draw_published, family_of
from .drawing import draw_setup, is_numbered
from .outcome import compose_outcome, summarise, summarise_peer, write_outcome
from .published import PrintedTable, Published, load_published
from .reference import Group, load_groups
from .runner import Run
from .texts import TEXTS
from .verdict import BANDS, BIAS_SHARE, CLASS_TOLERANCES, Verdict, is_nought

OURS = "Lumenray"

PICTURES = "pictures"
"""Folder of the pictures, inside the report's."""

OUTCOME = "validation.json"

CLASS_USES = {
    "X": "exact evaluation: point sources, arithmetic",
    "A": "unshadowed area sources, tabulated photometry, transmittance, colorimetry",
    "B": "sky components, one reflection, partial visibility",
    "C": "multiple interreflection",
    "D": "points close to an edge of an opening, half shadows, grazing light through glass",
    "Z": "must vanish within an absolute value",
}
"""What each tolerance class is for."""


def write_report(run: Run, folder: Path) -> list[Path]:
    """Write the report of a run.

    Parameters
    ----------
    run : Run
    folder : Path    Made if need be; files of an earlier report are replaced.

    Returns
    -------
    list of Path    Everything that was written.
    """
    folder = Path(folder)
    (folder / PICTURES).mkdir(parents=True, exist_ok=True)
    published = load_published()
    written = _draw_summary(run, published, folder / PICTURES)
    cases = list(run.cases)
    for i, case in enumerate(cases):
        written += _draw_case(run, case, folder / PICTURES)
        around = (cases[i - 1] if i else None, cases[i + 1] if i + 1 < len(cases) else None)
        page = compose_case(run, case, published, around)
        written.append(_write(folder / f"{case}.md", page))
    written.append(_write(folder / "README.md", compose_summary(run, published)))
    written.append(write_outcome(compose_outcome(run), folder / OUTCOME))
    return written


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


def compose_case(
    run: Run, case: str, published: Published, around: tuple[str | None, str | None]
) -> str:
    """Text of the page of a case; ``around``: the cases before and after it."""
    text = TEXTS[case]
    groups = _groups_of(run, case)
    before, after = around
    ways = ["[Report](README.md)"]
    ways += [f"[{key}]({key}.md)" for key in (before, after) if key]
    parts = [f"# {case} {run.cases[case].title}", " · ".join(ways), text.about]
    basis = f"**Reference values.** {text.basis}"
    if text.clause:
        basis += f" Subject of CIE 171:2006, {_clause(text.clause)}."
    parts.append(basis)
    parts.append(_state_case(run, case, groups))
    if case in run.setups:
        parts.append(f"![Set-up of {case}]({PICTURES}/{case}.png)")
        parts.append(_caption(run, case, groups))
    if any(key in run.engine.findings for key in groups):
        parts.append(f"![Errors of {case}]({PICTURES}/{case}_errors.png)")
    families: dict[str, list[Group]] = {}
    for group in groups.values():
        families.setdefault(family_of(group.id), []).append(group)
    for name, members in families.items():
        parts.append(f"## `{name}` {members[0].quantity} [{members[0].unit}]")
        if len(members) == 1:
            parts += _compose_group(run, members[0], published)
        else:
            parts += _compose_family(run, members)
    results = published.results_of(case)
    if results:
        parts.append("## Published results on this subject")
        parts.append(_table_results(published, results))
    return "\n\n".join(parts)


def _write(path: Path, text: str) -> Path:
    path.write_text(text.rstrip() + "\n", encoding="utf-8")
    return path


def _draw_case(run: Run, case: str, folder: Path) -> list[Path]:
    written = []
    if case in run.setups:
        picture = draw_setup(run.setups[case])
        written.append(save_picture(picture, folder / f"{case}.png"))
    rows = [
        (run.engine.findings[key], run.engine.verdicts[key])
        for key in _groups_of(run, case)
        if key in run.engine.findings
    ]
    if rows:
        written.append(save_picture(draw_errors(rows), folder / f"{case}_errors.png", 32))
    return written


def _draw_summary(run: Run, published: Published, folder: Path) -> list[Path]:
    ours = _largest_by_clause(run)
    written = [save_picture(draw_bands(_bands(run, published)), folder / "bands.png", 48)]
    if ours:
        picture = draw_published(ours, published.results)
        written.append(save_picture(picture, folder / "published.png", 48))
    return written


def _groups_of(run: Run, case: str) -> dict[str, Group]:
    return {key: group for key, group in run.groups.items() if group.case == case}


# ---- summary ----


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
        f" {_share(counts.share(counts.inside))} of the values are inside their tolerance, "
        f"{_share(counts.share(counts.within[1]))} less than 1 % off or inside a tolerance that is wider, "
        f"{_share(counts.share(counts.bands[1]))} less than 1 % off whatever their tolerance."
    )
    part = ""
    if run.is_quick or set(run.cases) != {group.case for group in load_groups().values()}:
        part = "\n\nThis run is a part of the suite and does not replace the whole."
    return done + verdict + shares + part


def _describe_run(run: Run) -> str:
    machine = run.machine
    informative = sum(group.is_informative for group in run.groups.values())
    rows = [
        ("program", f"{OURS} {run.version}"),
        ("cases", f"{len(run.cases)}: {', '.join(_span(list(run.cases)))}"),
        (
            "groups",
            f"{len(run.groups)}, of which {informative} informative (reported, not scored)",
        ),
        ("subset", "quick" if run.is_quick else "all groups of these cases"),
        ("seed", str(run.seed)),
        (
            "standard error",
            "a third of each tolerance or less"
            + (f", and {_percent(run.error)} of the value or less" if run.error else ""),
        ),
        (
            "machine",
            f"{machine['cpu']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}",
        ),
        ("software", f"Python {machine['python']}, Mitsuba {machine['mitsuba']}"),
        (
            "time",
            f"{_duration(run.seconds)}, of which {_duration(run.engine.seconds)} for {OURS}'s values",
        ),
        ("peers", ", ".join(run.peers) or "none asked"),
        ("every value", f"[{OUTCOME}]({OUTCOME})"),
        (
            "to repeat it",
            f"`lumenray validate{' --peers' if run.peers else ''} -o docs/validation`",
        ),
    ]
    return _table(("", ""), rows)


def _bands(run: Run, published: Published) -> dict[str, dict[int, float]]:
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
        (name, *(_share(shares[band]) for band in BANDS))
        for name, shares in _bands(run, published).items()
    ]
    table = _table(("share of values", *(f"< {band} % off" for band in BANDS)), rows)
    return (
        f"![Shares of values by relative error]({PICTURES}/bands.png)\n\n{table}\n\n"
        "The bands count every value by its relative error, whatever its tolerance; a reference that its own "
        "tolerance does not tell from 0 counts when inside that. The reference system was judged by its makers "
        "on another, shorter list; the second row is the nearest to it."
    )


def _compose_cases(run: Run) -> str:
    rows = []
    for key, case in run.cases.items():
        groups = _groups_of(run, key)
        scored = {k: g for k, g in groups.items() if not g.is_informative}
        counts = summarise(scored, run.engine)
        verdicts = [run.engine.verdicts[k] for k in scored if k in run.engine.verdicts]
        rows.append(
            (
                _thumbnail(run, key),
                f"[**{key}**]({key}.md) {case.title}",
                _clause(TEXTS[key].clause) or "–",
                str(counts.groups),
                str(counts.values),
                *_errors(verdicts),
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
        _table(columns, rows)
        + "\n\nTolerance used: the largest part of its tolerance that the error of a value takes."
    )


def _thumbnail(run: Run, case: str) -> str:
    if case not in run.setups:
        return ""
    return f'<a href="{case}.md"><img src="{PICTURES}/{case}.png" width="120" alt="{case}"></a>'


def _errors(verdicts: Sequence[Verdict]) -> tuple[str, str]:
    """Largest and root mean square relative error of groups in percent."""
    relative = np.concatenate([v.relative for v in verdicts]) if verdicts else np.zeros(0)
    relative = relative[~np.isnan(relative)]
    if not relative.size:
        return "–", "–"
    return (
        _plain_percent(float(np.abs(relative).max())),
        _plain_percent(float(np.sqrt((relative**2).mean()))),
    )


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
            row += [str(sum(v.inside.size for v in scored)) if scored else "–", *_errors(scored)]
        rows.append(tuple(row))
    parts = [
        "## Beside other programs in the same run",
        "The same scenes, sensors and reference values went to the other programs on the same machine. They were run "
        "until their own estimate of the error was a third of the tolerance, or to the limit of what they offer. "
        "Numbers of values differ where a program has no means to state a case.",
        _table(columns, rows),
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
        parts.append(_table(("groups", "number", "reason"), rows))
    return parts


def _families(keys: Iterable[str]) -> list[str]:
    return [f"`{name}`" for name in dict.fromkeys(family_of(key) for key in keys)]


def _largest_by_clause(run: Run) -> dict[str, float]:
    """Our largest relative error over the scored values of the cases of each CIE section. [-]"""
    largest: dict[str, float] = {}
    for key, verdict in run.engine.verdicts.items():
        clause = TEXTS[run.groups[key].case].clause
        if clause.startswith("5.") and verdict.is_scored:
            largest[clause] = max(largest.get(clause, 0.0), verdict.largest)
    return dict(sorted(largest.items(), key=lambda item: int(item[0].partition(".")[2])))


def _compose_published(run: Run, published: Published) -> str:
    ours = _largest_by_clause(run)
    parts = []
    if ours:
        parts.append(f"![Largest errors by CIE test]({PICTURES}/published.png)")
        parts.append(
            "Largest relative error on each test of CIE 171:2006, as published, and ours over all scored values of the "
            "cases with the same subject; ours include points, skies and variants beyond the printed list. Published "
            "figures are relative to the printed tables, of which some are in error (below)."
        )
    parts.append(_table_results(published, published.results, ours))
    parts.append("### The printed tables")
    parts.append(published.remarks["tables"])
    rows = [_compare_printed(table) for table in published.tables]
    parts.append(
        _table(
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


def _table_results(published: Published, results, ours: dict[str, float] | None = None) -> str:
    rows = []
    used = []
    for result in results:
        if result.source not in used:
            used.append(result.source)
        row = (
            result.test,
            result.subject,
            result.program + (f" ({result.year})" if result.year else ""),
            "–" if result.largest is None else _plain_percent(result.largest),
            "–" if result.mean is None else _plain_percent(result.mean),
            result.remark or "",
            result.source,
        )
        if ours is not None:
            mine = ours.get(result.test)
            row = (*row[:5], "–" if mine is None else _plain_percent(mine), *row[5:])
        rows.append(row)
    columns = ["test", "subject", "program", "largest %", "mean %", "remark", "source"]
    if ours is not None:
        columns.insert(5, f"{OURS}, largest %")
    sources = "; ".join(f"{key}: {published.sources[key]}" for key in used)
    return f"{_table(columns, rows)}\n\nSources. {sources}."


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
    told = _signed_percent(worst) + " %" if place else "within the rounding"
    return table.table, str(count), told, place, str(off)


def _compose_seeds(run: Run) -> str:
    if not run.determinism:
        return "No group with random values was repeated in this run."
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
    table = _table(
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
        "much as its standard errors say: chi-square per degree of freedom between 0.5 and 2, where the group has at "
        f"least ten random values. {good} of {len(run.determinism)} groups pass, one of each case that has random "
        f"values.\n\n{table}"
    )


def _describe_rules() -> str:
    rows = [
        (key, "absolute only" if not share else f"{100.0 * share:g} %", CLASS_USES[key])
        for key, share in CLASS_TOLERANCES.items()
    ]
    table = _table(("class", "relative tolerance", "for"), rows)
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


# ---- pages of cases ----


def _state_case(run: Run, case: str, groups: dict[str, Group]) -> str:
    scored = {key: group for key, group in groups.items() if not group.is_informative}
    counts = summarise(scored, run.engine)
    verdicts = [run.engine.verdicts[key] for key in scored if key in run.engine.verdicts]
    largest, rms = _errors(verdicts)
    seconds = sum(f.seconds for k, f in run.engine.findings.items() if k in groups)
    if counts.failed:
        verdict = f"**{len(counts.failed)} of {counts.groups} scored groups FAIL.**"
    elif scored:
        verdict = f"**{'All' if counts.groups > 1 else 'The'} {counts.groups if counts.groups > 1 else ''} scored "
        verdict = " ".join(verdict.split()) + (
            " groups pass.**" if counts.groups > 1 else " group passes.**"
        )
    else:
        verdict = "No group of this case is scored."
    rows = [_peer_row(OURS, largest, rms, counts.values, counts.inside)]
    for name, peer in run.peers.items():
        answered = [peer.verdicts[key] for key in scored if key in peer.verdicts]
        inside = sum(int(v.inside.sum()) for v in answered)
        rows.append(
            _peer_row(name, *_errors(answered), sum(v.inside.size for v in answered), inside)
        )
    table = _table(("", "values", "inside tolerance", "largest error %", "RMS error %"), rows)
    return f"{verdict} {OURS} took {_duration(seconds)}.\n\n{table}"


def _peer_row(name, largest, rms, values, inside) -> tuple[str, ...]:
    return name, str(values) if values else "cannot be asked", str(inside), largest, rms


def _caption(run: Run, case: str, groups: dict[str, Group]) -> str:
    """Whose sensors the picture shows."""
    labels = tuple(run.setups[case].labels)
    shown = next((key for key, group in groups.items() if group.labels == labels), None)
    told = "Set-up" + (f" with the points of `{shown}`" if shown else "")
    if is_numbered(labels):
        told += "; numbers are those of the rows of its table"
    return f"*{told}. Surfaces before the sensors are drawn thin; endless ones are cut off.*"


def _compose_group(run: Run, group: Group, published: Published) -> list[str]:
    """What is said of a group, and a row for every value."""
    key = group.id
    parts = [_state_group(run, group)]
    found, verdict = run.engine.findings.get(key), run.engine.verdicts.get(key)
    printed = published.printed(key)
    has_place = bool(np.isfinite(group.positions).all(axis=1).any())
    peers = {name: peer.findings[key] for name, peer in run.peers.items() if key in peer.findings}
    columns = ["no.", "point"] + (["position [m]", "normal"] if has_place else [])
    columns += ["reference", OURS, "error %", "standard error %", "allowed %", "verdict"]
    columns += (["CIE printed"] if printed else []) + list(peers)
    rows = []
    for i, label in enumerate(group.labels):
        row = [str(i + 1), _escape(label)]
        if has_place:
            row += [_vector(group.positions[i]), _vector(group.normals[i])]
        row.append(_number(group.values[i]))
        nought = bool(is_nought(group)[i])
        if found is None:
            row += ["–", "–", "–", _part(group.allowed[i], group.values[i], nought), "**none**"]
        else:
            difference = found.values[i] - group.values[i]
            row += [
                _number(found.values[i]),
                _part(difference, group.values[i], nought, signed=True),
                _part(found.errors[i], group.values[i], nought),
                _part(group.allowed[i], group.values[i], nought),
                "inside" if verdict.inside[i] else "**OUTSIDE**",
            ]
        if printed:
            row.append(_number(printed[label]) if label in printed else "–")
        row += [_number(peer.values[i]) for peer in peers.values()]
        rows.append(tuple(row))
    parts.append(_table(columns, rows))
    return parts


def _state_group(run: Run, group: Group) -> str:
    key = group.id
    head = f"Class {group.tolerance_class} ({_tolerance(group)})."
    if key not in run.engine.verdicts:
        return f"**FAIL.** {head} No values: {run.engine.missing[key]}."
    verdict = run.engine.verdicts[key]
    if not verdict.is_scored:
        word = "Informative."
    else:
        word = "Pass." if verdict.passes else "**FAIL.**"
    told = (
        f"{word} {head} Error: largest {_plain_percent(verdict.largest)} %, "
        f"mean {_signed_percent(verdict.mean)} %, RMS {_plain_percent(verdict.rms)} %; "
        f"{verdict.used:.2f} of the tolerance used; {_duration(run.engine.findings[key].seconds)}."
    )
    if verdict.is_scored and not verdict.passes:
        told += f"\n\n> {' '.join(verdict.faults)}"
    return told


def _compose_family(run: Run, members: list[Group]) -> list[str]:
    """One table for groups that differ in the sky only: values, and the worst errors."""
    parts = []
    labels = members[0].labels
    shared = all(group.labels == labels for group in members)
    scored = [run.engine.verdicts[g.id] for g in members if g.id in run.engine.verdicts]
    failed = [
        g.id
        for g in members
        if g.id not in run.engine.verdicts or not run.engine.verdicts[g.id].passes
    ]
    largest, rms = _errors(scored)
    word = (
        f"**{len(failed)} of {len(members)} groups FAIL.**"
        if failed
        else f"All {len(members)} groups pass."
    )
    parts.append(
        f"{word} Class {members[0].tolerance_class} ({_tolerance(members[0])}). "
        f"Error: largest {largest} %, RMS {rms} %."
    )
    faults = [_state_group(run, group) for group in members if group.id in failed]
    parts += [f"`{key}`: {fault}" for key, fault in zip(failed, faults, strict=True)]
    points = (
        labels
        if shared
        else tuple(str(i + 1) for i in range(max(map(len, (g.labels for g in members)))))
    )
    columns = ["sky", *map(_escape, points), "largest error %", "standard error %", "verdict"]
    columns += [f"{name}, largest %" for name in run.peers]
    rows = []
    for group in members:
        found, verdict = run.engine.findings.get(group.id), run.engine.verdicts.get(group.id)
        cells = [_sky(group.id)]
        if found is None:
            cells += ["–"] * len(points) + ["–", "–", "**none**"]
        else:
            cells += [
                _number(value, 4) if inside else f"**{_number(value, 4)}**"
                for value, inside in zip(found.values, verdict.inside, strict=True)
            ]
            cells += ["–"] * (len(points) - len(found.values))
            cells += [
                _plain_percent(verdict.largest),
                _largest_share(found.errors, group),
                "pass" if verdict.passes else "**FAIL**",
            ]
        for peer in run.peers.values():
            has = group.id in peer.verdicts
            cells.append(_plain_percent(peer.verdicts[group.id].largest) if has else "–")
        rows.append(tuple(cells))
    parts.append(f"Values of {OURS}:")
    parts.append(_table(columns, rows))
    reference = _table(
        ("sky", *map(_escape, points)),
        [
            (
                _sky(group.id),
                *(_number(value, 4) for value in group.values),
                *["–"] * (len(points) - len(group.values)),
            )
            for group in members
        ],
    )
    parts.append(f"<details><summary>Reference values</summary>\n\n{reference}\n\n</details>")
    positions = members[0].positions
    if shared and np.isfinite(positions).all():
        places = _table(
            ("point", "position [m]", "normal", "allowed %"),
            [
                (_escape(label), _vector(p), _vector(n), _part(a, v, bool(z)))
                for label, p, n, a, v, z in zip(
                    labels,
                    positions,
                    members[0].normals,
                    members[0].allowed,
                    members[0].values,
                    is_nought(members[0]),
                    strict=True,
                )
            ],
        )
        parts.append(f"<details><summary>Points</summary>\n\n{places}\n\n</details>")
    return parts


def _sky(key: str) -> str:
    """The sky type that ends a group's id."""
    return "".join(char for char in key.rpartition(".")[2] if char.isdigit())


def _tolerance(group: Group) -> str:
    share = CLASS_TOLERANCES[group.tolerance_class]
    told = f"{100.0 * share:g} %" if share else f"absolute {group.allowed.max():.3g} {group.unit}"
    others = sorted({c for c in group.classes if c != group.tolerance_class})
    named = [
        f"{c}: {', '.join(x for x, k in zip(group.labels, group.classes, strict=True) if k == c)}"
        for c in others
    ]
    return told + (f"; class {'; '.join(named)}" if named else "")


# ---- cells ----


def _table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    lines += [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join(lines)


def _escape(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*")


def _number(value: float, digits: int = 5) -> str:
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


def _vector(vector: np.ndarray) -> str:
    if not np.isfinite(vector).all():
        return "–"
    return f"({', '.join(f'{x:.9g}' for x in np.round(vector, 6) + 0.0)})"


def _percent(share: float) -> str:
    return f"{100.0 * share:g} %"


def _plain_percent(share: float) -> str:
    return f"{100.0 * share:.3f}" if np.isfinite(share) else "no number"


def _signed_percent(share: float) -> str:
    return f"{100.0 * share:+.3f}" if np.isfinite(share) else "no number"


def _part(size: float, of: float, is_nought: bool, signed: bool = False) -> str:
    """A difference in percent of a value, or as it is where the value is nought."""
    if is_nought:
        return f"{size:{'+' if signed else ''}.2g} abs."
    share = size / abs(of)
    return _signed_percent(share) if signed else _plain_percent(share)


def _largest_share(errors: np.ndarray, group: Group) -> str:
    sized = ~is_nought(group)
    if not sized.any():
        return "–"
    return _plain_percent(float((errors[sized] / np.abs(group.values[sized])).max()))


def _share(share: float) -> str:
    """Percent, cut and not rounded: 100 % means all."""
    return f"{np.floor(share * 1e4 + 1e-7) / 100.0:.2f} %"


def _clause(clause: str) -> str:
    return f"{clause} (suggested)" if clause == "6" else clause


def _duration(seconds: float) -> str:
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    if seconds < 3600.0:
        return f"{int(seconds // 60)} min {int(seconds % 60)} s"
    return f"{int(seconds // 3600)} h {int(seconds % 3600 // 60)} min"


def _span(keys: list[str]) -> list[str]:
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
