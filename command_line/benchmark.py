"""The commands ``lumenray benchmark``: speed and errors of this machine, against references and other programs."""

import argparse
from pathlib import Path

from ..engine.errors import LumenrayError
from .blend_file import quiet, start_blender
from .options import numbers, real, size, whole, words
from .output import add_force, check_free
from .output import say as tell

DOCUMENTS = Path("docs/benchmarks")
"""Where documents of whole benchmarks belong; those of parts go to `PARTS`."""

PARTS = Path("out")


def add_command(commands) -> None:
    """Describe the command to argparse."""
    benchmark = commands.add_parser("benchmark", help="measure the speed of this machine")
    benchmark.set_defaults(run=run)
    kinds = benchmark.add_subparsers(dest="kind", required=True, metavar="KIND")

    rooms = _add(
        kinds, "rooms", _run_rooms, "random small rooms against paths from the lights", "of a part"
    )
    rooms.add_argument("--count", type=whole(), default=300, help="how many (default: 300)")
    rooms.add_argument("--first", type=whole(0), default=0, help="number of the first (default: 0)")
    hidden = _add(
        kinds, "hidden", _run_hidden, "light that is hard to find against closed forms", "of a part"
    )
    hidden.add_argument(
        "--seeds", type=whole(), default=20, metavar="N", help="runs of each scene (default: 20)"
    )
    hidden.add_argument(
        "--scene",
        action="append",
        metavar="NAME",
        help="only this scene (may be repeated; default: all)",
    )
    for kind in (rooms, hidden):
        kind.add_argument("--jobs", type=whole(), default=1, help="processes (default: 1)")

    sync = _add(kinds, "sync", _run_sync, "what edits cost, compared with sending the whole scene")
    sync.add_argument(
        "--scenes", type=words, metavar="A,B", help="triangles (default: 10k,100k,1M,3M)"
    )
    sync.add_argument(
        "--objects", type=numbers, metavar="N,M", help="numbers of objects (default: 100,1000)"
    )
    _add(kinds, "raysets", _run_raysets, "error over the size of ray files, convergence, speed")
    _add(
        kinds,
        "scattering",
        _run_scattering,
        "measured materials: storage over error, sampling, speed, pictures",
    )
    denoising = _add(
        kinds,
        "denoising",
        _run_denoising,
        "denoised pictures of the office: error and means, beside Cycles at equal time",
    )
    denoising.add_argument(
        "--keep",
        type=Path,
        metavar="FOLDER",
        help="keep pictures here, and take those that are already there",
    )
    content = _add(
        kinds,
        "content",
        _run_content,
        "Blender's content, feature by feature, beside Cycles",
        "of a part",
    )
    content.add_argument(
        "--features",
        type=lambda text: tuple(filter(None, map(str.strip, text.split(";")))),
        metavar="A;B",
        help="only these, by their names with semicolons between them (default: all)",
    )
    content.add_argument(
        "--resume",
        action="store_true",
        help="go on with the results that --json already holds; of these only --features are measured again",
    )
    blends = _add(
        kinds,
        "blends",
        _run_blends,
        "a folder of .blend files as they are, beside Cycles: a sheet of pictures and their differences",
        "of a part",
    )
    blends.add_argument("folder", type=Path, metavar="FOLDER", help="folder with .blend files")
    blends.add_argument(
        "--files", type=words, metavar="A,B", help="only these, by their names (default: all)"
    )
    _add_daylight(kinds)
    paint = _add(
        kinds,
        "paint",
        _run_paint,
        "effect paints against reference values, Monte Carlo, a clock, and fitted to themselves",
        "of a part",
    )
    _add_parts(paint, "reference, walks, tables, speed, fit")
    cloth = _add(
        kinds,
        "cloth",
        _run_cloth,
        "cloths against reference values, both ways of light, close-ups, a clock",
        "of a part",
    )
    _add_parts(cloth, "reference, photons, woven, direct, presets, curtain, sheen")
    ink = _add(
        kinds,
        "ink",
        _run_ink,
        "dense pigment layers against reference values, colours by the size of particles, cost",
        "of a part",
    )
    _add_parts(ink, "reference, dense, trend, series, presets, processes")
    environment = _add(
        kinds,
        "environment",
        _run_environment,
        "pictures of the surroundings: bright sources as lights, suns mended, files",
        "of a part",
    )
    environment.add_argument(
        "--parts",
        type=words,
        metavar="A,B",
        help="only these of maps, shadow, repair, noise, shadows, files, collection (default: all)",
    )
    environment.add_argument(
        "--maps", type=Path, metavar="FOLDER", help="pictures that are analysed (default: none)"
    )
    environment.add_argument(
        "--resume",
        action="store_true",
        help="go on with the results that --json already holds; of these only --parts are measured again",
    )
    judgement = _add(
        kinds,
        "judgement",
        _run_judgement,
        "glare, action on the eye, colour indices, isolux and verdicts against standards and other programs",
        "without --tables",
    )
    judgement.add_argument(
        "--tables",
        type=Path,
        metavar="FOLDER",
        help="luminaires sample_NN.ldt with tables ugr_table_NN_NAME.csv of glare ratings (default: left out)",
    )
    needs = _add(
        kinds,
        "requirements",
        _run_requirements,
        "what modelling only what a scene needs saves, and whether its bounds hold",
        "of a part",
    )
    needs.add_argument(
        "--seeds", type=whole(2), default=20, metavar="N", help="runs of each scene (default: 20)"
    )
    needs.add_argument(
        "--scenes", type=words, metavar="A,B", help="only these, by their names (default: all)"
    )
    needs.add_argument(
        "--count",
        type=whole(0),
        default=200,
        metavar="N",
        help="random scenes in which bounds are tried (default: 200)",
    )
    needs.add_argument(
        "--resume",
        action="store_true",
        help="go on with the results that --json already holds, scene by scene",
    )
    _add_cluster(kinds)
    _add(kinds, "kernels", _run_kernels, "what is built for pictures of the office, and for edits")
    _add(kinds, "nodes", _run_nodes, "graphs of nodes beside pictures on surfaces, in the office")
    versions = _add(
        kinds,
        "versions",
        _run_versions,
        "the office by this version and by another one, side by side",
    )
    versions.add_argument(
        "checkout",
        type=Path,
        metavar="CHECKOUT",
        help="folder 'lumenray' with the other version, such as 'git worktree add' makes",
    )
    _add_service(kinds)
    _add_with_peers(kinds)
    _add_pictures(kinds)


