"""The command ``lumenray bake``: lux maps of objects."""

import argparse
from dataclasses import replace
from pathlib import Path

from ..blender_addon import assumptions
from ..engine.errors import Cancelled, FileFormatError, LumenrayError
from . import bake_observers, requirements
from .bake_table import print_bake, print_table
from .blend_file import open_blend, quiet
from .cluster_options import add_cluster, open_engine
from .interruption import Interruption
from .modelling import overrule
from .options import add_rule, add_scene, add_witness, real, rule_of, whole, words
from .output import add_output, check_free, complain, say
from .progress import Bar


def add_command(commands) -> None:
    """Describe the command to argparse. Options that the panel has as well are called as there."""
    bake = commands.add_parser("bake", help="compute lux maps of objects", epilog=assumptions.CODES)
    add_scene(bake)
    what = "folder for the atlas (.exr in lx, .png in false colours), report.json and error.png"
    add_output(bake, "DIR", what)
    bake.add_argument(
        "--objects",
        type=words,
        default=(),
        metavar="A,B",
        help="objects by name (default: the collection 'Bake', else all meshes)",
    )
    _add_layout(bake.add_argument_group("layout (default: as the scene says)"))
    _add_light(bake.add_argument_group("light (default: as the scene says)"))
    add_rule(bake, "lumel").add_argument(
        "--error-lx",
        type=real(),
        metavar="LX",
        help="standard error in lx; the first end that is met counts",
    )
    _add_files(bake.add_argument_group("files"))
    requirements.add_options(bake, "the first of the requirement, of every surface that is baked")
    assumptions.add_option(bake)
    add_cluster(bake)
    bake.set_defaults(run=run)


def _add_layout(layout) -> None:
    layout.add_argument(
        "--lumels-per-m",
        type=real(0.01, 1000.0),
        metavar="N",
        help="density on the surface; objects' own densities are left out then",
    )
    layout.add_argument(
        "--page-size", type=whole(32, 8192), metavar="N", help="largest side of a page in lumels"
    )
    layout.add_argument(
        "--most-pages",
        type=whole(0, 1000),
        metavar="N",
        help="all charts shrink to fit on so many; 0: any number",
    )
    layout.add_argument(
        "--margin", type=whole(1, 64), metavar="N", help="lumels by which charts are extended"
    )


def _add_light(light) -> None:
    light.add_argument(
        "--layers",
        choices=("none", "groups", "each"),
        help="illuminance by light group, or by each luminaire, beside the whole",
    )
    light.add_argument(
        "--exitance-in-colour",
        action=argparse.BooleanOptionalAction,
        help="also the light that leaves the surfaces",
    )
    light.add_argument(
        "--method",
        choices=("auto", "cells", "paths"),
        help="what stands for the radiance beyond the first bounce",
    )
    light.add_argument(
        "--caustics", choices=("auto", "on", "off"), help="trace light from the lights as well"
    )
    light.add_argument(
        "--denoise-exitance",
        action=argparse.BooleanOptionalAction,
        help="let Open Image Denoise filter the exitance; lux stay as computed",
    )
    add_witness(light)


def _add_files(files) -> None:
    files.add_argument(
        "--resume",
        action="store_true",
        help="go on with the unfinished bake in DIR, and replace what it wrote; error, time and samples may be others",
    )
    files.add_argument(
        "--isolux-lines",
        action=argparse.BooleanOptionalAction,
        help="also draw every page with isolux lines, illuminance.NUMBER.isolux.png and .svg (default: as the scene says)",
    )
    files.add_argument(
        "--arrays",
        action="store_true",
        help="also write every page and its layers as arrays of NumPy, NAME.NUMBER.npy, 32-bit floats, bottom row first",
    )
    files.add_argument(
        "--gltf",
        type=Path,
        metavar="OUT.glb",
        help="also write the baked objects with their light, for viewers on the web (.glb or .gltf)",
    )
    files.add_argument(
        "--most-textures", type=whole(), metavar="N", help="textures that this file may have"
    )
    files.add_argument(
        "--texture-size",
        type=whole(1, 16384),
        metavar="N",
        help="largest side of one of them, in texels",
    )
    files.add_argument(
        "--save",
        type=Path,
        metavar="F.blend",
        help="save the file with UV maps and images to this place",
    )


def run(options) -> int:
    """Bake objects of a file; return the exit code."""
    required = requirements.find(options)
    depsgraph = open_blend(options.file)
    check_files(options)
    kept = overrule(depsgraph.scene, options)
    job = bake_open(options, depsgraph)
    if options.save is not None:
        _save(options.save, job, kept)
    assumptions.tell(job.report, job.notes, job.shortfall)
    print_table(job.maps)
    print_bake(job.result)
    if required is not None:
        _judge(job, options, *required)
        bake_observers.judge_observers(options, depsgraph, required[0])
    say(f"written to {options.output}")
    if options.gltf in job.files:
        say(f"written to {options.gltf}")
    if job.result.shortfall:
        more = "; --resume goes on with it" if job.order.checkpoint is not None else ""
        complain(f"the bake was stopped before its end{more}")
    return assumptions.exit_code(job.report, options.accept_missing, job.shortfall)


