"""Options of commands whose results are judged by requirements, and the command ``lumenray requirements`` with its list."""

from pathlib import Path

from ..engine.judgement.requirement import AREAS
from .options import share
from .output import say, say_json


def add_command(commands) -> None:
    """Describe the command to argparse."""
    lists = commands.add_parser(
        "requirements", help="lighting requirements by activity, that results can be judged by"
    )
    lists.add_argument("key", nargs="?", help="only this one, or a group such as office")
    add_files(lists)
    lists.add_argument("--json", action="store_true", help="a JSON list instead of text")
    lists.set_defaults(run=run)


def add_files(parser) -> None:
    """Let a command be told of more requirements."""
    parser.add_argument(
        "--requirements",
        type=Path,
        action="append",
        default=[],
        metavar="F.toml",
        help="file of requirements of your own, beside those that ship; may be repeated",
    )


def add_options(parser, default: str):
    """Let a command judge its results; ``default``: words for what the area is where none is stated."""
    group = parser.add_argument_group("judgement")
    group.add_argument(
        "--require",
        type=_requirement,
        metavar="KEY[:AREA]",
        help=f"say whether a requirement such as office.writing is met; areas are {', '.join(AREAS)} (default: {default}); "
        "'lumenray requirements' lists them",
    )
    add_files(group)
    group.add_argument(
        "--maintenance",
        type=share(),
        default=1.0,
        metavar="F",
        help="maintenance factor on illuminances; leave it out where luminaires have theirs (default: 1)",
    )
    group.add_argument(
        "--modified",
        action="store_true",
        help="ask for the modified mean illuminance where the requirement has one",
    )


def _requirement(text: str) -> tuple[str, str]:
    import argparse

    key, _, area = text.partition(":")
    if not key or (area and area not in AREAS):
        raise argparse.ArgumentTypeError(
            f"expected KEY or KEY:AREA with an area of {', '.join(AREAS)}, found '{text}'"
        )
    return key, area


def find(options, kind: str | None = None):
    """Return the requirement that was asked for and its area, or None, before anything is computed.

    Parameters
    ----------
    kind : str or None    Of the sensors: what says the area where none is stated.

    Raises
    ------
    LumenrayError    There is no such requirement, or it asks nothing of the area.
    """
    if options.require is None:
        return None
    from ..engine.judgement.assessment import count_limits
    from ..engine.judgement.reader import find_requirement

    key, area = options.require
    requirement = find_requirement(key, options.requirements)
    if not area:
        area = "cylindrical" if kind == "cylindrical" else next(iter(requirement.areas), "task")
    return requirement, area, count_limits(requirement, area, options.modified)


def run(options) -> int:
    """List requirements; return the exit code."""
    from ..engine.judgement.reader import known_requirements
    from ..engine.judgement.requirement import LIGHT, LIMITS

    known = known_requirements(options.requirements)
    wanted = [
        each
        for key, each in known.items()
        if options.key in (None, key) or key.startswith(f"{options.key}.")
    ]
    if not wanted:
        from ..engine.errors import LumenrayError

        groups = ", ".join(sorted({key.partition(".")[0] for key in known}))
        raise LumenrayError(f"there is no requirement '{options.key}'; the groups are {groups}")
    if options.json:
        say_json(
            [
                {
                    "key": each.key,
                    "title": each.title,
                    "standard": each.standard,
                    "source": each.source,
                    "areas": each.areas,
                    "light": each.light,
                }
                for each in wanted
            ]
        )
        return 0
    for each in wanted:
        say(f"{each.key}: {each.title} ({each.standard})")
        for area, limits in each.areas.items():
            told = ", ".join(f"{LIMITS[name]} {value:g}" for name, value in limits.items())
            say(f"  {area} [{AREAS[area]}]: {told}")
        if each.light:
            say(
                "  light: "
                + ", ".join(f"{LIGHT[name]} {value:g}" for name, value in each.light.items())
            )
        if each.source:
            say(f"  source: {each.source}")
    return 0
