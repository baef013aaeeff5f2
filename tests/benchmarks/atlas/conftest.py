"""Fixtures of the tests of the atlas benchmark."""

import pytest


@pytest.fixture(scope="module", autouse=True)
def _started():
    """Settle where LLVM lies before Dr.Jit is loaded."""
    from lumenray.engine.transport import backend

    backend.start(spectral=False)
