"""Error over time: how long Lumenray and other programs take to come near exact values, in one run."""

import time
from pathlib import Path

from ..common.machine import OtherLoad, describe_machine
from ..common.output import read_numbers, write_numbers
from .forecast import measure_forecasts
from .honesty import measure_honesty
from .programs import Lumenray, find_peers, measure_scene
from .scenes import QUICK, TITLES, load_scene
from .views import measure_views

ROUNDS, QUICK_ROUNDS = 5, 4
"""How often every run is made, with other random numbers each time."""

LONGEST, QUICK_LONGEST = 2.0, 0.25
"""Runs that would take longer are not made. [s]"""


def run(
    is_quick: bool = False, with_peers: bool = True, scenes=None, longest=None, say=None
) -> dict:
    """Measure everything.

    Parameters
    ----------
    is_quick : bool    Fewer scenes and rounds, and shorter runs.
    with_peers : bool    Whether other programs are run too, where they are installed.
    scenes : iterable of str or None    Names out of `scenes.TITLES`; None: all, or those of a quick run.
    longest : float or None    Runs that would take longer are not made; None: the default. [s]
    say : callable or None    Told in one line what was done.

    Returns
    -------
    dict    Plain data, for JSON: ``machine``, ``is_quick``, ``rounds``, ``longest``, ``scenes``, ``views``, ``seconds``
        and ``other_load``.
    """
    say = say or (lambda _line: None)
    rounds = QUICK_ROUNDS if is_quick else ROUNDS
    longest = longest or (QUICK_LONGEST if is_quick else LONGEST)
    start, load = time.perf_counter(), OtherLoad()
    # First, because a process in which a thousand lamps were computed takes longer for every launch.
    views = measure_views(rounds, longest, say)
    ours = Lumenray("mono"), Lumenray("spectral")
    peers = find_peers(say) if with_peers else []
    measured = []
    try:
        for key in scenes or (QUICK if is_quick else TITLES):
            scene = load_scene(key)
            programs = measure_scene(scene, [*ours, *peers], rounds, longest, say)
            row = {"key": key, "title": scene.title, "groups": list(scene.groups)}
            row |= {"sensors": len(scene.exact), "programs": programs}
            row["honesty"] = measure_honesty(scene, ours[0], is_quick)
            row["forecasts"] = measure_forecasts(scene, ours[0], programs[ours[0].name], longest)
            measured.append(row)
    finally:
        # Programs that we waited for count as ours.
        for peer in peers:
            peer.close()
    return {
        "machine": describe_machine(),
        "is_quick": is_quick,
        "rounds": rounds,
        "longest": longest,
        "scenes": measured,
        "views": views,
        "seconds": round(time.perf_counter() - start, 1),
        "other_load": load.share(),
    }


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"scenes", "views", "rounds"})


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document and its pictures to a folder, and all numbers to a JSON file if one is named."""
    from .chart import draw_scenes, draw_views
    from .document import write_document

    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    draw_scenes(result["scenes"], folder / "accuracy.png")
    draw_views(result["views"], folder / "accuracy_views.png")
    write_document(result, folder / "accuracy.md")
