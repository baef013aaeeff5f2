"""What the command ``lumenray bake`` prints of lux maps: a table, and what holds for the bake as a whole."""

import math

from .output import name_cell, percent, say, table

MOST_DIGITS = 6
"""After the point, where the range of an extreme is very narrow."""

SMALL = 1e-3
"""Extremes below it are written with a power of ten. [lx, -]"""


def print_table(maps) -> None:
    """Print mean, minimum and maximum illuminance per surface."""
    rows = [
        ("surface", "mean lx", "min lx (95 %)", "max lx (95 %)", "uniformity (95 %)", "map error", "lumels")
    ]  # fmt: skip
    rows += [
        (
            name_cell(made.name),
            _format_mean(made.mean, made.mean_standard_error),
            _format_range(made.least),
            _format_range(made.largest),
            _format_range(made.uniformity),
            _format_error(made.relative_standard_error),
            f"{made.lumels}",
        )
        for made in maps
    ]
    say(table(rows))


def _format_mean(value: float, error: float) -> str:
    """Return a mean with its standard error by the size of the error."""
    from ..blender_addon.readout import format_estimate, format_number

    if not math.isfinite(error):
        return _plain(f"{format_number(value)} (error not known)")
    return _plain(format_estimate(value, error))


def _format_error(error: float) -> str:
    """Return a relative standard error in per cent; as in the panel, but for very large ones."""
    from ..blender_addon.readout import format_error

    return percent(error, ".0f") if 1.0 <= error < math.inf else format_error(error)


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
    from ..engine.requirements.budget import tell_parts

    absolute = absolute_error(result)
    lux = f" ({absolute:.3g} lx)" if math.isfinite(absolute) else ""
    say(
        f"all maps: mean {result.mean:.4g} lx, error {_format_error(result.relative_standard_error)}{lux}, "
        f"{_format_error(result.quadratic_relative_error)} of the root mean square"
    )
    simplified = result.maps[0].provenance.simplified if result.maps else 0.0
    if parts := tell_parts(result.relative_standard_error, simplified):
        say(f"the error is made of: {parts}")
    marks = result.history.marks
    made = [mark for mark in marks if mark.forecast is not None]
    if made:
        first, taken = made[0], marks[-1].seconds
        say(
            f"time: {format_seconds(taken)}; after {first.seconds:.1f} s the forecast was "
            f"{format_seconds(first.forecast)} ({percent(first.forecast / taken - 1, '+.1f')})"
        )
    seams = result.seams
    if seams.pairs:
        say(
            f"seams: {seams.pairs} places, steps {seams.before:.3g} lx before and {seams.after:.3g} lx "
            f"after matching, noise {seams.noise:.3g} lx"
        )
    known = [made for made in result.maps if 0.0 < made.bias_error < float("inf")]
    if known:
        worst = max(known, key=lambda made: abs(made.bias))
        say(
            f"bias of a mean by the cells: {worst.bias:.3g} ± {worst.bias_error:.2g} lx at most ({name_cell(worst.name)})"
        )
    if result.shrink < 0.999:
        say(f"density lowered to {percent(result.shrink, '.0f')} to fit the pages")
