"""What a table of a spectrum has to keep to, and what is said of one that is odd: ranges, order, gaps, ends, signs.

Both for files of spectra and for spectra within files of luminaires and rays.
"""

import numpy as np

from ..errors import FileFormatError
from ..photometry.spectra import GRID, luminous_efficiency
from ..photometry.units import VISIBLE
from ..reading.remarks import Remark

SHORTEST, LONGEST = 10.0, 1e5
"""Wavelengths that optical radiation has. [nm] (CIE S 017: 100 nm to 1 mm; tables of optical constants begin below)"""

NANOMETRES = 100.0
"""A table that ends below it is in another unit, or no table of a spectrum. [nm]"""

LARGEST = 1e30
"""Value that single precision can still be summed with."""

NOISE = 0.01
"""Share of the largest value down to which negative ones are noise about 0."""

GAP = 10.0
"""Times the usual step from which on a step is a gap."""

WIDE = 50.0
"""Least width of a gap that matters. [nm]"""

SLIP = 5.0
"""Ratio of neighbouring wavelengths, across a gap, from which on one of them is a typing error: a digit too many or few."""

DARK = 0.01
"""Share of the largest value at which a spectrum may end."""

LEAST_SEEN = 0.02
"""Share of what the eye sees that a table has to cover, unless it has fallen to nothing where it ends."""


def check_wavelengths(path, lines: np.ndarray, wavelengths: np.ndarray, values) -> list[Remark]:
    """Refuse wavelengths that cannot be, twice the same, or out of order; remark gaps.

    Parameters
    ----------
    path : str or Path    For messages.
    lines : (n,) int array    Where they stand.
    wavelengths : (n,) array    As the file orders them. [nm]
    values : (n,) array    Beside them; a gap with next to nothing on both sides is no matter.

    Raises
    ------
    FileFormatError
    """

    def fail(message, place=None):
        line = None if place is None else int(lines[place])
        raise FileFormatError(path, message, line)

    bad = np.flatnonzero(~np.isfinite(wavelengths))
    if len(bad):
        fail("expected finite numbers, found NaN or infinity", bad[0])
    bad = np.flatnonzero(wavelengths <= 0.0)
    if len(bad):
        fail(f"expected a wavelength above 0, found {wavelengths[bad[0]]:g}", bad[0])
    if wavelengths.max() < 20.0:
        fail(
            f"wavelengths end at {wavelengths.max():g}: expected nanometres, these look like micrometres"
        )
    if wavelengths.max() < NANOMETRES:
        fail(
            f"wavelengths from {wavelengths.min():g} to {wavelengths.max():g}: expected nanometres in the first column; "
            "are these numbers of samples, and the wavelengths in the first row?"
        )
    ordered = np.sort(wavelengths)
    doubled = np.flatnonzero(np.diff(ordered) <= 0.0)
    if len(doubled):
        nm = ordered[doubled[0]]
        fail(f"wavelength {nm:g} nm stands twice", np.flatnonzero(wavelengths == nm)[1])
    odd = _find_disorder(wavelengths)
    if odd is not None:
        fail(*odd)
    # After the order, which tells a typing error better.
    bad = np.flatnonzero((wavelengths < SHORTEST) | (wavelengths > LONGEST))
    if len(bad):
        fail(
            f"expected a wavelength from {SHORTEST:g} to {LONGEST:g} nm, found {wavelengths[bad[0]]:g}",
            bad[0],
        )
    return [Remark(text) for text in _check_gaps(wavelengths, values, fail)]


def tell_oddities(path, lines: np.ndarray, wavelengths: np.ndarray, values, name: str) -> list[str]:
    """Say what is odd about a lamp's spectrum that is part of a file: order, gaps, ends. None is a reason to refuse all.

    Parameters
    ----------
    path : str or Path    For messages.
    lines : (n,) int array    Where they stand, 0: nowhere that has a number.
    wavelengths : (n,) array    As the file orders them, each above 0 and once. [nm]
    values : (n,) array    Beside them, not negative, and not all 0.
    name : str    Of the spectrum, with which the sentences begin.

    Raises
    ------
    FileFormatError    A wavelength is so far from all others that it has a digit too many or few.
    """
    odd = _find_disorder(wavelengths)
    told = [] if odd is None else [f"is not in order, {odd[0]}; it is sorted"]
    order = np.argsort(wavelengths)
    lines, wavelengths, values = lines[order], wavelengths[order], values[order]

    def fail(message, place):
        raise FileFormatError(path, f"{name}: {message}", int(lines[place]) or None)

    told += _check_gaps(wavelengths, values, fail)
    cut, _ = _find_cut(wavelengths, values)
    told += [f"{cut}; beyond, there is no light"] if cut else []
    return [f"{name} {text}" for text in told]


