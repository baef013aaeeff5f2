"""Which wavelengths paths carry.

Where light has wavelengths, each path carries four of them. Drawn in proportion to what lamps give and the eye sees of it,
all bring about as much; drawn evenly from the whole range, some bring next to nothing. The mean is the same (theory 15.5).
"""

from ..scene.modelling import Switch
from .decision import Asked, Decision, Outcome
from .facts import Facts

NAME = "wavelengths"

SAVING = 0.37
"""Share of the samples to an error that is saved in a room of strong colours under LEDs. [-]"""

EVENLY, BY_LAMPS = "evenly from all", "by lamps and eye"
"""Choices."""


def decide(facts: Facts, asked: Asked, _allowance: float, switch: Switch) -> Outcome:
    """Draw wavelengths by what lamps give and the eye sees of it; exact."""
    if not facts.is_spectral:
        return Outcome(Decision(NAME, "none", "light has no wavelengths here", switch=switch))
    if switch is Switch.OFF:
        made = Decision(NAME, EVENLY, "as the user wants it", switch=switch)
        return Outcome(made, draws_evenly=True)
    eye = "colour matching functions" if asked.has_colour else "the eye"
    reason = (
        f"they are drawn in proportion to what the lamps give and {eye} see{'' if asked.has_colour else 's'} of it, with a "
        "tenth by the latter alone, so that none is missed"
    )
    return Outcome(Decision(NAME, BY_LAMPS, reason, saving=SAVING, switch=switch))
