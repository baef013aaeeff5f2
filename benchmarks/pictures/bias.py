"""What our way of making pictures adds to plain paths on the whole, block by block."""

import numpy as np

from .programs import Lumenray
from .statistics import find_bias, find_moved

SEEDS = 8
"""Pictures of each way."""

FIRST_SEED, SECOND_SEED = 500_000, 600_000


def measure_bias(ours: Lumenray, plain: Lumenray, row: dict, budget: float, say) -> dict:
    """Compare two ways; ``row``: what `race.race` has of plain paths, which tells how many samples the budget allows.

    Returns
    -------
    dict    As of `statistics.find_bias`, of our pictures whose pixels share no light, so of what cells change; ``samples``:
        per pixel in each picture; ``sharing``: the same of what sharing changes in pictures of the same samples.
    """
    affordable = [
        samples
        for samples, seconds in zip(row["samples"], row["seconds"], strict=True)
        if 3 * SEEDS * seconds <= budget
    ]
    samples = max(affordable, default=row["samples"][0])

    def stack(make, first: int) -> np.ndarray:
        return np.stack([make(samples, first + number).luminance for number in range(SEEDS)])

    own, shared = (stack(make, FIRST_SEED) for make in (ours.refer, ours.render))
    found = find_bias(own, stack(plain.render, SECOND_SEED))
    moved = find_moved(shared, own)
    for what, each in (("bias of cells", found), ("moved by sharing", moved)):
        say(
            f"{what}: {each['mean']:+.3f} % on the whole, {each['worst']:.2f} % beyond noise in the worst of "
            f"{each['blocks']} blocks"
        )
    return found | {"samples": samples, "sharing": moved}
