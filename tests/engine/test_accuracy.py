"""Errors, stopping and forecast."""

import numpy as np
import pytest
from lumenray.engine.accuracy.estimate import Accumulator, Estimate
from lumenray.engine.accuracy.stopping import Clock, StopRule, format_seconds
from lumenray.engine.errors import Cancelled, SceneError


def test_the_error_of_two_halves_is_half_their_difference():
    made = Estimate.from_groups(np.array([[3.0, 10.0], [5.0, 10.0]]), 64)
    assert made.mean.tolist() == [4.0, 10.0]
    assert made.standard_error.tolist() == [1.0, 0.0]


def test_the_stated_error_is_calibrated_for_known_noise():
    rng = np.random.default_rng(1)
    sums = Accumulator(2, 20000)
    for _ in range(8):
        sums.add(rng.normal(10.0, 3.0, (2, 20000, 4)).sum(axis=2), 4)
    made = sums.estimate()
    true = 3.0 / np.sqrt(64)
    assert made.samples == 64
    assert made.relative_error() == pytest.approx(true / 10.0, rel=0.02)
    assert np.std(made.mean) == pytest.approx(true, rel=0.02)


def test_relative_error_weighs_by_area():
    made = Estimate(np.array([1.0, 3.0]), np.array([1.0, 0.0]), 2)
    assert made.relative_error(np.array([1.0, 3.0])) == pytest.approx(0.5 / 2.5)
    assert Estimate(np.zeros(2), np.zeros(2), 2).relative_error() == float("inf")


def test_a_rule_without_an_end_is_refused():
    with pytest.raises(SceneError, match="samples, an error or a time"):
        StopRule()
    with pytest.raises(SceneError, match="above 0"):
        StopRule(error=-0.1)


def test_the_forecast_follows_one_over_the_square_root(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(error=0.01))
    now[0] = 110.0
    assert clock.progress(50, float("inf")).seconds_left is None
    # 2 % after 10 s needs four times as long: 30 s more.
    assert not clock.is_done(100, 0.02)
    assert clock.progress(100, 0.02).seconds_left == pytest.approx(30.0)
    assert clock.is_done(400, 0.01)
    assert format_seconds(709) == "11:49 min"


@pytest.mark.parametrize("power", [0.5, 0.65, 0.8])
def test_the_forecast_learns_how_the_error_falls(monkeypatch, power):
    # 100 samples a second; the error is 10 % after 100 samples and falls as a power of their number.
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(each=0.001))
    for samples in (100, 200, 400, 800):
        now[0] = samples / 100.0
        error = (100 / samples) ** power
        assert not clock.is_done(samples, error, 0.1 * error / 0.001)
    needed = 100.0 * 100.0 ** (1.0 / power) / 100.0
    # In the middle of the next pass the error is still that of the last one.
    now[0] = 10.0
    assert clock.progress(1000, 1.0).seconds_left == pytest.approx(needed - 10.0)


@pytest.mark.parametrize("power", [0.5, 0.8])
def test_three_passes_tell_how_the_error_falls(monkeypatch, power):
    """Each doubles what there is; two of them are not believed in full."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(error=0.001))
    left = []
    for samples in (100, 200, 400):
        now[0] = samples / 100.0
        error = 0.1 * (samples / 100.0) ** -power
        assert not clock.is_done(samples, error)
        left.append(clock.progress(samples, error).seconds_left + now[0])
    needed = 100.0 ** (1.0 / power)
    assert left[2] == pytest.approx(needed)
    plain = 100.0 ** (1.0 / 0.5)
    assert left[0] == pytest.approx(plain)
    assert min(needed, plain) <= left[1] * 1.0001 and left[1] <= plain * 1.0001


def test_a_fast_fall_of_the_error_at_first_is_not_carried_on_to_the_end(monkeypatch):
    """As one over the samples so far; integrands with edges let well-distributed points fall by the power 3/4 at last."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(error=0.001))
    for samples in (100, 200, 400, 800):
        now[0] = samples / 100.0
        assert not clock.is_done(samples, 10.0 / samples)
    # Either on as before, or all the way from here as with edges, of which a part may be thought to be chance.
    soonest, latest = 10_000.0 / 100.0, 8.0 * 12.5 ** (4.0 / 3.0)
    left = clock.progress(800, 10.0 / 800).seconds_left
    assert 1.2 * (soonest - now[0]) < left < 1.1 * (latest - now[0])


