"""Samples that a picture will need, foretold while a made-up one is made whose errors fall by known powers."""

import numpy as np
import pytest

from lumenray.engine.transport.pictures.allocation import Allocation
from lumenray.engine.transport.pictures.foresight import EASE, EASE_APART, Foresight
from lumenray.engine.transport.pictures.pixel_light import GATHERED, VIEW

GROUPS = 2


class MadeUpPicture:
    """Passes over tiles whose squares of errors fall by a power of their samples.

    Parameters
    ----------
    powers : dict    By kind.
    part : float    Power of all samples by which what is stated falls beside what samples scatter.
    """

    def __init__(self, powers: dict[int, float], part: float = 0.0):
        self.allocation = Allocation(64, 48, dict.fromkeys(powers, 1.0))
        rng = np.random.default_rng(3)
        self._scatter = {kind: rng.random(len(self.allocation.size)) ** 4 for kind in powers}
        self._powers, self._part = powers, part
        self.allocation.extend(self.allocation.begin())
        for _ in range(2):
            self.allocation.extend(self.allocation.double())

    @property
    def samples(self) -> float:
        return GROUPS * self.allocation.samples

    def squares(self) -> dict[int, np.ndarray]:
        made = self.allocation
        return {
            kind: (self._scatter[kind] / made.counts[kind] ** power)[made.tile]
            for kind, power in self._powers.items()
        }

    def error(self) -> float:
        mean = sum(each.mean() for each in self.squares().values())
        return float(np.sqrt(0.5 * mean * self.samples**self._part))

    def go_on(self) -> None:
        made = self.allocation
        made.extend(made.choose(self.squares(), 0.5 * made.samples))


def follow(picture: MadeUpPicture, foresight: Foresight, until: float) -> tuple[float, float]:
    """Make passes up to so many samples, and foretell."""
    while True:
        picture.go_on()
        now = picture.squares()
        foresight.note(now, picture.error())
        if picture.samples >= until:
            return foresight.span(now, now, now)


def needed(powers, part: float, goal: float) -> float:
    picture = MadeUpPicture(powers, part)
    while True:
        before, error = picture.samples, picture.error()
        picture.go_on()
        if picture.error() <= goal:
            share = np.log(error / goal) / np.log(error / picture.error())
            return before * (picture.samples / before) ** share


@pytest.mark.parametrize(
    ("powers", "part", "share"),
    [
        ({VIEW: 0.88}, -0.05, 0.15),
        ({VIEW: 0.9, GATHERED: 0.75}, -0.05, 0.2),
        # What is unusual shows later.
        ({VIEW: 0.7}, 0.0, 0.5),
        ({VIEW: 0.95, GATHERED: 0.6}, 0.0, 0.5),
        ({VIEW: 0.9, GATHERED: 0.85}, -0.15, 0.5),
    ],
)
def test_passes_tell_how_errors_will_fall(powers, part, share):
    picture = MadeUpPicture(powers, part)
    goal = 0.3 * picture.error()
    true = needed(powers, part, goal)
    assert true > 60.0
    least, most = follow(picture, Foresight(picture.allocation, GROUPS, goal), share * true)
    assert 0.85 * true < least <= most < 1.18 * true


def test_passes_draw_the_power_of_each_kind_its_own_way():
    """From what is supposed, and by little, as single passes tell of chance as much."""
    powers = {VIEW: 1.0, GATHERED: 0.6}
    picture = MadeUpPicture(powers)
    foresight = Foresight(picture.allocation, GROUPS, 1e-9)
    follow(picture, foresight, 400.0)
    learned = foresight.powers()
    for kind, supposed in ((VIEW, 1.0 - EASE), (GATHERED, 1.0 - EASE_APART)):
        drawn = (learned[kind] - supposed) / (powers[kind] - supposed)
        assert 0.05 < drawn < 0.5


def test_light_that_one_half_has_not_seen_makes_the_end_uncertain():
    """Relative to what the other half shows its scatter is large, and will show in both."""
    picture = MadeUpPicture({VIEW: 0.9})
    foresight = Foresight(picture.allocation, GROUPS, 0.1 * picture.error())
    picture.go_on()
    own = picture.squares()
    foresight.note(own, picture.error())
    alone = foresight.span(own, own, own)
    others = {kind: 9.0 * each for kind, each in own.items()}
    least, most = foresight.span(own, own, others)
    assert alone[0] == pytest.approx(alone[1])
    assert alone[0] < least < most
    assert most > 5.0 * alone[1]


def test_nothing_is_foretold_before_a_pass_tells():
    picture = MadeUpPicture({VIEW: 0.9})
    foresight, now = Foresight(picture.allocation, GROUPS, 0.01), picture.squares()
    assert foresight.span(now, now, now) is None
    foresight.note(now, float("inf"))
    assert foresight.span(now, now, now) is None
    foresight.note({VIEW: 0.0 * now[VIEW]}, 0.1)
    assert foresight.span(now, now, now) is None
