"""How an asked error is shared between samples and simplifications.

What is left out makes light wrong by its bound at most; samples, by their standard error. Both are independent, and add up
in quadrature, as all causes of error do here; a bound counts as a standard error, which is more than it can be.
"""

import math

MOST = 0.8
"""Share of an asked error up to which more samples make up for a bound; beside larger ones they get what that leaves. [-]"""

HIDDEN = 0.5
"""Error of samples over a bound below which they hardly make the whole smaller: by an eighth at most. [-]"""


def tell_parts(error: float, simplified: float) -> str:
    """Say what an error is made of; empty where nothing was simplified.

    Parameters
    ----------
    error : float    Relative error of a result, what may be wrong by simplifications included; infinite if not known. [-]
    simplified : float    Largest relative error by simplifications, as of a `Provenance`. [-]
    """
    if not simplified:
        return ""
    rest = math.sqrt(max(error**2 - simplified**2, 0.0))
    told = f"{100.0 * rest:.2g} %" if math.isfinite(error) else "not known"
    return f"sampling and the rest {told}, simplifications at most {100.0 * simplified:.2g} %"


def left_to_samples(error: float, bound: float) -> float:
    """Relative standard error that samples may have beside a bound; all that is asked where it is lost in that. [-]"""
    left = math.sqrt(error**2 - min(bound, MOST * error) ** 2)
    return min(max(left, HIDDEN * bound), error)
