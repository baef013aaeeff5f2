"""Bands of wavelengths, as few as surfaces need."""

import numpy as np
import pytest

from lumenray.engine.photometry.spectra import GRID, illuminant, luminous_efficiency

pytestmark = pytest.mark.mitsuba

LAMP = illuminant(GRID, "D65")


@pytest.fixture(scope="module")
def bands():
    from lumenray.engine.transport import backend

    backend.start(spectral=False)
    from lumenray.engine.transport.sensors import sky_bands

    return sky_bands


def edge(at, low=0.1, high=0.8):
    """Reflectance on the grid that rises from one value to another around a wavelength. (471,)"""
    return low + (high - low) / (1.0 + np.exp(-(GRID - at) / 12.0))


def choose(bands, *reflectances):
    samples = (bands.find_samples(LAMP) - GRID[0]).astype(int)
    values = np.stack(reflectances)[:, samples]
    return bands.choose_bands(LAMP, values, np.ones(len(values)))


def test_grey_surfaces_need_one_band(bands):
    made = choose(bands, np.full(len(GRID), 0.2), np.full(len(GRID), 0.7))
    assert made.count == 1 and made.within < 1e-12
    assert choose(bands, edge(580, 0.50, 0.51)).count == 1


def test_saturated_surfaces_need_many_bands_of_equal_light(bands):
    made = choose(bands, edge(580), edge(540), 0.9 - edge(560))
    assert made.count == 8
    assert made.shares == pytest.approx(0.125, abs=0.02)
    assert made.shares.sum() == pytest.approx(1.0)
    assert (np.diff(made.numbers.astype(int)) >= 0).all()


@pytest.mark.parametrize("count", [1, 2, 4, 8])
def test_two_reflections_are_off_by_no_more_than_is_said(bands, count, monkeypatch):
    # A chain of one surface with itself is the worst case; whole spectra against means by band.
    monkeypatch.setattr(bands, "COUNTS", (count,))
    rho = edge(575)
    made = choose(bands, rho)
    weight = LAMP * luminous_efficiency()
    weight = weight / weight.sum()
    light = np.bincount(made.numbers, weight)
    mean = np.bincount(made.numbers, weight * rho) / light
    exact, by_bands = weight @ rho**2, light @ mean**2
    off = (exact - by_bands) / (weight @ rho) ** 2
    # Thirty-two samples of the spectrum stand for all of it.
    assert 0.0 < off < 1.1 * made.within + 1e-4
