"""The commands ``lumenray benchmark``: speed and errors of this machine, against references and other programs."""

import argparse
from pathlib import Path

from ..engine.errors import LumenrayError
from .luminaire import say as tell
from .terminal import quiet

DOCUMENTS = Path("docs/benchmarks")
"""Where documents of whole benchmarks belong; those of parts go to `PARTS`."""

PARTS = Path("out")


def add_commands(commands, read_words, read_numbers, read_count) -> None:
    """Describe the commands.

    Parameters
    ----------
    commands : argparse's sub-parsers    To which ``benchmark`` is added.
    read_words, read_numbers, read_count : callable    From text to words, whole numbers and a number from 1 on.
    """
    benchmark = commands.add_parser("benchmark", help="measure the speed of this machine")
    kinds = benchmark.add_subparsers(dest="kind", required=True, metavar="KIND")

    rooms = _add(kinds, "rooms", "random small rooms against paths from the lights", "of a part")
    rooms.add_argument("--count", type=read_count, default=300, help="how many (default: 300)")
    rooms.add_argument("--first", type=int, default=0, help="number of the first (default: 0)")
    hidden = _add(kinds, "hidden", "light that is hard to find against closed forms", "of a part")
    hidden.add_argument(
        "--seeds", type=read_count, default=20, metavar="N", help="runs of each scene (default: 20)"
    )
    hidden.add_argument(
        "--scene",
        action="append",
        metavar="NAME",
        help="only this scene (may be repeated; default: all)",
    )
    for kind in (rooms, hidden):
        kind.add_argument("--jobs", type=read_count, default=1, help="processes (default: 1)")

    sync = _add(kinds, "sync", "what edits cost, compared with sending the whole scene")
    sync.add_argument(
        "--scenes", type=read_words, metavar="A,B", help="triangles (default: 10k,100k,1M,3M)"
    )
    sync.add_argument(
        "--objects", type=read_numbers, metavar="N,M", help="numbers of objects (default: 100,1000)"
    )
    _add(kinds, "raysets", "error over the size of ray files, convergence, speed")
    _add(kinds, "scattering", "measured materials: storage over error, sampling, speed, pictures")
    luminaires = _add(
        kinds,
        "luminaires",
        "agreement with Radiance, speed of look-up and noise of luminaires",
        "with --files",
    )
    luminaires.add_argument(
        "--files",
        type=Path,
        metavar="FOLDER",
        help="photometric files to compare (default: those of the library)",
    )
    accuracy = _add(
        kinds,
        "accuracy",
        "error over time against exact values, beside Radiance and Cycles",
        "with --quick",
    )
    atlas = _add(
        kinds,
        "atlas",
        "stated errors, forecasts, speed and leaks of lux maps, beside references and other programs",
        "with --quick",
    )
    for kind in (accuracy, atlas):
        kind.add_argument("--quick", action="store_true", help="few scenes and short runs")
        kind.add_argument(
            "--peers",
            action=argparse.BooleanOptionalAction,
            default=True,
            help="run other programs too, where they are installed (default: yes)",
        )
        kind.add_argument(
            "--check",
            type=Path,
            metavar="EARLIER.json",
            help="compare with the numbers of an earlier run; exit code 1 where they differ by more than chance",
        )
    atlas.add_argument(
        "--scale",
        action="store_true",
        help="also bake large buildings anew, up to 50 pages (about an hour)",
    )


def run(options) -> int:
    """Run the command; 1 where a benchmark has a verdict and it is against us."""
    try:
        from ..benchmarks.common.output import report_progress
    except ImportError:
        raise LumenrayError(
            "this installation has no benchmarks; they come with Lumenray's source code"
        ) from None
    return {
        "rooms": _run_rooms,
        "hidden": _run_hidden,
        "sync": _run_sync,
        "raysets": _run_raysets,
        "scattering": _run_scattering,
        "luminaires": _run_luminaires,
        "accuracy": _run_accuracy,
        "atlas": _run_atlas,
    }[options.kind](options, report_progress)


