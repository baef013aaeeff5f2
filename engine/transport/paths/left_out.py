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
    emitters : Bool or None    Which luminous surfaces' is, by number of the emitter; None: none's.
    """

    suns: bool
    emitters: object = None

    def has(self, emitter, active):
        """Whether light of an emitter is left out."""
        if self.emitters is None:
            return mi.Bool(False)
        number = dr.reinterpret_array(mi.UInt32, emitter)
        return dr.gather(mi.Bool, self.emitters, number, active)
