"""Pictures of an open shutter: the mean of pictures of moments, each with samples of its own.

The time that the shutter lets light through is cut into strata. Two times are drawn in each, so both see all of the shutter,
and half of what they differ by is the error of their mean: it holds the noise of their samples and what moves between them.
"""

import hashlib
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

from .accuracy.estimate import relative_error
from .accuracy.stopping import Clock
from .errors import SceneError
from .light_mix import GroupLight
from .views import Picture, ViewSettings

PAIR = 2
"""Times in a stratum."""

FEWEST = 2
"""Samples of a picture: one for each half of it."""

OF_MOMENT = 4
"""Samples of a pixel at a moment from which on there are more moments: each has to be synchronised."""

MOST_STRATA = 32
"""Strata of a round."""

FIRST_SAMPLES, SHORT = 32, 8
"""Samples of a pixel in the first round, where the rule does not allow but fewer, and where time may end it."""

DARK = 1 << 20
"""Samples of a whole picture that have found no light at all, after which it is known to be dark."""

GROWTH = 4.0
"""Most times as many samples after a round as before: of few, the error is not known well enough to aim by it."""

MARGIN = 1.1
"""How many times the samples are taken that the error seems to need, so that it is seldom missed by little."""

LEAST = 0.05
"""Samples of a round, relative to all before, that are worth one. [-]"""

SEEDS = 7_368_787
"""Distance between the seeds of moments."""

MEANS = (
    "tristimulus",
    "illuminance",
    "bands",
    "backdrop",
    "coverage",
    "denoising_albedo",
    "denoising_normal",
    "denoising_depth",
)
"""Fields of pictures, and of their light groups, that are means over the shutter."""

ERRORS = {"luminance_error": "tristimulus", "illuminance_error": "illuminance"}
"""Fields that hold the standard error of another one; of X, Y and Z that of Y."""


@dataclass(frozen=True)
class Shutter:
    """When the shutter is open.

    Parameters
    ----------
    frame : float    Whose picture it is.
    begin, length : float    [frame]
    opening : (n,) array or None    How much light it lets through, at times that are spread evenly; None: all, always.

    Raises
    ------
    SceneError    It is never open, or lets less than no light through.
    """

    frame: float
    begin: float
    length: float
    opening: np.ndarray | None = None

    def __post_init__(self):
        """Refuse what exposes nothing."""
        if not (math.isfinite(self.begin) and 0.0 < self.length < math.inf):
            raise SceneError(
                f"the shutter is open for {self.length:g} frames, expected a number above 0"
            )
        opening = self.opening
        if opening is not None and not (
            np.isfinite(opening).all() and (opening >= 0.0).all() and opening.sum() > 0.0
        ):
            raise SceneError("the shutter's curve lets no light through, or less than none")

    @property
    def middle(self) -> float:
        """Time halfway between opening and closing. [frame]"""
        return self.begin + 0.5 * self.length

    @property
    def end(self) -> float:
        """When it is closed again. [frame]"""
        return self.begin + self.length

    def time(self, share: float) -> float:
        """Time by which it has let a share of its light through. [frame]"""
        if self.opening is None:
            return self.begin + share * self.length
        # The curve is even between the middles of neighbouring values.
        through = np.concatenate([[0.0], np.cumsum(self.opening, dtype=np.float64)])
        places = np.linspace(0.0, 1.0, len(through))
        return self.begin + self.length * float(np.interp(share * through[-1], through, places))


def render_moments(
    shutter: Shutter,
    settings: ViewSettings,
    render: Callable[..., Picture],
    progress: Callable | None = None,
) -> Picture:
    """Render the mean over an open shutter until the rule of ``settings`` is met.

    Parameters
    ----------
    shutter : Shutter
    settings : ViewSettings    Light is followed by full paths; a file of bands is left to the caller.
    render : callable
        ``render(time, settings, progress)`` renders the scene as it is at a time [frame], as `Session.render`.
    progress : callable or None    As of `Session.render`; pictures so far are the mean of moments.

    Returns
    -------
    Picture    Depth, normals and indices are those of the moment next to the middle of the shutter.
    """
    return _Rounds(shutter, settings, render, progress).run()


