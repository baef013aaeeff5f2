"""Tone operators: pictures for looking, made of luminances that no display could show. Nothing is measured in them.

The photographic one exposes as a photographer does (E. Reinhard, M. Stark, P. Shirley, J. Ferwerda, SIGGRAPH 2002). The
visual one shows what a person could see there and no more (G. Ward Larson, H. Rushmeier, C. Piatko, IEEE TVCG 3(4), 1997):
the eye's own veil, contrasts by its adaptation, and the loss of colour at night.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..photometry.colour import MIDDLE_GREY, REC709_LUMINANCE, XYZ_TO_REC709
from .picture_view import PictureView
from .tone import limit_to_white
from .veiling import AGE, Eye

OPERATORS = ("photographic", "visual")
"""Names of operators."""

STATEMENT = "For looking, not for measuring"

DECADES = (-6, 9)
"""Powers of ten of luminances that the legend looks at. [cd/m2]"""

DARKEST = 1e-6
"""Luminance that stands for black. [cd/m2]"""

DISPLAY = (1.0, 100.0)
"""Luminances of a display's black and white. [cd/m2]"""

BINS = 100
"""Of the histogram."""

TOLERANCE = 0.025
"""Share of the histogram that may lie above its ceiling, and share of it that has to be left by trimming. [-]"""

ROUNDS = 200
"""Of trimming, at most; every one takes some of what is too much."""

SCOTOPIC, PHOTOPIC = 5.62e-3, 5.62
"""Adaptation luminances below which rods alone, and above which cones alone see. [cd/m2]"""

NIGHT = np.array([1.05, 0.97, 1.27])
"""Colour that light without colour has at night, in linear Rec. 709. (F. Durand, J. Dorsey, EGWR 2000)"""

WHITE = np.array([0.95047, 1.0, 1.08883])
"""D65."""


@dataclass(frozen=True, eq=False)
class Toned:
    """A picture for looking.

    Parameters
    ----------
    colour : (h, w, 3) float32 array    Linear Rec. 709 of a display, 0 to 1.
    words : str    What it is, for people.
    curve : callable    Share of the display's white by which neutral things of a luminance [cd/m2] are shown. (n,) -> (n,)
    """

    colour: np.ndarray
    words: str
    curve: Callable[[np.ndarray], np.ndarray]


def apply_operator(name: str, tristimulus, view: PictureView | None = None) -> Toned:
    """Return a picture for looking.

    Parameters
    ----------
    name : str    One of `OPERATORS`.
    tristimulus : (h, w, 3) array    X, Y, Z, the bottom row first. [cd/m2]
    view : PictureView or None    How it was taken, of the visual operator; None: it has no veil.
    """
    if name == "photographic":
        return photographic(tristimulus)
    return visual(tristimulus, view)


def legend_range(curve) -> tuple[float, float]:
    """Luminances that are just above black and just below white. [cd/m2]"""
    known = np.logspace(*DECADES, 1501)
    shown = curve(known)
    inner = known[(shown > 0.003) & (shown < 0.997)]
    return (float(inner[0]), float(inner[-1])) if len(inner) > 1 else (0.1, 1000.0)


def photographic(tristimulus, key: float = MIDDLE_GREY) -> Toned:
    """Expose a picture: its logarithmic mean becomes ``key``, and the brightest of it white.

    L = key Lw / mean,  Ld = L (1 + L / Lwhite^2) / (1 + L).
    """
    light = _clean(tristimulus)
    luminance = light[..., 1]
    mean = float(np.exp(np.log(np.maximum(luminance, DARKEST)).mean()))
    white = key * float(luminance.max()) / mean

    def curve(values):
        scaled = key * np.asarray(values, dtype=np.float64) / mean
        return scaled * (1.0 + scaled / max(white, 1e-9) ** 2) / (1.0 + scaled)

    words = (
        f"tone operator: photographic (Reinhard 2002), {_tell(mean)} cd/m² is at a key of {key:.2g}, "
        f"{_tell(float(luminance.max()))} cd/m² is white"
    )
    return Toned(_show(light, luminance, curve(luminance)), words, curve)


def visual(tristimulus, view: PictureView | None = None) -> Toned:
    """Show of a picture what a person there could see: veiled, with adapted contrasts, at night without colour."""
    light = _clean(tristimulus)
    eye = Eye(view, light.shape[:2])
    parts = eye.means(light)
    veil = eye.veil(parts)
    seen = light * eye.spread(np.broadcast_to(eye.kept, (*parts.shape[:2], 1))) + eye.spread(veil)
    adapted = np.maximum((parts * eye.kept + veil)[..., 1], DARKEST)
    curve = _adjust_histogram(adapted)
    is_day = eye.spread(day_vision(adapted)[..., None])
    luminance = seen[..., 1]
    rods = scotopic_luminance(seen)
    grey = np.maximum(rods, 0.0)[..., None] * (NIGHT / (NIGHT @ REC709_LUMINANCE))
    colour = is_day * (seen @ XYZ_TO_REC709.T) + (1.0 - is_day) * grey
    bright = is_day[..., 0] * luminance + (1.0 - is_day[..., 0]) * rods
    lowest, highest = np.percentile(adapted, [5.0, 95.0])
    words = "tone operator: visual adaptation (Ward Larson 1997), eyes adapted to "
    words += f"{_tell(lowest)} to {_tell(highest)} cd/m²"
    words += f", veil of an eye of {AGE:g} years (CIE 146)" if eye.has_veil else ", no veil"
    if is_day.min() < 1.0:
        words += ", rods see where it is dark"
    share = (curve(bright) / np.maximum(bright, DARKEST))[..., None]
    return Toned(limit_to_white(colour * share).astype(np.float32), words, curve)


