"""Pictures kept by light group: each group is rendered with its own lights alone, and all together meet the rule.

What a group gets of the samples follows from how much its noise counts in the sum, by rounds: a first one that tells, then
as many as the rule asks for. A group that is faint now may be turned up later, so none gets less than `LEAST_SHARE`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from .accuracy.estimate import relative_error
from .accuracy.stopping import Clock, StopRule
from .light_mix import GroupLight, add_colours, mix
from .scene.camera import Camera
from .views import ViewSettings

GROUP_SEEDS = 1_000_003
"""Distance between the seeds of rounds and groups."""

FIRST_SAMPLES = 8
"""Samples per pixel of every group in the first round, where the rule does not allow but fewer."""

FIRST_SHARE = 0.25
"""Largest share of the samples or of the time that the first round takes."""

LEAST_SHARE = 0.25
"""Least samples of a group, over those that it would have if all had alike. [-]"""

GROWTH = 4.0
"""Most times as many samples after a round as before: of few, the error is not known well enough to aim by it."""

MARGIN = 1.1
"""How many times the samples are taken that the error seems to need, so that it is seldom missed by little."""

FEWEST = 2
"""Samples of a picture: one for each half."""


@dataclass
class Rendered:
    """What one rendering gave: fields of `views.Picture` but the provenance, samples, what was lost, what to say."""

    fields: dict
    samples: int
    lost: dict[str, tuple[int, int]]
    notes: tuple[str, ...] = ()
    decisions: tuple[str, ...] = ()


@dataclass
class Share:
    """A group and what is known of its light.

    Parameters
    ----------
    name : str
    members : frozenset of str    As of `CompiledScene.shine`.
    mean : dict of str to array    By field, weighed by samples, of what adds up over groups.
    variance : dict of str to array    The same of what adds up as squares.
    samples : int    Per pixel.
    """

    name: str
    members: frozenset[str]
    mean: dict[str, np.ndarray] = field(default_factory=dict)
    variance: dict[str, np.ndarray] = field(default_factory=dict)
    samples: int = 0

    def add(self, made: Rendered) -> None:
        """Take in a rendering that is independent of those before."""
        old, new = self.samples, made.samples
        total = old + new
        for name in SUMS:
            if made.fields.get(name) is not None:
                before = self.mean.get(name, 0.0)
                self.mean[name] = (old * before + new * made.fields[name].astype(float)) / total
        for name in ERRORS:
            if made.fields.get(name) is not None:
                before = self.variance.get(name, 0.0)
                squares = made.fields[name].astype(float) ** 2
                self.variance[name] = (old**2 * before + new**2 * squares) / total**2
        self.samples = total

    def light(self) -> GroupLight:
        """Return it as plain data."""
        values = {name: value.astype(np.float32) for name, value in self.mean.items()}
        values |= {name: np.sqrt(v).astype(np.float32) for name, v in self.variance.items()}
        kept = {name: values.get(name) for name in KEPT}
        return GroupLight(self.name, self.samples, **kept)


KEPT = ("tristimulus", "luminance_error", "illuminance", "illuminance_error", "backdrop")
"""What is kept of every group."""

SUMS = ("tristimulus", "illuminance", "backdrop", "bands", "coverage")
ERRORS = ("luminance_error", "illuminance_error")


def render_groups(
    compiled,
    shares: list[tuple[str, frozenset[str]]],
    camera: Camera,
    settings: ViewSettings,
    render: Callable[..., Rendered],
    progress: Callable | None = None,
) -> Rendered:
    """Render a picture by light group until the rule of ``settings`` is met by the sum of all.

    Parameters
    ----------
    compiled : CompiledScene
    shares : list of (str, frozenset of str)    As of `light_groups.share_out`.
    render : callable    ``render(settings, progress)`` renders what shines of the scene.
    progress : callable or None    As of `Session.render`; pictures so far are the sum at the levels ``settings.preview``.

    Returns
    -------
    Rendered    Of the sum, with the field ``groups``; samples are those of all groups together.
    """
    groups = [Share(name, members) for name, members in shares]
    job = _Rounds(groups, settings, progress)
    try:
        while True:
            for number, rule in job.plan():
                group = groups[number]
                compiled.shine(group.members)
                seed = (settings.seed + GROUP_SEEDS * job.count) % 2**31
                own = replace(settings, rule=rule, seed=seed, groups=())
                job.take(number, render(own, job.follow(number)))
            if job.is_done():
                return job.finish()
    finally:
        compiled.shine()


class _Rounds:
    """Shares samples and time out between groups."""

    def __init__(self, groups: list[Share], settings: ViewSettings, progress):
        self.groups, self.rule, self.progress = groups, settings.rule, progress
        self.levels = settings.preview
        self.clock = Clock(settings.rule, "picture")
        self.error = float("inf")
        self.count = 0
        self.lost: dict[str, tuple[int, int]] = {}
        # What was said, and of which groups.
        self.notes: dict[str, set[str]] = {}
        self.decisions: dict[str, set[str]] = {}
        self.first: dict = {}

    @property
    def samples(self) -> int:
        return sum(group.samples for group in self.groups)

    def plan(self) -> list[tuple[int, StopRule]]:
        """Which groups are rendered next, and until when."""
        wanted = self._wanted()
        total = sum(wanted)
        # The first round has to be there whole, whatever the time.
        timed = self.rule.seconds is not None and self.samples > 0
        left = max(self.rule.seconds - self.clock.seconds, 1e-3) if timed else 0.0
        return [
            (k, StopRule(samples=n, seconds=left * n / total if timed else None))
            for k, n in enumerate(wanted)
            if n > 0
        ]

    def _wanted(self) -> list[int]:
        """New samples per pixel of each group."""
        count, rule, have = len(self.groups), self.rule, self.samples
        if have == 0:
            first = FIRST_SAMPLES
            if rule.samples is not None:
                fair = rule.samples / count
                shared = FIRST_SHARE * fair
                first = min(first, fair if shared < FEWEST else shared)
            return [_even(first)] * count
        total = rule.samples
        if rule.error is not None and np.isfinite(self.error):
            needed = have * min(MARGIN * (self.error / rule.error) ** 2, GROWTH)
            total = needed if total is None else min(total, needed)
        elif total is None or rule.error is not None:
            total = have * GROWTH if total is None else min(total, have * GROWTH)
        if rule.seconds is not None and rule.error is None and rule.samples is None:
            # Time alone ends it.
            total = have * 1_000_000.0
        goals = self._goals(total)
        wanted = [
            max(goal - group.samples, 0.0) for goal, group in zip(goals, self.groups, strict=True)
        ]
        # Some have more than their goal: what is new is shared by the others.
        new, asked = max(total - have, FEWEST), max(sum(wanted), 1e-9)
        wanted = [_even(each * new / asked) if each > 0.0 else 0 for each in wanted]
        return wanted if any(wanted) else [FEWEST] * count

    def _goals(self, total: float) -> np.ndarray:
        """Samples of each group for the least error of the sum of so many: in proportion to the noise of one sample."""
        scale = self._scale()
        noise = np.array(
            [
                np.sqrt(group.samples * (group.variance["luminance_error"] / scale**2).mean())
                for group in self.groups
            ]
        )
        even = total / len(self.groups)
        if not noise.sum() > 0.0:
            return np.full(len(self.groups), even)
        return np.maximum(total * noise / noise.sum(), LEAST_SHARE * even)

    def _scale(self) -> np.ndarray:
        """What errors of pixels are measured by, as of `picture.relative_error`. [cd/m2]"""
        luminance = sum(group.mean["tristimulus"][..., 1] for group in self.groups)
        return np.maximum(luminance, max(float(luminance.mean()), 1e-300))

    def follow(self, number: int):
        """Return what follows the progress of a group."""
        if self.progress is None:
            return None
        name = self.groups[number].name
        before = self.samples

        def follow(state, preview):
            told = self.clock.progress(before + state.samples, self.error)
            stage = f"light group {name}, {number + 1} of {len(self.groups)}"
            shown = None if preview is None else lambda: self._so_far(number, state, preview)
            self.progress(replace(told, stage=stage), shown)

        return follow

    def _so_far(self, number: int, state, preview) -> np.ndarray:
        """Sum of what is known of all groups, at their levels. (h, w, 3) [cd/m2]"""
        own, image = self.groups[number], preview().astype(float)
        if own.samples:
            known, new = own.mean["tristimulus"], max(state.samples, 1)
            image = (own.samples * known + new * image) / (own.samples + new)
        known = [group for group in self.groups if group.samples or group is own]
        images = [image if group is own else group.mean["tristimulus"] for group in known]
        return add_colours(images, known, self.levels)

    def take(self, number: int, made: Rendered) -> None:
        """Take in a rendering of a group."""
        self.groups[number].add(made)
        self.count += 1
        self.first = self.first or made.fields
        for told, words in ((self.notes, made.notes), (self.decisions, made.decisions)):
            for each in words:
                told.setdefault(each, set()).add(self.groups[number].name)
        for name, (lost, of) in made.lost.items():
            before = self.lost.get(name, (0, 0))
            self.lost[name] = (before[0] + lost, before[1] + of)

    def is_done(self) -> bool:
        """Take note of a round and tell whether the rule is met."""
        variance = sum(group.variance["luminance_error"] for group in self.groups)
        luminance = sum(group.mean["tristimulus"][..., 1] for group in self.groups)
        self.error = relative_error(luminance, np.sqrt(variance))
        is_believed = min(group.samples for group in self.groups) >= FIRST_SAMPLES
        return self.clock.is_done(self.samples, self.error if is_believed else float("inf"))

    def finish(self) -> Rendered:
        """Return the sum of what was rendered."""
        lights = tuple(group.light() for group in self.groups)
        mixed = mix(lights)
        fields = dict(self.first)
        fields |= {name: getattr(mixed, name) for name in KEPT if name in fields}
        if fields.get("bands") is not None:
            bands = sum(group.mean["bands"] for group in self.groups)
            fields["bands"] = bands.astype(np.float32)
        if fields.get("coverage") is not None:
            # All see the same shapes.
            weighed = sum(group.samples * group.mean["coverage"] for group in self.groups)
            fields["coverage"] = (weighed / self.samples).astype(np.float32)
        fields |= {"relative_error": self.error, "groups": lights}
        notes, decisions = self._name(self.notes), self._name(self.decisions)
        return Rendered(fields, self.samples, self.lost, notes, decisions)

    def _name(self, told: dict[str, set[str]]) -> tuple[str, ...]:
        """What was said, with the names of the groups where it was not said of all."""
        return tuple(
            words
            if len(names) == len(self.groups)
            else f"light group {', '.join(sorted(names))}: {words}"
            for words, names in told.items()
        )


def _even(samples: float) -> int:
    """Number of samples that both halves share, at least `FEWEST`."""
    return max(2 * math.ceil(0.5 * samples - 1e-9), FEWEST)