VERDICTS = "verdicts.json"
"""File of the verdicts on maps, beside their report."""


def _judge(job, options, requirement, area: str, limits: int) -> None:
    """Say of every map whether it meets a requirement, and write it down."""
    from ..engine.formats.report import write_json
    from ..engine.judgement.assessment import assess, describe, figures_of_map, tell
    from .output import name_cell

    rows = []
    for made in job.maps:
        figures, seconds = figures_of_map(made, limits), made.provenance.seconds
        judged = assess(
            requirement, area, figures, seconds, options.maintenance, is_modified=options.modified
        )
        say(f"{name_cell(made.name)}: " + "\n".join(tell(judged)))
        rows.append({"object": made.name, **describe(judged)})
    asked = {
        "key": requirement.key,
        "title": requirement.title,
        "standard": requirement.standard,
    }
    write_json(options.output / VERDICTS, asked | {"areas": rows})


def _save(path: Path, job, kept) -> None:
    """Save the open file with the maps; where that fails the report says so, and the maps in their folder stay.

    ``kept``: what the file says of simplifications, which stays.
    """
    import bpy

    from ..blender_addon.bake import job as bake
    from ..blender_addon.modelling.wishes import wishing

    scene = bpy.context.scene
    bake.store(job, scene)
    try:
        with wishing(scene.lumenray.modelling, kept), quiet():
            bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), copy=True)
    except RuntimeError as error:
        job.report.error(path.name, str(error).strip(), "the file is not saved")


def check_files(options) -> None:
    """Refuse to write over results that are there, see `check_free`; what goes on with a bake replaces its own."""
    from ..blender_addon.bake.folders import RESULTS

    if options.output.is_file():
        raise FileFormatError(options.output, "is a file, expected a folder to write into")
    if not options.resume:
        results = (path for name in RESULTS for path in options.output.glob(name))
        remedy = "--force replaces it, --resume goes on with an unfinished bake"
        check_free(options, *results, remedy=remedy)
        check_free(options, options.gltf, options.save, options.output / bake_observers.FILE)


def bake_open(options, depsgraph):
    """Bake objects of the open file; return the finished job."""
    from ..blender_addon.bake import folders as bake_folders
    from ..blender_addon.bake import job as bake

    objects = _chosen(options, depsgraph.scene)
    settings = _settings(options, depsgraph.scene.lumenray, objects)
    job = bake.prepare(depsgraph, objects, settings)
    assumptions.refuse_missing(job.report, options.accept_missing)
    try:
        with open_engine(options) as session, Bar("bake") as bar, Interruption(job):
            job.run(session, bar)
    except Cancelled:
        kept = bake_folders.checkpoint_path(settings.folder).is_file()
        more = "; --resume goes on with what is done" if kept else ""
        raise Cancelled(f"the bake was cancelled, nothing was written{more}") from None
    return job


def _settings(options, settings, objects):
    """Return the scene's `BakeSettings` with what was asked for."""
    from ..blender_addon.bake import job as bake

    rule = rule_of(options, lambda: bake.rule_of(settings.bake))
    order = {
        "density": options.lumels_per_m,
        "seed": options.seed,
        "transport": options.transport,
        "largest": options.page_size,
        "pages": options.most_pages,
        "margin": options.margin,
        "exitance": options.exitance_in_colour,
        "denoise": options.denoise_exitance,
        "method": options.method,
        "caustics": options.caustics,
        "witness": options.witness,
        "isolux": options.isolux_lines,
        "arrays": options.arrays,
    }
    around = {
        "densities": None if options.lumels_per_m is None else {},
        "layers": options.layers,
        "gltf": options.gltf and bake.gltf_path(options.gltf),
        "gltf_textures": options.most_textures,
        "gltf_size": options.texture_size,
    }
    return replace(
        bake.read_settings(settings, objects, rule, options.output).ask(**_stated(order)),
        **_stated(around),
        resume=options.resume,
        # The folder was named, and `check_files` has asked.
        overwrite=True,
    )


def _stated(values: dict) -> dict:
    """Those options that were given."""
    return {name: value for name, value in values.items() if value is not None}


def _chosen(options, scene) -> list:
    """Objects that were named, else those of the collection, else all."""
    from ..blender_addon.bake.job import bakeable

    missing = [name for name in options.objects if name not in scene.objects]
    if missing:
        raise LumenrayError(f"{options.file}: the scene has no object named {', '.join(missing)}")
    if options.objects:
        return [scene.objects[name] for name in options.objects]
    for collection in scene.collection.children_recursive:
        if collection.name == "Bake":
            return bakeable(collection.all_objects)
    return bakeable(scene.objects)
