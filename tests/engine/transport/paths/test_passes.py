"""Passes of pictures and of sensors: even over the frame, short at first, and no end before an error is known."""

import numpy as np
import pytest

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import Cancelled


def lit_room(width, height):
    """Session with a room and a lamp, and a camera in it."""
    from small_scenes import box, paint, session_of

    from lumenray.engine.scene.camera import Camera, Projection
    from lumenray.engine.scene.light import Output, PointLight, Quantity

    frame = np.eye(4)
    frame[:3, 3] = (1.0, 1.0, 1.9)
    camera = Camera(frame, Projection.PERSPECTIVE, width, height, 1.5, 1.0)
    lamp = PointLight("l", "l", Output(Quantity.LUMINOUS_FLUX, 100.0), np.array([0.5, 1.0, 1.0]))
    return session_of(box(2, 2, 2), paint(0.5), lamp), camera


@pytest.mark.mitsuba
def test_a_render_shows_the_whole_frame_after_one_sample_and_can_be_cancelled():
    from lumenray.engine.views import ViewSettings

    session, camera = lit_room(800, 400)
    seen = []

    def follow(progress, preview):
        if preview is not None:
            seen.append((progress.samples, preview()))
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
    from lumenray.engine.views import ViewSettings

    session, camera = lit_room(800, 400)
    counts = []
    session.render(
        camera, ViewSettings(StopRule(samples=16)), lambda state, _: counts.append(state.samples)
    )
    assert counts[-1] == 16
    assert max(np.diff(counts)) <= 2


@pytest.mark.mitsuba
def test_a_picture_does_not_end_by_an_error_that_two_samples_tell():
    from lumenray.engine.views import ViewSettings

    session, camera = lit_room(40, 30)
    picture = session.render(camera, ViewSettings(StopRule(error=0.99)))
    assert 8 <= picture.provenance.samples < 12


@pytest.mark.mitsuba
def test_sensor_jobs_begin_with_short_passes_and_give_the_same_values():
    """So a forecast can be made soon; that samples come in other portions changes nothing but rounding."""
    from small_scenes import box, paint, quad, session_of

    from lumenray.engine.scene.light import UniformWorld
    from lumenray.engine.transport.paths import illuminance
    from lumenray.engine.transport.paths.illuminance import Receivers, compute

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
