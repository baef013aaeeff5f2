"""How samples are planned, and the places that stand for all lumels."""

from types import SimpleNamespace

import numpy as np
import pytest

pytestmark = pytest.mark.mitsuba


def make_pilot(scatter, powers=(1.0, 1.0)):
    """A pilot that knows the variances of single samples of direct light and of rays; there are no other kinds."""
    from lumenray.engine.transport.lux_maps.job import Options
    from lumenray.engine.transport.lux_maps.pilot import Pilot

    count = len(scatter[0])
    job = SimpleNamespace(
        count=count,
        valid=np.ones(count, bool),
        area=np.ones(count),
        seed=1,
        options=Options(),
        guide=None,
        kinds=(0, 1),
    )
    pilot = Pilot(job)
    pilot._scatter[:2] = scatter
    pilot._powers[:2] = powers
    return pilot


def square_of(direct, gathered, samples, power):
    """Variance of a lumel whose direct part falls by a power from two samples on, the rest by their number."""
    n, m = samples
    return direct * (0.5 * (n / 2.0) ** -power if n > 2 else 1.0 / n) + gathered / m


@pytest.mark.parametrize("power", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("wanted", [0.1, 0.003])
def test_a_plan_meets_its_error_with_nearly_the_least_work(power, wanted):
    from lumenray.engine.transport.lux_maps.levels import COSTS

    direct, gathered = 2.0, 1.0
    pilot = make_pilot([np.full(50, v) for v in (direct, gathered)], (power, 1.0))
    levels = pilot.plan(square=wanted)
    n, m = (2.0 ** float(column[0]) for column in levels.columns[:2])
    assert square_of(direct, gathered, (n, m), power) <= 1.001 * wanted
    assert pilot.square(levels) == pytest.approx(
        square_of(direct, gathered, (n, m), power), rel=1e-4
    )
    pairs = [(2.0**i, 2.0**j) for i in range(11) for j in range(11)]
    least = min(
        COSTS[0] * a + COSTS[1] * b
        for a, b in pairs
        if square_of(direct, gathered, (a, b), power) <= wanted
    )
    # Numbers are powers of two.
    assert COSTS[0] * n + COSTS[1] * m <= 1.45 * least


@pytest.mark.parametrize("power", [1.0, 1.4, 1.9])
def test_the_power_is_learned_by_which_a_variance_falls(power):
    from lumenray.engine.transport.lux_maps.levels import NO_SAMPLES, Levels
    from lumenray.engine.transport.lux_maps.pilot import Drawn

    count, samples = 40_000, 32
    pilot = make_pilot([np.full(count, v) for v in (2.0, 1.0)])
    columns = np.full((4, count), NO_SAMPLES, np.uint8)
    columns[:2] = 5
    draw = np.random.default_rng(4)
    variances = (2.0 * 0.5 * (samples / 2.0) ** -power, 1.0 / samples, 0.0, 0.0)
    passes = [np.stack([np.sqrt(v) * draw.normal(size=count) for v in variances]) for _ in range(2)]
    pilot._learn(Levels(columns), Drawn(slice(None), pilot._share), passes[0] - passes[1])
    assert pilot._powers[:2] == pytest.approx([power, 1.0], abs=0.03)
    assert pilot.square(Levels(columns)) == pytest.approx(sum(variances), rel=0.04)


def test_a_plan_follows_what_passes_have_shown():
    pilot = make_pilot([np.full(50, v) for v in (2.0, 1.0)], (1.5, 1.0))
    levels = pilot.plan(square=0.01)
    pilot.correct(levels, 0.03)
    assert pilot.square(levels) == pytest.approx(0.03, rel=1e-5)
    assert pilot.square(pilot.plan(square=0.01)) <= 0.01 * 1.001


def test_a_pilot_goes_on_from_its_state_and_from_no_other():
    from lumenray.engine.errors import SceneError
    from lumenray.engine.transport.lux_maps.pilot import Pilot

    pilot = make_pilot([np.linspace(1.0, 2.0, 50) * v for v in (2.0, 1.0)], (1.5, 1.0))
    again = Pilot.from_state(pilot.job, pilot.state())
    levels = pilot.plan(square=0.01)
    np.testing.assert_array_equal(again.plan(square=0.01).columns, levels.columns)
    state = pilot.state()
    for name, wrong in (
        ("scatter", state["scatter"][:, 1:]),
        ("scatter", np.full_like(state["scatter"], np.nan)),
        ("powers", state["powers"].astype(np.float32)),
        ("traced", np.array([-1.0])),
        ("traced", None),
    ):
        with pytest.raises(SceneError, match=f"state of the pilot holds {name} that do not fit"):
            Pilot.from_state(pilot.job, state | {name: wrong})


def test_places_stand_for_all_valid_lumels_by_area():
    from lumenray.engine.transport.lux_maps.survey import Surveyor

    def block(number, areas, valid):
        count = np.arange(1, len(areas) + 1)
        start = np.cumsum(count) - count
        owner = np.repeat(np.arange(len(areas)), count)
        places = np.stack([np.full(len(owner), number), owner, np.zeros(len(owner))], axis=1)
        held = SimpleNamespace(
            positions=places.astype(float), normals=np.ones_like(places), start=start, count=count
        )
        return SimpleNamespace(
            area=np.array(areas), valid=np.array(valid), receivers=held, reached=None
        )

    blocks = [block(0, [1.0, 3.0, 9.0], [True, True, False]), block(1, [0.5, 1.5], [True, True])]
    surveyor = Surveyor(len(blocks), 1)
    for each in blocks:
        surveyor.add(each)
    known = surveyor.survey()
    assert known.area.tolist() == [1.0, 3.0, 9.0, 0.5, 1.5]
    assert known.places.tolist() == [6, 3]
    drawn = known.positions[known.draw(60_000, 2)][:, :2].astype(int)
    keys, counts = np.unique(drawn, axis=0, return_counts=True)
    found = {tuple(key): n / 60_000 for key, n in zip(keys.tolist(), counts, strict=True)}
    shares = {(0, 0): 1 / 6, (0, 1): 3 / 6, (1, 0): 0.5 / 6, (1, 1): 1.5 / 6}
    assert found.keys() == shares.keys()
    for key, share in shares.items():
        assert found[key] == pytest.approx(share, abs=0.02)


# ---- trials ----


def test_trials_are_made_on_some_lumels_of_every_tile():
    """What is not known of a tile is common to its lumels, so whole tiles would tell less."""
    tiles, size = 500, 64
    chosen = make_pilot([np.ones(tiles * size)] * 2)._choose(0.2, 100)
    share = chosen.reshape(tiles, size).mean(axis=1)
    assert chosen.mean() == pytest.approx(0.2, abs=0.01)
    # Binomial: within five standard deviations in each of them, and on the whole as wide as that.
    spread = np.sqrt(0.2 * 0.8 / size)
    assert np.abs(share - 0.2).max() < 5.0 * spread
    assert share.std() == pytest.approx(spread, rel=0.2)
    # At least so many, also where few are enough for the share.
    assert make_pilot([np.ones(640)] * 2)._choose(0.01, 300).sum() >= 300


@pytest.mark.parametrize("traced", [1e3, 2e4, 5e4, 1e5])
def test_paths_from_the_lights_are_as_many_as_give_nearly_the_least_work(traced):
    """``traced``: square of the error that a single path leaves. Against a search over numbers of paths and samples."""
    from lumenray.engine.transport.lux_maps import job as lux_job
    from lumenray.engine.transport.lux_maps.levels import COSTS, SAMPLE_COST

    count, scatter, wanted = 1 << 16, 4.0, 0.05
    pilot = make_pilot([np.full(count, v) for v in (0.0, scatter)])
    pilot.job.trace_share, pilot.job._traces = lux_job.TRACE_SHARES[1], True
    pilot.job.paths = lambda levels: lux_job.LuxJob.paths(pilot.job, levels)
    pilot._traced = traced
    pilot.choose_trace_share(pilot.plan(square=wanted))
    levels = pilot.plan(square=wanted)
    paths = pilot.job.paths(levels)
    assert pilot.square(levels) == pytest.approx(
        scatter / 2.0 ** levels.columns[1].mean() + traced / paths, rel=1e-3
    )
    assert pilot.square(levels) <= 1.001 * wanted

    def work(samples, paths):
        return count * (1.0 + COSTS[1] * samples) / SAMPLE_COST + lux_job.TRACE_COST * paths

    low, high = np.log2(lux_job.TRACED_PATHS).astype(int)
    least = min(
        work(2.0**i, 2.0**j)
        for i in range(11)
        for j in range(low, high + 1)
        if scatter / 2.0**i + traced / 2.0**j <= wanted
    )
    assert work(2.0 ** levels.columns[1].mean(), paths) <= 1.6 * least


def test_what_paths_from_the_lights_cannot_do_in_a_pass_is_said_and_left_to_further_ones():
    from lumenray.engine.transport.lux_maps import job as lux_job

    count, wanted = 1 << 16, 0.05
    pilot = make_pilot([np.full(count, v) for v in (0.0, 4.0)])
    pilot.job.trace_share, pilot.job._traces = lux_job.TRACE_SHARES[1], True
    pilot.job.paths = lambda levels: lux_job.LuxJob.paths(pilot.job, levels)
    pilot._traced = 1e7
    pilot.choose_trace_share(pilot.plan(square=wanted))
    levels = pilot.plan(square=wanted)
    assert levels.columns[1].max() <= 8
    assert pilot.square(levels) > 1e7 / lux_job.TRACED_PATHS[1] > wanted


def test_trials_know_errors_better_that_few_lumels_make():
    """A hundredth of the lumels makes half of it: without bias, and with less scatter than if they were drawn evenly."""
    from lumenray.engine.transport.lux_maps.levels import NO_SAMPLES, Levels

    count, few = 20_000, 200
    scatter = np.where(np.arange(count) < few, 99.0, 1.0)
    columns = np.full((4, count), NO_SAMPLES, np.uint8)
    columns[1] = 0
    known, rows = [], []
    for seed in range(60):
        pilot = make_pilot([np.zeros(count), scatter])
        pilot._lot = np.random.default_rng(seed).integers(0, 1024, count, dtype=np.uint16)
        drawn = pilot._draw(Levels(columns), 0.1)
        differences = np.sqrt(2.0 * scatter) * np.random.default_rng(100 + seed).normal(size=count)
        known.append(float((0.5 * differences[drawn.rows] ** 2) @ drawn.share) / scatter.mean())
        rows.append(drawn.rows.mean())
    assert np.mean(known) == pytest.approx(1.0, abs=3.0 * np.std(known) / np.sqrt(60))
    # Evenly, twenty lumels would hold half: their squares scatter by sqrt(3 / 20) of it.
    assert np.std(known) < 0.5 * np.sqrt(3.0 / 20.0) * 0.5
    assert np.mean(rows) < 0.11
