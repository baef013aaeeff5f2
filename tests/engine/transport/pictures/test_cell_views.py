"""Live views with cells: they show what paths show, sooner, and an edit finds the old light gone."""

import numpy as np
import pytest
from small_pictures import ROOMS, blocks_of, lamp, look_in, picture_of
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.transport.pictures import cell_view
from lumenray.engine.transport.pictures.kept_cells import KeptCells
from lumenray.engine.transport.pictures.picture import SHARED
from lumenray.engine.views import Display, LiveSettings, ViewSettings

pytestmark = pytest.mark.mitsuba

Z = 4.5
CELLS_SHARE = 0.01
"""What cells may change of a square of 8 x 8 pixels, beside noise, relative to it; those of a view are large. [-]"""

VIEW = look_in(48, 32)


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """Cells are found without waiting, paths wait for them, and pixels, which share nothing, err independently."""
    monkeypatch.setattr(cell_view, "SHARED", np.inf)
    monkeypatch.setattr(cell_view, "CALM", 0.0)
    monkeypatch.setattr(cell_view, "FINDING_SHARE", 1.0)


def finish(session, samples=256, method="cells", **more):
    """Work until the view is complete; returns its luminance, the error of that, and its last frame."""
    settings = LiveSettings(samples=samples, method=method, **more)
    session.watch(VIEW, settings, Display(white=1.0))
    frame = None
    while session.has_view_work:
        frame = session.refine() or frame
    work = session._view.work
    return work.image()[..., 1].astype(float), work.luminance_error().astype(float), frame


def assert_agree(one, other):
    """Assert that squares of two views or pictures (luminance, error) agree within their errors."""
    (a, a_error), (b, b_error) = one[:2], other[:2]
    errors = np.sqrt(blocks_of(a_error**2) + blocks_of(b_error**2)) / 8.0
    a, b = blocks_of(a), blocks_of(b)
    assert np.median(errors / b) < 0.02
    assert ((np.abs(a - b) - CELLS_SHARE * b) / errors).max() < Z
    total = np.sqrt((errors**2).mean() / errors.size)
    assert abs(a.mean() - b.mean()) < Z * total + 0.5 * CELLS_SHARE * b.mean()


def luminance_of(picture):
    return picture.tristimulus[..., 1].astype(float), picture.luminance_error.astype(float)


@pytest.mark.slow
@pytest.mark.parametrize("room", ["matt", "coats"])
def test_a_view_with_cells_shows_what_paths_show_with_less_noise(room):
    session = session_of(*ROOMS[room])
    view = finish(session, transport="mono")
    assert view[2].samples == 256
    assert view[2].is_final
    assert "bias not measured" in view[2].words
    paths = luminance_of(picture_of(ROOMS[room], 512, "paths", 3, VIEW, transport="mono"))
    assert_agree(view, paths)
    as_many = luminance_of(picture_of(ROOMS[room], 256, "paths", 4, VIEW, transport="mono"))
    assert view[2].relative_error == pytest.approx(
        np.sqrt(((view[1] / np.maximum(view[0], view[0].mean())) ** 2).mean()), rel=1e-3
    )
    assert (view[1] ** 2).mean() < 0.5 * (as_many[1] ** 2).mean()


@pytest.mark.slow
def test_pixels_of_a_view_share_even_light_and_state_how_far_it_is_off(monkeypatch):
    """Below the lamp, whose edges few samples miss or hit, with sharing and without."""
    matt = ROOMS["matt"]
    truths = [
        luminance_of(picture_of(matt, 512, "cells", seed, VIEW, transport="mono"))[0][:26]
        for seed in (11, 12)
    ]
    scale = np.maximum(truths[0], truths[0].mean())

    def errors_of(seeds):
        views = [finish(session_of(*matt), 16, seed=seed, transport="mono") for seed in seeds]
        true = [(view[0][:26] - truths[0]) * (view[0][:26] - truths[1]) for view in views]
        return [
            np.mean(each, axis=0) / scale**2
            for each in (true, [view[1][:26] ** 2 for view in views])
        ]

    alone, _ = errors_of(range(3))
    monkeypatch.setattr(cell_view, "SHARED", SHARED)
    shared, stated = errors_of(range(6))
    assert np.median(shared) < 0.3 * np.median(alone)
    assert 0.7 < stated.mean() / shared.mean() < 1.5