def _add_service(kinds) -> None:
    """Add the kind that measures the service."""
    service = _add(
        kinds,
        "service",
        _run_service,
        "the service under load: answers, a long queue, ends in between",
    )
    told = {"users": "at once", "count": "jobs in all", "kills": "ends of it"}
    for name, what in told.items():
        service.add_argument(
            f"--{name}", type=whole(), metavar="N", help=f"{what} (default: 20, 500, 10)"
        )


def _add_daylight(kinds) -> None:
    """Add the kind that measures natural light."""
    daylight = _add(
        kinds,
        "daylight",
        _run_daylight,
        "the sun's place, skies and the year of a room, beside Radiance",
        "of a part",
    )
    daylight.add_argument(
        "--parts",
        type=words,
        metavar="A,B",
        help="only these of sun, skies, year, speed, scale (default: all)",
    )
    daylight.add_argument(
        "--weather",
        type=Path,
        metavar="FILE",
        help="EPW or WEA whose hours are taken (default: a year that is made up)",
    )
    daylight.add_argument(
        "--resume",
        action="store_true",
        help="go on with the results that --json already holds; of these only --parts are measured again",
    )


def _add_with_peers(kinds) -> None:
    """Add the kinds that other programs are compared in."""
    luminaires = _add(
        kinds,
        "luminaires",
        _run_luminaires,
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
        _run_accuracy,
        "error over time against exact values, beside Radiance and Cycles",
        "with --quick",
    )
    atlas = _add(
        kinds,
        "atlas",
        _run_atlas,
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


def _add_forecasts(kinds) -> None:
    """Add the kind that compares forecasts with what jobs took."""
    forecasts = _add(
        kinds,
        "forecasts",
        _run_forecasts,
        "forecasts of the time that pictures and sensors take, after a tenth of it",
        "of a part",
    )
    forecasts.add_argument(
        "--scenes", type=words, metavar="A,B", help="only these scenes (default: all six)"
    )
    forecasts.add_argument(
        "--seconds",
        type=real(),
        metavar="SECONDS",
        help="processor time of a job, about, added up over the cores (default: 40)",
    )
    forecasts.add_argument(
        "--rounds",
        type=whole(1, 100),
        metavar="N",
        help="jobs of each kind in each scene (default: 5)",
    )


def _add_pictures(kinds) -> None:
    """Add the kinds that compare pictures, and forecasts of them and of sensors."""
    pictures = _add(
        kinds,
        "pictures",
        _run_pictures,
        "time to an error of pictures, their bias and stated errors, beside Cycles",
        "of a part",
    )
    pictures.add_argument(
        "--scenes", type=words, metavar="A,B", help="only these scenes (default: all six)"
    )
    pictures.add_argument(
        "--size",
        type=size(16, 4096),
        metavar="WxH",
        help="of the pictures in pixels (default: 640x400)",
    )
    pictures.add_argument(
        "--budget",
        type=real(),
        metavar="SECONDS",
        help="time for the pictures of each program in each scene (default: 240)",
    )
    pictures.add_argument(
        "--peers",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="run Cycles too, where it is installed (default: yes)",
    )
    pictures.add_argument(
        "--only-races",
        action="store_true",
        help="leave out bias, as for a look at another device",
    )
    pictures.add_argument(
        "--card",
        type=Path,
        nargs=2,
        metavar=("CARD.json", "CORES.json"),
        help="results of a graphics card and of processors of its machine, which are told besides",
    )
    pictures.add_argument(
        "--processor-time",
        action="store_true",
        help="count the processors' time, added up over their cores, on a machine that others share",
    )
    pictures.add_argument(
        "--resume",
        action="store_true",
        help="go on with the results that --json already holds; its scenes are not measured again",
    )
    _add_forecasts(kinds)


def run(options) -> int:
    """Run the command; 1 where a benchmark has a verdict and it is against us."""
    try:
        from ..benchmarks.common.output import report_progress
    except ImportError:
        raise LumenrayError(
            "this installation has no benchmarks; they come with Lumenray's source code"
        ) from None
    named = options.output and options.output / f"{options.kind}.md"
    if not getattr(options, "resume", False):
        check_free(options, named, options.json)
    return options.measure(options, report_progress)


def _add_cluster(kinds) -> None:
    cluster = _add(
        kinds,
        "cluster",
        _run_cluster,
        "the same bits whatever becomes of workers, how well several work together, and a thousand would",
        "of a part",
    )
    cluster.add_argument(
        "--runs", type=whole(0), default=50, metavar="N", help="with harm (default: 50)"
    )
    cluster.add_argument(
        "--workers",
        type=numbers,
        default=(1, 2),
        metavar="N,M",
        help="numbers of workers whose efficiency is measured, a processor each (default: 1,2)",
    )
    cluster.add_argument(
        "--repeats",
        type=whole(),
        default=3,
        metavar="N",
        help="runs by each number of workers (default: 3)",
    )
    cluster.add_argument(
        "--samples", type=whole(), default=1 << 20, metavar="N", help="of a sensor (default: 2^20)"
    )
    cluster.add_argument(
        "--elsewhere",
        type=Path,
        metavar="OTHER.json",
        help="results of this benchmark on another machine, whose efficiency is told too",
    )
    _add_parts(cluster, "harm, efficiency, scaling")


def _add_parts(kind, parts: str) -> None:
    """Let a kind of benchmark measure some of its parts, and go on with earlier results."""
    kind.add_argument(
        "--parts", type=words, metavar="A,B", help=f"only these of {parts} (default: all)"
    )
    kind.add_argument(
        "--resume",
        action="store_true",
        help="go on with the results that --json already holds; of these only --parts are measured again",
    )


def _add(kinds, name: str, measure, words: str, part: str = ""):
    """Begin a kind of benchmark that ``measure`` runs. ``part``: when it is one whose document goes elsewhere."""
    kind = kinds.add_parser(name, help=words)
    kind.set_defaults(measure=measure)
    kind.add_argument("--json", type=Path, metavar="OUT.json", help="write all numbers here")
    elsewhere = f", {part} {PARTS}" if part else ""
    kind.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help=f"folder for {name}.md and its pictures (default: {DOCUMENTS}{elsewhere})",
    )
    add_force(kind)
    return kind


