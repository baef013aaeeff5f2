"""How much of a scene a user wants to be modelled, as pure data."""

from dataclasses import dataclass
from enum import Enum


class Switch(Enum):
    """Who makes a decision."""

    AUTO = "auto"
    """Simplified where the bound of the error allows it."""

    FORCE = "force"
    """Simplified whatever it costs; the bound is in the error of results."""

    OFF = "off"
    """Modelled in full."""


DESCRIPTIONS = {
    "unseen": "Leave out what closed surfaces hide from all that is wanted; exact",
    "surfaces": "Put simpler surfaces in place of those that are the same; exact",
    "equal materials": "Let equal materials share a surface",
    "ray sets": "Take ray sets for points where these are right enough",
    "colours": "Choose photometric or spectral transport",
    "wavelengths": "Draw wavelengths by what lamps give and the eye sees of it; exact",
    "estimator": "Read reflected light from cells of the surfaces where that is sooner",
    "samples": "Give sensors as many samples as the asked error needs of each; exact",
    "roulette": "End paths of sensors by chance only once they count little; exact",
}
"""What each decision of `requirements.plan` does, by its name. Switches are made of this without loading what decides."""


@dataclass(frozen=True)
class Modelling:
    """A user's wishes about what is simplified.

    Parameters
    ----------
    switches : tuple of (str, Switch)    Decisions that are not left to us, by their names, see `DESCRIPTIONS`.
    share : float    Part of the asked error that simplifications may take. [-]
    """

    switches: tuple[tuple[str, Switch], ...] = ()
    share: float = 1.0 / 3.0
    id: str = "modelling"

    def of(self, name: str) -> Switch:
        """Who makes a decision."""
        return dict(self.switches).get(name, Switch.AUTO)

    @property
    def fault(self) -> str:
        """What is wrong with its numbers, empty if nothing."""
        if not 0.0 <= self.share < 1.0:
            return f"simplifications may take {self.share:g} of the asked error, expected 0 or more and less than 1"
        return ""
