"""Fixtures of the engine's tests."""

from concurrent.futures import ThreadPoolExecutor

import pytest


@pytest.fixture
def worker():
    """A worker whose sessions are fakes."""
    from workers import fake_worker, nothing_left

    with nothing_left(), fake_worker() as fake:
        yield fake


@pytest.fixture
def jobs():
    """Threads for jobs that are to run side by side."""
    with ThreadPoolExecutor(8) as pool:
        yield pool
