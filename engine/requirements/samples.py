"""How many samples single sensors get: as many as the asked error needs of each, or all alike.

Either way every mean is right; by need, those whose light scatters most get more of all that are made (theory 10.9).
"""

from ..scene.modelling import Switch
from .decision import Asked, Decision, Outcome
from .facts import Facts

NAME = "samples"

ALIKE, BY_NEED = "as many for all", "as many as each needs"
"""Choices."""


def decide(_facts: Facts, asked: Asked, _allowance: float, switch: Switch) -> Outcome:
    """Give sensors as many samples as the asked error needs of each; exact."""
    if switch is Switch.OFF:
        made = Decision(NAME, ALIKE, "as the user wants it", switch=switch)
        return Outcome(made, samples_evenly=True)
    if asked.error is None:
        return Outcome(Decision(NAME, ALIKE, "no error is asked for", switch=switch))
    reason = (
        "sensors whose light scatters most get more, where the first samples tell that this saves many; none gets less "
        "than a quarter of the mean"
    )
    return Outcome(Decision(NAME, BY_NEED, reason, switch=switch))
