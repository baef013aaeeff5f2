"""The page of a case: what is tested, a picture, a plot, and every value."""

import numpy as np

from .cells import (
    OURS,
    PICTURES,
    escape,
    groups_of,
    largest_share,
    lay_table,
    plain_percent,
    signed_percent,
    table_results,
    tell_clause,
    tell_duration,
    tell_errors,
    tell_number,
    tell_part,
    tell_vector,
)
from .charts import family_of
from .drawing import is_numbered
from .outcome import summarise
from .published import Published
from .reference import Group
from .runner import Run
from .texts import TEXTS
from .verdict import CLASS_TOLERANCES, is_nought


def compose_case(
    run: Run, case: str, published: Published, around: tuple[str | None, str | None]
) -> str:
    """Text of the page of a case; ``around``: the cases before and after it."""
    text = TEXTS[case]
    groups = groups_of(run, case)
    before, after = around
    ways = ["[Report](README.md)"]
    ways += [f"[{key}]({key}.md)" for key in (before, after) if key]
    parts = [f"# {case} {run.cases[case].title}", " · ".join(ways), text.about]
    basis = f"**Reference values.** {text.basis}"
    if text.clause:
        basis += f" Subject of CIE 171:2006, {tell_clause(text.clause)}."
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
        parts.append(table_results(published, results))
    return "\n\n".join(parts)


def _state_case(run: Run, case: str, groups: dict[str, Group]) -> str:
    scored = {key: group for key, group in groups.items() if not group.is_informative}
    counts = summarise(scored, run.engine)
    verdicts = [run.engine.verdicts[key] for key in scored if key in run.engine.verdicts]
    largest, rms = tell_errors(verdicts)
    seconds = sum(f.seconds for k, f in run.engine.findings.items() if k in groups)
    if counts.failed:
        verdict = f"**{len(counts.failed)} of {counts.groups} scored groups FAIL.**"
    elif counts.groups > 1:
        verdict = f"**All {counts.groups} scored groups pass.**"
    else:
        verdict = "**The group passes.**" if scored else "No group of this case is scored."
    rows = [_peer_row(OURS, largest, rms, counts.values, counts.inside)]
    for name, peer in run.peers.items():
        answered = [peer.verdicts[key] for key in scored if key in peer.verdicts]
        inside = sum(int(v.inside.sum()) for v in answered)
        rows.append(
            _peer_row(name, *tell_errors(answered), sum(v.inside.size for v in answered), inside)
        )
    table = lay_table(("", "values", "inside tolerance", "largest error %", "RMS error %"), rows)
    return f"{verdict} {OURS} took {tell_duration(seconds)}.\n\n{table}"


def _peer_row(name, largest, rms, values, inside) -> tuple[str, ...]:
    return name, str(values) if values else "cannot be asked", str(inside), largest, rms


def _caption(run: Run, case: str, groups: dict[str, Group]) -> str:
    """Whose sensors the picture shows."""
    setup = run.setups[case]
    labels = tuple(setup.labels)
    shown = None
    if len(labels) == len(setup.positions):
        shown = next((key for key, group in groups.items() if group.labels == labels), None)
    told = "Set-up" + (f" with the points of `{shown}`" if shown else "")
    if shown and is_numbered(labels):
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
        row = [str(i + 1), escape(label)]
        if has_place:
            row += [tell_vector(group.positions[i]), tell_vector(group.normals[i])]
        row.append(tell_number(group.values[i]))
        nought = bool(is_nought(group)[i])
        if found is None:
            row += ["–", "–", "–", tell_part(group.allowed[i], group.values[i], nought), "**none**"]
        else:
            difference = found.values[i] - group.values[i]
            row += [
                tell_number(found.values[i]),
                tell_part(difference, group.values[i], nought, signed=True),
                tell_part(found.errors[i], group.values[i], nought),
                tell_part(group.allowed[i], group.values[i], nought),
                "inside" if verdict.inside[i] else "**OUTSIDE**",
            ]
        if printed:
            row.append(tell_number(printed[label]) if label in printed else "–")
        row += [tell_number(peer.values[i]) for peer in peers.values()]
        rows.append(tuple(row))
    parts.append(lay_table(columns, rows))
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
        f"{word} {head} Error: largest {plain_percent(verdict.largest)} %, "
        f"mean {signed_percent(verdict.mean)} %, RMS {plain_percent(verdict.rms)} %; "
        f"{verdict.used:.2f} of the tolerance used; {tell_duration(run.engine.findings[key].seconds)}."
    )
    if verdict.is_scored and not verdict.passes:
        told += f"\n\n> {' '.join(verdict.faults)}"
    return told


