"""Fixtures of the extension's tests, which all start from an empty file."""

import pytest


@pytest.fixture(autouse=True)
def _empty_file(empty_file):
    pass


@pytest.fixture
def tree():
    """Return an empty node tree of a new material."""
    from material_trees import new_tree

    return new_tree()


@pytest.fixture
def cycles_colour(tmp_path):
    """Return a function that lets Cycles show a socket over the UV square, bottom row first."""
    from material_trees import PIXELS, render_colour

    def render(tree, socket, size=PIXELS):
        return render_colour(tree, socket, tmp_path / "cycles.exr", size)

    return render
