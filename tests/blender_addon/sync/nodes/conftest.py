"""Fixtures of the tests of colour graphs."""

import numpy as np
import pytest


@pytest.fixture
def agree(cycles_colour):
    """Return a function that compares our evaluation of a socket with Cycles'."""
    from material_trees import evaluate

    def compare(tree, output, tolerance=2e-3, rows=0, wrong_share=0.0):
        ours, report = evaluate(tree, output)
        theirs = cycles_colour(tree, output)
        is_wrong = np.abs(ours - theirs).max(-1) > tolerance * np.maximum(1, abs(theirs).max(-1))
        assert is_wrong.mean() <= wrong_share, (
            f"{is_wrong.sum()} pixels differ, first ours {ours[is_wrong][0]}, "
            f"Cycles {theirs[is_wrong][0]}"
        )
        assert len(report.rows) == rows, report.to_dicts()
        return ours

    return compare
