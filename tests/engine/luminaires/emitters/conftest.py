"""Fixtures of the tests of luminaires inside kernels."""

import pytest

from lumenray.engine.transport import backend


@pytest.fixture
def mono():
    """Have kernels of one channel, with the plug-ins of luminaires."""
    backend.start(spectral=False)
    from lumenray.engine.luminaires.emitters import plugins

    plugins.register()


@pytest.fixture(scope="module")
def palette():
    """A luminaire of every opening, turned at random, without narrow beams."""
    from luminaire_palettes import CENTRE, palette_of
    from luminaires import OPENINGS, luminaire, turn

    backend.start(spectral=False)
    lights = {
        name: luminaire("irregular", opening, CENTRE, turn(seed))
        for seed, (name, opening) in enumerate(OPENINGS.items())
    }
    made = palette_of(list(lights.values()))
    assert not made.has_narrow
    return made, lights
