"""How an asked error is shared between samples and simplifications.

What is left out makes light wrong by its bound at most; samples, by their standard error. Both are independent, and add up
in quadrature, as all causes of error do here; a bound counts as a standard error, which is more than it can be.
"""

import math

MOST = 0.5
"""Share of an asked error up to which more samples make up for a bound; beside larger ones they get what that leaves. [-]"""


def left_to_samples(error: float, bound: float) -> float:
    """Relative standard error that samples may have beside a bound. [-]"""
    return math.sqrt(error**2 - min(bound, MOST * error) ** 2)
