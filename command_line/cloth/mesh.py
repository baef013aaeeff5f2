"""The command ``lumenray cloth mesh``: a piece of cloth as tubes, for close-ups."""

from pathlib import Path

from ..options import whole
from ..output import add_force, check_free, say
from .file import composition


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    mesh = tasks.add_parser("mesh", help="make a mesh of its yarns, for pictures from close by")
    mesh.add_argument(
        "file", type=Path, metavar="FILE", help="composition, or the name of one that ships"
    )
    mesh.add_argument("-o", "--output", type=Path, metavar="OUT.obj", required=True)
    mesh.add_argument(
        "--repeats", type=whole(1, 64), default=1, metavar="N", help="of the weave (default: 1)"
    )
    add_force(mesh)
    mesh.set_defaults(run=run)


def run(options) -> int:
    """Write a mesh; return the exit code."""
    from ...engine.cloth.mesh import mesh_of, write_obj

    check_free(options, options.output)
    cloth = composition(options.file)
    mesh = mesh_of(cloth, options.repeats)
    write_obj(options.output, mesh, cloth.name)
    width, depth = 1e3 * mesh.size
    say(
        f"{cloth.name}: {len(mesh.quads):,} faces, {width:.4g} x {depth:.4g} mm; copies shifted by these join"
    )
    say(f"written to {options.output} ({options.output.stat().st_size:,} bytes)")
    return 0
