"""The command ``lumenray cloth close-up``: a picture of one repeat, threads and all."""

from pathlib import Path

from ..options import whole
from ..output import add_output, check_free, save_picture, say
from .file import composition

LARGEST_PICTURE, MOST_SAMPLES = 1024, 4096


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    own = tasks.add_parser("close-up", help="draw one repeat from near, lit from the right")
    own.add_argument(
        "file", type=Path, metavar="FILE", help="composition, or the name of one that ships"
    )
    add_output(own, "OUT.png", "picture to write")
    own.add_argument(
        "--size",
        type=whole(16, LARGEST_PICTURE),
        default=128,
        metavar="N",
        help="width of a repeat (default: 128)",
    )
    own.add_argument(
        "--samples",
        type=whole(1, MOST_SAMPLES),
        default=64,
        metavar="N",
        help="rays of each pixel (default: 64)",
    )
    own.add_argument("--repeats", type=whole(1, 32), default=2, metavar="N", help="(default: 2)")
    own.add_argument("--seed", type=whole(0), default=0, metavar="N", help="(default: 0)")
    own.set_defaults(run=run)


def run(options) -> int:
    """Draw a cloth from near; return the exit code."""
    from ...engine.transport import backend

    check_free(options, options.output)
    cloth = composition(options.file)
    backend.start(spectral=False)
    # Their arrays are of the variant that has been started.
    from ...engine.analysis.cloth_picture import draw_threads
    from ...engine.cloth.close_up import draw_close_up

    made = draw_close_up(cloth, options.size, options.samples, seed=options.seed)
    width, depth = made.size * options.repeats
    save_picture(draw_threads(made, options.repeats), options.output)
    say(f"{cloth.name}: {width:.3g} x {depth:.3g} mm")
    return 0
