"""What the commands for paints share: compositions by file or name, and what they print of them."""

from pathlib import Path

from ..output import table


def add_file(parser) -> None:
    """Let a command be told of a composition."""
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="composition, or the name of one that ships"
    )
    parser.add_argument(
        "--constituents",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="library of constituents beside the one that ships (may be repeated)",
    )


def open_paint(options):
    """Read the composition that a command was told of."""
    from ...engine.paint.reader import known_constituents, read_paint

    return read_paint(path_of(options.file), known_constituents(options.constituents))


def path_of(file: Path) -> Path:
    """Path of a composition, by its own or by the name of one that ships."""
    from ...libraries import paints

    if not file.exists() and str(file) in paints.presets():
        return paints.presets()[str(file)]
    return file


def lab_table(angles, lab) -> str:
    """Lines of colours by aspecular angle."""
    rows = [("aspecular", "L*", "a*", "b*")]
    rows += [
        (f"{angle:g} deg", *(f"{value:.2f}" for value in row))
        for angle, row in zip(angles, lab, strict=True)
    ]
    return table(rows)
