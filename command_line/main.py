"""The command ``lumenray``: pictures, lux maps and sensor readings of a .blend file, and photometric files; no window."""

import argparse
import math
import sys
import time
from pathlib import Path

from ..blender_addon import assumptions
from ..engine import VERSION
from ..engine.reading.printable import printable
from ..engine.scene.sensor import SensorKind
from . import benchmark as benchmark_commands
from . import brdf as scattering_commands
from . import explain as explain_command
from . import luminaire as luminaire_commands
from . import rayset as rayset_commands
from . import sensitivity as sensitivity_command
from . import spectrum as spectrum_commands
from . import validate as validate_command
from .luminaire import say
from .terminal import Bar, quiet

EPILOG = """examples:
  lumenray render office.blend -o office.exr --samples 128
  lumenray bake office.blend -o lux --objects "Floor,Desk Top A" --density 20 --error 0.01
  lumenray bake office.blend -o lux --absolute 5 --time 600 --layers groups --gltf office.glb
  lumenray measure office.blend --sensors grid.csv -o readings.csv --error 0.005
  lumenray explain office.blend
  lumenray luminaire info downlight.ies
  lumenray rayset info led.ray
  lumenray brdf info paint.bsdf

All answers are in photometric units (lx, cd/m2) and carry their standard error. The same seed gives the same answer.
"""

CODES = {
    "epilog": assumptions.CODES,
    "formatter_class": argparse.RawDescriptionHelpFormatter,
}
"""What argparse is told of commands that compute a scene."""

MOST_DIGITS = 6
"""After the point, where the range of an extreme is very narrow."""

SMALL = 1e-3
"""Extremes below it are written with a power of ten. [lx, -]"""


def build_parser() -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = argparse.ArgumentParser(
        prog="lumenray",
        description="Lighting of Blender scenes in real units, with a stated error.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"lumenray {VERSION}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    render = commands.add_parser(
        "render", help="render the scene's camera to an OpenEXR file", **CODES
    )
    _add_scene(render)
    render.add_argument(
        "-o",
        "--output",
        required=True,
        type=Path,
        metavar="OUT.exr",
        help="linear picture; a .png for looking and a .json report are written beside it",
    )
    render.add_argument(
        "--size", type=_size, metavar="WxH", help="picture size in pixels (default: the scene's)"
    )
    render.add_argument(
        "--spectral",
        type=int,
        metavar="BANDS",
        default=0,
        help="also write a spectral OpenEXR with this many bands from 380 to 780 nm",
    )
    render.add_argument(
        "--illuminance",
        action="store_true",
        help="also compute the illuminance of the visible surfaces [lx]",
    )
    render.add_argument(
        "--raw",
        action="store_true",
        help="do not smooth the .png (the .exr is never smoothed)",
    )
    _add_rule(render, "pixel")
    assumptions.add_option(render)

    _add_bake(commands)

    _add_measure(commands)
    _add_scene(explain_command.add_command(commands))
    _add_scene(sensitivity_command.add_command(commands))
    luminaire_commands.add_commands(commands, _size)
    rayset_commands.add_commands(commands)
    scattering_commands.add_commands(commands)
    spectrum_commands.add_commands(commands, _size)
    validate_command.add_command(commands)

    demo = commands.add_parser("demo", help="render and bake the bundled office")
    demo.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("out"),
        metavar="DIR",
        help="folder for the results (default: out)",
    )

    benchmark_commands.add_commands(commands, _words, _numbers, _count)
    return parser


def _add_measure(commands) -> None:
    measure = commands.add_parser("measure", help="illuminance at sensors from a list", **CODES)
    _add_scene(measure)
    measure.add_argument(
        "--sensors",
        required=True,
        type=Path,
        metavar="IN.csv",
        help="x,y,z,nx,ny,nz in metres; the normal is where the sensor faces",
    )
    measure.add_argument(
        "-o",
        "--output",
        required=True,
        type=Path,
        metavar="OUT.csv",
        help="the same columns and illuminance_lx, standard_error_lx",
    )
    measure.add_argument(
        "--kind",
        choices=[kind.value for kind in SensorKind],
        default=SensorKind.PLANAR.value,
        help="which illuminance; spherical and cylindrical (vertical) ones have no normal (default: planar)",
    )
    measure.add_argument(
        "--reflections",
        type=int,
        metavar="N",
        help="count only light that was reflected at most N times; 0 is the direct part",
    )
    measure.add_argument(
        "--colour",
        action="store_true",
        help="also write the chromaticity x, y of the light that arrives",
    )
    measure.add_argument(
        "--each",
        type=float,
        metavar="E",
        help="go on until the relative standard error of every sensor is below E",
    )
    _add_witness(measure)
    _add_rule(measure, "sensor")
    assumptions.add_option(measure)


