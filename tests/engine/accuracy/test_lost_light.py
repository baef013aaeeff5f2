"""What results lack without samples that were no numbers, and how it is told."""

import numpy as np
import pytest

from lumenray.engine.accuracy.lost_samples import find_missing, tell_lost


def test_what_is_missing_is_as_bright_as_the_rest():
    # Nine tenths of the samples gave 90.
    np.testing.assert_allclose(find_missing([90.0, 50.0, 3.0], [0.1, 0.5, 0.0]), [10.0, 50.0, 0.0])


def test_what_nobody_knows_has_no_finite_error():
    # All lost; some lost and the others dark; nothing lost in the dark.
    shares = [1.0, 0.2, 0.0]
    np.testing.assert_array_equal(find_missing(np.zeros(3), shares), [np.inf, np.inf, 0.0])


def test_dark_values_may_lack_what_others_would():
    np.testing.assert_allclose(find_missing([0.0, 10.0], [0.2, 0.2], 100.0), [25.0, 2.5])


def test_lost_samples_are_told_by_what_they_belong_to():
    (told,) = tell_lost({"samples of the maps": (37, 120_000), "light paths": (0, 500)})
    assert told.startswith("37 of 120000 samples of the maps were no numbers and were left out")
    assert "0.031 %" in told and "light paths" not in told
    assert tell_lost({"samples": (0, 120_000)}) == ()


@pytest.mark.parametrize("lost", [1, 7])
def test_the_largest_share_is_told(lost):
    (told,) = tell_lost({"samples of the maps": (lost, 100), "samples of cells": (lost, 10)})
    assert f"may lack {10 * lost} %" in told