@pytest.mark.slow
def test_the_stated_error_of_a_view_is_how_far_seeds_are_apart():
    views = [finish(session_of(*ROOMS["matt"]), 128, seed=seed) for seed in range(3)]
    scatter = np.var([view[0] for view in views], axis=0, ddof=1).mean()
    stated = np.mean([(view[1] ** 2).mean() for view in views])
    assert 0.7 < scatter / stated < 1.4


@pytest.mark.slow
def test_after_an_edit_a_view_is_that_of_the_edited_scene():
    session = session_of(*ROOMS["matt"])
    finish(session)
    moved = lamp(0.6, 1.2, 2.3)
    session.apply(SceneDelta(changed=(moved,)))
    items = [item for item in ROOMS["matt"] if item.id != "lamp"]
    picture = luminance_of(picture_of((*items, moved), 256, "cells", 3, VIEW))
    assert_agree(finish(session), picture)


@pytest.mark.slow
def test_what_paths_have_found_is_joined_and_the_image_gets_no_worse(monkeypatch):
    monkeypatch.setattr(cell_view, "FINDING_SHARE", 0.75)
    session = session_of(*ROOMS["matt"])
    session.watch(VIEW, LiveSettings(samples=1024, method="cells"), Display(white=1.0))
    errors = []
    while session.has_view_work:
        session.refine()
        error = session._view.work.error
        if np.isfinite(error) and error not in errors:
            errors.append(error)
    # Errors are estimates, and an image joins what it has by them.
    assert all(later < 2.0 * earlier for earlier, later in zip(errors, errors[1:], strict=False))
    assert errors[-1] < 0.1 * errors[0]
    assert 0.0 < session._view.work._weight < 0.5
    work = session._view.work
    view = work.image()[..., 1].astype(float), work.luminance_error().astype(float)
    assert_agree(view, luminance_of(picture_of(ROOMS["matt"], 256, "cells", 3, VIEW)))


@pytest.mark.slow
def test_the_size_of_slices_decides_nothing():
    """What takes 15 ms differs from machine to machine."""
    session = session_of(*ROOMS["matt"])
    found = []
    for lanes in (1 << 19, 20_000):
        with session._engine("mono") as scene:
            places = np.tile([[1.5, 2.0, 0.0]], (64, 1)) - scene.origin
            normals = np.tile([[0.0, 0.0, 1.0]], (64, 1))
            cells = KeptCells().open(scene, places.astype(np.float32), normals, 1000, 5)
            cells.cut(lanes)
            steps = sum(1 for _ in cells.preparing())
            found.append((steps, [np.array(table) for table in cells._tables]))
    assert found[1][0] > 2 * found[0][0]
    np.testing.assert_allclose(found[1][1], found[0][1], rtol=1e-4, atol=1e-6)


@pytest.mark.slow
def test_a_picture_in_between_does_not_disturb_a_view():
    session = session_of(*ROOMS["matt"])
    settings = LiveSettings(samples=512, method="cells")
    session.watch(VIEW, settings, Display(white=1.0))
    while session.has_view_work:
        session.refine()
        if session._view.work.samples > 32:
            break
    picture = session.render(VIEW, ViewSettings(StopRule(samples=256), 3, method="cells"))
    assert_agree(finish(session, 512), luminance_of(picture))


def test_a_view_of_nothing_is_dark():
    session = session_of(*ROOMS["matt"][3:])
    session.watch(VIEW, LiveSettings(samples=64, method="cells"), Display(white=1.0))
    while session.has_view_work:
        session.refine()
    assert session._view.work.image().max() == 0.0
