"""Fixtures of all tests; small scenes live in `helpers`."""

import sys
from pathlib import Path

import pytest

# Test folders are no packages, so shared helpers are found by their folder.
sys.path.insert(0, str(Path(__file__).parent / "helpers"))


@pytest.fixture(params=["mono", "spectral"])
def transport(request):
    """Run with both kinds of transport."""
    return request.param