def _write(module, result: dict, options, is_part: bool = False) -> None:
    folder = options.output or (PARTS if is_part else DOCUMENTS)
    module.write_results(result, folder, options.json)
    tell(f"written to {folder / options.kind}.md")


def _read_earlier(options, module) -> dict | None:
    """Return what ``--resume`` goes on with."""
    if options.resume and options.json is None:
        raise LumenrayError("--resume needs --json: the file that is gone on with")
    return module.read_results(options.json) if options.resume and options.json.exists() else None


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


def _run_environment(options, say) -> int:
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.environment import run as environment

    earlier = _read_earlier(options, environment)
    result = environment.run(options.parts, options.maps, say, earlier)
    bars = environment.check_bars(result)
    tell(tell_bars(bars))
    _write(environment, result, options, not set(environment.PARTS) <= result["parts"].keys())
    return int(any(bar.passed is False for bar in bars))


def _run_paint(options, say) -> int:
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.paint import run as paint

    result = paint.run(options.parts, say, _read_earlier(options, paint))
    bars = paint.check_bars(result)
    tell(tell_bars(bars))
    _write(paint, result, options, not set(paint.PARTS) <= result["parts"].keys())
    return int(any(bar.passed is False for bar in bars))


def _run_cloth(options, say) -> int:
    from ..engine.transport import backend

    backend.start(spectral=False)
    # Its arrays are of the variant that has been started.
    from ..benchmarks.cloth import run as cloth
    from ..benchmarks.common.bars import tell_bars

    result = cloth.run(options.parts, say, _read_earlier(options, cloth))
    bars = cloth.check_bars(result)
    tell(tell_bars(bars))
    _write(cloth, result, options, not set(cloth.PARTS) <= result["parts"].keys())
    return int(any(bar.passed is False for bar in bars))


