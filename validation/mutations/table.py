"""What became of all faults, as Markdown."""

from collections.abc import Sequence

from lumenray.engine import VERSION

from .trials import Outcome, multiple

PROGRAM = "python -m lumenray.validation.mutations"


def compose_table(outcomes: Sequence[Outcome], everything: bool) -> str:
    """Table of what was found, as Markdown."""
    caught = sum(outcome.is_caught for outcome in outcomes)
    asked = "All its groups were run" if everything else "It was run until a group failed"
    lines = [
        "# Mutation check",
        "",
        "Would the validation suite notice if the engine were wrong? Faults of physics were put into the engine of version",
        f"{VERSION} one at a time, each in a process of its own, and the quick subset of the suite was run against each.",
        f"{asked}; every group named here passes without the fault.",
        "",
        f"**{caught} of {len(outcomes)} faults are caught.** The error is the largest of a value, in multiples of what its",
        f"group allows. The table is made by `make mutations`; `{PROGRAM} --all` runs",
        "the whole quick subset against every fault.",
        "",
        "| fault | what is wrong | caught | by | error / tolerance |",
        "| --- | --- | --- | --- | ---: |",
    ]
    for outcome in outcomes:
        found = ", ".join(trial.group for trial in outcome.found_by)
        word = "yes" if outcome.is_caught else "**no**"
        if outcome.fault:
            found = f"broke off: {outcome.fault}"
        cells = (outcome.mutation.name, outcome.mutation.what, word, found)
        lines.append(f"| {' | '.join(map(_cell, cells))} | {multiple(outcome.worst)} |")
    lines += ["", "## How each was put in", ""]
    for outcome in outcomes:
        lines.append(f"**{outcome.mutation.name}**")
        for change in outcome.mutation.changes:
            old, new = change.text
            module, _, name = change.target.partition(":")
            lines += ["", f"`engine/{module.replace('.', '/')}.py`, `{name}`:"]
            lines += ["", "```diff", f"- {old}", f"+ {new}", "```"]
        lines.append("")
    return "\n".join(lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
