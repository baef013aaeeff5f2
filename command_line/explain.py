"""The command ``lumenray explain``: how a scene is computed, and what that costs in exactness."""

import json
from dataclasses import asdict

from ..blender_addon import assumptions
from .luminaire import say

NEAREST = 10
"""Objects of every ray set that are told of."""


def add_command(commands):
    """Describe the command, below argparse's sub-parsers ``commands``; return its parser."""
    explain = commands.add_parser(
        "explain", help="how a scene is computed: what is traced how, and what that costs"
    )
    explain.add_argument("--json", action="store_true", help="JSON instead of text")
    explain.add_argument(
        "--all", action="store_true", help="all objects of every ray set, not the nearest ten"
    )
    return explain


def run(options, depsgraph, transport: str) -> int:
    """Explain an open file.

    Raises
    ------
    LumenrayError    The scene cannot be computed.
    """
    from ..blender_addon.sync.scene import convert_scene
    from ..engine.session import Session

    converted = convert_scene(depsgraph)
    session = Session()
    session.apply(converted.delta)
    made = session.explain(transport)
    report = converted.report
    if options.json:
        say(json.dumps({**asdict(made), "conversion": report.to_dicts()}, indent=2))
        return 0
    say(str(options.file))
    for text in made.decisions:
        say(f"  transport  {text}")
    say(f"  traced     {made.traced}")
    for text in made.notes:
        say(f"  note       {text}")
    most = None if options.all else NEAREST
    for light in dict.fromkeys(choice.light for choice in made.choices):
        _print_choices([choice for choice in made.choices if choice.light == light], most)
    assumptions.tell(report)
    return 0


def _print_choices(choices, most: int | None) -> None:
    """Tell how the light of a ray set reaches objects; ``most`` of them, None: all."""
    first = choices[0]
    say(
        f"\nray set '{first.light}': in lux maps rays within {_length(first.limit)}, a point beyond"
    )
    say(
        f"  {'object':28} {'nearest':>9} {'sizes':>7}  {'lux maps':8} {'error':>7}  {'pictures, sensors':>17}"
    )
    for choice in choices[:most]:
        say(
            f"  {choice.receiver[:28]:28} {_length(choice.nearest):>9} {choice.sizes:7.1f}  {choice.method:8} "
            f"{100 * choice.error:5.2g} %  {100 * choice.point_error:15.2g} %"
        )
    if most is not None and len(choices) > most:
        say(f"  and {len(choices) - most} objects farther away (--all tells them)")


def _length(metres: float) -> str:
    return f"{1e3 * metres:.3g} mm" if metres < 1.0 else f"{metres:.3g} m"
