"""The races on a graphics card beside those on processors of the same machine, told in the same document."""

import math

from ..common.document import make_table
from ..common.statistics import geometric_mean
from .chart import STYLES
from .programs import BEFORE, OURS
from .race import reach
from .statistics import TARGETS

METHODS = (OURS, BEFORE)
"""Programs that are told."""

TEXT = """## On a graphics card

{card}, beside {cores}, of one machine{system}; pictures of {width} x {height} pixels, at most {budget:g} s for each program
in a scene, without bias. A card is used where it is chosen; *Automatic* takes the processor. How far means are
apart is told in their common standard error.
"""


def tell_card(card: dict, cores: dict) -> str:
    """The part of the document about two results of `run.measure`, of a card and of processors of its machine."""
    rows, factors = [], {name: [] for name in METHODS}
    by_key = {scene["key"]: scene for scene in cores["scenes"]}
    for scene in card["scenes"]:
        other = by_key.get(scene["key"])
        for name in METHODS:
            own, theirs = (each and each["programs"].get(name) for each in (scene, other))
            if own is None or theirs is None:
                continue
            cells = [scene["title"], STYLES[name][0]]
            for target in TARGETS:
                ours, others = reach(own, target), reach(theirs, target)
                bound = ours.bound or others.bound
                cells.append(
                    f"{ours.bound}{ours.seconds:.3g} and {others.bound}{others.seconds:.3g}"
                )
                if not bound:
                    factors[name].append(others.seconds / ours.seconds)
                cells.append("-" if bound else f"x {others.seconds / ours.seconds:.3g}")
            rows.append(f"| {' | '.join([*cells, _tell_means(own, theirs)])} |")
    heads = [
        f"{100 * target:g} %, s, card and processors | processors over card" for target in TARGETS
    ]
    totals = [
        f"{STYLES[name][0]}: x {geometric_mean(found):.3g}"
        for name, found in factors.items()
        if found
    ]
    width, height = card["size"]
    text = TEXT.format(
        card=card["device"],
        cores=cores["device"],
        system=f" ({card['machine']['system']}, {card['machine']['memory_gib']} GiB)",
        width=width,
        height=height,
        budget=card["budget"],
    )
    table = make_table(
        f"| scene | program | {' | '.join(heads)} | means, cd/m², and how far apart |", rows, 2
    )
    return f"{text}\n{table}\nGeometric means of processors over card: {'; '.join(totals)}.\n"


def _tell_means(own: dict, theirs: dict) -> str:
    error = math.hypot(own["mean_error"], theirs["mean_error"])
    apart = (own["mean"] - theirs["mean"]) / error if error else 0.0
    return f"{own['mean']:.4g} and {theirs['mean']:.4g}, {apart:+.1f}"
