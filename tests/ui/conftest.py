"""Fixtures of the tests of what is drawn."""

import pytest


@pytest.fixture(autouse=True)
def _interface(empty_file):
    """Start from an empty file, with all panels registered."""
    from panels import interface

    with interface():
        yield
