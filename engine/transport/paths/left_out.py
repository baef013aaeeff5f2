"""Light that paths from receivers do not count, since it is found otherwise."""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi


@dataclass(frozen=True)
class LeftOut:
    """Light over ideal glass and curved mirrors that is found otherwise, such as by tracing it from the lights.

    Parameters
    ----------
    suns : bool    Whether that of the suns is.
    surfaces : Bool or None    Which luminous surfaces' is, by their place among the lights; None: none's.
    """

    suns: bool
    surfaces: object = None

    def has(self, lights, emitter, row, active):
        """Whether light of an emitter is left out. ``lights``: the `LightTable`; ``row``: as of `LightTable.index`."""
        if self.surfaces is None:
            return mi.Bool(False)
        return dr.gather(mi.Bool, self.surfaces, lights.index(emitter, active, row), active)