def _add(kinds, name: str, words: str, part: str = ""):
    """Begin a kind of benchmark. ``part``: when it is one whose document goes elsewhere."""
    kind = kinds.add_parser(name, help=words)
    kind.add_argument("--json", type=Path, metavar="OUT.json", help="write all numbers here")
    elsewhere = f", {part} {PARTS}" if part else ""
    kind.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help=f"folder for {name}.md and its pictures (default: {DOCUMENTS}{elsewhere})",
    )
    return kind


def _write(module, result: dict, options, is_part: bool = False) -> None:
    folder = options.output or (PARTS if is_part else DOCUMENTS)
    module.write_results(result, folder, options.json)
    tell(f"written to {folder / options.kind}.md")


def _run_rooms(options, say) -> int:
    from ..benchmarks.rooms import run as rooms

    made = rooms.run(options.count, options.first, options.jobs, say=say)
    is_part = options.count < rooms.COUNT or options.first != rooms.FIRST
    _write(rooms, made, options, is_part)
    return int(any(row["off"] > 1.0 for row in made["rows"]))


def _run_hidden(options, say) -> int:
    from ..benchmarks.hidden import run as hidden_light

    made = hidden_light.run(options.seeds, options.scene, options.jobs, say=say)
    is_part = options.scene is not None or options.seeds < hidden_light.SEEDS
    _write(hidden_light, made, options, is_part)
    return int(not all(row["passed"] for row in hidden_light.summarise(made)))


def _run_sync(options, say) -> int:
    try:
        import bpy  # noqa: F401
    except ImportError as error:
        raise LumenrayError(
            f"Blender's Python module cannot be loaded ({error}); run 'make setup'"
        ) from None
    from ..benchmarks.sync import run as sync
    from ..benchmarks.sync.bars import check_bars, tell_bars

    scenes, objects = options.scenes or tuple(sync.SCENES), options.objects or sync.OBJECTS
    unknown = [name for name in scenes if name not in sync.SCENES]
    if unknown:
        raise LumenrayError(
            f"there is no scene {', '.join(unknown)}; choose from {', '.join(sync.SCENES)}"
        )
    with quiet():
        result = sync.run(scenes, objects, say=say)
    tell(tell_bars(check_bars(result)))
    _write(sync, result, options)
    return 0


def _run_raysets(options, say) -> int:
    from ..benchmarks.raysets import run as raysets

    _write(raysets, raysets.run(say=say), options)
    return 0


def _run_scattering(options, say) -> int:
    from ..benchmarks.scattering import run as scattering

    _write(scattering, scattering.run(say=say), options)
    return 0


def _run_luminaires(options, say) -> int:
    _start_engine()
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.luminaires import run as luminaires
    from ..benchmarks.luminaires.bars import check_bars

    result = luminaires.run(options.files, say=say)
    tell(tell_bars(check_bars(result)))
    _write(luminaires, result, options, bool(options.files))
    return 0


def _run_accuracy(options, say) -> int:
    _start_engine()
    from ..benchmarks.accuracy import run as accuracy
    from ..benchmarks.accuracy.bars import check_bars
    from ..benchmarks.accuracy.document import tell_comparison
    from ..benchmarks.accuracy.statistics import compare_results
    from ..benchmarks.common.bars import tell_bars

    # The file may be the one that is written.
    earlier = accuracy.read_results(options.check) if options.check else None
    result = accuracy.run(options.quick, options.peers, say=say)
    tell(tell_bars(check_bars(result)))
    _write(accuracy, result, options, options.quick)
    if earlier is None:
        return 0
    rows = compare_results(earlier, result)
    tell(tell_comparison(rows))
    return int(not all(row.passes for row in rows))


def _run_atlas(options, say) -> int:
    from ..benchmarks.atlas import run as atlas
    from ..benchmarks.atlas.bars import check_bars, compare_results
    from ..benchmarks.common.bars import tell_bars

    # As above.
    earlier = atlas.read_results(options.check) if options.check else None
    result = atlas.measure(options.quick, options.peers, options.scale, say=say)
    tell(tell_bars(check_bars(result)))
    _write(atlas, result, options, options.quick)
    if earlier is None:
        return 0
    compared = compare_results(earlier, result)
    tell(tell_bars(compared))
    return int(not all(bar.passed for bar in compared))


def _start_engine() -> None:
    """Settle where LLVM lies before Dr.Jit is loaded, which looks for it then."""
    from ..engine.transport import backend

    backend.start(spectral=False)
