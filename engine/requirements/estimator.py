"""How light that is reflected is found: by full paths, or read from cells of the surfaces.

Cells are off by a little, which every job that reads them measures, and which its errors hold; a job for which that is too
much goes back to full paths. So nothing of it is taken out of the budget here (theory 2.6, 11.9, 12.6).
"""

from ..scene.modelling import Switch
from .decision import Asked, Decision, Outcome
from .facts import Facts

NAME = "estimator"

SAVING = 0.9
"""Share of the time to an error that is saved in a room that daylight enters by a small window. [-]"""

AUTO, CELLS, PATHS = "auto", "cells", "paths"
"""Methods, as jobs know them."""

MEASURED = "what they change is measured, and stands in the errors"


def decide(facts: Facts, _asked: Asked, _allowance: float, switch: Switch) -> Outcome:
    """Read reflected light from cells of the surfaces where that is sooner, and right within what is asked."""
    if switch is Switch.OFF:
        return _outcome(PATHS, "full paths", "as the user wants it", switch)
    if not facts.has_diffuse:
        return _outcome(AUTO, "full paths", "no surface is matt, so none can have cells", switch)
    if switch is Switch.FORCE:
        return _outcome(CELLS, "cells", f"as the user wants it; {MEASURED}", switch, SAVING)
    reason = (
        f"cells are read where the first samples tell that full paths would take longer; {MEASURED}"
    )
    return _outcome(AUTO, "cells or full paths", reason, switch)


def _outcome(method: str, choice: str, reason: str, switch: Switch, saving: float = 0.0) -> Outcome:
    return Outcome(Decision(NAME, choice, reason, saving=saving, switch=switch), method=method)
