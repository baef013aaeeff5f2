"""The option by which a command overrules what of a scene is modelled."""

import argparse
from dataclasses import replace

from ..engine.errors import LumenrayError
from ..engine.scene.modelling import Modelling, Switch

ALL = "all"
"""Stands for all decisions."""


def add_modelling(parser) -> None:
    """Let a command overrule decisions about what is modelled."""
    parser.add_argument(
        "--model",
        action="append",
        type=_wish,
        default=[],
        metavar="DECISION=auto|force|off",
        help="simplify by a decision of 'lumenray explain' whatever it costs (force), or not at all (off); 'all=off' models "
        "everything in full; may be repeated (default: as the scene says)",
    )


def overrule(scene, options) -> Modelling:
    """Let an open Blender scene ask for what the options of a command ask for; return what the file says.

    Raises
    ------
    LumenrayError    There is no such decision.
    """
    from ..blender_addon.modelling.wishes import read_wishes, write_wishes
    from ..engine.requirements.plan import DECISIONS

    settings = scene.lumenray.modelling
    kept = read_wishes(settings)
    switches = dict(kept.switches)
    for name, switch in options.model:
        if name not in {ALL, *DECISIONS}:
            raise LumenrayError(
                f"--model: there is no decision '{name}', expected {', '.join(DECISIONS)} or {ALL}"
            )
        switches |= dict.fromkeys(DECISIONS if name == ALL else (name,), switch)
    if options.model:
        write_wishes(settings, replace(kept, switches=tuple(switches.items())))
    return kept


def _wish(text: str) -> tuple[str, Switch]:
    """Read an option's value."""
    name, _, choice = text.partition("=")
    try:
        return name, Switch(choice)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not understood, expected such as colours=off, with auto, force or off"
        ) from None