def day_vision(adaptation) -> np.ndarray:
    """Share of the cones in what is seen: 0 below `SCOTOPIC`, 1 above `PHOTOPIC`, straight between. (...) [cd/m2 -> -]"""
    return np.clip((np.asarray(adaptation) - SCOTOPIC) / (PHOTOPIC - SCOTOPIC), 0.0, 1.0)


def scotopic_luminance(tristimulus) -> np.ndarray:
    """Luminance for rods of X, Y, Z, on a scale on which that of D65 is as for cones. (..., 3) -> (...) [cd/m2]

    Y (1.33 (1 + (Y + Z) / X) - 1.68), by Ward Larson and others.
    """

    def rods(light):
        x, y, z = np.moveaxis(np.asarray(light, dtype=np.float64), -1, 0)
        # Saturated blue, which the approximation is not made for, stays finite.
        return y * (1.33 * (1.0 + np.minimum((y + z) / np.maximum(x, 1e-12), 20.0)) - 1.68)

    return np.maximum(rods(tristimulus), 0.0) / float(rods(WHITE))


def threshold(luminance) -> np.ndarray:
    """Just noticeable difference of luminance for an eye that is adapted to a luminance. [cd/m2 -> cd/m2]

    J. Ferwerda, S. Pattanaik, P. Shirley, D. Greenberg, SIGGRAPH 1996, rods and cones together.
    """
    x = np.log10(np.maximum(np.asarray(luminance, dtype=np.float64), 1e-9))
    made = np.select(
        [x < -3.94, x < -1.44, x < -0.0184, x < 1.9],
        [
            np.full_like(x, -2.86),
            np.maximum(0.405 * x + 1.6, 0.0) ** 2.18 - 2.86,
            x - 0.395,
            np.maximum(0.249 * x + 0.65, 0.0) ** 2.7 - 0.72,
        ],
        x - 1.255,
    )
    return 10.0**made


def _adjust_histogram(adapted: np.ndarray):
    """Return the curve from luminance to shares of the display's white: no contrast that nobody would see there."""
    black, white = DISPLAY
    span = np.log(white / black)
    brightness = np.log(adapted).ravel()
    low, high = float(brightness.min()), float(brightness.max())
    counts = None
    if high - low > 1e-3:
        counts = _trim(brightness, low, high, span)
    if counts is None:
        # All of it fits on the display: its contrasts stay as they are.
        mean = float(np.exp(brightness.mean()))
        factor = float(threshold(0.5 * white) / threshold(mean))
        return lambda values: _to_share(factor * np.asarray(values, dtype=np.float64))
    edges = np.linspace(low, high, BINS + 1)
    shares = np.append(0.0, np.cumsum(counts) / counts.sum())

    def curve(values):
        logs = np.log(np.maximum(np.asarray(values, dtype=np.float64), DARKEST))
        return _to_share(np.exp(np.log(black) + span * np.interp(logs, edges, shares)))

    return curve


def _trim(brightness, low: float, high: float, span: float):
    """Return a histogram of brightness of which nothing is shown with more contrast than is seen; None: nothing is left.

    Its ceiling is count / T <= (threshold(Ld) / Ld) / (threshold(Lw) / Lw) width / span.
    """
    counts, edges = np.histogram(brightness, BINS, (low, high))
    counts = counts.astype(np.float64)
    whole, width = counts.sum(), (high - low) / BINS
    world = np.exp(0.5 * (edges[:-1] + edges[1:]))
    seen = world / threshold(world) * width / span
    for _ in range(ROUNDS):
        total = counts.sum()
        if total < TOLERANCE * whole:
            return None
        middle = (np.cumsum(counts) - 0.5 * counts) / total
        shown = DISPLAY[0] * np.exp(span * middle)
        ceiling = total * seen * threshold(shown) / shown
        excess = np.maximum(counts - ceiling, 0.0).sum()
        if excess <= TOLERANCE * total:
            return counts
        counts = np.minimum(counts, ceiling)
    return None


def _tell(luminance: float) -> str:
    return f"{luminance:.0f}" if luminance >= 100.0 else f"{luminance:.2g}"


def _to_share(shown):
    """From luminances of a display to shares of its white. [cd/m2 -> -]"""
    black, white = DISPLAY
    return np.clip((shown - black) / (white - black), 0.0, 1.0)


def _clean(tristimulus) -> np.ndarray:
    return np.maximum(np.nan_to_num(np.asarray(tristimulus, dtype=np.float32)), 0.0)


def _show(light, luminance, shares) -> np.ndarray:
    """Colours of light whose luminance is shown by shares of white, their hue kept where they are too bright. (h, w, 3)"""
    factor = shares / np.maximum(luminance, DARKEST)
    return limit_to_white((light @ XYZ_TO_REC709.T) * factor[..., None]).astype(np.float32)
