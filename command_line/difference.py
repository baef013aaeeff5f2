"""The command ``lumenray difference``: where pictures or lux maps differ, and whether by more than chance."""

from pathlib import Path

import numpy as np

from ..engine.errors import FileFormatError
from .output import add_force, check_free, percent, say, sheet

QUANTITIES = (
    ("Luminance.Y", "Luminance.error", "luminance", "cd/m2"),
    ("Illuminance.X", "Illuminance.error", "illuminance", "lx"),
    ("Y", "standard_error.Y", "illuminance", "lx"),
)
"""Channels of values and of their standard errors, what they are called for people, and their unit."""

COVERED = "covered.Y"
"""Channel that is 1 where a lux map lies on a surface."""

BEYOND, BLOCK = 3.0, 8
"""Standard errors from which on squares of pixels differ by more than chance, and their side. [pixel]"""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    parser = commands.add_parser(
        "difference", help="what one picture or lux map has more than another, in false colours"
    )
    words = "OpenEXR file of lumenray render or lumenray bake"
    parser.add_argument("file", type=Path, metavar="A.exr", help=words)
    parser.add_argument("other", type=Path, metavar="B.exr", help="one of the same size")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Path,
        metavar="OUT.png",
        help="drawing of A - B, .png or .svg",
    )
    parser.add_argument(
        "--quantity",
        choices=("luminance", "illuminance"),
        help="which of the file's quantities (default: the first that both have)",
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options) -> int:
    """Draw and tell a difference; return the exit code."""
    from ..engine.analysis.value_plan import difference_scale, draw_map
    from ..engine.formats.exr import read_channels

    check_free(options, options.output)
    if options.output.suffix.lower() not in {".png", ".svg"}:
        raise FileFormatError(options.output, "expected a name that ends in .png or .svg")
    first, second = read_channels(options.file), read_channels(options.other)
    name, error_name, quantity, unit = _shared(options, first, second)
    one, other = (channels[name].astype(np.float64) for channels in (first, second))
    if one.shape != other.shape:
        sizes = [f"{each.shape[1]}x{each.shape[0]}" for each in (one, other)]
        raise FileFormatError(
            options.other, f"has {sizes[1]} pixels, expected {sizes[0]} as {options.file.name}"
        )
    shown = np.isfinite(one) & np.isfinite(other)
    for channels in (first, second):
        if COVERED in channels and name == "Y":
            shown &= channels[COVERED] > 0.5
    if not shown.any():
        raise FileFormatError(
            options.file, f"has no {quantity} where {options.other.name} has some"
        )
    apart = one - other
    mean, before = float(apart[shown].mean()), float(other[shown].mean())
    largest = float(np.abs(apart[shown]).max())
    told = [("mean of A", f"{before + mean:.4g} {unit}"), ("mean of B", f"{before:.4g} {unit}")]
    relative = f" ({percent(mean / before, '+.3g')})" if before > 0.0 else ""
    told.append(("mean of A - B", f"{mean:+.4g} {unit}{relative}"))
    told.append(("largest", f"{largest:.4g} {unit}"))
    told.append(("root mean square", f"{np.sqrt((apart[shown] ** 2).mean()):.4g} {unit}"))
    if error_name in first and error_name in second:
        noise = np.hypot(*(each[error_name].astype(np.float64) for each in (first, second)))
        beyond = percent(_beyond_chance(apart, noise, shown))
        told.append(
            ("beyond chance", f"{beyond} of its squares of {BLOCK} pixels, by {BEYOND:g} errors")
        )
    caption = f"{options.file.name} - {options.other.name}: mean {mean:+.4g}, largest {largest:.4g} {unit}"
    scale = difference_scale(apart[shown], unit)
    drawing = draw_map(f"Difference of {quantity}", apart, shown, caption, scale, [], unit)
    drawing.save(options.output)
    say(sheet(f"{quantity}, {options.file.name} - {options.other.name}", told))
    say(f"written to {options.output}")
    return 0


def _beyond_chance(apart, noise, shown) -> float:
    """Share of squares of pixels whose means differ by more than their errors allow. [-]

    Errors of single pixels are known badly, and those of neighbours may have one cause: that of a square is the root mean
    square of its pixels', as if all erred alike, which it cannot exceed.
    """
    count = _squares(shown)
    known = count > 0.0
    mean = _squares(np.where(shown, apart, 0.0))[known] / count[known]
    error = np.sqrt(_squares(np.where(shown, noise, 0.0) ** 2)[known] / count[known])
    return float((np.abs(mean) > BEYOND * error).mean())


def _squares(values: np.ndarray) -> np.ndarray:
    """Sums over squares of pixels, those at the upper and right rim as large as is left. (h, w) -> (a, b)"""
    height, width = values.shape
    padded = np.pad(
        np.asarray(values, dtype=np.float64), [(0, -height % BLOCK), (0, -width % BLOCK)]
    )
    return padded.reshape(padded.shape[0] // BLOCK, BLOCK, -1, BLOCK).sum(axis=(1, 3))


def _shared(options, first, second) -> tuple[str, str, str, str]:
    """Return the quantity that is compared: its channels, name and unit.

    Raises
    ------
    FileFormatError    The files have none in common.
    """
    for row in QUANTITIES:
        if options.quantity in {None, row[2]} and row[0] in first and row[0] in second:
            return row
    wanted = options.quantity or "luminance or illuminance"
    raise FileFormatError(options.file, f"has no {wanted} in common with {options.other.name}")
