"""Samples that are no numbers are left out of sums: results tell how many, and errors hold what they would bring."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from baking_rooms import bake, furnished_room, lamp
from glass_scenes import GLASS, ball, point
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.session import Session
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

ROOM = (*furnished_room(), paint(0.6), lamp((1.0, 1.0, 1.5)))
OBJECTS = ("room", "block")
PLACES, UP = np.array([[0.5, 0.5, 0.2], [1.5, 0.4, 0.5]]), np.tile([0.0, 0.0, 1.0], (2, 1))
TOLD = "no numbers and were left out"


def spoil(monkeypatch, owner, name, share=0.25):
    """Let a function of the engine give what is no number in a share of its lanes."""
    whole = getattr(owner, name)

    def spoiled(*values, **named):
        made = whole(*values, **named)
        # By a number that is not the one of the sample, of which points know.
        number = dr.arange(mi.UInt32, dr.width(made)) * 2654435761
        is_lost = mi.Float(number >> 8) < share * (1 << 24)
        return dr.select(is_lost, dr.nan, made)

    monkeypatch.setattr(owner, name, spoiled)


def measured(**more):
    return session_of(*ROOM).measure(PLACES, UP, StopRule(samples=1 << 14), **more)


def rendered():
    frame = np.array([[1, 0, 0, 1.0], [0, 0, -1, 0.1], [0, 1, 0, 1.0], [0, 0, 0, 1.0]])
    camera = Camera(frame, Projection.PERSPECTIVE, 24, 24, 1.5, 1.5)
    return session_of(*ROOM).render(camera, ViewSettings(StopRule(samples=64), illuminance=True))


def lost_of(notes):
    return [note for note in notes if TOLD in note]


def lost_in(result):
    return lost_of(each.message for each in result.departures)


def assert_held(value, error, whole, noise, share=0.25):
    """A value lacks its share of light, and its error holds that and is not much larger."""
    lacks = np.asarray(whole, dtype=float) - value
    assert (np.abs(lacks - share * np.asarray(whole)) < 5.0 * np.asarray(noise)).all()
    assert (np.asarray(error) > 0.8 * lacks).all()
    assert (np.asarray(error) < 1.5 * lacks + 5.0 * np.asarray(noise)).all()


# ---- sensors ----


@pytest.mark.parametrize("colour", [False, True])
def test_readings_tell_lost_samples_and_hold_their_light(monkeypatch, colour):
    from lumenray.engine.transport.paths import gather

    whole = measured(colour=colour)
    assert lost_of(whole.provenance.notes) == []
    spoil(monkeypatch, gather, "spectral_illuminance")
    made = measured(colour=colour)
    (told,) = lost_of(made.provenance.notes)
    lost, made_in_all = (int(word) for word in told.split()[:3:2])
    assert made_in_all == 2 << 14
    assert lost == pytest.approx(0.25 * made_in_all, rel=0.05)
    assert_held(
        made.illuminance, made.standard_error, whole.illuminance, whole.standard_error + 0.5
    )


def test_readings_without_any_sample_left_state_no_finite_error(monkeypatch):
    from lumenray.engine.transport.paths import gather

    spoil(monkeypatch, gather, "spectral_illuminance", 1.0)
    made = measured()
    assert not made.illuminance.any()
    assert np.isinf(made.standard_error).all()
    (told,) = lost_of(made.provenance.notes)
    assert told.startswith("32768 of 32768 samples")


def test_a_path_that_ends_with_a_share_that_is_no_number_is_lost(monkeypatch):
    """It may end before it meets any light that would show it."""
    from lumenray.engine.transport.paths.path_loop import PathLoop

    whole, scatter = measured(reflections=1), PathLoop._scatter

    def spoiled(self, path, at):
        made = scatter(self, path, at)
        path.throughput = dr.select(path.stream.next_float32() < 0.25, dr.nan, path.throughput)
        return made

    monkeypatch.setattr(PathLoop, "_scatter", spoiled)
    made = measured(reflections=1)
    assert len(lost_of(made.provenance.notes)) == 1
    lacks = whole.illuminance - made.illuminance
    assert (lacks > 0.05 * whole.illuminance).all()
    assert (made.standard_error > 0.9 * lacks).all()


# ---- pictures ----


def test_pictures_tell_lost_samples_and_hold_their_light(monkeypatch):
    from lumenray.engine.accuracy.estimate import relative_error
    from lumenray.engine.transport.paths import gather
    from lumenray.engine.transport.pictures import pixel_light

    whole = rendered()
    assert lost_of(whole.provenance.notes) == []
    spoil(monkeypatch, pixel_light, "trace")
    spoil(monkeypatch, gather, "spectral_illuminance")
    made = rendered()
    (told,) = lost_of(made.provenance.notes)
    assert "samples of the picture and" in told and "of the illuminance" in told
    luminance, reference = (each.tristimulus[..., 1].astype(float) for each in (made, whole))
    assert luminance.mean() == pytest.approx(0.75 * reference.mean(), rel=0.05)
    for values, errors, known in (
        (luminance, made.luminance_error, reference),
        (made.illuminance, made.illuminance_error, whole.illuminance),
    ):
        # What is missing is about the share that was lost, by chance a little more or less.
        assert errors.mean() > 0.95 * (known - values).mean()
    stated = relative_error(luminance, made.luminance_error)
    assert made.relative_error == pytest.approx(stated, rel=1e-3)


# ---- maps ----


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("method", ["cells", "paths"])
@pytest.mark.parametrize("kind", ["direct", "gathered"])
def test_maps_tell_lost_samples_and_hold_their_light(monkeypatch, method, kind):
    """However few of the samples are of the kind that is lost."""
    from lumenray.engine.transport.lux_maps import lumel_light

    whole = bake(ROOM, OBJECTS, samples=64, method=method)
    assert lost_in(whole) == []
    spoil(monkeypatch, lumel_light, kind)
    made = bake(ROOM, OBJECTS, samples=64, method=method)
    (told,) = lost_in(made)
    assert "samples of the maps" in told
    for one, other in zip(made.maps, whole.maps, strict=True):
        lacks = other.mean - one.mean
        assert lacks > 0.05 * other.mean
        assert lacks < one.mean_standard_error < other.mean
        values, known = made.lumels(one.number), whole.lumels(other.number)
        gap = np.average(known.illuminance - values.illuminance, weights=values.area)
        assert np.average(values.standard_error, weights=values.area) > gap
        assert one.relative_standard_error > lacks / other.mean


def test_maps_without_any_sample_left_state_no_finite_error(monkeypatch):
    from lumenray.engine.transport.paths import gather

    spoil(monkeypatch, gather, "photometric", 1.0)
    made = bake(ROOM, OBJECTS, samples=16, method="paths")
    assert made.mean == 0.0
    assert np.isinf(made.relative_standard_error)
    for each in made.maps:
        assert np.isinf(each.mean_standard_error)
        assert np.isinf(each.largest.high)
    assert np.isinf(made.pages[0].standard_error[made.pages[0].covered]).all()


@pytest.mark.slow
def test_maps_tell_what_cells_lost(monkeypatch):
    from lumenray.engine.transport.lux_maps import cell_iterations

    whole = bake(ROOM, OBJECTS, samples=64, method="cells")
    spoil(monkeypatch, cell_iterations, "direct")
    made = bake(ROOM, OBJECTS, samples=64, method="cells")
    (told,) = lost_in(made)
    assert "samples of cells" in told and "of the maps" not in told
    for one, other in zip(made.maps, whole.maps, strict=True):
        assert 0.0 < other.mean - one.mean < one.mean_standard_error


@pytest.mark.slow
def test_a_bake_that_goes_on_remembers_what_it_lost(monkeypatch, tmp_path):
    from lumenray.engine.baking import saver
    from lumenray.engine.baking.layer_state import LayerState
    from lumenray.engine.transport.lux_maps import lumel_light

    states, arrays_of = [], LayerState.arrays
    monkeypatch.setattr(LayerState, "arrays", lambda self: states.append(self) or arrays_of(self))
    monkeypatch.setattr(saver, "SAVE_INTERVAL", 0.0)
    spoil(monkeypatch, lumel_light, "direct")
    bake(ROOM, OBJECTS, samples=64, checkpoint=str(tmp_path / "state"))
    again = LayerState.from_arrays(StopRule(samples=64), arrays_of(states[-1]))
    assert again.losses.any
    np.testing.assert_array_equal(again.losses.counts, states[-1].losses.counts)
    np.testing.assert_array_equal(again.losses.shares, states[-1].losses.shares)


# ---- light paths ----


@pytest.mark.slow
def test_maps_tell_what_traced_light_lost(monkeypatch):
    from lumenray.engine.transport.light_tracing import deposits

    items = (GLASS, ball("ball", 0.2, (0, 0, 1), "glass", 16), paint(0.0), point((0, 0, 2)))
    items += (quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint"),)
    whole = bake(items, ("floor",), samples=16, density=8.0)
    assert lost_in(whole) == []
    spoil(monkeypatch, deposits, "photometric")
    made = bake(items, ("floor",), samples=16, density=8.0)
    (told,) = lost_in(made)
    assert "light paths" in told
    (one,), (other,) = made.maps, whole.maps
    assert 0.0 < other.mean - one.mean < one.mean_standard_error


def test_the_second_witness_tells_paths_that_it_lost(monkeypatch):
    from lumenray.engine.transport.witness import walk

    bend = walk.bend

    def spoiled(si, bsdf, stream, active):
        bs, weight = bend(si, bsdf, stream, active)
        return bs, dr.select(stream.next_float32() < 0.1, dr.nan, weight)

    monkeypatch.setattr(walk, "bend", spoiled)
    session = Session()
    session.apply(SceneDelta(changed=ROOM))
    made = session.measure(PLACES, UP, StopRule(samples=1 << 12))
    assert any("light was no number" in note for note in made.provenance.notes)
