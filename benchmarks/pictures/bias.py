"""What our way of making pictures adds to plain paths on the whole, block by block."""

import numpy as np

from .programs import Lumenray
from .statistics import find_bias

SEEDS = 8
"""Pictures of each way."""

FIRST_SEED, SECOND_SEED = 500_000, 600_000


def measure_bias(ours: Lumenray, plain: Lumenray, row: dict, budget: float, say) -> dict:
    """Compare two ways; ``row``: what `race.race` has of plain paths, which tells how many samples the budget allows.

    Returns
    -------
    dict    As of `statistics.find_bias`, and ``samples``: per pixel in each picture.
    """
    affordable = [
        samples
        for samples, seconds in zip(row["samples"], row["seconds"], strict=True)
        if 2 * SEEDS * seconds <= budget
    ]
    samples = max(affordable, default=row["samples"][0])
    stacks = []
    for program, first in ((ours, FIRST_SEED), (plain, SECOND_SEED)):
        made = [program.render(samples, first + number).luminance for number in range(SEEDS)]
        stacks.append(np.stack(made))
    found = find_bias(*stacks) | {"samples": samples}
    say(
        f"bias: {found['mean']:+.3f} % on the whole, {found['worst']:.2f} % beyond noise in the worst of "
        f"{found['blocks']} blocks"
    )
    return found
