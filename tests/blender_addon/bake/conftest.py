"""Fixtures of the tests of bakes."""

import pytest


@pytest.fixture
def paint():
    """Return a matt material."""
    from blender_objects import new_paint

    return new_paint()
