"""Samples that are no numbers: what results lack without them, and how people are told.

They come from a fault of the engine or of a scene's data, and are left out. Nobody knows what they would have brought, so
stated errors hold what they bring where they are like the others: of a share s of all samples, s / (1 - s) of the value.
"""

import numpy as np

ALL = 1.0 - 1e-6
"""Share that counts as all: it is summed up in single precision. [-]"""


def find_missing(values, shares, others=0.0) -> np.ndarray:
    """What values lack without some of their samples, in their unit.

    Parameters
    ----------
    values, shares : (n,) array or float    What the other samples gave, over the number of all; the share of those lost. [-]
    others : (n,) array or float    What stands for values of 0, of which nobody knows how bright the lost samples were.

    Returns
    -------
    (n,) array    Infinite where nothing was left, or all is dark.
    """
    values, shares = np.asarray(values, dtype=np.float64), np.asarray(shares, dtype=np.float64)
    values = np.where(values > 0.0, values, others)
    is_known = (shares < ALL) & (values > 0.0)
    missing = values * shares / np.where(is_known, 1.0 - shares, 1.0)
    return np.where(is_known | (shares <= 0.0), missing, np.inf)


def tell_lost(parts: dict[str, tuple[int, int]]) -> tuple[str, ...]:
    """Say how many samples were lost; nothing where none were.

    Parameters
    ----------
    parts : dict    Of the number of lost ones, and of all, by what they are called.
    """
    told = [f"{lost} of {made} {name}" for name, (lost, made) in parts.items() if lost]
    if not told:
        return ()
    share = max(100.0 * lost / max(made, 1) for lost, made in parts.values())
    return (
        f"{' and '.join(told)} were no numbers and were left out: the result may lack {share:.2g} % of the light "
        "that they stand for or more, and the stated errors hold as large a share",
    )
