"""Pictures beside Cycles and plain paths: time to an error, bias and stated errors; in one run."""

import time
from contextlib import nullcontext
from pathlib import Path

from ...validation.bench import CannotStateError
from ..common.machine import OtherLoad, describe_machine
from ..common.output import read_numbers, write_numbers

BUDGET = 240.0
"""Time that the pictures of a program in a scene may take together. [s]"""


def measure(
    scenes: tuple[str, ...],
    size: tuple[int, int],
    budget: float,
    keep,
    with_peers: bool = True,
    earlier: dict | None = None,
    say=None,
    by_processor: bool = False,
    only_races: bool = False,
    card: tuple[dict, dict] | None = None,
) -> dict:
    """Measure.

    Parameters
    ----------
    scenes : tuple of str    Out of `scenes.BUILDERS`.
    size : (int, int)    Of the pictures. [pixel]
    budget : float    Time for each program in each scene. [s]
    keep : callable    ``keep(result, key, pair)`` with all results so far, after each scene; ``pair``: ours and Cycles'
        picture at equal time, None without Cycles.
    with_peers : bool    Whether Cycles is run too, where it is installed.
    earlier : dict or None    Results that are gone on with: scenes that they have in this size are not measured again.
    say : callable or None    Told in one line what was done.
    by_processor : bool    Whether all times, and the budget, are of the processors, added up over their cores.
    only_races : bool    Whether bias is left out.
    card : (dict, dict) or None    Results of a graphics card and of processors of its machine, which are told besides; None:
        those that ``earlier`` has, if any.

    Returns
    -------
    dict    Plain data, for JSON: the numbers of `summary.summarise`, and ``machine``, ``device``, ``size``, ``budget``,
        ``scenes``, ``has_methods``, ``card``.
    """
    from ...engine.transport import backend

    # Dr.Jit looks for LLVM when it is loaded, so where that lies is settled first.
    variant = backend.start(spectral=False)
    from ...engine.transport.devices import of_variant
    from .programs import has_methods
    from .scenes import BUILDERS
    from .summary import summarise

    say = say or (lambda _line: None)
    rows = {row["key"]: row for row in (earlier or {}).get("scenes", ())}
    card = card or (earlier or {}).get("card")
    device = of_variant(variant).describe()

    def collect() -> dict:
        ordered = [rows[key] for key in BUILDERS if key in rows]
        return {
            **summarise(ordered),
            "machine": describe_machine(),
            "device": device,
            "card": card,
            "size": list(size),
            "budget": budget,
            "has_methods": has_methods(),
            "scenes": ordered,
        }

    for key in scenes:
        if key in rows and rows[key]["size"] == list(size):
            say(f"{key}: taken from earlier results")
            continue
        rows[key], pair = measure_scene(
            key,
            size,
            budget,
            with_peers,
            lambda line, k=key: say(f"{k}: {line}"),
            by_processor,
            only_races,
        )
        keep(collect(), key, pair)
    return collect()


def measure_scene(
    key: str,
    size,
    budget: float,
    with_peers: bool,
    say,
    by_processor: bool = False,
    only_races: bool = False,
) -> tuple[dict, list | None]:
    """Measure one scene; parameters as of `measure`.

    Returns
    -------
    row : dict    ``key``, ``title``, ``size``, ``budget``, ``programs``: see `race.race`, or ``refusal``; ``bias``: see
        `bias.measure_bias`, None where there is one way only, or races only; ``stand_ins``, ``pair``,
        ``seconds``, ``other_load``.
    pair : list of `programs.Made` or None    Ours and Cycles' at equal time.
    """
    from .bias import measure_bias
    from .programs import BEFORE, CYCLES, OURS, Cycles, Lumenray, has_methods, processor_time
    from .race import pair_at_equal_time, race
    from .scenes import build

    scene = build(key, size)
    ours, plain = Lumenray(scene, OURS), Lumenray(scene, BEFORE)
    programs, refusals, pid = [ours, plain] if has_methods() else [ours], {}, None
    begin = time.perf_counter()
    if with_peers:
        try:
            programs.append(Cycles(scene))
            pid = programs[-1].pid
        except CannotStateError as error:
            refusals[CYCLES] = {"refusal": str(error)}
            say(f"Cycles: {error}")
    load = OtherLoad(pid)
    try:
        with processor_time() if by_processor else nullcontext():
            made, pictures = race(programs, budget, say)
            pair = pair_at_equal_time(pictures, (OURS, CYCLES)) if CYCLES in pictures else None
            del pictures
            has_bias = has_methods() and not only_races
            bias = measure_bias(ours, plain, made[BEFORE], budget, say) if has_bias else None
        share = load.share()
    finally:
        for program in programs:
            program.close()
    return {
        "key": key,
        "title": scene.title,
        "size": list(size),
        "budget": budget,
        "programs": made | refusals,
        "bias": bias,
        "stand_ins": sorted(scene.stand_ins),
        "pair": None if pair is None else [each.seconds for each in pair],
        "seconds": round(time.perf_counter() - begin, 1),
        "other_load": share,
        "by_processor": by_processor,
    }, pair


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"speedup", "bias_percent", "scenes"})


def write_pair(pair: list, key: str, folder: Path) -> None:
    """Write two pictures beside each other."""
    from .chart import draw_pair

    folder.mkdir(parents=True, exist_ok=True)
    draw_pair(pair, folder / f"pictures_{key}.png")


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document and its chart to a folder, and all numbers to a JSON file if one is named."""
    from .chart import draw_races
    from .document import write_document

    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    draw_races(result["scenes"], folder / "pictures_races.png")
    write_document(result, folder / "pictures.md")
