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
from .caught_light import CaughtLayout, Shown
from .light_mix import GroupLight, add_colours, mix
from .scene.camera import Camera
from .scene.light_groups import WORLD
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


class CaughtGroups:
    """What light groups give to what is seen of shadow catchers, whose light is divided by that of all of them.

    Parameters
    ----------
    groups : list of Share    Those of which something is known.
    layout : CaughtLayout
    shape : (int, int)    Rows and columns of the picture.
    is_transparent : bool
        Whether what is seen straight of catchers is a part of the surroundings, as on a transparent film.

    Attributes
    ----------
    shown : dict of str to Shown    By the groups' names.
    """

    def __init__(
        self,
        groups: list["Share"],
        layout: CaughtLayout,
        shape: tuple[int, int],
        is_transparent: bool,
    ):
        self._groups, self._layout, self._shape = groups, layout, shape
        self._is_transparent = is_transparent
        columns = [group.caught for group in groups]
        shown, is_open = layout.share_out(columns, [WORLD in group.members for group in groups])
        self.shown: dict[str, Shown] = dict(zip((g.name for g in groups), shown, strict=True))
        self._open = is_open.mean(axis=0)
        self._whole = layout.join([each.mean(axis=0, dtype=np.float64) for each in columns])

    def light(self, group: "Share", name: str) -> np.ndarray:
        """What a group's field gets of it: ``tristimulus``, ``backdrop`` or ``bands``. (h, w, c)"""
        shown = self.shown[group.name]
        if name == "bands":
            made = shown.bands + shown.band_change
        elif name == "backdrop" and not self._is_transparent:
            made = np.zeros_like(shown.tristimulus)
        else:
            made = shown.tristimulus + (shown.change if name == "tristimulus" else 0.0)
        return made.mean(axis=0).reshape(*self._shape, -1)

    def difference(self, group: "Share") -> np.ndarray:
        """Error of the luminance that a group gives to it, with a sign. (h, w) [cd/m2]"""
        return self.shown[group.name].difference.reshape(self._shape)

    def scatter(self, group: "Share") -> np.ndarray:
        """Variance of that of all groups by the samples of one. (h, w) [cd2/m4]"""
        counts = np.full(len(self._whole), group.samples // 2)
        made = self._layout.scatter(group.caught, self._whole, counts, 0.0, len(self._groups))
        return made.mean(axis=0).reshape(self._shape)

    def coverage(self, without: np.ndarray) -> np.ndarray:
        """Share of a pixel that shows anything, by that of a picture where catchers are holes. (h, w)"""
        is_open = self._open if self._is_transparent else 0.0
        return np.clip(without + (self._whole[:, 0] - is_open).reshape(self._shape), 0.0, 1.0)


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
    caught : (2, n, count) array or None    Means of what is known of shadow catchers, see `CaughtLayout`.
    """

    name: str
    members: frozenset[str]
    mean: dict[str, np.ndarray] = field(default_factory=dict)
    variance: dict[str, np.ndarray] = field(default_factory=dict)
    samples: int = 0
    caught: np.ndarray | None = None

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
        if made.fields.get("caught") is not None:
            before = 0.0 if self.caught is None else self.caught
            self.caught = (old * before + new * made.fields["caught"].astype(float)) / total
        self.samples = total

    def light(self, caught: CaughtGroups | None) -> GroupLight:
        """Return it as plain data. ``caught``: what all groups give to shadow catchers."""
        mean, variance, shared = dict(self.mean), dict(self.variance), None
        if caught is not None:
            for name in CAUGHT:
                if name in mean:
                    mean[name] = mean[name] + caught.light(self, name)
            shared = caught.difference(self)
            variance["luminance_error"] = variance["luminance_error"] + shared**2
            shared = shared.astype(np.float32)
        values = {name: value.astype(np.float32) for name, value in mean.items()}
        values |= {name: np.sqrt(v).astype(np.float32) for name, v in variance.items()}
        kept = {name: values.get(name) for name in KEPT}
        return GroupLight(self.name, self.samples, **kept, shared_error=shared)


KEPT = ("tristimulus", "luminance_error", "illuminance", "illuminance_error", "backdrop")
"""What is kept of every group."""

SUMS = ("tristimulus", "illuminance", "backdrop", "bands", "coverage")
ERRORS = ("luminance_error", "illuminance_error")

CAUGHT = ("tristimulus", "backdrop", "bands")
"""Fields that hold what is seen of shadow catchers."""


def render_groups(
    compiled,
    shares: list[tuple[str, frozenset[str]]],
    camera: Camera,
    settings: ViewSettings,
    render: Callable[..., Rendered],
    progress: Callable | None = None,
    layout: CaughtLayout | None = None,
) -> Rendered:
    """Render a picture by light group until the rule of ``settings`` is met by the sum of all.

    Parameters
    ----------
    compiled : CompiledScene
    shares : list of (str, frozenset of str)    As of `light_groups.share_out`.
    render : callable    ``render(settings, progress)`` renders what shines of the scene.
    progress : callable or None    As of `Session.render`; pictures so far are the sum at the levels ``settings.preview``.
    layout : CaughtLayout or None    Of the field ``caught`` of what is rendered, where shadow catchers are seen.

    Returns
    -------
    Rendered    Of the sum, with the field ``groups``; samples are those of all groups together.
    """
    groups = [Share(name, members) for name, members in shares]
    job = _Rounds(groups, settings, progress, layout)
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

    def __init__(self, groups: list[Share], settings: ViewSettings, progress, layout):
        self.groups, self.rule, self.progress = groups, settings.rule, progress
        self.layout, self.is_transparent = layout, settings.transparent
        self.caught: CaughtGroups | None = None
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
                np.sqrt(group.samples * (self._variance(group) / scale**2).mean())
                for group in self.groups
            ]
        )
        even = total / len(self.groups)
        if not noise.sum() > 0.0:
            return np.full(len(self.groups), even)
        return np.maximum(total * noise / noise.sum(), LEAST_SHARE * even)

    def _variance(self, group: Share) -> np.ndarray:
        """Variance of the picture's luminance by the samples of a group. (h, w) [cd2/m4]"""
        scatter = 0.0 if self.caught is None else self.caught.scatter(group)
        return group.variance["luminance_error"] + scatter

    def _colour(self, group: Share) -> np.ndarray:
        """X, Y, Z that a group gives. (h, w, 3) [cd/m2]"""
        known = self.caught is not None and group.name in self.caught.shown
        more = self.caught.light(group, "tristimulus") if known else 0.0
        return group.mean["tristimulus"] + more

    def _scale(self) -> np.ndarray:
        """What errors of pixels are measured by, as of `picture.relative_error`. [cd/m2]"""
        luminance = sum(self._colour(group)[..., 1] for group in self.groups)
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
            # Of shadow catchers what was known before is shown.
            image += self._colour(own) - own.mean["tristimulus"]
        known = [group for group in self.groups if group.samples or group is own]
        images = [image if group is own else self._colour(group) for group in known]
        return add_colours(images, known, self.levels)

    def take(self, number: int, made: Rendered) -> None:
        """Take in a rendering of a group."""
        self.groups[number].add(made)
        if self.layout is not None:
            shape = made.fields["luminance_error"].shape
            known = [group for group in self.groups if group.samples]
            self.caught = CaughtGroups(known, self.layout, shape, self.is_transparent)
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
        if self.caught is not None:
            variance = variance + sum(self.caught.difference(group) for group in self.groups) ** 2
        luminance = sum(self._colour(group)[..., 1] for group in self.groups)
        self.error = relative_error(luminance, np.sqrt(variance))
        is_believed = min(group.samples for group in self.groups) >= FIRST_SAMPLES
        return self.clock.is_done(self.samples, self.error if is_believed else float("inf"))

    def finish(self) -> Rendered:
        """Return the sum of what was rendered."""
        lights = tuple(group.light(self.caught) for group in self.groups)
        mixed = mix(lights)
        fields = {name: value for name, value in self.first.items() if name != "caught"}
        fields |= {name: getattr(mixed, name) for name in KEPT if name in fields}
        if fields.get("bands") is not None:
            bands = sum(group.mean["bands"] for group in self.groups)
            if self.caught is not None:
                bands = bands + sum(self.caught.light(group, "bands") for group in self.groups)
            fields["bands"] = bands.astype(np.float32)
        if fields.get("coverage") is not None:
            # All see the same shapes.
            weighed = sum(group.samples * group.mean["coverage"] for group in self.groups)
            coverage = weighed / self.samples
            if self.caught is not None:
                coverage = self.caught.coverage(coverage)
            fields["coverage"] = coverage.astype(np.float32)
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
