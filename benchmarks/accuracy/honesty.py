"""Whether the standard error that Lumenray states is the true one."""

import numpy as np

from .programs import Lumenray
from .scenes import ExactScene

WORK = (256, 4096)
"""Samples per sensor: of short jobs, where stated errors are hardest to believe."""

MOST_RUNS, FEWEST_RUNS = 64, 12
"""Of each; fewer where one takes long."""

NORMAL = 2.576
"""Standard errors in half of a 99 % interval."""

SECONDS, QUICK_SECONDS = 5.0, 1.5
"""Time for all of them. [s]"""


def measure_honesty(scene: ExactScene, ours: Lumenray, is_quick: bool) -> list[dict]:
    """Repeat short jobs and compare the spread of their true errors with what they state.

    Returns
    -------
    list of dict    ``work``, ``runs``, ``share``: root mean square over the sensors of the true error over the stated one,
        ``spread``: half of its 99 % interval.
    """
    longest = QUICK_SECONDS if is_quick else SECONDS
    rows = []
    for work in WORK:
        # What was compiled or changed over for it does not count.
        ours.run(scene, work, -1)
        seconds = ours.run(scene, work, -1).seconds
        runs = int(np.clip(longest / len(WORK) / seconds, FEWEST_RUNS, MOST_RUNS))
        made = [ours.run(scene, work, number) for number in range(runs)]
        true = np.array([(one.values - scene.exact) ** 2 for one in made])
        stated = np.array([one.stated**2 for one in made])
        # Every sensor counts alike, the brightest as the darkest.
        shares = true / stated.mean(axis=0)
        share = float(np.sqrt(shares.mean()))
        # Runs are independent; the error of a root is half that of its square.
        error = shares.mean(axis=1).std(ddof=1) / np.sqrt(runs) / (2.0 * share)
        rows.append({"work": work, "runs": runs, "share": share, "spread": float(NORMAL * error)})
    return rows
