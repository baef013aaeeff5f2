"""What a decision is: what was asked for, what was chosen, and what that may cost."""

import math
from dataclasses import dataclass, field

from ..scene.modelling import Switch


@dataclass(frozen=True)
class Asked:
    """What a job wants of a scene.

    Parameters
    ----------
    error : float or None    Relative standard error of the whole; None where no error is asked for, so that only what
        changes nothing is simplified. [-]
    has_colour : bool    Whether colours or spectra are wanted, and not photometric quantities alone.
    objects : frozenset of str    Ids of objects whose own light is wanted.
    """

    error: float | None = None
    has_colour: bool = True
    objects: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Decision:
    """One decision, for people.

    Parameters
    ----------
    name : str    Of the decision; the same as that of its switch.
    choice : str    What is computed.
    reason : str    Why.
    bound : float    Largest relative error of the light by what is left out; 0: exact. [-]
    saving : float    Share of the time that is saved, about, as `docs/benchmarks/requirements.md` has it. [-]
    switch : Switch    Who made it.
    """

    name: str
    choice: str
    reason: str
    bound: float = 0.0
    saving: float = 0.0
    switch: Switch = Switch.AUTO


@dataclass(frozen=True)
class Outcome:
    """A decision with what it does.

    Parameters
    ----------
    decision : Decision
    changes : dict    Items in place of the scene's, by id; None: left out.
    is_spectral : bool or None    Whether light has wavelengths; None where it is not what was decided.
    is_dispersive : bool    Whether glass refracts by the wavelength.
    """

    decision: Decision
    changes: dict[str, object] = field(default_factory=dict)
    is_spectral: bool | None = None
    is_dispersive: bool = False


def accepts(bound: float, allowance: float, switch: Switch) -> bool:
    """Whether a simplification of a bound is made.

    Parameters
    ----------
    bound : float    Infinite where none is known. [-]
    allowance : float    What is left of the budget. [-]
    switch : Switch
    """
    if switch is Switch.OFF or not math.isfinite(bound):
        return False
    return switch is Switch.FORCE or bound <= allowance