def _compose_family(run: Run, members: list[Group]) -> list[str]:
    """One table for groups that differ in the sky only: values, and the worst errors."""
    labels = members[0].labels
    shared = all(group.labels == labels for group in members)
    scored = [run.engine.verdicts[g.id] for g in members if g.id in run.engine.verdicts]
    failed = [
        g.id
        for g in members
        if g.id not in run.engine.verdicts or not run.engine.verdicts[g.id].passes
    ]
    largest, rms = tell_errors(scored)
    word = (
        f"**{len(failed)} of {len(members)} groups FAIL.**"
        if failed
        else f"All {len(members)} groups pass."
    )
    parts = [
        f"{word} Class {members[0].tolerance_class} ({_tolerance(members[0])}). "
        f"Error: largest {largest} %, RMS {rms} %."
    ]
    faults = [_state_group(run, group) for group in members if group.id in failed]
    parts += [f"`{key}`: {fault}" for key, fault in zip(failed, faults, strict=True)]
    points = (
        labels
        if shared
        else tuple(str(i + 1) for i in range(max(map(len, (g.labels for g in members)))))
    )
    parts.append(f"Values of {OURS}:")
    parts.append(_lay_values(run, members, points))
    reference = lay_table(
        ("sky", *map(escape, points)),
        [
            (
                _sky(group.id),
                *(tell_number(value, 4) for value in group.values),
                *["–"] * (len(points) - len(group.values)),
            )
            for group in members
        ],
    )
    parts.append(f"<details><summary>Reference values</summary>\n\n{reference}\n\n</details>")
    if shared and np.isfinite(members[0].positions).all():
        places = _lay_points(members[0])
        parts.append(f"<details><summary>Points</summary>\n\n{places}\n\n</details>")
    return parts


def _lay_values(run: Run, members: list[Group], points) -> str:
    """Table of what was found at the points under every sky, with the verdicts of all programs."""
    columns = ["sky", *map(escape, points), "largest error %", "standard error %", "verdict"]
    columns += [f"{name}, largest %" for name in run.peers]
    rows = []
    for group in members:
        found, verdict = run.engine.findings.get(group.id), run.engine.verdicts.get(group.id)
        cells = [_sky(group.id)]
        if found is None:
            cells += ["–"] * len(points) + ["–", "–", "**none**"]
        else:
            cells += [
                tell_number(value, 4) if inside else f"**{tell_number(value, 4)}**"
                for value, inside in zip(found.values, verdict.inside, strict=True)
            ]
            cells += ["–"] * (len(points) - len(found.values))
            cells += [
                plain_percent(verdict.largest),
                largest_share(found.errors, group),
                "pass" if verdict.passes else "**FAIL**",
            ]
        for peer in run.peers.values():
            has = group.id in peer.verdicts
            cells.append(plain_percent(peer.verdicts[group.id].largest) if has else "–")
        rows.append(tuple(cells))
    return lay_table(columns, rows)


def _lay_points(group: Group) -> str:
    """Table of a group's points: where they are, and what is allowed there."""
    rows = zip(
        group.labels,
        group.positions,
        group.normals,
        group.allowed,
        group.values,
        is_nought(group),
        strict=True,
    )
    return lay_table(
        ("point", "position [m]", "normal", "allowed %"),
        [
            (escape(label), tell_vector(p), tell_vector(n), tell_part(a, v, bool(z)))
            for label, p, n, a, v, z in rows
        ],
    )


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
