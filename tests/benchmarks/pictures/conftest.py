"""Fixtures of the tests of the benchmark of pictures."""

import pytest


@pytest.fixture(scope="module", autouse=True)
def _started():
    """Settle where LLVM lies before Dr.Jit is loaded."""
    from lumenray.engine.transport import backend

    backend.start(spectral=False)
