"""Pictures of an open shutter: their mean is that over its time, and their error holds what moves."""

from dataclasses import replace

import numpy as np
import pytest

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.light_mix import GroupLight
from lumenray.engine.moving_picture import Shutter, render_moments
from lumenray.engine.scene.provenance import Provenance
from lumenray.engine.views import Picture, ViewSettings

SHUTTER = Shutter(5.0, 4.75, 0.5)
EDGES = np.random.default_rng(3).random((20, 30))
"""When each pixel becomes bright, as a share of the shutter's time."""

NOISE = 0.3


def pictures(noise=NOISE, groups=()):
    """Render pixels that become bright at `EDGES`, with noise by the seed; ``times`` keeps what was asked for."""

    def render(time, settings, progress):
        render.times.append(time)
        draw = np.random.default_rng(settings.seed)
        share = (time - SHUTTER.begin) / SHUTTER.length
        light = 1.0 + (share > EDGES)
        light = light + noise / np.sqrt(settings.rule.samples) * draw.standard_normal(light.shape)
        light = np.repeat(light[..., None], 3, axis=2).astype(np.float32)
        made = Provenance("1", "mono", f"{time}", settings.seed, settings.rule.samples, 0.1)
        flat = np.full(EDGES.shape, time, np.float32)
        lights = tuple(
            GroupLight(name, settings.rule.samples, part * light, 0.1 * light[..., 1])
            for name, part in groups
        )
        fields = (light, 0.1 * light[..., 1], 0.1, flat, light, flat, flat)
        return Picture(*fields, provenance=made, groups=lights)

    render.times = []
    return render


def settings(seed=0, **rule):
    return ViewSettings(StopRule(**rule), seed=seed)


def test_the_mean_over_the_shutter_is_expected_and_its_error_holds_what_moves():
    truth, gaps, errors = 2.0 - EDGES, [], []
    for seed in range(40):
        made = render_moments(SHUTTER, settings(seed, samples=64), pictures())
        gaps.append(made.tristimulus[..., 1] - truth)
        errors.append(made.luminance_error)
    gaps, errors = np.array(gaps, float), np.array(errors, float)
    # Without what moves the noise alone would be stated.
    assert (errors**2).mean() > 1.3 * NOISE**2 / 64
    assert np.sqrt((gaps**2).mean() / (errors**2).mean()) == pytest.approx(1.0, abs=0.03)
    ratio = gaps.mean() / (gaps.std() / np.sqrt(gaps.size))
    assert abs(ratio) < 4.0
    # No pixel is off, wherever its edge lies in a part of the shutter's time.
    each = gaps.mean(axis=0) / (gaps.std(axis=0) / np.sqrt(len(gaps)))
    assert abs(each).max() < 6.0


def test_errors_of_whole_pictures_are_those_of_their_pixels():
    made = render_moments(SHUTTER, settings(samples=64), pictures())
    by_hand = made.luminance_error / np.maximum(made.tristimulus[..., 1], made.tristimulus.mean())
    assert made.relative_error == pytest.approx(float(np.sqrt((by_hand**2).mean())), rel=1e-5)


