import json
import math

import numpy as np
import pytest
from PIL import Image, ImageColor

from lumenray.engine.accuracy.history import History, Mark
from lumenray.engine.analysis.error_graph import (
    DARK,
    LIGHT,
    draw_error_graph,
    error_ticks,
    graph_pixels,
    time_ticks,
    to_rows,
)
from lumenray.engine.errors import FileFormatError

SETUP = 2.0


def history_of(count, target=0.01, forecast=202.0, step=2.0):
    """A tenth after one pass, falling by the root; the first pass has no error."""
    marks = [Mark(SETUP + step, 16.0, math.inf, None)]
    for number in range(2, count + 1):
        marks.append(Mark(SETUP + step * number, 16.0 * number, 0.1 / math.sqrt(number), forecast))
    return History(tuple(marks), target, SETUP)


def colour_mask(picture, colour, background="#ffffff"):
    """Pixels (h, w) of the hue of a colour, blended with the background or not."""
    values = np.asarray(picture).astype(float)
    ground = np.array(ImageColor.getrgb(background), dtype=float)
    towards = np.array(ImageColor.getrgb(colour), dtype=float) - ground
    share = (values - ground) @ towards / (towards @ towards)
    rest = np.abs(values - ground - share[..., None] * towards).max(axis=2)
    return (share > 0.5) & (rest < 24.0)


@pytest.mark.parametrize("size", [(960, 540), (480, 270)])
@pytest.mark.parametrize("dark", [False, True])
def test_the_branch_leads_from_the_curve_to_the_target(size, dark):
    colours = DARK if dark else LIGHT
    picture = draw_error_graph(history_of(25), size=size, dark=dark)
    assert picture.size == size
    line = colour_mask(picture, colours.target, colours.background).sum(axis=1)
    level = int(line.argmax())
    # The target's line goes across.
    assert line[level] > 0.8 * size[0]
    top = size[1] // 5
    curve = np.argwhere(
        colour_mask(picture, colours.curves[1], colours.background)[top : level - 2]
    )
    rows, columns = curve[:, 0] + top, curve[:, 1]
    start = columns[rows == rows.min()].mean()
    end = columns[rows == rows.max()].mean()
    # From 7.07 % at 6 s to 1 % at 202 s, both axes logarithmic: halfway across, at sqrt(6 * 202) s, it is 2.47 %.
    near = np.abs(columns - 0.5 * (start + end)) <= 0.01 * size[0]
    assert near.any()
    share = (rows[near].mean() - rows.min()) / (level - rows.min())
    assert share == pytest.approx(math.log(7.07 / 2.47) / math.log(7.07), abs=0.05)


def dots_of(history):
    """Columns in which there are dots of earlier forecasts."""
    return np.flatnonzero(
        (
            np.abs(
                np.asarray(draw_error_graph(history)).astype(int) - ImageColor.getrgb(LIGHT.earlier)
            )
            < 4
        )
        .all(axis=2)
        .sum(axis=0)
        > 4
    )


def test_a_forecast_that_moved_shows_as_dots_elsewhere():
    steady = history_of(25)
    early = [Mark(m.seconds, m.samples, m.error, 80.0) for m in steady.marks[4:10]]
    moved = History((*steady.marks[:4], *early, *steady.marks[10:]), 0.01, SETUP)
    assert np.ptp(dots_of(steady)) < 20
    # 80 s and 202 s lie a quarter of the axis apart.
    assert np.ptp(dots_of(moved)) > 150


def test_a_finished_bake_says_so():
    done, going = (
        colour_mask(draw_error_graph(history_of(count)), LIGHT.target)[:60].sum()
        for count in (100, 25)
    )
    assert done > 100
    assert going == 0


@pytest.mark.one_at_a_time
@pytest.mark.parametrize(
    "history",
    [
        History(),
        History((Mark(3.0, 16.0, math.inf, None),), 0.01, 1.0),
        History((Mark(3.0, 16.0, 0.02, None),), None, 1.0),
        History((Mark(3.0, 16.0, 0.02, 3.0),), 0.05, 3.0),
        History((Mark(3.0, 16.0, 0.0, 3.0),), 0.05, 3.0),
        History((Mark(1e-4, 1.0, 30.0, 1e9), Mark(2e-4, 2.0, 1e-9, 1e9)), 1e-12, 0.0),
        history_of(5, target=None, forecast=3600.0),
        history_of(5000, target=1e-3, forecast=2e4, step=0.1),
    ],
)
@pytest.mark.parametrize("size", [(480, 270), (960, 540), (10, 4000)])
def test_every_history_can_be_drawn(history, size):
    picture = draw_error_graph(history, size=size)
    assert len(picture.getcolors(1 << 24)) > 1
    json.dumps(to_rows(history), allow_nan=False)


def test_the_file_is_the_picture(tmp_path):
    made = draw_error_graph(history_of(25), tmp_path / "new" / "error.png", (480, 270))
    with Image.open(tmp_path / "new" / "error.png") as read:
        assert read.format == "PNG"
        assert np.array_equal(np.asarray(read), np.asarray(made))
    with pytest.raises(FileFormatError, match=r"ends in \.png"):
        draw_error_graph(history_of(25), tmp_path / "error.picture")


def test_pixels_are_as_blender_keeps_them():
    pixels = graph_pixels(history_of(25), size=(480, 270), dark=True)
    assert (pixels.shape, pixels.dtype) == ((270, 480, 4), np.float32)
    assert (pixels[..., 3] == 1.0).all()
    # The bottom row first: the target's green line lies in the lower half.
    green = pixels[..., 1] - pixels[..., 2] > 0.2
    assert green[:135].sum() > 10 * green[135:].sum()


def test_rows_hold_the_marks():
    rows = to_rows(history_of(3))
    assert rows[0]["relative_standard_error"] is None
    assert rows[2] == {
        "seconds": 8.0,
        "samples": 48.0,
        "relative_standard_error": 0.1 / math.sqrt(3.0),
        "forecast_seconds": 202.0,
    }


def test_axes_are_marked_at_round_values():
    assert error_ticks(0.005, 0.1, 8) == pytest.approx([0.005, 0.01, 0.02, 0.05, 0.1])
    assert error_ticks(1e-6, 1.0, 8) == pytest.approx([1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0])
    assert time_ticks(9.0, 700.0, 9) == [10, 20, 30, 60, 120, 300, 600]
    assert time_ticks(3000.0, 40_000.0, 9) == [3600, 7200, 18_000, 36_000]
