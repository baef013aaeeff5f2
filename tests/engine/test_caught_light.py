"""What shadow catchers show by sums over samples: parts of light groups add up, and errors are those of what is shown."""

import numpy as np
import pytest

from lumenray.engine.caught_light import LENGTH, OPEN, SHADED, CaughtLayout

PIXELS, BANDS = 5, 2
LAYOUT = CaughtLayout(BANDS, True)


def draw_samples(rng, count: int, light: float, shade) -> np.ndarray:
    """Samples of pixels that a group lights so much, of which so much is left. (count, pixels, columns)"""
    made = np.zeros((count, PIXELS, LAYOUT.count))
    made[..., 0] = 1.0
    for start in (1, 1 + LENGTH + BANDS):
        part = made[..., start : start + LENGTH + BANDS]
        behind = rng.normal(20.0, 3.0, (count, PIXELS, 1))
        part[..., :3] = behind * [0.9, 1.0, 1.1]
        part[..., LENGTH:] = behind * 0.01
        without = light * rng.gamma(4.0, 0.25, (count, PIXELS, 1)) * [0.95, 1.0, 1.05]
        part[..., OPEN] = without
        part[..., SHADED] = without * (rng.uniform(size=(count, PIXELS, 1)) < shade)
        with_all, alone = part[..., SHADED][..., 1], part[..., OPEN][..., 1]
        part[..., 9:13] = np.stack(
            [with_all**2, with_all * alone, alone**2, part[..., 1] ** 2], axis=-1
        )
    return made


def halves_of(samples: np.ndarray) -> np.ndarray:
    return np.stack([samples[0::2].mean(axis=0), samples[1::2].mean(axis=0)])


def test_parts_of_groups_are_their_light_over_all():
    """Of 1 and 3 units of light 0.5 and 1 are left: parts 1/8 and 3/4 of what is behind, of which mirrors had all before."""
    rng = np.random.default_rng(1)
    groups = [halves_of(draw_samples(rng, 40_000, *each)) for each in ((1.0, 0.5), (3.0, 1.0))]
    (first, second), is_open = LAYOUT.share_out(groups, [True, False])
    behind = np.array([18.0, 20.0, 22.0])
    assert first.tristimulus.mean(axis=(0, 1)) == pytest.approx(behind / 8.0, rel=0.01)
    assert second.tristimulus.mean(axis=(0, 1)) == pytest.approx(behind * 0.75, rel=0.01)
    assert first.change.mean(axis=(0, 1)) == pytest.approx(behind * (1 / 8 - 1), rel=0.01)
    assert second.change.mean(axis=(0, 1)) == pytest.approx(behind * 0.75, rel=0.01)
    assert second.bands.mean() == pytest.approx(0.2 * 0.75, rel=0.01)
    assert is_open.mean() == pytest.approx(7.0 / 8.0, rel=0.01)


def test_sums_of_groups_are_the_whole_to_rounding():
    """Few samples, in which every group has another chance: their sum is what all columns together show."""
    rng = np.random.default_rng(2)
    groups = [halves_of(draw_samples(rng, 6, *each)) for each in ((1.0, 0.5), (3.0, 0.8))]
    shown, is_open = LAYOUT.share_out(groups, [False, True])
    whole, of_whole = LAYOUT.shade(LAYOUT.join(groups))
    for name in ("tristimulus", "bands", "change", "band_change"):
        total = sum(getattr(each, name) for each in shown)
        assert total == pytest.approx(getattr(whole, name), rel=1e-12, abs=1e-12)
    assert is_open == pytest.approx(of_whole, rel=1e-12)


def test_what_nothing_shades_stays_as_it_is():
    rng = np.random.default_rng(3)
    groups = [halves_of(draw_samples(rng, 4, light, 1.0)) for light in (1.0, 0.01, 3.0)]
    shown, _ = LAYOUT.share_out(groups, [False, False, False])
    behind = np.mean([each[..., 1:4] for each in groups], axis=0)
    assert sum(each.tristimulus for each in shown) == pytest.approx(behind, rel=1e-12)
    assert sum(each.change for each in shown) == pytest.approx(0.0, abs=1e-12)


def test_without_any_light_the_surroundings_keep_what_is_behind():
    columns = np.zeros((2, PIXELS, LAYOUT.count))
    columns[..., 1:4] = columns[..., 1 + LENGTH + BANDS : 4 + LENGTH + BANDS] = 5.0
    lamp, world = LAYOUT.share_out([columns, columns], [False, True])[0]
    assert world.tristimulus == pytest.approx(5.0)
    assert not lamp.tristimulus.any()
    assert not lamp.change.any()
    assert world.change == pytest.approx(0.0, abs=1e-12)


def test_the_scatter_of_samples_is_that_of_what_is_shown():
    """By repeated trials of as many samples; of both groups together it is the sum of what either says."""
    rng = np.random.default_rng(4)
    lights, count = ((1.0, 0.5), (3.0, 0.8)), 400
    found, stated = [], []
    for _ in range(150):
        groups = [halves_of(draw_samples(rng, count, *each)) for each in lights]
        shown, _ = LAYOUT.share_out(groups, [True, False])
        found.append(sum(each.luminance.mean(axis=0) for each in shown))
        whole = LAYOUT.join([each.mean(axis=0) for each in groups])
        scatter = [
            LAYOUT.scatter(each, whole, np.full(PIXELS, count // 2), 0.0, 2).mean(axis=0)
            for each in groups
        ]
        stated.append(sum(scatter))
    ratio = np.var(found, axis=0, ddof=1).mean() / np.mean(stated)
    assert 0.7 < ratio < 1.15