def _run_ink(options, say) -> int:
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.ink import run as ink

    result = ink.run(options.parts, say, _read_earlier(options, ink))
    bars = ink.check_bars(result)
    tell(tell_bars(bars))
    _write(ink, result, options, not set(ink.PARTS) <= result["parts"].keys())
    return int(any(bar.passed is False for bar in bars))


def _run_sync(options, say) -> int:
    start_blender()
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.sync import run as sync
    from ..benchmarks.sync.bars import COLUMNS, check_bars

    scenes, objects = options.scenes or tuple(sync.SCENES), options.objects or sync.OBJECTS
    unknown = [name for name in scenes if name not in sync.SCENES]
    if unknown:
        raise LumenrayError(
            f"there is no scene {', '.join(unknown)}; choose from {', '.join(sync.SCENES)}"
        )
    with quiet():
        result = sync.run(scenes, objects, say=say)
    tell(tell_bars(check_bars(result), COLUMNS))
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


def _run_denoising(options, say) -> int:
    start_blender()
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.denoising import run as denoising
    from ..benchmarks.denoising.document import check_bars

    result = denoising.run(options.keep, say=say)
    tell(tell_bars(check_bars(result)))
    _write(denoising, result, options)
    return 0


def _run_content(options, say) -> int:
    start_blender()
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.common.output import write_numbers
    from ..benchmarks.content import run as content

    earlier = _read_earlier(options, content)
    result = content.run(
        options.features, say, lambda made: write_numbers(made, options.json), earlier
    )
    tell(tell_bars(content.check_bars(result)))
    _write(content, result, options, bool(options.features) and earlier is None)
    return 0


def _run_blends(options, say) -> int:
    start_blender()
    from ..benchmarks.blends import run as blends
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.common.output import write_numbers

    with quiet():
        result, pictures = blends.run(
            options.folder,
            options.files,
            say=say,
            keep=lambda made, _: write_numbers(made, options.json),
        )
    tell(tell_bars(blends.check_bars(result)))
    folder = options.output or (PARTS if options.files else DOCUMENTS)
    blends.write_results(result, pictures, folder, options.json)
    tell(f"written to {folder / options.kind}.md")
    return 0


def _run_daylight(options, say) -> int:
    from ..benchmarks.daylight import run as daylight

    earlier = _read_earlier(options, daylight)
    _start_engine()
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.common.output import write_numbers

    result = daylight.run(
        options.parts,
        options.weather,
        say=say,
        keep=lambda made: write_numbers(made, options.json),
        earlier=earlier,
    )
    tell(tell_bars(daylight.check_bars(result)))
    _write(daylight, result, options, bool(options.parts) and earlier is None)
    return 0


def _run_judgement(options, say) -> int:
    _start_engine()
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.judgement import run as judgement

    result = judgement.run(options.tables, say=say)
    tell(tell_bars(judgement.check_bars(result)))
    _write(judgement, result, options, options.tables is None)
    return 0


def _run_requirements(options, say) -> int:
    _start_engine()
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.common.output import write_numbers
    from ..benchmarks.requirements import run as needs

    unknown = set(options.scenes or ()) - set(needs.BUILDERS)
    if unknown:
        raise LumenrayError(
            f"there is no scene '{min(unknown)}', expected some of {', '.join(needs.BUILDERS)}"
        )
    result = needs.run(
        options.seeds,
        options.scenes,
        options.count,
        _read_earlier(options, needs),
        say,
        lambda state: write_numbers(state, options.json),
    )
    tell(tell_bars(needs.check_bars(result)))
    is_part = options.seeds < needs.SEEDS or len(result["scenes"]) < len(needs.BUILDERS)
    is_part |= result.get("count", 0) < needs.bounds.COUNT
    _write(needs, result, options, is_part)
    return 0