def _add_bake(commands) -> None:
    bake = commands.add_parser("bake", help="compute lux maps of objects", **CODES)
    _add_scene(bake)
    bake.add_argument(
        "-o",
        "--output",
        required=True,
        type=Path,
        metavar="DIR",
        help="folder for the atlas (.exr in lx, .png in false colours), report.json and error.png",
    )
    bake.add_argument(
        "--objects",
        default="",
        metavar="A,B",
        help="objects by name (default: the collection 'Bake', else all meshes)",
    )
    layout = bake.add_argument_group("layout (default: as the scene says)")
    layout.add_argument(
        "--density",
        type=float,
        metavar="LUMELS_PER_METRE",
        help="resolution on the surface; objects' own densities are left out then",
    )
    layout.add_argument("--size", type=int, metavar="N", help="largest side of a page in lumels")
    layout.add_argument(
        "--pages", type=int, metavar="N", help="most pages, all charts shrink to fit; 0: any number"
    )
    layout.add_argument(
        "--margin", type=int, metavar="N", help="lumels by which charts are extended"
    )
    light = bake.add_argument_group("light (default: as the scene says)")
    light.add_argument(
        "--layers",
        choices=("none", "groups", "each"),
        help="illuminance by light group, or by each luminaire, beside the whole",
    )
    light.add_argument(
        "--exitance",
        action=argparse.BooleanOptionalAction,
        help="also the light that leaves the surfaces, in colour",
    )
    light.add_argument(
        "--smooth",
        action=argparse.BooleanOptionalAction,
        help="smooth the maps after their error is known",
    )
    light.add_argument(
        "--method",
        choices=("auto", "cells", "paths"),
        help="what stands for the radiance beyond the first bounce",
    )
    light.add_argument(
        "--caustics", choices=("auto", "on", "off"), help="trace light from the lights as well"
    )
    _add_witness(light)
    rule = _add_rule(bake, "lumel")
    rule.add_argument(
        "--absolute",
        type=float,
        metavar="LX",
        help="standard error in lx; the first end that is met counts",
    )
    bake.add_argument(
        "--resume",
        action="store_true",
        help="go on with the unfinished bake in DIR; error, time and samples may be others",
    )
    bake.add_argument(
        "--gltf",
        type=Path,
        metavar="OUT.glb",
        help="also write the baked objects with their light, for viewers on the web (.glb or .gltf)",
    )
    bake.add_argument("--gltf-textures", type=int, metavar="N", help="most textures of that file")
    bake.add_argument(
        "--gltf-size", type=int, metavar="N", help="largest side of one of them, in texels"
    )
    bake.add_argument(
        "--save",
        type=Path,
        metavar="F.blend",
        help="save the file with UV maps and images to this place",
    )
    assumptions.add_option(bake)


def _add_scene(parser) -> None:
    parser.add_argument("file", type=Path, metavar="F.blend", help="Blender file")
    parser.add_argument(
        "--seed", type=int, metavar="N", help="same seed, same result (default: the scene's)"
    )
    parser.add_argument(
        "--transport",
        choices=("auto", "mono", "spectral"),
        help="photometric or spectral computation (default: the scene's)",
    )


def _add_witness(parser) -> None:
    parser.add_argument(
        "--witness",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="compare with a few light paths from the lights, so that errors cover what they find (default: yes)",
    )


def _add_rule(parser, per: str):
    rule = parser.add_argument_group("when to stop (default: as the scene says)")
    rule.add_argument("--samples", type=int, metavar="N", help=f"paths per {per}")
    rule.add_argument(
        "--error", type=float, metavar="E", help="relative standard error, 0.01 is 1 %%"
    )
    rule.add_argument("--time", type=float, metavar="S", help="seconds")
    return rule


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdigit() and height.isdigit() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"expected WIDTHxHEIGHT such as 640x400, found '{text}'")
    return int(width), int(height)


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",") if word.strip())


def _numbers(text: str) -> tuple[int, ...]:
    words = _words(text)
    if not words or not all(word.isdigit() and int(word) for word in words):
        raise argparse.ArgumentTypeError(f"expected numbers such as 100,1000, found '{text}'")
    return tuple(int(word) for word in words)