@pytest.mark.parametrize(("samples", "moments"), [(2, 2), (16, 4), (64, 16), (256, 64), (4096, 64)])
def test_samples_are_shared_out_between_moments_in_all_parts_of_the_time(samples, moments):
    render = pictures()
    made = render_moments(SHUTTER, settings(samples=samples), render)
    assert len(render.times) == moments
    assert samples <= made.provenance.samples <= max(samples, 2 * moments)
    parts = (np.array(render.times) - SHUTTER.begin) / SHUTTER.length * (moments / 2)
    np.testing.assert_array_equal(np.bincount(parts.astype(int)), np.full(moments // 2, 2))


def test_the_same_seed_gives_the_same_picture_and_moments_have_seeds_of_their_own():
    first, second, other = (
        render_moments(SHUTTER, settings(seed, samples=16), pictures()) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first.tristimulus, second.tristimulus)
    assert first.provenance.scene_hash == second.provenance.scene_hash
    assert (first.tristimulus != other.tristimulus).any()
    seeds = []

    def render(time, own, _progress):
        seeds.append(own.seed)
        return pictures()(time, own, None)

    render_moments(SHUTTER, settings(samples=16), render)
    assert len(set(seeds)) == len(seeds)


def test_a_shutter_that_opens_slowly_weighs_times_by_its_curve():
    shutter = replace(SHUTTER, opening=np.arange(256) + 0.5)
    # Light let through grows as the square of the time.
    for share in (0.0, 0.1, 0.5, 0.9, 1.0):
        expected = shutter.begin + shutter.length * np.sqrt(share)
        assert shutter.time(share) == pytest.approx(expected, abs=1e-3)
    made = [
        render_moments(shutter, settings(seed, samples=256), pictures()).tristimulus[..., 1]
        for seed in range(8)
    ]
    gap = np.mean(made, axis=0) - (2.0 - EDGES**2)
    assert abs(gap).max() < 0.05
    assert abs(gap.mean()) < 0.003


def test_an_error_is_reached_in_rounds_of_new_moments():
    render = pictures()
    made = render_moments(SHUTTER, settings(error=0.01), render)
    assert 0.005 < made.relative_error <= 0.01
    assert len(set(render.times)) == len(render.times) > 64


def test_time_ends_rounds_of_as_many_samples_as_it_allows(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("lumenray.engine.accuracy.stopping.read_clock", lambda: now[0])
    of_moment = pictures()

    def render(time, own, progress):
        # Each moment has to be prepared, and each sample takes its time.
        now[0] += 0.1 + 0.05 * own.rule.samples
        return of_moment(time, own, progress)

    made = render_moments(SHUTTER, settings(seconds=20.0), render)
    assert 19.0 < now[0] < 26.0
    assert made.provenance.samples > 150


def test_a_picture_without_light_ends_once_it_is_known_to_be_dark():
    of_moment = pictures(noise=0.0)

    def render(time, own, progress):
        made = of_moment(time, own, progress)
        dark = replace(made, tristimulus=0.0 * made.tristimulus)
        return replace(dark, provenance=replace(made.provenance, samples=1 << 12))

    made = render_moments(SHUTTER, settings(error=0.01), render)
    assert made.relative_error == 0.0
    assert not made.tristimulus.any()


def test_depth_normals_and_indices_are_of_the_middle():
    render = pictures()
    made = render_moments(SHUTTER, settings(samples=64), render)
    nearest = min(render.times, key=lambda time: abs(time - SHUTTER.middle))
    assert (made.depth == np.float32(nearest)).all()


def test_groups_are_means_too_and_add_up():
    render = pictures(groups=(("one", 0.25), ("rest", 0.75)))
    made = render_moments(SHUTTER, settings(samples=64), render)
    total = sum(group.tristimulus for group in made.groups)
    np.testing.assert_allclose(total, made.tristimulus, rtol=1e-6)
    one = made.groups[0]
    np.testing.assert_allclose(one.luminance_error, 0.25 * made.luminance_error, rtol=1e-4)
    assert one.samples == made.provenance.samples


def test_what_is_said_names_the_moments_and_progress_counts_all_samples():
    told = []

    def render(time, own, progress):
        made = pictures()(time, own, None)
        state = progress_state(own.rule.samples)
        progress(state, lambda: made.tristimulus)
        return made

    def progress(state, preview):
        told.append((state.samples, state.stage, float(preview().mean())))

    made = render_moments(SHUTTER, settings(samples=64), render, progress)
    assert "mean of 16 moments between the frames 4.75 and 5.25" in made.provenance.notes[0]
    assert [samples for samples, *_ in told] == list(range(4, 65, 4))
    assert told[-1][1] == "moment 16 of the shutter"
    assert told[-1][2] == pytest.approx(made.tristimulus.mean(), rel=1e-5)


def progress_state(samples):
    from lumenray.engine.accuracy.stopping import Progress

    return Progress(1.0, samples, 0.1, 0.1, None)


def test_a_cancelled_moment_ends_all():
    def render(*_):
        raise Cancelled("cancelled")

    with pytest.raises(Cancelled):
        render_moments(SHUTTER, settings(samples=64), render)


@pytest.mark.parametrize(
    "values",
    [{"length": 0.0}, {"length": np.inf}, {"opening": np.zeros(4)}, {"opening": -np.ones(4)}],
)
def test_a_shutter_that_exposes_nothing_is_refused(values):
    with pytest.raises(SceneError, match="shutter"):
        replace(SHUTTER, **values)
