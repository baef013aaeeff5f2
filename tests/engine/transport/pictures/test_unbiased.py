"""Pictures by cells whose bias is taken out: whatever cells hold, the expected picture is that of full paths."""

import numpy as np
import pytest
from small_pictures import ROOMS, block_errors, blocks_of, look_in, picture_of
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.transport.lux_maps import cell_guide, cell_reader
from lumenray.engine.transport.pictures import kept_cells, picture, view_cells
from lumenray.engine.transport.pictures.view_cells import ViewCells
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

Z = 4.5
WRONG = 1.5
"""What cells are made to hold of their light."""

SEEDS, SIDE = 8, 16
COARSE_CELLS, COARSE_NEAR = 100, 0.3


@pytest.fixture
def wrong_cells(monkeypatch):
    """Cells that are too bright, all and everywhere."""
    use = ViewCells.use

    def use_wrong(self, half):
        use(self, half)
        self.cells.values = self.cells.values * WRONG

    monkeypatch.setattr(ViewCells, "use", use_wrong)


@pytest.fixture
def coarse_cells(monkeypatch):
    """A hundred cells of half a metre and more, which are read next to corners."""
    for name in ("FEWEST_CELLS", "MOST_CELLS"):
        monkeypatch.setattr(kept_cells, name, COARSE_CELLS)
    for module in (cell_reader, cell_guide, view_cells):
        monkeypatch.setattr(module, "NEAR", COARSE_NEAR)


def worst_of(first, second):
    """Largest difference of the means of squares of two pictures, in standard errors."""
    a, b = (blocks_of(each.tristimulus[..., 1]) for each in (first, second))
    return (np.abs(a - b) / np.hypot(block_errors(first), block_errors(second))).max()


def compare(room, **more):
    """Assert that what wrong cells change is seen without the correction, and not with it."""
    items, view = ROOMS[room], look_in(32, 24)
    paths = picture_of(items, 256, "paths", 1, view, **more)
    biased, corrected = (
        picture_of(items, 64, "cells", 2, view, unbiased=unbiased, **more)
        for unbiased in (False, True)
    )
    assert worst_of(biased, paths) > 3.0 * Z
    assert worst_of(corrected, paths) < Z
    errors = block_errors(corrected) / blocks_of(corrected.tristimulus[..., 1])
    assert np.median(errors) < 0.05
    return corrected


@pytest.mark.usefixtures("wrong_cells")
@pytest.mark.parametrize("room", ["matt", pytest.param("metal", marks=pytest.mark.slow)])
def test_what_wrong_cells_change_is_taken_out(room):
    """Of matt surfaces, of points on bright cells, and of what is read in rough metal by paths of the camera."""
    corrected = compare(room, transport="mono")
    assert "corrected by full paths" in corrected.provenance.notes[-1]
    assert any("what they change is corrected" in each for each in corrected.provenance.decisions)


@pytest.mark.slow
@pytest.mark.usefixtures("wrong_cells")
@pytest.mark.parametrize("room", ROOMS)
def test_what_wrong_cells_change_is_taken_out_in_every_kind_of_room(room):
    compare(room, transport="spectral")


@pytest.mark.slow
@pytest.mark.usefixtures("coarse_cells")
def test_coarse_cells_show_in_blocks_but_where_they_are_corrected():
    """Blocks of 16 x 16 pixels, 8 seeds: differences from full paths over their standard errors are standard normal."""
    session, view = session_of(*ROOMS["matt"]), look_in(64, 48)

    def blocks(samples, method, first, **more):
        """Block means of pictures. (seeds, blocks)"""
        made = [
            session.render(
                view, ViewSettings(StopRule(samples=samples), seed, method=method, **more)
            )
            for seed in range(first, first + SEEDS)
        ]
        return np.array([blocks_of(each.tristimulus[..., 1], SIDE).ravel() for each in made])

    paths = blocks(256, "paths", 100)

    def apart(values):
        """Differences of block means from those of full paths, in standard errors."""
        error = np.sqrt((values.var(axis=0, ddof=1) + paths.var(axis=0, ddof=1)) / SEEDS)
        return (values.mean(axis=0) - paths.mean(axis=0)) / error

    biased, corrected = (
        apart(blocks(64, "cells", 200, unbiased=unbiased)) for unbiased in (False, True)
    )
    # Student's t of 14 degrees of freedom has a variance of 7 / 6; of 12 blocks all are below 3.9 with 98 %.
    assert (biased**2).mean() > 8.0
    assert np.abs(corrected).max() < 3.9
    assert (corrected**2).mean() < 2.5


def test_what_is_unbiased_and_automatic_is_made_by_full_paths(monkeypatch):
    for name in ("FEWEST_PIXELS", "FEWEST_PATHS"):
        monkeypatch.setattr(picture, name, 1)
    session, rule, view = session_of(*ROOMS["matt"]), StopRule(samples=4), look_in(16, 12)
    biased, unbiased = (
        session.render(view, ViewSettings(rule, 1, unbiased=unbiased)) for unbiased in (False, True)
    )
    assert any("the bias is measured" in each for each in biased.provenance.decisions)
    assert any("unbiased picture is asked" in each for each in unbiased.provenance.decisions)
    paths = session.render(view, ViewSettings(rule, 1, method="paths"))
    np.testing.assert_array_equal(unbiased.tristimulus, paths.tristimulus)