def _find_disorder(wavelengths: np.ndarray) -> tuple[str, int] | None:
    """A wavelength that lies elsewhere than its neighbours, in words, and its place; None if there is none."""
    steps = np.diff(wavelengths)
    sense = 1.0 if (steps > 0.0).sum() >= (steps < 0.0).sum() else -1.0
    wrong = np.flatnonzero(sense * steps < 0.0)
    if not len(wrong):
        return None
    first = int(wrong[0])
    # Either of both may be the odd one: that without which its neighbours are in order.
    is_first = first == 0 or sense * (wavelengths[first + 1] - wavelengths[first - 1]) > 0.0
    odd = first if is_first else first + 1
    around = [f"{wavelengths[k]:g}" for k in (odd - 1, odd + 1) if 0 <= k < len(wavelengths)]
    return f"wavelength {wavelengths[odd]:g} nm stands beside {' and '.join(around)} nm", odd


def _check_gaps(wavelengths: np.ndarray, values: np.ndarray, fail) -> list[str]:
    """Say where wide gaps are, those between next to nothing left out; refuse one that a digit too many or few makes."""
    if len(wavelengths) < 4:
        return []
    steps = np.abs(np.diff(wavelengths))
    usual = float(np.median(steps))
    wide = np.flatnonzero((steps > GAP * usual) & (steps > WIDE))
    told = []
    for place in wide:
        low, high = sorted(wavelengths[place : place + 2])
        if high > SLIP * low:
            odd = place + 1 if place + 1 == len(wavelengths) - 1 else place
            fail(
                f"wavelength {wavelengths[odd]:g} nm, while the others lie {usual:g} nm apart; is a digit too many or few?",
                odd,
            )
        if np.abs(values[place : place + 2]).max() <= DARK * np.abs(values).max():
            continue
        told.append(
            f"has no value between {low:g} and {high:g} nm, where it is taken as a straight line"
        )
    return told[:3]


def check_powers(path, lines: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, list[Remark]]:
    """Return values of which none is negative, and remarks.

    Raises
    ------
    FileFormatError    One is no number, too large, or more negative than noise is.
    """
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        line = int(lines[bad[0]])
        raise FileFormatError(path, "expected finite numbers, found NaN or infinity", line)
    bad = np.flatnonzero(np.abs(values) > LARGEST)
    if len(bad):
        raise FileFormatError(
            path,
            f"expected a value of at most {LARGEST:g}, found {values[bad[0]]:g}",
            int(lines[bad[0]]),
        )
    lowest = int(np.argmin(values))
    if values[lowest] >= 0.0:
        return values, []
    if values[lowest] < -NOISE * values.max():
        raise FileFormatError(
            path,
            f"expected a value of at least 0, found {values[lowest]:g}",
            int(lines[lowest]),
        )
    count = int((values < 0.0).sum())
    text = f"{count} of {len(values)} values are negative, down to {values[lowest]:g}; taken as 0"
    return np.maximum(values, 0.0), [Remark(text, int(lines[lowest]))]


def tell_range(path, wavelengths: np.ndarray, values: np.ndarray) -> list[Remark]:
    """Remark on a table that ends within the visible range while it is large.

    Raises
    ------
    FileFormatError    It hardly holds anything that is visible, and is cut off there.
    """
    if values.max() <= 0.0:
        return [Remark("is zero at all wavelengths: as a light it gives nothing")]
    told, seen = _find_cut(wavelengths, values)
    if not told:
        return []
    if seen < LEAST_SEEN:
        raise FileFormatError(
            path,
            f"{told}, and covers {seen:.1%} of what the eye sees; expected a table up to {VISIBLE[1]:g} nm, "
            "or one that falls to 0",
        )
    return [Remark(f"{told}; beyond, a light has nothing, and a reflectance goes on as it is")]


def _find_cut(wavelengths: np.ndarray, values: np.ndarray) -> tuple[str, float]:
    """Say where a table ends within the visible range while it is large, empty: nowhere; and its share of sight."""
    low, high = wavelengths[0], wavelengths[-1]
    largest = values.max()
    cut = [
        (word, nm, value / largest)
        for word, nm, value in (("begins", low, values[0]), ("ends", high, values[-1]))
        if VISIBLE[0] < nm < VISIBLE[1] and value > DARK * largest
    ]
    weight = luminous_efficiency()
    seen = weight[(low <= GRID) & (high >= GRID)].sum() / weight.sum()
    told = " and ".join(
        f"{word} at {nm:g} nm with {share:.0%} of its largest value" for word, nm, share in cut
    )
    return told, float(seen)
