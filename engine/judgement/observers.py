"""What ratings of glare of observers say of a requirement."""

import math

from ..accuracy.student import t_quantile
from ..errors import SceneError
from .requirement import LIGHT, Requirement
from .verdict import Range, State, Verdict, judge, tail


def glare_limit(requirement: Requirement) -> float:
    """Return the largest UGR that a requirement allows.

    Raises
    ------
    SceneError    It asks nothing of it.
    """
    if "ugr" not in requirement.light:
        raise SceneError(f"{requirement.key} asks nothing of {LIGHT['ugr']}")
    return requirement.light["ugr"]


def judge_observers(
    limit: float, ratings, freedom: float, count: int | None = None
) -> list[Verdict]:
    """Judge observers, who share the probability of a wrong verdict.

    Parameters
    ----------
    limit : float    Largest UGR.
    ratings : sequence of (float, float)    UGR of each and its standard error; NaN: no glare source is seen.
    freedom : float    Degrees of freedom of the errors.
    count : int or None    How many limits share it, where others do besides those of the observers.

    Returns
    -------
    list of Verdict    Of each. How much longer open ones need is not foretold: the size of pixels has a part in the errors.
    """
    count = count or len(ratings)
    reach = t_quantile(1.0 - tail(count), freedom)
    verdicts = []
    for value, error in ratings:
        if math.isnan(value):
            # Nothing is seen that dazzles.
            found = Range(-math.inf, -math.inf, -math.inf)
            verdicts.append(Verdict(LIGHT["ugr"], limit, True, found, State.MET))
            continue
        known = error if math.isfinite(error) else math.inf
        found = Range(value, value - reach * known, value + reach * known)
        made = judge(LIGHT["ugr"], limit, found, count, is_most=True)
        verdicts.append(Verdict(made.name, limit, True, found, made.state))
    return verdicts
