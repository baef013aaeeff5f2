"""What the commands for cloths share: compositions by file or name, and how they are computed."""

from pathlib import Path

from ..options import whole

MOST_RAYS = 10_000_000


def add_file(parser) -> None:
    """Let a command be told of a composition, and how many rays to send."""
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="composition, or the name of one that ships"
    )
    parser.add_argument(
        "--rays",
        type=whole(100, MOST_RAYS),
        metavar="N",
        help="for each direction from which light comes (default: 120000)",
    )
    parser.add_argument(
        "--mean",
        action="store_true",
        help="the mean of warp and weft, straight and side by side, in place of the weave",
    )
    parser.add_argument(
        "--seed", type=whole(0), default=0, metavar="N", help="of the rays (default: 0)"
    )


def composition(path: Path):
    """Read the composition that a command was told of."""
    from ...engine.cloth.reader import read_cloth
    from ...libraries import cloths

    if not path.exists() and str(path) in cloths.presets():
        path = cloths.presets()[str(path)]
    return read_cloth(path)


def compute_cloth(options):
    """Compute the composition that a command was told of."""
    from ...engine.transport import backend

    cloth = composition(options.file)
    backend.start(spectral=False)
    # Its arrays are of the variant that has been started.
    from ...engine.cloth.plan import RAYS
    from ...engine.cloth.woven import weave

    return weave(cloth, rays=options.rays or RAYS, seed=options.seed, is_mean=options.mean)
