"""The hanging cloth of panels: what is behind shows through openings, colours are those of the tables."""

import numpy as np
import pytest

from lumenray.engine.cloth.drape import draw_drape
from lumenray.engine.scene.material import Measured
from lumenray.engine.scene.scattering import ScatterTable

BANDS = np.array([450.0, 550.0, 650.0])


def cloth(reflectance, openness):
    zero, axis, turns = np.zeros(1), np.array([0.0, np.pi]), np.array([0.0, 0.5 * np.pi])

    def table(share, direct=None):
        values = np.broadcast_to(np.asarray(share, np.float32) / np.pi, (2, 1, 2, 2, 3)).copy()
        straight = None if direct is None else np.full((2, 1, 3), direct, np.float32)
        return ScatterTable(turns, zero, axis, axis, BANDS, values, straight, is_orthotropic=True)

    reflection, passing = table(reflectance), table([0.05] * 3, openness)
    return Measured(reflection, reflection, passing, passing)


def contrast(picture):
    """Brightness of a pane over that of the window's middle bar."""
    side = len(picture)
    return picture[side // 4, side // 4, :3].mean() - picture[side // 2, side // 4, :3].mean()


def test_the_window_shows_through_openings_only():
    dense, net = (draw_drape(cloth([0.3] * 3, openness), 64) for openness in (0.0, 0.4))
    assert dense.shape == (64, 64, 4)
    assert np.isfinite(dense).all()
    assert (dense >= 0.0).all()
    assert (dense <= 1.0).all()
    assert contrast(net) > contrast(dense) + 0.1


def test_a_red_cloth_is_red():
    picture = draw_drape(cloth([0.02, 0.02, 0.6], 0.0), 32)
    red, green, blue = picture[..., :3].mean(axis=(0, 1))
    assert red > 1.5 * max(green, blue)


def test_a_turn_changes_nothing_of_an_even_cloth():
    one = cloth([0.4] * 3, 0.1)
    assert draw_drape(one, 32, 0.7) == pytest.approx(draw_drape(one, 32), abs=2e-3)
