"""The command ``lumenray explain``: what of a scene is computed, why, and what that costs in exactness."""

import textwrap
from dataclasses import asdict

from ..blender_addon import assumptions
from ..engine.scene.ray_emission import EVERYWHERE
from .blend_file import open_session
from .options import add_scene, share, transport_of
from .output import name_cell, percent, rounded, say, say_json, sheet, table

NEAREST = 10
"""Objects of every ray set that are told of."""

ERROR = 0.01
"""Relative error that is asked for where none is named. [-]"""

WIDTH = 110
"""Of reasons. [character]"""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    explain = commands.add_parser(
        "explain",
        help="what of a scene is computed, why, and what that costs in exactness",
        epilog="What the scene's data tell is told at once; --trial adds what is known once a little light has been sent.",
    )
    add_scene(explain)
    explain.add_argument(
        "--error",
        type=share(),
        default=ERROR,
        metavar="E",
        help=f"relative standard error that is asked for (default: {ERROR:g})",
    )
    explain.add_argument(
        "--colour", action="store_true", help="colours are wanted too, as of a picture"
    )
    explain.add_argument(
        "--trial", action="store_true", help="compile the scene and send a little light"
    )
    explain.add_argument("--json", action="store_true", help="JSON instead of text")
    explain.add_argument(
        "--all", action="store_true", help="all objects of every ray set, not the nearest ten"
    )
    # What is missing is told, too.
    explain.set_defaults(run=run, accept_missing=True)


def run(options) -> int:
    """Explain a file; return the exit code."""
    from ..engine.requirements.decision import Asked

    settings, report, session = open_session(options)
    asked = Asked(options.error, options.colour)
    made = session.explain(transport_of(options, settings), asked, options.trial)
    if options.json:
        say_json(rounded({**_to_dict(made), "conversion": report.to_dicts()}))
        return assumptions.exit_code(report, is_accepted=False)
    say(str(options.file))
    _print_plan(made.plan)
    if options.trial:
        say(sheet("\ntrial", [("traced", made.traced), ("notes", made.notes)]))
    most = None if options.all else NEAREST
    for light in dict.fromkeys(choice.light for choice in made.choices):
        _print_choices([choice for choice in made.choices if choice.light == light], most)
    assumptions.tell(report)
    return assumptions.exit_code(report, is_accepted=False)


def _to_dict(made) -> dict:
    """An explanation as data."""
    plan = made.plan
    return {
        "asked_error": plan.asked.error,
        "decisions": [{**asdict(each), "switch": each.switch.value} for each in plan.decisions],
        "budget": {
            "simplifications_allowed": plan.allowed,
            "simplifications_at_most": plan.spent,
            "sampling": plan.sampling_error,
        },
        "traced": made.traced,
        "notes": made.notes,
        "ray_choices": [asdict(choice) for choice in made.choices],
    }


def _print_plan(plan) -> None:
    """Tell the decisions as rows of columns, each with its reason below it, and the budget."""
    what = "light and colours" if plan.asked.has_colour else "light"
    say(f"{what}, asked for to a relative standard error of {percent(plan.asked.error)}\n")
    rows = [("decision", "computed", "error by it", "time saved", "switch")]
    rows += [
        (
            each.name,
            each.choice,
            f"at most {percent(each.bound, '.2g')}" if each.bound else "none, exact",
            f"about {percent(each.saving, '.0f')}" if each.saving else "-",
            each.switch.value,
        )
        for each in plan.decisions
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    indent = " " * (widths[0] + 2)
    reasons = ["", *(each.reason for each in plan.decisions)]
    for row, reason in zip(rows, reasons, strict=True):
        say("  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip())
        for line in textwrap.wrap(reason, WIDTH - len(indent)):
            say(indent + line)
    say(f"\nbudget: {plan.budget_text}")


def _print_choices(choices, most: int | None) -> None:
    """Tell how the light of a ray set reaches objects; ``most`` of them, None: all."""
    first = choices[0]
    limit = f"rays within {_length(first.limit)}, a point beyond"
    if first.limit >= EVERYWHERE:
        limit = "rays everywhere"
    say(f"\nray set '{first.light}': in lux maps {limit}")
    rows = [("object", "nearest", "sizes", "lux maps", "error", "pictures, sensors")]
    rows += [
        (
            name_cell(choice.receiver),
            _length(choice.nearest),
            f"{choice.sizes:.1f}",
            choice.method,
            percent(choice.error, ".2g"),
            percent(choice.seen_error, ".2g"),
        )
        for choice in choices[:most]
    ]
    say(table(rows))
    if most is not None and len(choices) > most:
        say(f"  and {len(choices) - most} objects farther away (--all tells them)")


def _length(metres: float) -> str:
    return f"{1e3 * metres:.3g} mm" if metres < 1.0 else f"{metres:.3g} m"
