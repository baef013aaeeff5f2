"""Forecast of the time that an animation takes yet."""

import bpy
import pytest

from lumenray.blender_addon.rendering.animation import Frames, FrameTimes
from lumenray.engine.accuracy.stopping import Progress
from lumenray.tools.libraries.scenes import tiny


@pytest.fixture
def clock(monkeypatch):
    """Clock that is set by hand."""
    now = [100.0]
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    return now


def state(left=None):
    return Progress(0.5, 16, 0.02, 5.0, left)


def times(clock, *seconds):
    """Frames that took so long, and one more that begins."""
    made = FrameTimes()
    made.begin()
    for each in seconds:
        clock[0] += each
        made.begin()
    return made


def test_frames_to_come_take_as_long_as_those_that_are_done(clock):
    made = times(clock, 30.0, 10.0, 12.0)
    # The first one, which starts the engine, tells of itself alone: 11 s each for six more.
    assert made.seconds_left(Frames(4, 10), state(3.0)) == pytest.approx(3.0 + 6 * 11.0)
    assert times(clock, 30.0).seconds_left(Frames(2, 3), state(3.0)) == pytest.approx(33.0)


def test_a_frame_without_a_forecast_takes_as_long_as_others(clock):
    made = times(clock, 30.0, 10.0)
    clock[0] += 4.0
    assert made.seconds_left(Frames(3, 4), state()) == pytest.approx(6.0 + 10.0)
    clock[0] += 40.0
    assert made.seconds_left(Frames(3, 4), state()) == pytest.approx(10.0)


def test_nothing_is_foretold_before_a_frame_is_done(clock):
    made = times(clock)
    assert made.seconds_left(Frames(1, 50), state(3.0)) is None
    assert made.describe(Frames(1, 50), state(3.0)).startswith("frame 1 of 50, 16 samples")


def test_old_frames_are_forgotten(clock):
    made = times(clock, *[100.0] * 20, *[10.0] * 8)
    assert made.seconds_left(Frames(29, 30), state(0.0)) == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("start", "end", "step", "current", "expected"),
    [
        (1, 250, 1, 1, (1, 250)),
        (1, 250, 10, 241, (25, 25)),
        (5, 12, 3, 8, (2, 3)),
        (1, 4, 1, 9, (9, 9)),
    ],
)
def test_frames_are_counted_by_their_step(start, end, step, current, expected):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.frame_step = start, end, step
    scene.frame_current = current
    assert Frames.of(scene) == Frames(*expected)


@pytest.mark.usefixtures("extension")
def test_an_animation_tells_when_its_last_frame_will_be_done(tmp_path, monkeypatch):
    texts = []
    describe = FrameTimes.describe

    def note(self, frames, progress):
        texts.append(describe(self, frames, progress))
        return texts[-1]

    monkeypatch.setattr(FrameTimes, "describe", note)
    tiny.build_closed_box()
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x, scene.render.resolution_y = 16, 12
    scene.render.resolution_percentage = 100
    scene.lumenray.render.samples = 4
    scene.frame_start, scene.frame_end, scene.frame_step = 1, 5, 2
    scene.render.filepath = str(tmp_path / "box")
    bpy.ops.render.render(animation=True)
    by_frame = [
        [text for text in texts if text.startswith(f"frame {number} of 3, ")]
        for number in (1, 2, 3)
    ]
    assert all(by_frame)
    assert not any("left of all frames" in text for text in by_frame[0])
    assert all("left of all frames" in text for text in (*by_frame[1], *by_frame[2]))
