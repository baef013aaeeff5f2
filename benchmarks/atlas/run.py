"""Lux maps beside references and other programs: stated errors, forecasts, speed, leaks, scale; in one run."""

import time
from pathlib import Path

from ..common.machine import OtherLoad, describe_machine, measure_unsteadiness
from ..common.output import read_numbers, write_numbers


def measure(
    is_quick: bool = False,
    with_peers: bool = True,
    with_scale: bool = False,
    scenes: tuple[str, ...] | None = None,
    say=None,
) -> dict:
    """Measure everything.

    Parameters
    ----------
    is_quick : bool    Fewer scenes, bakes and samples.
    with_peers : bool    Whether other programs are run too, where they are installed.
    with_scale : bool    Whether large buildings are baked anew; else the results of the last time are taken.
    scenes : tuple of str or None    Out of `scenes.BUILDERS`; None: all, or those of a quick run.
    say : callable or None    Told in one line what was done.

    Returns
    -------
    dict    Plain data, for JSON: the numbers of `summary.summarise`, and ``machine``, ``is_quick``, ``scenes``,
        ``races``, ``geometry``, ``scale``, ``seconds``, ``unsteadiness`` (see `machine.measure_unsteadiness`) and
        ``other_load``.
    """
    from ...engine.transport import backend

    # Dr.Jit looks for LLVM when it is loaded, so where that lies is settled first.
    backend.start(spectral=False)
    from . import geometry as atlas_geometry
    from . import scale as atlas_scale
    from .calibration import FORECAST_SECONDS, QUICK_FORECAST_SECONDS, measure_scene
    from .race import race
    from .scenes import BUILDERS, QUICK, RACE, build
    from .summary import summarise
    from .variants import make_plain

    say = say or (lambda _line: None)
    chosen = scenes or (QUICK if is_quick else tuple(BUILDERS))
    start, load = time.perf_counter(), OtherLoad()
    races, calibration = [], []
    for key in chosen:
        scene = build(key)
        if key in RACE:
            races.append(race(make_plain(scene), with_peers, is_quick, say))
        calibration.append(measure_scene(scene, is_quick, say))
    geometry = {
        "leaks": atlas_geometry.measure_leaks(say),
        "seams": atlas_geometry.measure_seams(say),
        "hard": atlas_geometry.measure_hard_cases(say),
    }
    share, seconds = load.share(), time.perf_counter() - start
    length = QUICK_FORECAST_SECONDS if is_quick else FORECAST_SECONDS
    say("how steadily the machine works")
    unsteadiness = measure_unsteadiness(length)
    scale = atlas_scale.measure_scale(say) if with_scale else atlas_scale.read_scale()
    return {
        **summarise(calibration, races),
        "machine": describe_machine(),
        "is_quick": is_quick,
        "scenes": calibration,
        "races": races,
        "geometry": geometry,
        "scale": scale,
        "seconds": round(seconds, 1),
        "unsteadiness": unsteadiness,
        "other_load": share,
    }


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"calibration", "speedup", "races"})


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document and its pictures to a folder, and all numbers to a JSON file if one is named."""
    from .chart import draw_calibration, draw_races, draw_scale
    from .document import write_document

    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    if result["races"]:
        draw_races(result["races"], folder / "atlas_races.png")
    if result["scenes"]:
        draw_calibration(result["scenes"], folder / "atlas_calibration.png")
    if result["scale"] is not None:
        draw_scale(result["scale"], folder / "atlas_scale.png")
    write_document(result, folder / "atlas.md")
