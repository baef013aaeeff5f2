"""From the switches of a scene to what the engine is told, and back."""

from contextlib import contextmanager

from ...engine.scene.modelling import Modelling, Switch
from .settings import SWITCHES

DIGITS = 6
"""That the share has in Blender's single precision."""


def read_wishes(settings, has_share: bool = True) -> Modelling:
    """Return what a scene's settings, a `LumenrayModellingSettings`, ask for; ``has_share``: whether the share counts."""
    asked = {name: Switch[getattr(settings, key)] for name, key in SWITCHES.items()}
    switches = tuple((name, switch) for name, switch in asked.items() if switch is not Switch.AUTO)
    usual = settings.bl_rna.properties["share"].default
    if not has_share or settings.share == usual:
        return Modelling(switches)
    return Modelling(switches, float(f"{settings.share:.{DIGITS}g}"))


def write_wishes(settings, wishes: Modelling) -> None:
    """Let a scene's settings ask for what the engine was told."""
    for name, key in SWITCHES.items():
        setattr(settings, key, wishes.of(name).name)
    if wishes.share == Modelling.share:
        settings.property_unset("share")
    else:
        settings.share = wishes.share


@contextmanager
def wishing(settings, wishes: Modelling):
    """Let a scene's settings ask for something else for a while."""
    kept = read_wishes(settings)
    write_wishes(settings, wishes)
    try:
        yield
    finally:
        write_wishes(settings, kept)