def _count(text: str) -> int:
    if not (text.isdigit() and int(text)):
        raise argparse.ArgumentTypeError(f"expected a number from 1 on, found '{text}'")
    return int(text)


def main(arguments=None) -> int:
    """Run the command; 0 on success, 1 with one line on standard error on any failure, else see `assumptions.CODES`."""
    options = build_parser().parse_args(arguments)
    from ..engine.errors import LumenrayError

    try:
        return {
            "render": _render,
            "bake": _bake,
            "measure": _measure,
            "explain": _explain,
            "sensitivity": _sensitivity,
            "luminaire": luminaire_commands.run,
            "rayset": rayset_commands.run,
            "brdf": scattering_commands.run,
            "spectrum": spectrum_commands.run,
            "validate": validate_command.run,
            "demo": _demo,
            "benchmark": benchmark_commands.run,
        }[options.command](options)
    except LumenrayError as error:
        print(f"lumenray: {printable(str(error))}", file=sys.stderr)
    except KeyboardInterrupt:
        print("lumenray: stopped", file=sys.stderr)
    return 1


# ---- Blender ----


def _open(path: Path):
    """Open a .blend file and return its evaluated dependency graph."""
    from ..engine.errors import LumenrayError

    try:
        import bpy
    except ImportError as error:
        raise LumenrayError(
            f"Blender's Python module cannot be loaded ({error}); run 'make setup'"
        ) from None
    from ..blender_addon import registry

    if not path.is_file():
        raise LumenrayError(f"{path}: no such file")
    registry.register()
    try:
        with quiet():
            bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        raise LumenrayError(f"{path}: Blender cannot open it ({str(error).strip()})") from None
    return bpy.context.evaluated_depsgraph_get()


def _rule(options, kind, samples, error, seconds):
    from ..blender_addon.rendering.render_engine import stop_rule
    from ..engine.accuracy.stopping import StopRule

    if options.samples is None and options.error is None and options.time is None:
        return stop_rule(kind, samples, error, seconds)
    return StopRule(options.samples, options.error, options.time)


def _transport(options, settings) -> str:
    return options.transport or settings.transport.lower()


# ---- commands ----


def _render(options) -> int:
    depsgraph = _open(options.file)
    return _render_open(options, depsgraph)


def _render_open(options, depsgraph):
    """Render the open file and write picture, preview and report. Returns the exit code."""
    from dataclasses import replace

    from ..blender_addon.foundation.exposure import white_luminance
    from ..blender_addon.rendering.render_engine import shown_light, view_settings
    from ..blender_addon.sync.scene import convert_scene
    from ..engine.analysis.false_colour import write_display
    from ..engine.errors import LumenrayError
    from ..engine.formats import exr
    from ..engine.formats.report import compose, write_json
    from ..engine.photometry.colour import automatic_white, scene_linear
    from ..engine.session import Session

    scene = depsgraph.scene
    settings = scene.lumenray
    if options.size:
        scene.render.resolution_x, scene.render.resolution_y = options.size
        scene.render.resolution_percentage = 100
    converted = convert_scene(depsgraph)
    if converted.camera is None:
        raise LumenrayError(f"{options.file}: the scene has no camera; add one and make it active")
    assumptions.refuse_missing(converted.report, options.accept_missing)
    wanted = replace(
        view_settings(scene),
        rule=_rule(options, settings.stop, settings.samples, settings.error, settings.time),
        seed=settings.seed if options.seed is None else options.seed,
        transport=_transport(options, settings),
        illuminance=options.illuminance or settings.use_pass_illuminance,
        bands=options.spectral or (settings.spectral_bands if settings.use_spectral_file else 0),
        spectral_file=str(options.output.with_name(options.output.stem + "_spectral.exr")),
    )
    session = Session()
    session.apply(converted.delta)
    bar = Bar("render")
    picture = session.render(converted.camera, wanted, bar)
    bar.close()
    white = white_luminance(settings) or automatic_white(picture.tristimulus[..., 1])
    linear = scene_linear(shown_light(picture), white)
    channels = {name: linear[..., i] for i, name in enumerate("RGB")}
    if picture.coverage is not None:
        channels["A"] = picture.coverage
    channels |= {
        "Luminance.Y": picture.tristimulus[..., 1],
        "Luminance.error": picture.luminance_error,
        "Depth.Z": picture.depth,
        **{f"Normal.{name}": picture.normal[..., i] for i, name in enumerate("XYZ")},
        "IndexOB.X": picture.object_index,
        "IndexMA.X": picture.material_index,
    }
    if picture.illuminance is not None:
        channels |= {
            "Illuminance.X": picture.illuminance,
            "Illuminance.error": picture.illuminance_error,
        }
    # whiteLuminance is OpenEXR's standard attribute: the luminance of (1, 1, 1).
    exr.write_channels(
        options.output,
        channels,
        {"whiteLuminance": white, "sceneHash": picture.provenance.scene_hash},
    )
    shown = linear if options.raw else _smoothed(picture, linear, white)
    write_display(options.output.with_suffix(".png"), shown)
    luminance = picture.tristimulus[..., 1]
    shortfall = wanted.rule.shortfall(picture.relative_error)
    row = {
        "name": scene.camera.name,
        "quantity": "luminance",
        "unit": "cd/m2",
        "mean": float(luminance.mean()),
        "minimum": float(luminance.min()),
        "maximum": float(luminance.max()),
        "relative_standard_error": picture.relative_error,
        "samples": picture.provenance.samples,
    }
    content = compose(
        options.file.name,
        picture.provenance,
        picture.provenance.seconds,
        [row],
        converted.report.to_dicts(),
        shortfall,
    )
    content["preview"] = (
        "as computed"
        if options.raw
        else "smoothed for looking at; all numbers are of the unsmoothed data"
    )
    write_json(options.output.with_suffix(".json"), content)
    assumptions.tell(converted.report, picture.provenance.notes, shortfall)
    print(
        f"{options.output}: {picture.provenance.samples} samples a pixel in {picture.provenance.seconds:.1f} s, "
        f"mean luminance {row['mean']:.4g} cd/m2, picture error {100 * picture.relative_error:.2f} %, "
        f"white = {white:.4g} cd/m2"
    )
    return assumptions.exit_code(converted.report, options.accept_missing, shortfall)