def test_kernels_that_the_first_pass_makes_do_not_count_for_all_others(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    clock = Clock(StopRule(each=0.01))
    # Eight seconds for kernels, then 100 samples a second.
    for samples in (100, 200, 300, 400):
        now[0] = 8.0 + samples / 100.0
        error = 0.1 * (100 / samples) ** 0.5
        assert not clock.is_done(samples, error, error / 0.01)
    # A hundred times the samples of the first pass, whatever that took.
    assert clock.progress(400, error).seconds_left == pytest.approx(96.0)


@pytest.mark.parametrize("power, most", [(0.5, 0.38), (0.75, 0.26)])
@pytest.mark.slow
def test_the_forecast_of_the_worst_of_many_sensors_is_not_thrown_off_by_chance(
    monkeypatch, power, most
):
    """Fifty sensors of known errors, whose worst one ends the job after 150 passes: forecast after three tenths."""
    now = [0.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    rng = np.random.default_rng(4)
    groups, sensors, batch, passes = 16, 50, 256, 150
    off = []
    for _ in range(60):
        now[0] = 0.0
        scale = np.exp(0.4 * rng.normal(size=sensors))
        allowed = scale.max() * (batch * passes) ** -power / np.sqrt(groups)
        clock, walk, forecasts, samples = Clock(StopRule(each=1.0)), 0.0, [], 0
        while True:
            samples += batch
            now[0] += 1.0
            walk = walk + rng.normal(size=(groups, sensors)) * np.sqrt(batch)
            means = scale * walk / samples * samples ** (0.5 - power)
            error = Estimate.from_groups(means, samples).standard_error
            if clock.is_done(samples, np.sqrt(np.mean(error**2)), error.max() / allowed):
                break
            forecasts.append(now[0] + clock.progress(samples, 1.0).seconds_left)
        off.append(np.log(forecasts[int(0.3 * len(forecasts))] / now[0]))
    assert np.sqrt(np.mean(np.square(off))) < most
    assert abs(np.median(off)) < 0.12


@pytest.mark.mitsuba
def test_a_bake_stops_at_the_wanted_error_and_can_be_cancelled():
    from lumenray.engine.baking.order import BakeOrder
    from lumenray.engine.scene.light import Output, PointLight, Quantity
    from small_scenes import box, paint, quad, session_of

    floor = quad("floor", (0.2, 0.2, 0.1), (1, 0, 0), (0, 1, 0), "paint")
    items = (
        box(2, 2, 2),
        floor,
        paint(0.5),
        PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 100.0), np.ones(3), 0.1),
    )
    session = session_of(*items)

    def bake(progress=None, **rule):
        order = BakeOrder(("floor",), StopRule(**rule), density=16.0)
        return session.bake_objects(order, progress)

    seen = []
    made = bake(seen.append, error=0.01)
    assert made.relative_standard_error <= 0.01
    assert made.maps[0].relative_standard_error <= 0.01
    assert made.maps[0].samples > 4
    assert all(a.done <= b.done + 0.2 for a, b in zip(seen, seen[1:], strict=False))
    with pytest.raises(Cancelled):
        bake(lambda _: session.cancel(), samples=1 << 20)
    # The session goes on after a cancel.
    assert bake(samples=4).maps[0].samples == pytest.approx(4, abs=1)


def lit_room(width, height):
    """Session with a room and a lamp, and a camera in it."""
    from lumenray.engine.scene.camera import Camera, Projection
    from lumenray.engine.scene.light import Output, PointLight, Quantity
    from small_scenes import box, paint, session_of

    frame = np.eye(4)
    frame[:3, 3] = (1.0, 1.0, 1.9)
    camera = Camera(frame, Projection.PERSPECTIVE, width, height, 1.5, 1.0)
    lamp = PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 100.0), np.array([0.5, 1.0, 1.0]))
    return session_of(box(2, 2, 2), paint(0.5), lamp), camera


@pytest.mark.mitsuba
def test_a_render_shows_the_whole_frame_after_one_sample_and_can_be_cancelled():
    from lumenray.engine.session import ViewSettings

    session, camera = lit_room(800, 400)
    seen = []

    def follow(progress, preview):
        seen.append((progress.samples, preview() if preview is not None else None))
        if progress.samples == 1:
            session.cancel()

    with pytest.raises(Cancelled):
        session.render(camera, ViewSettings(StopRule(samples=1024)), follow)
    (_, first), (samples, whole) = seen[:2]
    # Rows appear from below; the upper ones are still empty.
    assert first.shape == (400, 800, 3)
    assert first[0].min() > 0.0
    assert first[-1].max() == 0.0
    assert samples == 1
    assert whole[..., 1].min() > 0.0


@pytest.mark.mitsuba
@pytest.mark.slow
def test_no_strip_of_a_picture_is_ahead_of_the_others_by_more_than_two_samples():
    from lumenray.engine.session import ViewSettings

    session, camera = lit_room(800, 400)
    counts = []
    session.render(
        camera, ViewSettings(StopRule(samples=16)), lambda state, _: counts.append(state.samples)
    )
    assert counts[-1] == 16
    assert max(np.diff(counts)) <= 2


@pytest.mark.mitsuba
def test_a_picture_does_not_end_by_an_error_that_two_samples_tell():
    from lumenray.engine.session import ViewSettings

    session, camera = lit_room(40, 30)
    picture = session.render(camera, ViewSettings(StopRule(error=0.99)))
    assert picture.provenance.samples == 8


@pytest.mark.mitsuba
def test_sensor_jobs_begin_with_short_passes_and_give_the_same_values():
    """So a forecast can be made soon; that samples come in other portions changes nothing but rounding."""
    from lumenray.engine.scene.light import UniformWorld
    from lumenray.engine.transport.paths import illuminance
    from lumenray.engine.transport.paths.illuminance import Receivers, compute
    from small_scenes import box, paint, quad, session_of

    lid = quad("lid", (-1, -1, 1), (2, 0, 0), (0, 2, 0), "paint")
    with session_of(paint(0.5), box(1, 1, 1, inwards=False), lid, UniformWorld(10.0))._engine(
        "mono"
    ) as scene:
        seen = []
        at = Receivers.at_points([[1.5, 0.5, 0.2], [-0.5, 0.3, 0.4]], [[0, 0, 1], [0, 1, 0]])
        made = compute(scene, at, StopRule(samples=1 << 16), 3, 16, progress=seen.append)
        assert made.samples == 1 << 16
        samples = [each.samples for each in seen]
        assert samples[:4] == [1024, 2048, 4096, 8192]
        whole = compute(scene, at, StopRule(samples=1 << 16), 3, 16)
        assert (made.mean == whole.mean).all()
        illuminance.FIRST_SHARE, share = 1, illuminance.FIRST_SHARE
        try:
            at_once = compute(scene, at, StopRule(samples=1 << 16), 3, 16)
        finally:
            illuminance.FIRST_SHARE = share
        assert made.mean == pytest.approx(at_once.mean, rel=1e-6)
