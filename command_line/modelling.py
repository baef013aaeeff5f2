"""Options by which a command overrules what of a scene is modelled."""

import argparse

from ..engine.scene.modelling import Modelling, Switch


def add_modelling(parser) -> None:
    """Let a command overrule decisions about what is modelled."""
    parser.add_argument(
        "--model",
        action="append",
        type=_wish,
        default=[],
        metavar="DECISION=auto|force|off",
        help="simplify by a decision of 'lumenray explain' whatever it costs (force), or not at all (off); 'all=off' models "
        "everything in full",
    )


def apply_modelling(session, options) -> None:
    """Tell an engine what was asked for; what the file says stays where nothing was."""
    from ..engine.requirements.plan import DECISIONS
    from ..engine.scene.scene import SceneDelta

    if not options.model:
        return
    kept = session.scene.modelling
    switches = dict(kept.switches)
    for name, switch in options.model:
        switches |= dict.fromkeys(DECISIONS if name == "all" else (name,), switch)
    session.apply(SceneDelta(changed=(Modelling(tuple(switches.items()), kept.share),)))


def _wish(text: str) -> tuple[str, Switch]:
    """Read an option's value."""
    name, _, choice = text.partition("=")
    try:
        return name, Switch(choice)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not understood, expected such as colours=off, with auto, force or off"
        ) from None