def _smoothed(picture, linear, white):
    """Smooth a picture for looking at; the numbers stay as they are."""
    from ..engine.analysis.noise_filter import smooth

    error = picture.luminance_error / white
    return smooth(linear, error, picture.normal, picture.depth, picture.albedo)


def _explain(options) -> int:
    depsgraph = _open(options.file)
    return explain_command.run(options, depsgraph, _transport(options, depsgraph.scene.lumenray))


def _sensitivity(options) -> int:
    depsgraph = _open(options.file)
    settings = depsgraph.scene.lumenray
    seed = settings.seed if options.seed is None else options.seed
    return sensitivity_command.run(options, depsgraph, _transport(options, settings), seed)


def _bake(options) -> int:
    import bpy

    depsgraph = _open(options.file)
    job = _bake_open(options, depsgraph)
    if options.save is not None:
        from ..blender_addon.bake import job as bake

        bake.store(job, bpy.context.scene)
        with quiet():
            bpy.ops.wm.save_as_mainfile(filepath=str(options.save.resolve()), copy=True)
    assumptions.tell(job.report, job.notes, job.shortfall)
    print_table(job.maps)
    print_bake(job.result)
    print(f"written to {options.output}")
    if options.gltf in job.files:
        print(f"written to {options.gltf}")
    if job.result.shortfall:
        more = "; --resume goes on with it" if job.order.checkpoint is not None else ""
        print(f"lumenray: the bake was stopped before its end{more}", file=sys.stderr)
    return assumptions.exit_code(job.report, options.accept_missing, job.shortfall)


def _bake_open(options, depsgraph):
    """Bake objects of the open file. Returns the finished job."""
    from dataclasses import replace

    from ..blender_addon.bake import folders as bake_folders
    from ..blender_addon.bake import job as bake
    from ..engine.errors import Cancelled
    from ..engine.session import Session
    from .interruption import Interruption

    settings = depsgraph.scene.lumenray
    objects = _chosen(options, depsgraph.scene)
    made = bake.read_settings(settings, objects, _bake_rule(options, settings), options.output)
    stated = {
        "density": options.density,
        "densities": None if options.density is None else {},
        "seed": options.seed,
        "transport": options.transport,
        "largest": options.size,
        "pages": options.pages,
        "margin": options.margin,
        "layers": options.layers,
        "exitance": options.exitance,
        "smooth": options.smooth,
        "method": options.method,
        "caustics": options.caustics,
        "witness": options.witness,
        "gltf_textures": options.gltf_textures,
        "gltf_size": options.gltf_size,
    }
    made = replace(
        made,
        **{name: value for name, value in stated.items() if value is not None},
        resume=options.resume,
        # The folder was named.
        overwrite=True,
        gltf=made.gltf if options.gltf is None else bake.gltf_path(options.gltf),
    )
    job = bake.prepare(depsgraph, objects, made)
    assumptions.refuse_missing(job.report, options.accept_missing)
    bar = Bar("bake")
    try:
        with Interruption(job):
            job.run(Session(), bar)
    except Cancelled:
        kept = bake_folders.checkpoint_path(made.folder).is_file()
        more = "; --resume goes on with what is done" if kept else ""
        raise Cancelled(f"the bake was cancelled, nothing was written{more}") from None
    finally:
        bar.close()
    return job


