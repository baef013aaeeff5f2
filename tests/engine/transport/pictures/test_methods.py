"""Pictures by cells against pictures by paths."""

import numpy as np
import pytest
from small_pictures import ROOMS, block_errors, blocks_of, lamp, look_in, picture_of
from small_scenes import quad

pytestmark = pytest.mark.mitsuba

Z = 4.5
CELLS_SHARE = 0.015
"""What cells may change of a square of 8 x 8 pixels beside the noise of single pixels, relative to it: their size in corners
and edges, and noise of theirs that the pixels have in common. [-]"""

OPEN = quad("floor", (0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 4.0, 0.0), "paint")


def compare(items, samples, longer=4, **more):
    """Assert that squares of both pictures agree within confidence."""
    cells = picture_of(items, samples, "cells", 1, **more)
    paths = picture_of(items, longer * samples, "paths", 2, **more)
    a, b = (blocks_of(each.tristimulus[..., 1]) for each in (cells, paths))
    errors = np.hypot(block_errors(cells), block_errors(paths))
    gaps = np.abs(a - b) - CELLS_SHARE * b
    worst = (gaps / errors).max()
    assert worst < Z, f"{worst:.3g} standard errors"
    # The errors must be small enough to find anything.
    assert np.median(errors / b) < 0.03
    total = np.sqrt((errors**2).mean() / errors.size)
    assert abs(a.mean() - b.mean()) < Z * total + 0.5 * CELLS_SHARE * b.mean()
    return cells, paths


def test_cells_show_what_paths_show():
    compare(ROOMS["matt"], 128)


@pytest.mark.slow
@pytest.mark.parametrize("room", ROOMS)
def test_cells_show_what_paths_show_of_every_kind_of_room(room, transport):
    compare(ROOMS[room], 256, transport=transport)


@pytest.mark.slow
def test_a_sliver_of_a_lamp_is_not_missed():
    """The lamp's edge fills so little of some pixels that the first samples of a whole square may miss it."""
    room = ROOMS["matt"]
    items = tuple(lamp(0.6, 2.0, 2.3) if item is room[2] else item for item in room)
    paths = picture_of(items, 1024, "paths", 1)
    for seed in (7919, 2, 3):
        cells = picture_of(items, 256, "cells", seed)
        gaps = blocks_of((cells.tristimulus - paths.tristimulus)[..., 1])
        errors = np.hypot(block_errors(cells), block_errors(paths))
        allowed = Z * errors + CELLS_SHARE * blocks_of(paths.tristimulus[..., 1])
        assert (np.abs(gaps) < allowed).all(), seed


@pytest.mark.slow
def test_other_channels_agree_by_both_methods():
    """Illuminance, bands, and what of the picture is not there, before the open end of a room."""
    items, view = (*ROOMS["matt"][1:], OPEN), look_in(32, 24)
    more = {"illuminance": True, "bands": 4, "transparent": True, "transport": "spectral"}
    cells = picture_of(items, 128, "cells", 1, view, **more)
    paths = picture_of(items, 512, "paths", 2, view, **more)
    assert 0.1 < cells.coverage.mean() < 0.9
    np.testing.assert_allclose(blocks_of(cells.coverage), blocks_of(paths.coverage), atol=0.01)
    np.testing.assert_array_equal(cells.backdrop, 0.0)
    assert cells.bands.shape == (24, 32, 4)
    errors = np.hypot(cells.illuminance_error, paths.illuminance_error)
    gaps = (cells.illuminance - paths.illuminance).astype(float)
    ratio = np.sqrt((gaps**2).mean() / (errors.astype(float) ** 2).mean())
    assert 0.75 < ratio < 1.35, ratio
    total = np.sqrt((errors.astype(float) ** 2).sum())
    assert abs(cells.illuminance.sum(dtype=float) - paths.illuminance.sum(dtype=float)) < Z * total


@pytest.mark.slow
def test_bands_agree_by_both_methods():
    items, view = ROOMS["matt"], look_in(16, 12)
    found = {
        method: np.array(
            [
                picture_of(items, 64, method, seed, view, bands=4).bands.mean(axis=(0, 1))
                for seed in range(first, first + 6)
            ]
        )
        for method, first in (("cells", 0), ("paths", 10))
    }
    gap = found["cells"].mean(axis=0) - found["paths"].mean(axis=0)
    noise = np.sqrt(sum(each.var(axis=0, ddof=1) for each in found.values()) / 6)
    assert (found["cells"].mean(axis=0) > 10.0 * noise).all()
    assert (np.abs(gap) < 6.0 * noise).all(), gap / noise


def test_the_stated_error_holds_what_cells_change(monkeypatch):
    from lumenray.engine.transport.pictures.pixel_light import PixelLight

    def picture(change):
        def differences(self, pixels):
            return change + np.where(np.arange(len(pixels)) % 2, 0.01, -0.01)

        monkeypatch.setattr(PixelLight, "differences", differences)
        return picture_of(ROOMS["matt"], 16, "cells", 1)

    none, much = picture(0.0), picture(5.0)
    np.testing.assert_array_equal(none.tristimulus, much.tristimulus)
    luminance = none.tristimulus[..., 1].astype(float)
    share = 5.0 / luminance.mean()
    expected = np.hypot(none.luminance_error, share * luminance)
    np.testing.assert_allclose(much.luminance_error, expected, rtol=1e-2)
    assert much.relative_error > none.relative_error
    assert "no chance" in much.provenance.notes[-1]
    assert "no chance" not in none.provenance.notes[-1]
