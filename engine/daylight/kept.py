"""Daylight coefficients in a file, so that another weather, or a run that was stopped, need not trace them anew."""

from dataclasses import asdict

from ..formats.checkpoint import read_checkpoint, write_checkpoint
from ..scene.provenance import Provenance
from .coefficients import DaylightCoefficients

ARRAYS = ("sky", "reflected", "doubts", "reading", "direct", "direct_error", "neighbours", "shares")
NUMBERS = ("steps", "samples", "lost")


def write_coefficients(path, made: DaylightCoefficients, scene: str, order: str):
    """Write coefficients; ``scene``, ``order``: digests that `read_coefficients` compares."""
    facts = {name: getattr(made, name) for name in NUMBERS}
    facts |= {"provenance": asdict(made.provenance), "scene": scene, "order": order}
    return write_checkpoint(path, {name: getattr(made, name) for name in ARRAYS}, facts)


def read_coefficients(path, scene: str, order: str) -> DaylightCoefficients:
    """Read coefficients.

    Raises
    ------
    FileFormatError    They are damaged, or of another scene or order.
    """
    arrays, facts = read_checkpoint(path, scene, order)
    origin = dict(facts["provenance"])
    for name in ("decisions", "notes"):
        origin[name] = tuple(origin[name])
    return DaylightCoefficients(
        **{name: arrays[name] for name in ARRAYS},
        **{name: facts[name] for name in NUMBERS},
        provenance=Provenance(**origin),
    )
