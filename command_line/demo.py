"""The command ``lumenray demo``: a picture and lux maps of the bundled office."""

import time
from pathlib import Path

from ..blender_addon import assumptions
from . import bake, render
from .bake_table import print_table
from .blend_file import open_blend
from .options import Parser
from .output import add_force, say

FOLDER = Path("out")
"""Where the results go if nothing is said."""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    demo = commands.add_parser("demo", help="render and bake the bundled office")
    demo.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help=f"folder for the results (default: {FOLDER})",
    )
    add_force(demo)
    demo.set_defaults(run=run)


def run(options) -> int:
    """Render and bake; return the exit code."""
    from ..libraries import scenes

    start, folder = time.perf_counter(), options.output or FOLDER
    path = scenes.scene_path("office")
    force = ["--force"] if options.force or options.output is None else []
    # A look at what it does, not a result to build by. The time is for machines that first have to make kernels.
    rule = ["--error", "5%", "--time", "180"]
    picture = _options(render, "render", str(path), "-o", str(folder / "office.exr"), *force)
    lux = _options(bake, "bake", str(path), "-o", str(folder), *rule, *force)
    depsgraph = open_blend(path)
    render.check_files(picture)
    bake.check_files(lux)
    say(f"Rendering {path.name}, a bundled office, with the Lumenray engine")
    render.render_open(picture, depsgraph)
    job = bake.bake_open(lux, depsgraph)
    assumptions.tell(job.report, job.notes, job.shortfall)
    print_table(job.maps)
    seconds = time.perf_counter() - start
    say(f"{seconds:.0f} s. Look at {folder}/office.png and {folder}/illuminance.1001.png")
    return 0


def _options(command, *words: str):
    """Read the options of another command."""
    parser = Parser(prog="lumenray")
    command.add_command(parser.add_subparsers())
    return parser.parse_args(words)