class _Rounds:
    """Shares samples out between moments."""

    def __init__(self, shutter: Shutter, settings: ViewSettings, render, progress):
        self.shutter, self.settings, self.render = shutter, settings, render
        self.rule, self.progress = settings.rule, progress
        self.clock = Clock(settings.rule, "picture")
        self.draw = np.random.default_rng([settings.seed & 0xFFFFFFFF, 79])
        self.sums = _Sums()
        self.samples = self.moments = 0
        self.of_groups: Counter[str] = Counter()
        # Sum of the pictures of all moments so far, for showing.
        self.shown: np.ndarray | float = 0.0
        self.error = float("inf")
        self.middle: tuple[float, Picture] | None = None
        self.hashes = hashlib.sha256()
        self.notes: dict[str, None] = {}
        self.decisions: dict[str, None] = {}
        self.simplified = 0.0

    def run(self) -> Picture:
        """Make rounds until the rule is met."""
        wanted = self._first()
        while True:
            self._round(wanted)
            self.error = self.sums.relative_error()
            if math.isinf(self.error) and self.samples * self._pixels >= DARK:
                self.error = 0.0
            if self.clock.is_done(self.samples, self.error):
                return self._finish()
            wanted = self._more()
            if wanted < LEAST * self.samples:
                return self._finish()

    # ---- private ----

    @property
    def _pixels(self) -> int:
        return self.middle[1].depth.size

    def _first(self) -> float:
        """Samples of a pixel in the first round."""
        samples, first = self.rule.samples, FIRST_SAMPLES
        if self.rule.seconds is not None:
            first = SHORT
        elif samples is not None and self.rule.error is None:
            return samples
        return min(first, samples or first)

    def _more(self) -> float:
        """Samples of a pixel in the next round."""
        have, more = self.samples, (GROWTH - 1.0) * self.samples
        if self.rule.error is not None and math.isfinite(self.error):
            more = min(more, have * (MARGIN * (self.error / self.rule.error) ** 2 - 1.0))
        if self.rule.samples is not None:
            more = min(more, self.rule.samples - have)
        if self.rule.seconds is not None:
            left = self.rule.seconds - self.clock.seconds
            more = min(more, have * left / max(self.clock.seconds, 1e-9))
        return more

    def _round(self, wanted: float) -> None:
        """Render a pair of moments in every stratum."""
        count = int(np.clip(wanted // (PAIR * OF_MOMENT), 1, MOST_STRATA))
        each = max(FEWEST * math.ceil(wanted / (PAIR * count * FEWEST) - 1e-9), FEWEST)
        part = _Sums()
        shares = (np.arange(count)[:, None] + self.draw.random((count, PAIR))) / count
        before = self.samples
        for pair in np.sort(shares, axis=1):
            part.add(*(self._moment(self.shutter.time(share), each) for share in pair))
        self.sums.join(part.mean(), before, self.samples - before)

    def _moment(self, time: float, samples: int) -> Picture:
        """Render at a time."""
        seed = (self.settings.seed + SEEDS * self.moments) % 2**31
        own = replace(
            self.settings,
            rule=replace(self.rule, samples=samples, seconds=None, error=None),
            seed=seed,
            method="paths",
            spectral_file=None,
        )
        made = self.render(time, own, self._follow(samples))
        self.moments += 1
        self.samples += made.provenance.samples
        self.shown = self.shown + made.tristimulus
        self.of_groups.update({group.name: group.samples for group in made.groups})
        self.hashes.update(made.provenance.scene_hash.encode())
        self.notes |= dict.fromkeys(made.provenance.notes)
        self.decisions |= dict.fromkeys(made.provenance.decisions)
        self.simplified = max(self.simplified, made.provenance.simplified)
        away = abs(time - self.shutter.middle)
        if self.middle is None or away < self.middle[0]:
            self.middle = away, made
        return made

    def _follow(self, samples: int):
        """Return what follows the progress of a moment."""
        if self.progress is None:
            return None
        moment = self.moments + 1

        def follow(state, preview):
            done = self.samples + min(state.samples, samples)
            told = self.clock.progress(done, self.error)
            shown = None if preview is None else lambda: (self.shown + preview()) / moment
            self.progress(replace(told, stage=f"moment {moment} of the shutter"), shown)

        return follow

    def _finish(self) -> Picture:
        """Return the mean of what was rendered."""
        _, middle = self.middle
        values = self.sums.values()
        own = {name: values.pop((None, name)) for name in MEANS if (None, name) in values}
        own |= {name: values.pop((None, name)) for name in ERRORS if (None, name) in values}
        groups = tuple(
            replace(
                group,
                samples=self.of_groups[group.name],
                # Errors are found anew, of each group by itself.
                shared_error=None,
                **{name: value for (of, name), value in values.items() if of == group.name},
            )
            for group in middle.groups
        )
        shutter = self.shutter
        note = (
            f"motion blur: the mean of {self.moments} moments between the frames {shutter.begin:.6g} and "
            f"{shutter.end:.6g}, drawn two in each part of the shutter's time; the errors hold what moves between them"
        )
        reason = "each moment of the shutter is followed by full paths, as cells would hold for one alone"
        decisions = (*(each for each in self.decisions if each != ASKED), reason)
        provenance = replace(
            middle.provenance,
            scene_hash=self.hashes.hexdigest(),
            seed=self.settings.seed,
            samples=self.samples,
            seconds=self.clock.seconds,
            decisions=decisions,
            notes=(note, *self.notes),
            simplified=self.simplified,
        )
        made = replace(
            middle, **own, groups=groups, relative_error=self.error, provenance=provenance
        )
        return made.widened(self.simplified)


ASKED = "full paths are asked for"
"""What pictures say of a method that nobody but this module has asked for."""


class _Sums:
    """Means over the shutter and the squares of their errors, by light group (None: of all) and field."""

    def __init__(self):
        self.pairs = 0
        self._means: dict[tuple[str | None, str], np.ndarray] = {}
        self._squares: dict[tuple[str | None, str], np.ndarray] = {}

    def add(self, first: Picture, second: Picture) -> None:
        """Add two independent pictures of a stratum."""
        self.pairs += 1
        others = dict(_images(second))
        for key, image in _images(first):
            other = others[key]
            self._means[key] = self._means.get(key, 0.0) + 0.5 * (image + other)
            if key[1] in ERRORS.values():
                gap = image - other
                gap = gap[..., 1] if gap.ndim == 3 else gap
                self._squares[key] = self._squares.get(key, 0.0) + 0.25 * gap**2

    def mean(self) -> "_Sums":
        """Of the strata that were added."""
        made = _Sums()
        made._means = {key: value / self.pairs for key, value in self._means.items()}
        made._squares = {key: value / self.pairs**2 for key, value in self._squares.items()}
        return made

    def join(self, other: "_Sums", old: int, new: int) -> None:
        """Take in an independent mean of ``new`` samples beside the ``old`` ones."""
        mine, theirs = old / (old + new), new / (old + new)
        for own, more, power in (
            (self._means, other._means, 1),
            (self._squares, other._squares, 2),
        ):
            for key, value in more.items():
                own[key] = mine**power * own.get(key, 0.0) + theirs**power * value

    def relative_error(self) -> float:
        """As of `Picture`. [-]"""
        key = (None, "tristimulus")
        return relative_error(self._means[key][..., 1], np.sqrt(self._squares[key]))

    def values(self) -> dict[tuple[str | None, str], np.ndarray]:
        """Return means and standard errors."""
        made = {key: value.astype(np.float32) for key, value in self._means.items()}
        for error, name in ERRORS.items():
            for key, square in self._squares.items():
                if key[1] == name:
                    made[key[0], error] = np.sqrt(square).astype(np.float32)
        return made


def _images(picture: Picture):
    """Yield what is a mean over the shutter, by light group (None: of all) and field, in double precision."""
    for of in (None, *picture.groups):
        holder = picture if of is None else of
        names = {entry.name for entry in fields(Picture if of is None else GroupLight)}
        for name in MEANS:
            image = getattr(holder, name) if name in names else None
            if image is not None:
                yield (None if of is None else of.name, name), image.astype(np.float64)
