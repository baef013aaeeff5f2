"""The command ``lumenray explain``: how a scene is computed, and what that costs in exactness."""

from dataclasses import asdict

from ..blender_addon import assumptions
from .blend_file import open_session
from .options import add_scene, transport_of
from .output import name_cell, percent, rounded, say, say_json, sheet, table

NEAREST = 10
"""Objects of every ray set that are told of."""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    explain = commands.add_parser(
        "explain", help="how a scene is computed: what is traced how, and what that costs"
    )
    add_scene(explain)
    explain.add_argument("--json", action="store_true", help="JSON instead of text")
    explain.add_argument(
        "--all", action="store_true", help="all objects of every ray set, not the nearest ten"
    )
    # What is missing is told, too.
    explain.set_defaults(run=run, accept_missing=True)


def run(options) -> int:
    """Explain a file; return the exit code."""
    settings, report, session = open_session(options)
    made = session.explain(transport_of(options, settings))
    if options.json:
        say_json(rounded({**asdict(made), "conversion": report.to_dicts()}))
        return assumptions.exit_code(report, is_accepted=False)
    told = [("transport", made.decisions), ("traced", made.traced), ("notes", made.notes)]
    say(sheet(str(options.file), told))
    most = None if options.all else NEAREST
    for light in dict.fromkeys(choice.light for choice in made.choices):
        _print_choices([choice for choice in made.choices if choice.light == light], most)
    assumptions.tell(report)
    return assumptions.exit_code(report, is_accepted=False)


def _print_choices(choices, most: int | None) -> None:
    """Tell how the light of a ray set reaches objects; ``most`` of them, None: all."""
    first = choices[0]
    say(
        f"\nray set '{first.light}': in lux maps rays within {_length(first.limit)}, a point beyond"
    )
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