def _bake_rule(options, settings):
    from ..blender_addon.bake import job as bake
    from ..engine.accuracy.stopping import StopRule

    stated = (options.samples, options.error, options.time, options.absolute)
    if all(value is None for value in stated):
        return bake.rule_of(settings)
    return StopRule(
        samples=options.samples,
        error=options.error,
        seconds=options.time,
        absolute=options.absolute,
    )


def _chosen(options, scene) -> list:
    from ..blender_addon.bake.job import bakeable
    from ..engine.errors import LumenrayError

    if options.objects:
        names = [name.strip() for name in options.objects.split(",") if name.strip()]
        missing = [name for name in names if name not in scene.objects]
        if missing:
            raise LumenrayError(
                f"{options.file}: the scene has no object named {', '.join(missing)}"
            )
        return [scene.objects[name] for name in names]
    for collection in scene.collection.children_recursive:
        if collection.name == "Bake":
            return bakeable(collection.all_objects)
    return bakeable(scene.objects)


def _measure(options) -> int:
    from ..blender_addon.sync.scene import convert_scene
    from ..engine.accuracy.estimate import Estimate
    from ..engine.accuracy.stopping import StopRule
    from ..engine.errors import SceneError
    from ..engine.formats.sensors import read_sensors, write_measurements
    from ..engine.session import Session

    sensors = read_sensors(options.sensors)
    depsgraph = _open(options.file)
    settings = depsgraph.scene.lumenray
    converted = convert_scene(depsgraph)
    assumptions.refuse_missing(converted.report, options.accept_missing)
    session = Session()
    session.apply(converted.delta)
    bar = Bar("measure")
    if options.each is not None:
        rule = StopRule(seconds=options.time, each=options.each)
    else:
        rule = _rule(options, "SAMPLES", max(settings.bake_samples, 1024), 0.0, 0.0)
    if options.reflections is not None and options.reflections < 0:
        raise SceneError(f"--reflections is {options.reflections}, expected 0 or more")
    made = session.measure(
        sensors[:, :3],
        sensors[:, 3:],
        rule,
        settings.seed if options.seed is None else options.seed,
        _transport(options, settings),
        bar,
        kind=SensorKind(options.kind),
        reflections=options.reflections,
        colour=options.colour,
        witness=options.witness,
    )
    bar.close()
    found = Estimate(made.illuminance, made.standard_error, made.provenance.samples)
    shortfall = rule.shortfall(found.relative_error(), each=found.largest_error(rule.floor))
    notes = made.provenance.notes
    write_measurements(
        options.output,
        sensors,
        made.illuminance,
        made.standard_error,
        made.tristimulus,
        assumptions.lines_of(converted.report, notes, shortfall),
    )
    assumptions.tell(converted.report, notes, shortfall)
    print(
        f"{len(sensors)} sensors, {made.provenance.samples} samples each, written to {options.output}"
    )
    return assumptions.exit_code(converted.report, options.accept_missing, shortfall)


def _demo(options) -> int:
    from ..libraries import scenes

    start = time.perf_counter()
    path = scenes.scene_path("office")
    depsgraph = _open(path)
    common = {
        "file": path,
        "seed": None,
        "transport": None,
        "samples": None,
        "error": None,
        "time": None,
        "accept_missing": False,
    }
    view = argparse.Namespace(
        **common,
        output=options.output / "office.exr",
        size=None,
        raw=False,
        spectral=0,
        illuminance=False,
    )
    print(f"Rendering {path.name}, a bundled office, with the Lumenray engine")
    _render_open(view, depsgraph)
    # A look at what it does, not a result to build by.
    rule = ["--error", "0.05", "--time", "60"]
    lux = build_parser().parse_args(["bake", str(path), "-o", str(options.output), *rule])
    job = _bake_open(lux, depsgraph)
    assumptions.tell(job.report, job.notes, job.shortfall)
    print_table(job.maps)
    seconds = time.perf_counter() - start
    print(
        f"{seconds:.0f} s. Look at {options.output}/office.png and {options.output}/illuminance.1001.png"
    )
    return 0


