"""Cells that pictures of one session share: the same where nothing has changed, right where something has."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
from small_pictures import ROOMS, block_errors, blocks_of, lamp, look_in
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import Output, Quantity
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.transport.pictures import kept_cells
from lumenray.engine.transport.pictures.kept_cells import NOTE
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

Z = 4.5
SCREEN = quad("screen", (0.4, 2.2, 0.4), (1.0, 0.0, 0.0), (0.0, 0.3, 1.2), "red")
MOVED = quad("screen", (1.4, 1.6, 0.4), (1.0, 0.0, 0.0), (0.0, 0.3, 1.2), "red")
ELSEWHERE = replace(lamp(0.6, 0.8, 1.2), output=Output(Quantity.LUMINOUS_FLUX, 4000.0))


@pytest.fixture
def divisions(monkeypatch):
    """List of the divisions of surfaces that are made."""
    made = []
    make = kept_cells.Division
    monkeypatch.setattr(kept_cells, "Division", lambda *a: made.append(make(*a)) or made[-1])
    return made


def rendered(session, samples=64, seed=1, view=None, **more):
    more = {"shares": False} | more
    settings = ViewSettings(StopRule(samples=samples), seed, method="cells", **more)
    return session.render(view or look_in(), settings)


def turned(x=0.3):
    """Camera as of `look_in`, a step aside."""
    view = look_in()
    frame = view.frame.copy()
    frame[0, 3] += x
    return replace(view, frame=frame)


def assert_agree(one, other, most_error=0.05):
    """Assert that squares of two pictures agree within their errors, which are small enough to tell."""
    a, b = (blocks_of(each.tristimulus[..., 1]) for each in (one, other))
    errors = np.hypot(block_errors(one), block_errors(other))
    assert np.median(errors / b) < most_error
    assert (np.abs(a - b) / errors).max() < Z
    total = np.sqrt((errors**2).mean() / errors.size)
    assert abs(a.mean() - b.mean()) < Z * total


def test_the_same_picture_again_is_the_same_and_divides_nothing(divisions):
    session = session_of(*ROOMS["matt"])
    first, again = (rendered(session, 4) for _ in range(2))
    assert len(divisions) == 1
    np.testing.assert_array_equal(first.tristimulus, again.tristimulus)
    np.testing.assert_array_equal(first.luminance_error, again.luminance_error)
    assert NOTE not in (*first.provenance.notes, *again.provenance.notes)


@pytest.mark.slow
def test_another_view_of_the_same_scene_uses_its_cells_and_says_so(divisions):
    session = session_of(*ROOMS["matt"])
    rendered(session, 2)
    kept = rendered(session, view=turned())
    assert len(divisions) == 1
    assert NOTE in kept.provenance.notes
    alone = rendered(session_of(*ROOMS["matt"]), seed=2, view=turned())
    assert NOTE not in alone.provenance.notes
    assert_agree(kept, alone)


@pytest.mark.slow
def test_another_seed_has_light_of_its_own(divisions):
    session = session_of(*ROOMS["matt"])
    pictures = [rendered(session, 32, seed) for seed in (1, 2)]
    assert len(divisions) == 1
    assert_agree(*pictures)
    halves = [each.tristimulus[..., 1].astype(float) for each in pictures]
    gap = ((halves[0] - halves[1]) ** 2).mean()
    expected = sum((each.luminance_error.astype(float) ** 2).mean() for each in pictures)
    assert 0.7 < gap / expected < 1.4


@pytest.mark.parametrize("transport", ["mono", pytest.param("spectral", marks=pytest.mark.slow)])
def test_after_an_edit_of_a_light_its_picture_is_that_of_the_new_light(divisions, transport):
    """Another place, amount and spectrum, on the other side of a screen."""
    session = session_of(*ROOMS["matt"])
    rendered(session, 2, transport=transport)
    session.apply(SceneDelta(changed=(ELSEWHERE,)))
    edited = rendered(session, 32, transport=transport)
    assert len(divisions) == 1
    assert NOTE in edited.provenance.notes
    items = [item for item in ROOMS["matt"] if item.id != "lamp"]
    alone = rendered(session_of(*items, ELSEWHERE), 32, seed=2, transport=transport)
    assert_agree(edited, alone, 0.07)


@pytest.mark.slow
def test_light_that_is_switched_off_is_gone_and_comes_again():
    session = session_of(*ROOMS["matt"])
    first = rendered(session, 8)
    session.apply(SceneDelta(removed=("lamp",)))
    assert rendered(session, 8).tristimulus.max() == 0.0
    session.apply(SceneDelta(changed=(lamp(),)))
    assert_agree(rendered(session, 32, seed=3), first, 0.15)


@pytest.mark.slow
def test_after_an_edit_of_a_surface_its_picture_is_that_of_the_new_surface(divisions):
    session = session_of(*ROOMS["matt"])
    rendered(session, 2)
    session.apply(SceneDelta(changed=(paint(0.2),)))
    edited = rendered(session)
    assert len(divisions) == 1
    alone = rendered(session_of(*ROOMS["matt"][:1], paint(0.2), *ROOMS["matt"][2:]), seed=2)
    assert_agree(edited, alone)


def test_after_an_edit_of_an_object_all_begins_anew(divisions):
    session = session_of(*ROOMS["matt"])
    rendered(session, 2)
    session.apply(SceneDelta(changed=(MOVED,)))
    edited = rendered(session, 2)
    assert len(divisions) == 2
    assert NOTE not in edited.provenance.notes
    alone = rendered(session_of(*ROOMS["matt"][:4], MOVED), 2)
    np.testing.assert_array_equal(edited.tristimulus, alone.tristimulus)


@pytest.mark.slow
def test_light_groups_share_a_division_and_add_up(divisions):
    other = replace(ELSEWHERE, id="other", name="other")
    session = session_of(*ROOMS["matt"], other)
    made = rendered(session, 24, groups=(LightGroup("one", ("lamp",)),))
    assert len(divisions) == 1
    assert NOTE not in made.provenance.notes
    assert_agree(made, rendered(session_of(*ROOMS["matt"], other), 32, seed=2), 0.1)


def test_cells_of_one_scene_go_with_it_and_are_not_those_of_the_next(monkeypatch):
    """A scene that is compiled anew has shapes of its own."""
    made, make = [], kept_cells.Division
    # Counted, but not held: what is held would hold its scene.
    monkeypatch.setattr(kept_cells, "Division", lambda *a: made.append(1) or make(*a))
    session = session_of(*ROOMS["matt"])
    rendered(session, 2, transport="mono")
    scene = weakref.ref(session._compiled)
    other = rendered(session, 2, transport="spectral")
    assert len(made) == 2
    assert NOTE not in other.provenance.notes
    gc.collect()
    assert scene() is None


def test_cells_that_nobody_looks_at_get_no_light_and_paths_go_on_there(divisions, monkeypatch):
    """And the picture is that of full paths."""
    made = []
    prepare = kept_cells.ViewCells.prepare
    monkeypatch.setattr(
        kept_cells.ViewCells, "prepare", lambda self: (prepare(self), made.append(self))[0]
    )
    session = session_of(*ROOMS["matt"])
    by_cells = rendered(session, 256)
    (division,), (cells,) = divisions, made
    looked_at = np.flatnonzero(division.looks)
    assert np.isin(division.read, looked_at).all()
    assert not np.isin(division.margin(), looked_at).any()
    assert len(division.read) + len(division.margin()) <= len(division.sides)
    uneven = np.array(cells.cells.uneven)
    others = np.setdiff1d(np.arange(len(uneven)), division.read)
    assert len(others)
    assert uneven[others].all()
    assert not uneven[division.read].all()
    by_paths = session.render(
        look_in(), ViewSettings(StopRule(samples=1024), 2, method="paths", shares=False)
    )
    assert_agree(by_cells, by_paths)
