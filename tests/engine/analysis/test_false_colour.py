"""False colours."""

import numpy as np


def test_false_colours_are_ordered_and_round(tmp_path):
    from lumenray.engine.analysis.false_colour import colours, nice_maximum, write_false_colour

    assert nice_maximum(np.array([730.0])) == 800.0
    assert nice_maximum(np.array([0.0])) == 1.0
    ends = colours(np.array([-5.0, 0.0, 100.0, 500.0]), 0.0, 100.0)
    assert np.array_equal(ends[0], ends[1])
    assert np.array_equal(ends[2], ends[3])
    assert not np.array_equal(ends[1], ends[2])
    path = write_false_colour(tmp_path / "m.png", np.ones((4, 5)), np.ones((4, 5), bool), "Floor")
    from PIL import Image

    assert Image.open(path).size[0] > 100