def _run_cluster(options, say) -> int:
    from ..benchmarks.cluster import run as cluster
    from ..benchmarks.common.bars import tell_bars

    result = cluster.run(
        options.parts,
        options.runs,
        options.workers,
        options.repeats,
        options.samples,
        say,
        _read_earlier(options, cluster),
        options.elsewhere and cluster.read_results(options.elsewhere),
    )
    bars = cluster.check_bars(result)
    tell(tell_bars(bars))
    is_small = options.runs < cluster.RUNS or options.samples < cluster.SAMPLES
    is_part = is_small or not set(cluster.PARTS) <= result["parts"].keys()
    _write(cluster, result, options, is_part)
    return int(any(bar.passed is False for bar in bars))


def _run_kernels(options, say) -> int:
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.kernels import run as kernels

    result = kernels.run(say=say)
    tell(tell_bars(kernels.check_bars(result)))
    _write(kernels, result, options)
    return 0


def _run_nodes(options, say) -> int:
    start_blender()
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.nodes import run as nodes

    result = nodes.run(say=say)
    tell(tell_bars(nodes.check_bars(result)))
    _write(nodes, result, options)
    return 0


def _run_versions(options, say) -> int:
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.versions import run as versions

    result = versions.run(options.checkout, say)
    tell(tell_bars(versions.check_bars(result)))
    _write(versions, result, options)
    return 0


def _run_service(options, say) -> int:
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.service import run as service

    asked = (options.users, options.count, options.kills)
    whole_size = (service.USERS, service.JOBS, service.KILLS)
    sizes = [own or most for own, most in zip(asked, whole_size, strict=True)]
    result = service.run(*sizes, say)
    bars = service.check_bars(result)
    tell(tell_bars(bars))
    _write(service, result, options, tuple(sizes) != whole_size)
    return int(any(bar.passed is False for bar in bars))


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


def _choose_scenes(options, builders) -> tuple[str, ...]:
    """Return what ``--scenes`` names, by default all."""
    unknown = [name for name in options.scenes or () if name not in builders]
    if unknown:
        raise LumenrayError(
            f"there is no scene {', '.join(unknown)}; choose from {', '.join(builders)}"
        )
    return tuple(options.scenes or builders)


def _run_forecasts(options, say) -> int:
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.pictures.forecasts import run as forecasts

    _start_engine()
    from ..benchmarks.pictures.scenes import BUILDERS

    scenes = _choose_scenes(options, BUILDERS)
    seconds = options.seconds or forecasts.SECONDS
    rounds = options.rounds or forecasts.ROUNDS
    is_part = set(scenes) != set(BUILDERS) or seconds < forecasts.SECONDS
    is_part = is_part or rounds < forecasts.ROUNDS
    result = forecasts.measure(scenes, seconds, rounds, say)
    tell(tell_bars(forecasts.check_bars(result)))
    _write(forecasts, result, options, is_part)
    return 0


def _run_pictures(options, say) -> int:
    from ..benchmarks.common.bars import tell_bars
    from ..benchmarks.pictures import run as pictures

    earlier = _read_earlier(options, pictures)
    _start_engine()
    from ..benchmarks.pictures.bars import check_bars
    from ..benchmarks.pictures.scenes import BUILDERS, SIZE

    scenes = _choose_scenes(options, BUILDERS)
    wanted, budget = options.size or SIZE, options.budget or pictures.BUDGET
    is_part = set(scenes) != set(BUILDERS) or tuple(wanted) != SIZE or budget < pictures.BUDGET
    is_part = is_part or options.only_races
    folder = options.output or (PARTS if is_part else DOCUMENTS)

    def keep(result: dict, key: str, pair) -> None:
        if pair is not None:
            pictures.write_pair(pair, key, folder)
        pictures.write_results(result, folder, options.json)

    card = options.card and tuple(map(pictures.read_results, options.card))
    result = pictures.measure(
        scenes,
        wanted,
        budget,
        keep,
        options.peers,
        earlier,
        say,
        options.processor_time,
        options.only_races,
        card,
    )
    tell(tell_bars(check_bars(result)))
    _write(pictures, result, options, is_part)
    return 0


def _start_engine() -> None:
    """Settle where LLVM lies before Dr.Jit is loaded, which looks for it then."""
    from ..engine.transport import backend

    backend.start(spectral=False)
