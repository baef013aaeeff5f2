"""Live views: they become the picture, their display follows, and faults are said."""

from dataclasses import replace

import numpy as np
import pytest
from live_scenes import camera_at, lamp
from small_scenes import box, paint, session_of

from lumenray.engine import denoised_view
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.analysis.denoiser import DenoiserError, find_denoiser
from lumenray.engine.errors import SceneError
from lumenray.engine.light_mix import Level, LightMix
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.mesh import Placement
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.views import Display, DisplayMode, LiveSettings, ViewSettings

pytestmark = pytest.mark.mitsuba


def finish(session):
    """Work until the view is complete; returns all frames."""
    frames = []
    while session.has_view_work:
        frame = session.refine()
        if frame is not None:
            frames.append(frame)
    return frames


@pytest.mark.slow
def test_a_live_view_becomes_the_picture():
    session = session_of(
        box(4, 4, 3, "paint"), paint(0.5), lamp("l", 2, 2, 2.9), replace(paint(0.2, "m"), id="m")
    )
    camera = camera_at(2, 2, 2.0, 160, 120)
    session.watch(camera, LiveSettings(samples=64), Display(white=100.0))
    frames = finish(session)
    assert frames[0].pixels.shape[1] < 160
    assert frames[-1].pixels.shape == (120, 160, 4)
    assert frames[-1].is_final
    assert frames[-1].samples == 64
    assert not any(frame.is_final for frame in frames[:-1])
    assert frames[-1].relative_error < frames[len(frames) // 2].relative_error
    picture = session.render(camera, ViewSettings(StopRule(samples=64), seed=1))
    luminance = picture.tristimulus[..., 1] / 100.0
    shown = frames[-1].pixels[..., :3] @ [0.2126, 0.7152, 0.0722]
    error = np.sqrt(2.0) * picture.luminance_error.mean() / 100.0
    blocks = (luminance - shown).reshape(12, 10, 16, 10).mean(axis=(1, 3))
    assert np.abs(blocks).max() < 5.0 * error / 10.0 + 1e-3
    assert luminance.mean() == pytest.approx(shown.mean(), rel=0.01)


def test_display_follows_without_new_samples():
    session = session_of(box(4, 4, 3, "paint"), paint(0.5), lamp("l", 2, 2, 2.9))
    camera = camera_at(2, 2, 2.0, 32, 24)
    session.watch(camera, LiveSettings(samples=4), Display(white=100.0))
    last = finish(session)[-1]
    session.watch(camera, LiveSettings(samples=4), Display(white=200.0))
    again = finish(session)
    assert len(again) == 1
    np.testing.assert_allclose(again[0].pixels[..., :3], 0.5 * last.pixels[..., :3], rtol=1e-5)
    session.watch(camera, LiveSettings(samples=4), Display(DisplayMode.FALSE_LUMINANCE, high=100.0))
    false = finish(session)[-1]
    assert false.is_display_referred
    assert (false.low, false.high, false.unit) == (0.0, 100.0, "cd/m²")
    session.watch(camera, LiveSettings(samples=4), Display(DisplayMode.FALSE_ILLUMINANCE))
    assert finish(session)[-1].unit == "lx"


def test_the_first_frame_is_an_image():
    session = session_of(box(4, 4, 3, "paint"), paint(0.5), lamp("l", 2, 2, 2.9))
    for width in (32, 300):
        session.watch(camera_at(2, 2, 2.0, width, 24), LiveSettings(samples=4), Display())
        first = next(frame for frame in iter(session.refine, 0) if frame is not None)
        assert (first.pixels[..., 1] > 0.0).mean() > 0.5


def test_a_fault_in_a_scene_is_said_and_the_next_edit_is_right():
    session = session_of(box(4, 4, 3, "paint"), paint(0.5), lamp("l", 2, 2, 2.9))
    camera = camera_at(2, 2, 2.0, 32, 24)
    session.watch(camera, LiveSettings(samples=4), Display())
    finish(session)
    session.apply(SceneDelta(changed=(Placement("o", "o", "missing", np.eye(4), ("paint",)),)))
    with pytest.raises(SceneError, match="does not hold"):
        session.refine()
    session.apply(SceneDelta(removed=("o",)))
    assert finish(session)[-1].is_final


def test_a_view_by_groups_is_mixed_without_new_samples_and_is_the_picture():
    lamps = (lamp("a", 1, 2, 2.5), lamp("b", 3, 2, 2.5))
    session = session_of(box(4, 4, 3, "paint"), paint(0.5), *lamps)
    camera = camera_at(2, 2, 2.0, 160, 120)
    settings = LiveSettings(samples=32, groups=(LightGroup("left", ("a",)),))
    session.watch(camera, settings, Display(white=1.0))
    frames = finish(session)
    assert frames[0].pixels.shape[1] < 160
    whole = frames[-1]
    assert whole.samples == 32

    def shown(*levels):
        session.watch(camera, settings, Display(white=1.0, mix=LightMix(levels)))
        (frame,) = finish(session)
        assert frame.samples == 32
        return frame

    left, right = (shown(Level(name, is_on=False)) for name in ("rest", "left"))
    total = left.pixels[..., :3] + right.pixels[..., :3]
    np.testing.assert_allclose(total, whole.pixels[..., :3], rtol=1e-5, atol=1e-4)
    half = shown(Level("left", 0.5), Level("rest", 2.0))
    expected = 0.5 * left.pixels[..., :3] + 2.0 * right.pixels[..., :3]
    np.testing.assert_allclose(half.pixels[..., :3], expected, rtol=1e-5, atol=1e-4)
    assert left.relative_error > whole.relative_error
    # Every half is the picture of its lamp.
    for item, frame in zip(lamps, (left, right), strict=True):
        alone = session_of(box(4, 4, 3, "paint"), paint(0.5), item)
        picture = alone.render(camera, ViewSettings(StopRule(samples=32), seed=1))
        luminance = frame.pixels[..., :3] @ [0.2126, 0.7152, 0.0722]
        gap = luminance - picture.tristimulus[..., 1]
        assert luminance.mean() == pytest.approx(picture.tristimulus[..., 1].mean(), rel=0.02)
        assert gap.reshape(12, 10, 16, 10).mean(axis=(1, 3)).std() < 0.05 * luminance.mean()


def test_a_view_by_groups_goes_on_after_a_render_and_begins_anew_after_an_edit():
    session = session_of(
        box(4, 4, 3, "paint"), paint(0.5), lamp("a", 1, 2, 2.5), lamp("b", 3, 2, 2.5)
    )
    camera = camera_at(2, 2, 2.0, 32, 24)
    settings = LiveSettings(samples=16, groups=(LightGroup("left", ("a",)),))
    session.watch(camera, settings, Display(white=100.0))
    undisturbed = finish(session)[-1]
    session.unwatch()
    session.watch(camera, settings, Display(white=100.0))
    session.refine()
    session.render(camera, ViewSettings(StopRule(samples=2)))
    np.testing.assert_array_equal(finish(session)[-1].pixels, undisturbed.pixels)
    session.apply(SceneDelta(changed=(lamp("b", 3, 2, 2.5, lumens=2000.0),)))
    brighter = finish(session)[-1]
    assert brighter.pixels[..., 1].mean() == pytest.approx(
        1.5 * undisturbed.pixels[..., 1].mean(), rel=0.02
    )
    # Without groups the same scene shows the same light.
    session.watch(camera, LiveSettings(samples=64), Display(white=100.0))
    plain = finish(session)[-1]
    assert plain.pixels[..., 1].mean() == pytest.approx(brighter.pixels[..., 1].mean(), rel=0.02)


def still_view(monkeypatch, samples=8, mode=DisplayMode.PICTURE, rest=0.0):
    """Session with a room whose view wants to be denoised at rest."""
    monkeypatch.setattr(denoised_view, "REST", rest)
    session = session_of(box(4, 4, 3, "paint"), paint(0.5), lamp("l", 2, 2, 2.9))
    settings = LiveSettings(samples=samples, denoise=True)
    session.watch(camera_at(2, 2, 2.0, 64, 48), settings, Display(mode, white=100.0))
    return session


def roughness(frame):
    """How much neighbouring pixels differ."""
    return np.abs(np.diff(frame.pixels[..., 1])).mean()


@pytest.mark.skipif(find_denoiser() is None, reason="Open Image Denoise is not installed")
def test_a_view_at_rest_is_denoised_and_says_so(monkeypatch):
    frames = finish(still_view(monkeypatch))
    raw = [frame for frame in frames if not frame.words]
    last = frames[-1]
    assert last.words == "denoised by Open Image Denoise"
    assert last.is_final
    assert not any(frame.is_final for frame in frames[:-1])
    assert last.samples == raw[-1].samples == 8
    assert roughness(last) < 0.5 * roughness(raw[-1])
    assert last.pixels.mean() == pytest.approx(raw[-1].pixels.mean(), rel=0.01)


@pytest.mark.skipif(find_denoiser() is None, reason="Open Image Denoise is not installed")
def test_what_is_read_as_a_number_is_never_denoised(monkeypatch):
    for mode in (DisplayMode.LUMINANCE, DisplayMode.FALSE_LUMINANCE):
        frames = finish(still_view(monkeypatch, mode=mode))
        assert frames[-1].is_final
        assert not any(frame.words for frame in frames)


@pytest.mark.skipif(find_denoiser() is None, reason="Open Image Denoise is not installed")
def test_an_edit_gives_up_what_is_being_denoised_and_shows_what_is_computed(monkeypatch):
    session = still_view(monkeypatch, samples=1 << 16)
    tasks = []
    make = denoised_view.Denoising
    monkeypatch.setattr(
        denoised_view, "Denoising", lambda *a, **k: tasks.append(make(*a, **k)) or tasks[-1]
    )
    while not tasks:
        session.refine()
    session.apply(SceneDelta(changed=(paint(0.2),)))
    first = next(frame for frame in iter(session.refine, 0) if frame is not None)
    assert not first.words
    assert tasks[0].wait(0.0)
    with pytest.raises(DenoiserError):
        tasks[0].result()


def test_a_view_whose_denoiser_fails_stays_as_computed_and_says_why(monkeypatch):
    def fail(*_, **__):
        raise DenoiserError("it is broken")

    monkeypatch.setattr(denoised_view, "find_denoiser", lambda: "somewhere")
    monkeypatch.setattr(denoised_view, "Denoising", fail)
    last = finish(still_view(monkeypatch))[-1]
    assert last.is_final
    assert last.words == "not denoised: it is broken"


def test_without_a_denoiser_a_view_is_as_computed(monkeypatch):
    monkeypatch.setattr(denoised_view, "find_denoiser", lambda: None)
    last = finish(still_view(monkeypatch))[-1]
    assert (last.is_final, last.words) == (True, "")
