"""Lines and values over a live view in false colours."""

import numpy as np
import pytest

from lumenray.engine.analysis.display import show
from lumenray.engine.analysis.view_marks import find_marks
from lumenray.engine.views import Display, DisplayMode

WIDTH, HEIGHT, OVER = 960, 540, 400.0


def field():
    """Light of a lamp over the middle of a plane, as cos^4. (540, 960)"""
    x, y = np.arange(WIDTH) + 0.5 - WIDTH / 2, np.arange(HEIGHT)[:, None] + 0.5 - HEIGHT / 2
    return 1000.0 / (1.0 + (x**2 + y**2) / OVER**2) ** 2


@pytest.mark.parametrize(("noise", "within"), [(0.0, 1.0), (0.08, 3.0)])
def test_lines_over_a_view_are_where_the_field_has_their_level(noise, within):
    light = field() * np.random.default_rng(1).normal(1.0, max(noise, 1e-12), (HEIGHT, WIDTH))
    made = find_marks(light, noise, (WIDTH, HEIGHT), True, True)
    size = np.array([WIDTH, HEIGHT])
    radius = np.hypot(*(made.lines.reshape(-1, 2) * size - size / 2).T)
    levels = np.unique(made.labels[:, 2])
    exact = OVER * np.sqrt(np.sqrt(1000.0 / levels) - 1.0)
    assert len(levels) >= 4
    # Each piece belongs to one of the levels, and each level has pieces.
    off = np.abs(radius[:, None] - exact)
    assert np.sqrt(np.mean(off.min(axis=1) ** 2)) < within
    assert set(off.argmin(axis=1)) == set(range(len(levels)))
    at = np.hypot(*(made.labels[:, :2] * size - size / 2).T)
    np.testing.assert_allclose(
        at, OVER * np.sqrt(np.sqrt(1000.0 / made.labels[:, 2]) - 1.0), atol=4 * within
    )
    told = field()[tuple((made.values[:, 1::-1] * size[::-1]).astype(int).T)]
    np.testing.assert_allclose(made.values[:, 2], told, rtol=0.05)
    assert len(made.values) == 8 * 7


def test_false_colours_have_lines_and_values_where_they_are_asked_for():
    image = np.repeat(field()[..., None], 4, axis=2).astype(np.float32)
    mode = DisplayMode.FALSE_ILLUMINANCE
    plain = show(image, Display(mode=mode))
    assert "lines" not in plain
    made = show(image, Display(mode=mode, lines=True), noise=0.01)
    assert len(made["lines"]) and not len(made["values"])
    assert "means over about" in made["statement"]
    np.testing.assert_array_equal(made["pixels"], plain["pixels"])
    assert (made["low"], made["high"], made["unit"]) == (plain["low"], plain["high"], "lx")
    # Marks of pictures would be of what nobody reads off.
    assert "lines" not in show(image, Display(lines=True))
    dark = show(np.zeros_like(image), Display(mode=mode, lines=True, values=True))
    assert not len(dark["lines"]) and (dark["values"][:, 2] == 0.0).all()


def test_noise_of_an_even_wall_makes_no_lines_nor_does_what_is_not_seen():
    """A wall of 1000 beside one of 400, both even, above nothing: the edge between them alone has lines."""
    light = np.where(np.arange(WIDTH) < 600, 1000.0, 400.0) + np.zeros((HEIGHT, 1))
    light *= np.random.default_rng(4).normal(1.0, 0.05, light.shape)
    light[:200] = 0.0
    made = find_marks(light, 0.05, (WIDTH, HEIGHT), True, False)
    assert len(made.lines)
    # Slopes are told on wider means than lines, so that those of the wall's own value stay beside the edge.
    assert np.abs(made.lines[..., 0] * WIDTH - 600.0).max() < 60.0
    assert made.lines[..., 1].min() * HEIGHT > 195.0
    assert made.labels[:, 2].min() >= 400.0


def test_noise_that_is_not_stated_is_seen_in_the_pixels():
    """Illuminance has other noise than the luminance that a view states the error of."""
    wall = np.random.default_rng(3).normal(85.0, 17.0, (HEIGHT, WIDTH))
    honest, silent = (
        find_marks(wall, noise, (WIDTH, HEIGHT), True, True) for noise in (0.2, 0.001)
    )
    widths = [made.words.split(" (")[0] for made in (silent, honest)]
    assert widths[0] == widths[1] != find_marks(field(), 0.0, (WIDTH, HEIGHT), True, True).words
    assert float(silent.words.split("noise ")[1].split(" ")[0]) > 1.5
