"""Ra, Rf and Rg against colour-science, on twenty spectra and more."""

import numpy as np
import pytest

from lumenray.engine.analysis.sensor_colours import find_colours, rendering_range
from lumenray.engine.photometry.colour_fidelity import fidelity_and_gamut
from lumenray.engine.photometry.colour_rendering import colour_rendering, general_index
from lumenray.engine.photometry.colour_temperature import colour_temperature
from lumenray.engine.photometry.spectra import GRID, daylight, illuminant, observer, planck

LAMPS = (
    "A", "D50", "D65", "FL1", "FL2", "FL3", "FL4", "FL5", "FL6", "FL7", "FL8", "FL9", "FL10", "FL11", "FL12", "LED-B1",
    "LED-B2", "LED-B3", "LED-B4", "LED-B5", "LED-BH1", "LED-RGB1", "LED-V1", "LED-V2", "HP2", "HP3",
)  # fmt: skip


@pytest.fixture(scope="module")
def colour():
    return pytest.importorskip("colour")


@pytest.mark.parametrize("lamp", LAMPS)
def test_indices_are_those_of_colour_science(colour, lamp):
    power = illuminant(GRID, lamp)
    theirs = colour.SpectralDistribution(dict(zip(GRID, power, strict=True)))
    fidelity, gamut = fidelity_and_gamut(power)
    quality = colour.quality.colour_fidelity_index_ANSIIESTM3018(theirs, additional_data=True)
    assert general_index(power) == pytest.approx(colour.colour_rendering_index(theirs), abs=0.06)
    assert fidelity == pytest.approx(quality.R_f, abs=0.06)
    # A sample at the edge of two bins of hue may fall into either.
    assert gamut == pytest.approx(quality.R_g, abs=0.25)
    temperature, duv = colour_temperature(power @ observer())
    assert temperature == pytest.approx(quality.CCT, rel=3e-4)
    assert duv == pytest.approx(quality.D_uv, abs=2e-5)


def test_printed_figures_of_a_fluorescent_lamp():
    """FL2 has Rf 70, Rg 86, 4225 K and Duv 0.0019 in the calculator of ANSI/IES TM-30."""
    power = illuminant(GRID, "FL2")
    fidelity, gamut = fidelity_and_gamut(power)
    temperature, duv = colour_temperature(power @ observer())
    assert (round(fidelity), round(gamut), round(temperature), round(duv, 4)) == (
        70,
        86,
        4225,
        0.0019,
    )


@pytest.mark.parametrize("temperature", [2000.0, 3000.0, 4500.0])
def test_blackbodies_render_like_themselves(temperature):
    assert general_index(planck(GRID, temperature)) == pytest.approx(100.0, abs=0.05)


@pytest.mark.parametrize("temperature", [5500.0, 7500.0])
def test_daylight_renders_like_itself(temperature):
    power = daylight(GRID, temperature)
    assert general_index(power) == pytest.approx(100.0, abs=0.05)
    fidelity, gamut = fidelity_and_gamut(power)
    assert fidelity == pytest.approx(100.0, abs=0.1)
    assert gamut == pytest.approx(100.0, abs=0.1)


def test_the_scale_of_a_spectrum_has_no_meaning():
    power = illuminant(GRID, "FL11")
    assert np.allclose(colour_rendering(power), colour_rendering(1e-4 * power))


def test_green_light_has_nothing_to_be_compared_with():
    green = np.exp(-(((GRID - 530.0) / 10.0) ** 2))
    assert general_index(green) is None
    assert fidelity_and_gamut(green) is None


def in_bands(power):
    """Means of bands of 5 nm, and their edges."""
    edges = np.linspace(380.0, 780.0, 81)
    inside = [(low <= GRID) & (high > GRID) for low, high in zip(edges, edges[1:], strict=False)]
    return edges, np.array([power[each].mean() for each in inside])


def test_bands_tell_almost_what_the_spectrum_tells():
    power = illuminant(GRID, "LED-B3")
    edges, bands = in_bands(power)
    made = find_colours(edges, np.stack([bands, np.zeros_like(bands)]))
    assert made.rendering[0] == pytest.approx(general_index(power), abs=0.6)
    assert made.fidelity[0] == pytest.approx(fidelity_and_gamut(power)[0], abs=0.6)
    assert np.isnan(made.rendering[1]) and np.isnan(made.temperature[1])


def test_the_range_of_an_index_holds_that_of_the_light_without_noise():
    edges, bands = in_bands(illuminant(GRID, "LED-B3"))
    value = find_colours(edges, bands[None]).rendering[0]
    draw, held = np.random.default_rng(3), 0
    for _ in range(40):
        noise = 0.02 * bands.max() * np.ones_like(bands)
        _, low, high = rendering_range(edges, bands + noise * draw.standard_normal(80), noise, 2.0)
        held += low <= value <= high
    assert held >= 36