def print_table(maps) -> None:
    """Print mean, minimum and maximum illuminance per surface."""
    rows = [
        ("surface", "mean lx", "min lx (95 %)", "max lx (95 %)", "uniformity (95 %)", "map error", "lumels")
    ]  # fmt: skip
    rows += [
        (
            _cell(made.name),
            _format_mean(made.mean, made.mean_standard_error),
            _format_range(made.least),
            _format_range(made.largest),
            _format_range(made.uniformity),
            _format_error(made.relative_standard_error),
            f"{made.lumels}",
        )
        for made in maps
    ]
    first, *widths = (max(map(len, column)) for column in zip(*rows, strict=True))
    for name, *cells in rows:
        right = (f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))
        say("  ".join([f"{name:<{first}}", *right]))


def _cell(name: str) -> str:
    """Return a name of the scene as it may stand in a line of a table."""
    return " ".join(printable(name).expandtabs(1).splitlines())


def _format_mean(value: float, error: float) -> str:
    """Return a mean with its standard error by the size of the error."""
    from ..blender_addon.readout import format_estimate, format_number

    if not math.isfinite(error):
        return _plain(f"{format_number(value)} (error not known)")
    return _plain(format_estimate(value, error))


def _format_error(error: float) -> str:
    """Return a relative standard error in per cent; as in the panel, but for very large ones."""
    from ..blender_addon.readout import format_error

    return f"{100.0 * error:.0f} %" if 1.0 <= error < math.inf else format_error(error)


def _format_range(extreme) -> str:
    """Return an `Extreme` with its range, all with as many digits as the width of the range and the value's size need."""
    from ..blender_addon.readout import format_number

    # Without the sign that a zero may have.
    numbers = (extreme.value + 0.0, extreme.low + 0.0, extreme.high + 0.0)
    if not math.isfinite(extreme.high):
        return _plain(f"{format_number(extreme.value)} (range not known)")
    size, half = abs(extreme.value), 0.5 * (extreme.high - extreme.low)
    if 0.0 < size < SMALL:
        value, low, high = (_plain(format_number(number)) for number in numbers)
    else:
        # The second digit of half the range, the third one of the value.
        needed = [1 - math.floor(math.log10(half))] if half > 0.0 else []
        needed += [2 - math.floor(math.log10(size))] if size > 0.0 else []
        digits = min(max(0, *needed), MOST_DIGITS) if needed else 0
        value, low, high = (f"{number:.{digits}f}" for number in numbers)
    return f"{value} ({low} to {high})"


def _plain(text: str) -> str:
    """Take the thin spaces out of numbers: not every terminal has them, and other programs read the table."""
    return text.replace("\u2009", "")


def print_bake(result) -> None:
    """Print what holds for a bake as a whole: error, forecast, seams, bias, and what had to shrink."""
    from ..engine.accuracy.stopping import format_seconds
    from ..engine.baking.files import absolute_error

    absolute = absolute_error(result)
    lux = f" ({absolute:.3g} lx)" if math.isfinite(absolute) else ""
    print(
        f"all maps: mean {result.mean:.4g} lx, error {_format_error(result.relative_standard_error)}{lux}, "
        f"{_format_error(result.quadratic_relative_error)} of the root mean square"
    )
    marks = result.history.marks
    made = [mark for mark in marks if mark.forecast is not None]
    if made:
        first, taken = made[0], marks[-1].seconds
        print(
            f"time: {format_seconds(taken)}; after {first.seconds:.1f} s the forecast was "
            f"{format_seconds(first.forecast)} ({100 * (first.forecast / taken - 1):+.1f} %)"
        )
    seams = result.seams
    if seams.pairs:
        print(
            f"seams: {seams.pairs} places, steps {seams.before:.3g} lx before and {seams.after:.3g} lx "
            f"after matching, noise {seams.noise:.3g} lx"
        )
    known = [made for made in result.maps if 0.0 < made.bias_error < float("inf")]
    if known:
        worst = max(known, key=lambda made: abs(made.bias))
        say(
            f"bias of a mean by the cells: {worst.bias:.3g} ± {worst.bias_error:.2g} lx at most ({_cell(worst.name)})"
        )
    if result.shrink < 0.999:
        print(f"density lowered to {100 * result.shrink:.0f} % to fit the pages")


if __name__ == "__main__":
    sys.exit(main())
